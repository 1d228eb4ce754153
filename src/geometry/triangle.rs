//! Rays against triangles, eight at a time, watertight (Woop, Benthin and Wald 2013).
//!
//! Vertices are f32, the ray and all arithmetic f64. Neighbouring triangles compute the edge function of a shared edge from the same
//! numbers with opposite sign, so no ray slips between them. A ray that goes exactly through an edge or a corner is taken to be moved aside
//! by an infinitesimal amount, the same for all triangles (simulation of simplicity, Edelsbrunner and Mücke 1990): of the triangles there
//! it meets as many as a ray close by would, so that counting crossings counts right.

use std::hint::select_unpredictable;

use glam::{DVec3, Vec3};

use super::ray::{NO_PRIMITIVE, PrimitiveId, Ray};

/// Triangles in a pack.
pub const PACK: usize = 8;

/// Eight triangles, structure of arrays. Unused lanes are [`NO_PRIMITIVE`] and NaN, which nothing meets.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct TrianglePack {
    /// `[corner][axis][lane]`
    pub(super) corners: [[[f32; PACK]; 3]; 3],
    pub ids: [PrimitiveId; PACK],
}

impl TrianglePack {
    pub const EMPTY: Self = Self { corners: [[[f32::NAN; PACK]; 3]; 3], ids: [NO_PRIMITIVE; PACK] };

    pub fn set(&mut self, lane: usize, id: PrimitiveId, triangle: [Vec3; 3]) {
        self.ids[lane] = id;
        for (corner, position) in triangle.iter().enumerate() {
            for axis in 0..3 {
                self.corners[corner][axis][lane] = position[axis];
            }
        }
    }
}

/// A ray, sheared so that it runs along the axis in which its direction is longest.
#[derive(Debug, Clone, Copy)]
pub struct ShearedRay {
    /// Axes: two across, then the longest; the first two are swapped where needed to keep the winding.
    pub(super) axes: [usize; 3],
    pub(super) origin: [f64; 3],
    pub(super) shear: [f64; 3],
}

impl ShearedRay {
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        // Without branches: which axis it is can hardly be foretold.
        let longest = select_unpredictable(x > y && x > z, 0, 2 - usize::from(y > z));
        let [next, last] = [[1, 2, 0][longest], [2, 0, 1][longest]];
        let is_swapped = d[longest] < 0.0;
        let (x, y) = (select_unpredictable(is_swapped, last, next), select_unpredictable(is_swapped, next, last));
        let origin = ray.origin.to_array();
        Self {
            axes: [x, y, longest],
            origin: [origin[x], origin[y], origin[longest]],
            shear: [d[x] / d[longest], d[y] / d[longest], 1.0 / d[longest]],
        }
    }
}

impl ShearedRay {
    /// Decides a ray through an edge or corner: whether it meets the triangle when it is moved by (ε, ε²) across its direction.
    #[cold]
    fn is_met_aside(&self, pack: &TrianglePack, lane: usize, edges: [f64; 3], is_front: bool) -> bool {
        let [kx, ky, kz] = self.axes;
        let corners: [[f64; 2]; 3] = std::array::from_fn(|corner| {
            let c = &pack.corners[corner];
            let depth = f64::from(c[kz][lane]) - self.origin[2];
            let across = |axis: usize, k: usize| (f64::from(c[axis][lane]) - self.origin[k]) - self.shear[k] * depth;
            [across(kx, 0), across(ky, 1)]
        });
        // The edge opposite each corner, in the order in which its function was computed.
        [(2, 1), (0, 2), (1, 0)].into_iter().zip(edges).all(|((a, b), edge)| {
            let [(xa, ya), (xb, yb)] = [a, b].map(|k: usize| (corners[k][0], corners[k][1]));
            let sign = if edge != 0.0 {
                edge
            } else if ya != yb {
                ya - yb
            } else {
                xb - xa
            };
            (sign > 0.0) == is_front && sign != 0.0
        })
    }
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    pub t: f64,
    /// Weights of the second and third corner.
    pub barycentric: [f64; 2],
    pub is_front: bool,
}

/// Edge functions of the triangles of a pack and distances at which the ray's line meets their planes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct PackTest {
    /// Edge functions opposite each corner: `[corner][lane]`.
    pub edges: [[f64; PACK]; 3],
    /// Their sums: positive seen from the front.
    pub determinants: [f64; PACK],
    pub distances: [f64; PACK],
}

impl PackTest {
    pub const EMPTY: Self = Self { edges: [[0.0; PACK]; 3], determinants: [0.0; PACK], distances: [0.0; PACK] };

    /// Calls `found` for every triangle of `met`, unless the ray goes through an edge or corner and is taken to pass beside it.
    #[inline(always)]
    pub fn for_each(
        &self,
        mut met: u32,
        ray: &ShearedRay,
        pack: &TrianglePack,
        mut found: impl FnMut(PrimitiveId, TriangleHit),
    ) {
        while met != 0 {
            let lane = met.trailing_zeros() as usize % PACK;
            met &= met - 1;
            let [u, v, w] = self.edges.map(|edge| edge[lane]);
            let determinant = self.determinants[lane];
            if (u == 0.0 || v == 0.0 || w == 0.0) && !ray.is_met_aside(pack, lane, [u, v, w], determinant > 0.0) {
                continue;
            }
            let barycentric = [v / determinant, w / determinant];
            found(pack.ids[lane], TriangleHit { t: self.distances[lane], barycentric, is_front: determinant > 0.0 });
        }
    }
}

/// Area vector of a triangle: along its outward normal, as long as twice its area.
#[inline]
pub fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::kernel::{Kernel, Portable};

    const TRIANGLE: [Vec3; 3] = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];

    fn meet(ray: &Ray, pack: &TrianglePack, found: impl FnMut(PrimitiveId, TriangleHit)) {
        let ray = ShearedRay::new(ray);
        let mut test = PackTest::EMPTY;
        let met = Portable::meet_triangles(&ray, pack, f64::NEG_INFINITY, f64::INFINITY, &mut test);
        test.for_each(met, &ray, pack, found);
    }

    fn hit(origin: DVec3, direction: DVec3) -> Option<TriangleHit> {
        let mut pack = TrianglePack::EMPTY;
        pack.set(1, 7, TRIANGLE);
        let mut result = None;
        meet(&Ray::new(origin, direction), &pack, |id, hit| {
            assert_eq!(id, 7);
            result = Some(hit);
        });
        result
    }

    /// Its normal is +z: seen from above it is counter-clockwise.
    #[test]
    fn facing_in_all_six_directions() {
        for (swap, sign) in (0..3).flat_map(|k| [(k, 1.0), (k, -1.0)]) {
            let turn = |p: DVec3| match swap {
                0 => p,
                1 => DVec3::new(p.z, p.x, p.y),
                _ => DVec3::new(p.y, p.z, p.x),
            };
            let mut pack = TrianglePack::EMPTY;
            pack.set(0, 0, TRIANGLE.map(|p| turn(p.as_dvec3()).as_vec3()));
            let ray = Ray::new(turn(DVec3::new(0.25, 0.25, sign * 2.0)), turn(DVec3::new(0.0, 0.0, -sign)));
            let mut seen = None;
            meet(&ray, &pack, |_, hit| seen = Some(hit));
            let seen = seen.expect("the triangle is straight ahead");
            assert_eq!((seen.t, seen.is_front), (2.0, sign > 0.0), "axis {swap}, sign {sign}");
            assert_eq!(seen.barycentric, [0.25, 0.25]);
        }
    }

    #[test]
    fn negative_zero_and_axis_parallel_directions_hit() {
        assert!(hit(DVec3::new(0.2, 0.2, 1.0), DVec3::new(-0.0, -0.0, -1.0)).is_some());
        assert!(hit(DVec3::new(0.2, 0.2, -1.0), DVec3::new(-0.0, 0.0, 1.0)).is_some());
    }

    /// The triangles around a corner, seen along rays through it and through its edges: exactly one of them is met.
    #[test]
    fn rays_through_edges_and_corners_meet_one_triangle() {
        let rim: Vec<Vec3> = (0..6)
            .map(|k| (f64::from(k).sin() as f32, f64::from(k).cos() as f32))
            .map(|(y, x)| Vec3::new(x, y, 0.25))
            .collect();
        let count = |ray: &Ray| {
            let mut met = 0;
            for k in 0..6 {
                let mut pack = TrianglePack::EMPTY;
                // The angle from the last corner of the rim to the first is a little wider than the others.
                pack.set(k % PACK, k as u32, [Vec3::ZERO, rim[k], rim[(k + 1) % 6]]);
                meet(ray, &pack, |_, hit| met += if hit.is_front { 1 } else { 100 });
            }
            met
        };
        for direction in
            [DVec3::NEG_Z, DVec3::new(0.3, 0.1, -1.0), DVec3::new(-0.7, 0.2, -0.7), DVec3::new(0.0, 0.5, -1.0)]
        {
            let d = direction.normalize();
            assert_eq!(count(&Ray::new(-d * 4.0, d)), 1, "through the corner along {d}");
            for corner in &rim {
                // Exactly on an edge as far as the arithmetic can tell: half of a corner's coordinates.
                let at = corner.as_dvec3() * 0.5;
                assert_eq!(count(&Ray::new(at + DVec3::Z, DVec3::NEG_Z)), 1);
                assert_eq!(count(&Ray::new(at - DVec3::Z, DVec3::Z)), 100);
            }
        }
        assert!(hit(DVec3::new(-1.0, 0.2, 0.0), DVec3::X).is_none(), "edge-on");
        assert!(hit(DVec3::new(0.6, 0.6, 1.0), DVec3::NEG_Z).is_none());
    }
}
