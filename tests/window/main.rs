//! The window, without a display and on a virtual one.

mod harness;
#[path = "../tev_listener.rs"]
mod tev_listener;

mod accessibility;
mod app;
mod building;
mod declared;
mod estimator;
mod export;
mod gpu;
mod journey;
mod layout;
mod lights;
mod measuring;
mod media;
mod opening;
mod path;
mod recovery;
mod samples;
mod screen;
mod slice;
mod teach;
mod texts;
mod textures;
mod tree;
