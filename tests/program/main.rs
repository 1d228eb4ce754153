//! The real binary, run as its users run it.

mod desk;
#[path = "../tev_listener.rs"]
mod tev_listener;

mod cli;
mod declared;
mod files;
mod gpu;
mod hostile_text;
mod inlining;
mod merge;
mod numbers;
mod tev;
mod writing;
