//! The window, without a display and on a virtual one.

mod harness;

mod accessibility;
mod app;
mod layout;
mod measuring;
mod recovery;
mod screen;
mod texts;
