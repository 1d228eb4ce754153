//! A scene as its author wrote it: plain data, no acceleration structures, nothing derived.
//!
//! Meshes and environment images are read by [`crate::formats`] and held by [`Arc`], so a description is cheap to clone (undo, worker
//! requests) and compiling it needs no files.

mod objects;
mod shape;

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

pub use self::objects::{Emission, Kind, Light, Object, Objects, Paint, Quantity, Refractor, Role, Solid, UvTransform};
pub use self::shape::{MeshPart, Shape, Transform};
use super::environment::EnvironmentImage;
use super::note::LoadNote;
use crate::optics::{Ior, Medium};

/// The most radiance, intensity, irradiance and power of lights, and the most radiance of environments. What can be made of it, such as squares of sums over all samples, stays finite.
pub const MAX_RADIANCE: f64 = 1e100;

/// A whole scene. Lengths are in scene units, angles in degrees, radiance in linear RGB (Rec. 709); right-handed, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Shown in titles; defaults to the file's stem.
    pub name: String,
    pub camera: CameraDescription,
    /// What the scene declares the camera to be in, as in [`Refractor::outside`]; only mode `declared` and `check` ask.
    pub camera_medium: Option<String>,
    pub world: WorldMedium,
    pub environment: Environment,
    pub media: Vec<Medium>,
    pub objects: Objects,
    /// Where the scene came from, kept so that saving preserves comments and order.
    pub source: Option<Arc<Source>>,
}

/// The file that a description was read from.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Path of the scene file; relative paths in the scene are relative to its folder. For a built-in scene a path that does not
    /// exist, ending in `NAME.toml`.
    pub path: PathBuf,
    /// The file's text as read; empty where it is of another format than the program's own.
    pub text: String,
    /// Whether the scene is compiled into the program and has no file of its own.
    pub is_builtin: bool,
    /// What became of a file of another format, which is read and never written; `None` for the program's own.
    pub import: Option<Import>,
}

/// How a scene of another format was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// For people, such as `glTF`.
    pub format: &'static str,
    /// What has no counterpart and was approximated or left out, once a kind.
    pub notes: Vec<LoadNote>,
    /// All files that were read beside the scene's own, except for meshes and images that the description names.
    pub files: Vec<PathBuf>,
}

impl Source {
    /// A file of another format.
    pub fn imported(path: PathBuf, import: Import) -> Self {
        Self { path, text: String::new(), is_builtin: false, import: Some(import) }
    }

    /// Whether it is a file of the program's own format, which edits may be written back to.
    pub fn is_own_file(&self) -> bool {
        !self.is_builtin && self.import.is_none()
    }
}

/// The camera as written: a thin lens, or a pinhole when `aperture_radius` is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDescription {
    pub position: DVec3,
    pub target: DVec3,
    pub up: DVec3,
    /// Full angle over the image's height, in degrees, at any aspect.
    pub vertical_fov: f64,
    pub aperture_radius: f64,
    /// Distance from the lens to the plane in focus; `None` focuses on `target`.
    pub focus_distance: Option<f64>,
}

/// The global medium.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldMedium {
    pub ior: Ior,
    /// σ per scene unit; acts only inside the scene's bounding sphere.
    pub absorption: [f64; 3],
}

/// What surrounds the scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Environment {
    Color([f64; 3]),
    /// Linear in the direction's y between the three, `horizon` at 0.
    Gradient {
        zenith: [f64; 3],
        horizon: [f64; 3],
        nadir: [f64; 3],
    },
    /// Latitude–longitude image, top row +y, u = ½ + atan2(x, −z)/2π.
    Image {
        /// As written in the file.
        path: PathBuf,
        image: Arc<EnvironmentImage>,
        /// About +y, counter-clockwise seen from above, in degrees.
        rotation: f64,
        /// Multiplies radiance.
        scale: f64,
    },
}

impl Description {
    /// Whether it was read from `source`, edited since or not.
    pub fn is_of(&self, source: Option<&Arc<Source>>) -> bool {
        match (source, &self.source) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        }
    }

    pub fn medium(&self, name: &str) -> Option<&Medium> {
        self.media.iter().find(|m| m.name == name)
    }

    /// What is declared to lie outside of refractors and lights and around the camera, where something is.
    pub fn declared(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().filter_map(|object| object.outside()).chain(self.camera_medium.as_deref())
    }

    /// The same, to be changed.
    pub fn declared_mut(&mut self) -> impl Iterator<Item = &mut String> {
        self.objects.iter_mut().filter_map(|object| object.outside_mut()?.as_mut()).chain(self.camera_medium.as_mut())
    }
}
