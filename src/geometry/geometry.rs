//! All primitives of a scene and the tree over them.

use std::ops::Range;

use glam::DVec3;

/// All primitives of a scene and the tree over them.
#[derive(Debug)]
pub struct Geometry {
    /// Scene coordinates of the local origin.
    pub origin: DVec3,
}

/// The primitives of one object.
pub type ObjectRange = Range<u32>;

/// The surface at a hit.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    pub position: DVec3,
}
