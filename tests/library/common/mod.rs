//! Scenes made in memory, and ways to ask them, shared by the whole-system tests.

pub mod exr_bytes;
pub mod meshes;
pub mod parts;
pub mod random_scene;
pub mod touch;
pub mod truth;

use iorect::render::Film;
use iorect::report::stability::scenes;
pub use iorect::report::stability::scenes::{Numbers, add, deflection_degrees, empty, mean, nest, sphere, through};
use iorect::scene::description::Description;
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

pub fn ready(description: Description) -> Prepared {
    scenes::ready(description).expect("the scene is fine")
}

/// Renders and returns the film.
pub fn render(prepared: &Prepared, mode: Mode, size: (u32, u32), spp: u32, max_depth: Option<u32>) -> Film {
    scenes::render(prepared, mode, size, spp, 1, max_depth).expect("the camera is fine")
}
