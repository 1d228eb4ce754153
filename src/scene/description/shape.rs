//! The surface of an object, and where it stands.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use super::objects::Quantity;
use crate::geometry::Mesh;
use crate::scene::note::LoadNote;

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
}

/// Which part of a mesh's file is meant, by the names that the file gives: what has all that is named here. Without names it is the whole.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct MeshPart {
    /// A group or an object of OBJ, a solid of STL, a node or a mesh of glTF.
    pub group: Option<String>,
    pub material: Option<String>,
}

impl MeshPart {
    pub fn of_group(name: impl Into<String>) -> Self {
        Self { group: Some(name.into()), material: None }
    }

    pub fn of_material(name: impl Into<String>) -> Self {
        Self { group: None, material: Some(name.into()) }
    }

    pub fn is_whole(&self) -> bool {
        *self == Self::default()
    }
}

/// The surface of an object, in object space; of lights alone, also where one stands that has no surface.
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
        part: MeshPart,
        mesh: Arc<Mesh>,
        /// What of the file was passed over.
        notes: Vec<LoadNote>,
    },
    /// A light that shines equally in all directions.
    Point {
        position: DVec3,
    },
    /// A light that shines in a cone about the way to `target`. With t the angle to that way its intensity is that along it, times
    /// clamp((cos t − cos outer)/(cos inner − cos outer), 0, 1)².
    Spot {
        position: DVec3,
        target: DVec3,
        /// Half angle within which it is brightest, in degrees.
        inner_angle: f64,
        /// Half angle beyond which it is dark, in degrees.
        outer_angle: f64,
    },
    /// A light from afar.
    Directional {
        /// The way that its light goes.
        direction: DVec3,
        /// Full angle under which it is seen, in degrees; that of the sun is 0.53. At 0 nothing sees it.
        angle: f64,
    },
}

impl Shape {
    /// The whole mesh of a file.
    pub fn mesh(path: impl Into<PathBuf>, mesh: impl Into<Arc<Mesh>>) -> Self {
        Self::Mesh { path: path.into(), part: MeshPart::default(), mesh: mesh.into(), notes: Vec::new() }
    }

    /// Whether there is something to be met.
    pub fn has_surface(&self) -> bool {
        !matches!(self, Self::Point { .. } | Self::Spot { .. } | Self::Directional { .. })
    }

    /// What a light of this shape is measured by where it is not by its power.
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Point { .. } | Self::Spot { .. } => Quantity::Intensity,
            Self::Directional { .. } => Quantity::Irradiance,
            _ => Quantity::Radiance,
        }
    }

    /// Lowest and highest coordinates in object space; a round shape's facets may stay inside by a little. A light from afar has no place: both
    /// are the origin.
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
            Self::Point { position } | Self::Spot { position, .. } => (*position, *position),
            Self::Directional { .. } => (DVec3::ZERO, DVec3::ZERO),
            Self::Mesh { mesh, .. } => (mesh.positions.iter())
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(*p), max.max(*p))),
        }
    }
}
