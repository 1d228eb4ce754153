//! The window, without a display and on a virtual one.

mod harness;

mod app;
mod measuring;
mod recovery;
mod screen;
