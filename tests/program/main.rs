//! The real binary, run as its users run it.

mod desk;

mod cli;
mod files;
mod hostile_text;
mod inlining;
mod merge;
mod numbers;
mod writing;
