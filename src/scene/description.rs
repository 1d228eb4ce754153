//! A scene as its author wrote it: plain data, no acceleration structures, nothing derived.
//!
//! Meshes and environment images are read by [`super::load`] and held by [`Arc`], so a description is cheap to clone (undo, worker
//! requests) and compiling it needs no files.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use super::LoadNote;
use super::environment::EnvironmentImage;
use super::shapes::{MAX_LENGTH, MIN_LENGTH};
use crate::geometry::Mesh;
use crate::optics::{Ior, Medium};

/// The most radiance of lights and environments. What can be made of it, such as squares of sums over all samples, stays finite.
pub const MAX_RADIANCE: f64 = 1e100;

/// A whole scene. Lengths are in scene units, angles in degrees, radiance in linear RGB (Rec. 709); right-handed, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Shown in titles; defaults to the file's stem.
    pub name: String,
    pub camera: CameraDescription,
    /// The global medium.
    pub world: WorldMedium,
    pub environment: Environment,
    pub media: Vec<Medium>,
    /// In file order, which breaks ties between overlapping volumes.
    pub refractors: Vec<Refractor>,
    pub solids: Vec<Solid>,
    pub lights: Vec<Light>,
    /// Where the scene came from, kept so that saving preserves comments and order.
    pub source: Option<Arc<Source>>,
}

/// The file that a description was read from.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Path of the scene file; relative paths in the scene are relative to its folder. For a built-in scene a path that does not
    /// exist, ending in `NAME.toml`.
    pub path: PathBuf,
    /// The file's text as read.
    pub text: String,
    /// Whether the scene is compiled into the program and has no file of its own.
    pub is_builtin: bool,
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

/// A dielectric object.
#[derive(Debug, Clone, PartialEq)]
pub struct Refractor {
    pub name: String,
    /// Name of the medium inside.
    pub medium: String,
    pub shape: Shape,
    /// Higher wins where volumes overlap.
    pub priority: i32,
    /// Whether normals are interpolated over faces.
    pub smooth: bool,
    /// An invisible object is not there at all: nothing hits it, and it contains nothing.
    pub visible: bool,
    pub transform: Transform,
}

/// An opaque object; two-sided.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    pub name: String,
    pub shape: Shape,
    pub paint: Paint,
    /// A perfect mirror, tinted by `paint`.
    pub mirror: bool,
    /// Whether normals are interpolated over faces.
    pub smooth: bool,
    /// As [`Refractor::visible`].
    pub visible: bool,
    pub transform: Transform,
}

/// An emitting, black, opaque object; emits from its outward side.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    pub name: String,
    pub shape: Shape,
    pub radiance: [f64; 3],
    /// As [`Refractor::visible`].
    pub visible: bool,
    pub transform: Transform,
}

/// Albedo of a solid, each component in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    Color([f64; 3]),
    /// Squares of side `size`: on quads by lengths along u and v from the corner, on other shapes by object x and z.
    Checker {
        a: [f64; 3],
        b: [f64; 3],
        size: f64,
    },
}

/// Scale first, then rotate about the fixed x, y and z axes through the origin, then translate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Non-zero; a negative determinant reverses the winding.
    pub scale: DVec3,
    /// Degrees.
    pub rotate: DVec3,
    pub translate: DVec3,
}

impl Transform {
    pub const IDENTITY: Self = Self { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO };

    /// World from object.
    pub fn matrix(&self) -> glam::DAffine3 {
        let rotation = glam::DMat3::from_rotation_z(self.rotate.z.to_radians())
            * glam::DMat3::from_rotation_y(self.rotate.y.to_radians())
            * glam::DMat3::from_rotation_x(self.rotate.x.to_radians());
        glam::DAffine3 { matrix3: rotation * glam::DMat3::from_diagonal(self.scale), translation: self.translate }
    }

    /// Why `shape` cannot be transformed like this, in words.
    pub fn fault(&self, shape: &Shape) -> Option<String> {
        let is_within = |v: DVec3| v.is_finite() && v.abs().max_element() <= MAX_LENGTH;
        let size = self.scale.abs();
        if !(is_within(self.translate) && is_within(self.scale) && self.rotate.is_finite()) {
            Some(format!("Numbers of a transform must be finite and at most {MAX_LENGTH:e}."))
        } else if size.min_element() == 0.0 {
            Some("A scale must not be 0.".to_owned())
        } else if size.min_element() < MIN_LENGTH {
            Some(format!("A scale must be at least {MIN_LENGTH:e}."))
        } else if matches!(shape, Shape::Sphere { .. }) && (size.x != size.y || size.y != size.z) {
            Some("A sphere is analytic and scales by the same amount along all axes; use an icosphere.".to_owned())
        } else {
            None
        }
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The surface of an object, in object space.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Analytic.
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Subdivided icosahedron, vertices on the sphere.
    Icosphere {
        center: DVec3,
        radius: f64,
        subdivisions: u32,
    },
    Box {
        min: DVec3,
        max: DVec3,
    },
    /// Axis y; `center` is the centroid.
    Cylinder {
        center: DVec3,
        radius: f64,
        height: f64,
        segments: u32,
    },
    /// Axis y.
    Torus {
        center: DVec3,
        major: f64,
        minor: f64,
        segments: u32,
        rings: u32,
    },
    /// (r, y) points revolved about the y axis.
    Lathe {
        profile: Vec<[f64; 2]>,
        segments: u32,
    },
    /// One-sided in orientation: normal edge_u × edge_v; edges are full lengths.
    Quad {
        center: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    },
    Mesh {
        /// As written in the file.
        path: PathBuf,
        mesh: Arc<Mesh>,
        /// What of the file was passed over.
        notes: Vec<LoadNote>,
    },
}

impl Shape {
    /// Lowest and highest coordinates in object space; a round shape's facets may stay inside by a little.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let around = |center: DVec3, half: DVec3| (center - half, center + half);
        match self {
            Self::Sphere { center, radius } | Self::Icosphere { center, radius, .. } => {
                around(*center, DVec3::splat(*radius))
            }
            Self::Box { min, max } => (min.min(*max), min.max(*max)),
            Self::Cylinder { center, radius, height, .. } => {
                around(*center, DVec3::new(*radius, height / 2.0, *radius))
            }
            Self::Torus { center, major, minor, .. } => {
                around(*center, DVec3::new(major + minor, *minor, major + minor))
            }
            Self::Lathe { profile, .. } => {
                let radius = profile.iter().fold(0.0, |most: f64, [r, _]| most.max(*r));
                let [low, high] = (profile.iter())
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [_, y]| [low.min(*y), high.max(*y)]);
                (DVec3::new(-radius, low, -radius), DVec3::new(radius, high, radius))
            }
            Self::Quad { center, edge_u, edge_v } => around(*center, (edge_u.abs() + edge_v.abs()) / 2.0),
            Self::Mesh { mesh, .. } => (mesh.positions.iter())
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(*p), max.max(*p))),
        }
    }
}

impl Description {
    /// Every object's name, refractors first, then solids, then lights: the order of object ids.
    pub fn object_names(&self) -> impl Iterator<Item = &str> {
        (self.refractors.iter().map(|r| r.name.as_str()))
            .chain(self.solids.iter().map(|s| s.name.as_str()))
            .chain(self.lights.iter().map(|l| l.name.as_str()))
    }

    /// The medium of that name.
    pub fn medium(&self, name: &str) -> Option<&Medium> {
        self.media.iter().find(|m| m.name == name)
    }
}
