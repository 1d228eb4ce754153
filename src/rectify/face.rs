//! Primitives compared with each other: whether they meet, and how much of one another covers.

use glam::DVec3;

use super::relation::{Relation, TrianglePair};
use super::tolerance::Tolerance;
use crate::geometry::sphere::Sphere;
use crate::geometry::{Geometry, PrimitiveId, closest_point};

/// How much of a cell a coincident face covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cover {
    Nothing,
    /// Some of it, or it cannot be told.
    Part,
    All,
}

#[inline]
fn bounds_of_triangle([a, b, c]: &[DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

#[inline]
fn bounds_of_sphere(sphere: &Sphere) -> (DVec3, DVec3) {
    (sphere.center - sphere.radius, sphere.center + sphere.radius)
}

/// A primitive, ready to be compared with others.
#[derive(Debug, Clone, Copy)]
pub enum Face {
    Triangle {
        corners: [DVec3; 3],
        /// Unit, outward; zero for a triangle without area.
        normal: DVec3,
    },
    Sphere(Sphere),
}

impl Face {
    pub fn of(geometry: &Geometry, primitive: PrimitiveId) -> Self {
        match geometry.sphere(primitive) {
            Some(sphere) => Self::Sphere(*sphere),
            None => Self::with_corners(geometry.corners(primitive)),
        }
    }

    fn with_corners(corners: [DVec3; 3]) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        Self::Triangle { corners, normal }
    }

    /// A primitive, if the box around it meets the box from `min` to `max`.
    #[inline]
    pub(super) fn in_box(geometry: &Geometry, primitive: PrimitiveId, min: DVec3, max: DVec3) -> Option<Self> {
        let is_in = |(low, high): (DVec3, DVec3)| (low.cmple(max) & high.cmpge(min)).all();
        match geometry.sphere(primitive) {
            Some(sphere) => is_in(bounds_of_sphere(sphere)).then_some(Self::Sphere(*sphere)),
            None => {
                let corners = geometry.corners(primitive);
                is_in(bounds_of_triangle(&corners)).then(|| Self::with_corners(corners))
            }
        }
    }

    /// Lowest and highest coordinates of a primitive.
    pub(super) fn bounds_of(geometry: &Geometry, primitive: PrimitiveId) -> (DVec3, DVec3) {
        match geometry.sphere(primitive) {
            Some(sphere) => bounds_of_sphere(sphere),
            None => bounds_of_triangle(&geometry.corners(primitive)),
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::Triangle { corners, .. } => bounds_of_triangle(corners),
            Self::Sphere(sphere) => bounds_of_sphere(sphere),
        }
    }

    /// Whether this and another are spheres farther apart than `margin`, beside each other or one in the other. A quick test that settles
    /// most pairs of spheres.
    pub(super) fn is_clear_of(&self, other: &Self, margin: f64) -> bool {
        let (Self::Sphere(a), Self::Sphere(b)) = (self, other) else { return false };
        let squared = a.center.distance_squared(b.center);
        let (apart, within) = (a.radius + b.radius + margin, (a.radius - b.radius).abs() - margin);
        squared > apart * apart || (within > 0.0 && squared < within * within)
    }

    /// Largest magnitude of each coordinate.
    fn reach(&self) -> DVec3 {
        let (min, max) = self.bounds();
        min.abs().max(max.abs())
    }

    /// Whether two faces of one object that touch do so at more than the corners and the edge that they share.
    pub(super) fn touches_beyond_corners(&self, other: &Self, tolerance: Tolerance) -> bool {
        let (Self::Triangle { corners: a, normal }, Self::Triangle { corners: b, .. }) = (self, other) else {
            return true;
        };
        let margin = tolerance.along(*normal, self.reach().max(other.reach()));
        let shared = |p: &DVec3| b.iter().position(|q| q == p);
        let joints: [Option<usize>; 3] = std::array::from_fn(|i| shared(&a[i]));
        match joints.iter().flatten().count() {
            0 => true,
            // An edge from the common corner that lies on the other face.
            1 => (0..3).any(|i| {
                let Some(j) = joints[i] else { return false };
                let lies_on = |edges: &[DVec3; 3], k: usize, face: &[DVec3; 3], corner: usize| {
                    [1, 2].into_iter().any(|step| is_along(edges[(k + step) % 3], face, corner, margin))
                };
                lies_on(a, i, b, j) || lies_on(b, j, a, i)
            }),
            _ => false,
        }
    }

    /// How `other` meets this face; `None` where it does not.
    pub fn relation(&self, other: &Self, tolerance: Tolerance) -> Option<Relation> {
        let least = tolerance.least;
        match (self, other) {
            (Self::Triangle { corners: f, normal: nf }, Self::Triangle { corners: t, normal: nt }) => {
                TrianglePair { f, nf: *nf, t, nt: *nt, reach: self.reach().max(other.reach()), tolerance }.relation()
            }
            (Self::Triangle { corners, .. }, Self::Sphere(sphere))
            | (Self::Sphere(sphere), Self::Triangle { corners, .. }) => {
                let near = closest_point(*corners, sphere.center).distance(sphere.center);
                let far = corners.iter().map(|c| c.distance(sphere.center)).fold(0.0, f64::max);
                let through = near < sphere.radius - least && far > sphere.radius + least;
                (near <= sphere.radius + least && far >= sphere.radius - least).then_some(Relation::Crosses { through })
            }
            (Self::Sphere(a), Self::Sphere(b)) => {
                let (distance, difference) = (a.center.distance(b.center), (a.radius - b.radius).abs());
                if distance <= least && difference <= least {
                    return Some(Relation::Coincides { same: true });
                }
                let through = difference + least < distance && distance < a.radius + b.radius - least;
                (difference - least <= distance && distance <= a.radius + b.radius + least)
                    .then_some(Relation::Crosses { through })
            }
        }
    }

    /// Distance from a point to the surface.
    pub fn distance(&self, point: DVec3) -> f64 {
        match self {
            Self::Triangle { corners, .. } => closest_point(*corners, point).distance(point),
            Self::Sphere(s) => (s.center.distance(point) - s.radius).abs(),
        }
    }

    /// Whether this face, which coincides with `other`, covers all of it.
    pub(super) fn cover_all(&self, other: &Self, tolerance: Tolerance) -> bool {
        match other {
            Self::Triangle { corners, .. } => self.cover(corners, tolerance) == Cover::All,
            Self::Sphere(_) => true,
        }
    }

    /// The planes of the edges, (a, b, c, d) each, as [`Self::cover`] sees them: a point in the face's plane is covered where ax + by + cz + d ≥ 0 for
    /// all three. Those of a sphere cover every point.
    pub(super) fn edge_planes(&self, tolerance: Tolerance) -> [[f64; 4]; 3] {
        let Self::Triangle { corners, normal } = self else { return [[0.0, 0.0, 0.0, 1.0]; 3] };
        let reach = self.reach();
        std::array::from_fn(|k| {
            let inward = normal.cross(corners[(k + 1) % 3] - corners[k]).normalize_or_zero();
            let margin = 2.0 * tolerance.along(inward, reach);
            [inward.x, inward.y, inward.z, margin - inward.dot(corners[k])]
        })
    }

    /// Whether this face, which coincides with the one that `cell` is a part of, covers that cell. Its edges count as wider by the tolerance.
    pub fn cover(&self, cell: &[DVec3], tolerance: Tolerance) -> Cover {
        let Self::Triangle { corners, normal } = self else { return Cover::All };
        let reach = self.reach();
        let mut covers_all = true;
        for k in 0..3 {
            let inward = normal.cross(corners[(k + 1) % 3] - corners[k]).normalize_or_zero();
            let margin = 2.0 * tolerance.along(inward, reach);
            let depth = |p: &DVec3| inward.dot(*p - corners[k]) + margin;
            if cell.iter().all(|p| depth(p) < 0.0) {
                return Cover::Nothing;
            }
            covers_all &= cell.iter().all(|p| depth(p) >= 0.0);
        }
        if covers_all {
            return Cover::All;
        }
        // For triangular cells, also test whether an edge of the cell separates the two.
        if let [a, b, c] = *cell {
            let up = (b - a).cross(c - a);
            for (start, end) in [(a, b), (b, c), (c, a)] {
                let inward = up.cross(end - start).normalize_or_zero();
                let margin = 2.0 * tolerance.along(inward, reach);
                if corners.iter().all(|p| inward.dot(*p - start) < -margin) {
                    return Cover::Nothing;
                }
            }
        }
        Cover::Part
    }
}

/// Whether the edge from corner `k` of a face to `end` lies on that face, some way from the corner on.
fn is_along(end: DVec3, face: &[DVec3; 3], k: usize, margin: f64) -> bool {
    let corner = face[k];
    let (p, q) = (face[(k + 1) % 3] - corner, face[(k + 2) % 3] - corner);
    // At half the distance to the third edge, or to the end if that is nearer, the face is still there.
    let reach = (end - corner).length().min(p.cross(q).length() / p.distance(q)) / 2.0;
    let point = corner + (end - corner).normalize_or_zero() * reach;
    // A point within a few tolerances of the corner cannot be told from it.
    reach > 4.0 * margin && closest_point(*face, point).distance(point) <= margin
}

/// Whether `other` coincides with `face`; if so, whether with the same normal.
pub fn coincides(geometry: &Geometry, face: PrimitiveId, other: PrimitiveId) -> Option<bool> {
    let tolerance = Tolerance::between(geometry, geometry.object_of(face), geometry.object_of(other));
    match Face::of(geometry, face).relation(&Face::of(geometry, other), tolerance) {
        Some(Relation::Coincides { same }) => Some(same),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight roundings of a length of 1.
    const TIGHT: Tolerance = Tolerance { length: 1.0, least: 1e-12 };

    fn face(corners: [[f64; 3]; 3]) -> Face {
        let corners = corners.map(DVec3::from);
        Face::Triangle { corners, normal: (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero() }
    }

    fn flat() -> Face {
        face([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    fn relation(other: [[f64; 3]; 3]) -> Option<Relation> {
        flat().relation(&face(other), TIGHT)
    }

    #[test]
    fn triangles_that_cross_touch_and_miss() {
        let [through, resting] = [true, false].map(|through| Some(Relation::Crosses { through }));
        // Through the middle, wholly inside the outline: a small object pokes through a large face.
        assert_eq!(relation([[0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), through);
        // With a corner, and with an edge, resting on the inside.
        assert_eq!(relation([[0.2, 0.2, 0.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), resting);
        assert_eq!(relation([[0.2, 0.2, 0.0], [0.3, 0.2, 0.0], [0.2, 0.3, 1.0]]), resting);
        // At a corner, along an edge, across an edge from outside.
        assert_eq!(relation([[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0]]), Some(Relation::Touches));
        assert_eq!(relation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 1.0]]), Some(Relation::Touches));
        // Beside it and above it.
        assert_eq!(relation([[1.2, 0.2, -1.0], [1.3, 0.2, 1.0], [1.2, 0.3, 1.0]]), None);
        assert_eq!(relation([[0.2, 0.2, 1e-6], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), None);
        assert_eq!(relation([[0.0, 0.0, 1e-6], [1.0, 0.0, 1e-6], [0.0, 1.0, 1e-6]]), None);
    }

    #[test]
    fn triangles_in_one_plane() {
        let same = Some(Relation::Coincides { same: true });
        let opposed = Some(Relation::Coincides { same: false });
        assert_eq!(relation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), same);
        assert_eq!(relation([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), opposed);
        assert_eq!(relation([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [0.0, 5.0, 0.0]]), same);
        assert_eq!(relation([[0.1, 0.1, 0.0], [0.2, 0.1, 0.0], [0.1, 0.2, 0.0]]), same);
        // Neighbours that share an edge or a corner, and one farther away.
        assert_eq!(relation([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]), Some(Relation::Touches));
        assert_eq!(relation([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), Some(Relation::Touches));
        assert_eq!(relation([[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]), None);
    }

    #[test]
    fn spheres_and_triangles() {
        let ball = |x: f64, z: f64, radius: f64| Face::Sphere(Sphere { center: DVec3::new(x, 0.2, z), radius });
        assert_eq!(flat().relation(&ball(0.2, 0.5, 0.6), TIGHT), Some(Relation::Crosses { through: true }));
        assert_eq!(flat().relation(&ball(0.2, 0.5, 0.4), TIGHT), None);
        assert_eq!(flat().relation(&ball(0.2, 0.0, 5.0), TIGHT), None);
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(0.0, 0.0, 1.0), TIGHT), Some(Relation::Coincides { same: true }));
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(0.0, 0.0, 1.0 + 1e-6), TIGHT), None);
        assert_eq!(
            ball(0.0, 0.0, 1.0).relation(&ball(1.5, 0.0, 1.0), TIGHT),
            Some(Relation::Crosses { through: true })
        );
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(2.5, 0.0, 1.0), TIGHT), None);
    }

    #[test]
    fn how_much_is_covered() {
        let cell = |size: f64, x: f64| {
            [DVec3::new(x, 0.1, 0.0), DVec3::new(x + size, 0.1, 0.0), DVec3::new(x, 0.1 + size, 0.0)]
        };
        assert_eq!(flat().cover(&cell(0.1, 0.1), TIGHT), Cover::All);
        assert_eq!(flat().cover(&cell(3.0, 0.1), TIGHT), Cover::Part);
        assert_eq!(flat().cover(&cell(0.1, 2.0), TIGHT), Cover::Nothing);
        assert_eq!(flat().cover(&[DVec3::new(1.0, 0.0, 0.0)], TIGHT), Cover::All);
    }
}
