//! Rays and what they hit.

use glam::DVec3;

/// Index of a triangle or sphere in its [`super::Geometry`]: triangles first, then spheres.
pub type PrimitiveId = u32;

/// No primitive.
pub const NO_PRIMITIVE: PrimitiveId = PrimitiveId::MAX;

/// A half-line. It leaves from a primitive (or from none), which it cannot hit again at its own start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit length.
    pub direction: DVec3,
    /// The primitive that `origin` lies on: never hit again if flat, hit again only across its inside if a sphere.
    pub from: PrimitiveId,
    /// Only hits behind (`t_min`, `after`) in the order (distance, primitive) count: a walk through a surface that does not
    /// bend light keeps its ray and advances these two, and so meets every later surface at bit-identical distances.
    pub t_min: f64,
    pub after: PrimitiveId,
}

impl Ray {
    /// A ray from a point in space.
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, from: NO_PRIMITIVE, t_min: 0.0, after: NO_PRIMITIVE }
    }

    /// A ray from a point on the primitive `from`.
    #[inline]
    pub fn leaving(origin: DVec3, direction: DVec3, from: PrimitiveId) -> Self {
        Self { origin, direction, from, t_min: 0.0, after: NO_PRIMITIVE }
    }

    /// The same ray, behind `hit`.
    #[inline]
    pub fn beyond(&self, hit: &Hit) -> Self {
        Self { t_min: hit.t, after: hit.primitive, ..*self }
    }

    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Where a ray meets a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in scene units.
    pub t: f64,
    pub primitive: PrimitiveId,
    /// Barycentric weights of the second and third corner; unused for spheres.
    pub barycentric: [f64; 2],
    /// Whether the ray meets the outward side. From the sign of the intersection's determinant, not from a rounded normal.
    pub is_front: bool,
}
