//! Rays, primitives, and the tree over them. The only module that knows obvhs, which builds the tree; the walk is ours.

mod bvh;
mod distance;
mod enclosure;
mod geometry;
mod kernel;
mod mesh;
pub mod ray;
pub mod sphere;
mod triangle;

pub use distance::closest_point;
pub use enclosure::Enclosure;
pub use geometry::{Geometry, ObjectRange, Part, SurfacePoint, uniform_direction};
pub use mesh::Mesh;
pub use ray::{Hit, PrimitiveId, Ray};
