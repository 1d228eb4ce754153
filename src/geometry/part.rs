//! What a geometry is built from.

use glam::DVec3;

use super::mesh::Mesh;

/// The surface of one object, in scene coordinates.
#[derive(Debug, Clone)]
pub enum Part {
    Mesh {
        mesh: Mesh,
        /// Whether the mesh's normals are kept for shading.
        smooth: bool,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Nothing to be met, at a place that the scene reaches to.
    Point(DVec3),
}
