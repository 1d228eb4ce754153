//! The window's flags.

use std::path::PathBuf;

use clap::Args;

use super::values::{Size, backend, pixel, size};
use crate::render::BackendChoice;

/// The window, and the flags by which the project takes pictures of it.
#[derive(Debug, Args)]
pub struct WindowArguments {
    /// Scene to open: a file or a built-in scene's name [default: iced-water]
    #[arg(value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Take a picture of the window and quit
    #[arg(long, hide = true, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
    /// Measure how long the window takes for a frame while panes render, write that and quit
    #[arg(long, hide = true, value_name = "FILE.json", conflicts_with = "screenshot")]
    pub measure_frames: Option<PathBuf>,
    /// Size of the window in pixels
    #[arg(long, hide = true, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub window_size: Option<Size>,
    /// Samples per pixel to wait for before the picture is taken
    #[arg(long, hide = true, default_value_t = 32, requires = "screenshot")]
    pub samples: u32,
    /// Number of panes in the picture: 1, 2 or 4
    #[arg(long, hide = true, requires = "screenshot")]
    pub panes: Option<usize>,
    /// What renders the pictures
    #[arg(long, hide = true, value_name = "BACKEND", default_value = "auto", value_parser = backend)]
    pub backend: BackendChoice,
    /// One pane over the other, with a divider
    #[arg(long, hide = true, requires = "screenshot")]
    pub wipe: bool,
    /// The light theme
    #[arg(long, hide = true, requires = "screenshot")]
    pub light: bool,
    /// Tab at the right: render, rectification, inspector or measure, which begins to measure
    #[arg(long, hide = true, requires = "screenshot", value_parser = ["render", "rectification", "inspector", "measure"])]
    pub tab: Option<String>,
    /// Place in the first pane whose path is inspected, in percent of its width and height
    #[arg(long, hide = true, requires = "screenshot", value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pub inspect: Option<[u32; 2]>,
    /// The ghost view of that path, from the side
    #[arg(long, hide = true, requires = "inspect")]
    pub ghost: bool,
}
