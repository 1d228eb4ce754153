//! Rays, primitives, and the tree over them. The only module that knows obvhs, which builds the tree; the walk is ours.

mod beam;
pub mod binary;
mod bounds;
mod box_ray;
mod bvh;
mod collapse;
mod distance;
mod frame;
mod geometry;
mod hierarchy;
mod kernel;
mod many;
mod mesh;
mod node;
mod part;
mod question;
pub mod ray;
mod refit;
mod search;
mod sets;
pub mod sphere;
pub mod topology;
mod triangle;
mod walk;
mod winding;

pub use distance::closest_point;
pub use frame::Frame;
pub use geometry::{Geometry, Mask, ObjectRange, SurfacePoint, uniform_direction};
pub use kernel::KernelChoice;
pub use mesh::{CornerUvs, Mesh};
pub use part::Part;
pub use ray::{Hit, NO_PRIMITIVE, PrimitiveId, Ray};
pub use sets::Sets;
pub use topology::{Enclosure, Topology};
pub use winding::WindingTree;
