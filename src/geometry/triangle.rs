//! Rays against triangles, four at a time, watertight (Woop, Benthin and Wald 2013).
//!
//! Vertices are f32, the ray and all arithmetic f64. Neighbouring triangles compute the edge function of a shared edge from the same
//! numbers with opposite sign, so no ray slips between them.

use glam::{DVec3, Vec3};

use super::ray::{NO_PRIMITIVE, PrimitiveId, Ray};

/// Triangles in a pack.
pub const PACK: usize = 4;

/// Four triangles, structure of arrays. Unused lanes are [`NO_PRIMITIVE`] and all zero, which nothing hits.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub struct TrianglePack {
    /// `[corner][axis][lane]`
    corners: [[[f32; PACK]; 3]; 3],
    pub ids: [PrimitiveId; PACK],
}

impl TrianglePack {
    pub const EMPTY: Self = Self { corners: [[[0.0; PACK]; 3]; 3], ids: [NO_PRIMITIVE; PACK] };

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
    axes: [usize; 3],
    origin: [f64; 3],
    shear: [f64; 3],
}

impl ShearedRay {
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let z = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            (x, y) = (y, x);
        }
        Self {
            axes: [x, y, z],
            origin: [ray.origin[x], ray.origin[y], ray.origin[z]],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]],
        }
    }
}

/// What [`intersect`] finds of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    pub t: f64,
    /// Weights of the second and third corner.
    pub barycentric: [f64; 2],
    pub is_front: bool,
}

/// Calls `found` for every triangle of the pack that the ray's *line* meets, at positive or negative distance.
#[inline(always)]
pub fn intersect(ray: &ShearedRay, pack: &TrianglePack, mut found: impl FnMut(PrimitiveId, TriangleHit)) {
    let [kx, ky, kz] = ray.axes;
    // Corners relative to the ray's origin, sheared: [corner][lane].
    let mut x = [[0.0f64; PACK]; 3];
    let mut y = [[0.0f64; PACK]; 3];
    let mut z = [[0.0f64; PACK]; 3];
    for corner in 0..3 {
        let c = &pack.corners[corner];
        for lane in 0..PACK {
            let depth = f64::from(c[kz][lane]) - ray.origin[2];
            x[corner][lane] = (f64::from(c[kx][lane]) - ray.origin[0]) - ray.shear[0] * depth;
            y[corner][lane] = (f64::from(c[ky][lane]) - ray.origin[1]) - ray.shear[1] * depth;
            z[corner][lane] = ray.shear[2] * depth;
        }
    }
    let mut edges = [[0.0f64; PACK]; 3];
    let mut hit = [false; PACK];
    for lane in 0..PACK {
        let u = x[2][lane] * y[1][lane] - y[2][lane] * x[1][lane];
        let v = x[0][lane] * y[2][lane] - y[0][lane] * x[2][lane];
        let w = x[1][lane] * y[0][lane] - y[1][lane] * x[0][lane];
        let smallest = u.min(v).min(w);
        let largest = u.max(v).max(w);
        // All of one sign, zero included: on the edge counts as inside. All zero: seen edge-on, its neighbours are hit instead.
        hit[lane] = (smallest >= 0.0) | (largest <= 0.0);
        edges[0][lane] = u;
        edges[1][lane] = v;
        edges[2][lane] = w;
    }
    for lane in 0..PACK {
        if !hit[lane] || pack.ids[lane] == NO_PRIMITIVE {
            continue;
        }
        let [u, v, w] = [edges[0][lane], edges[1][lane], edges[2][lane]];
        let determinant = u + v + w;
        if determinant == 0.0 {
            continue;
        }
        let t = (u * z[0][lane] + v * z[1][lane] + w * z[2][lane]) / determinant;
        found(
            pack.ids[lane],
            TriangleHit { t, barycentric: [v / determinant, w / determinant], is_front: determinant > 0.0 },
        );
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

    const TRIANGLE: [Vec3; 3] = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];

    fn hit(origin: DVec3, direction: DVec3) -> Option<TriangleHit> {
        let mut pack = TrianglePack::EMPTY;
        pack.set(1, 7, TRIANGLE);
        let mut result = None;
        intersect(&ShearedRay::new(&Ray::new(origin, direction)), &pack, |id, hit| {
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
            intersect(&ShearedRay::new(&ray), &pack, |_, hit| seen = Some(hit));
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

    #[test]
    fn edges_and_corners_belong_to_the_triangle_and_edge_on_misses() {
        assert!(hit(DVec3::new(0.5, 0.5, 1.0), DVec3::NEG_Z).is_some());
        assert!(hit(DVec3::new(0.0, 0.0, 1.0), DVec3::NEG_Z).is_some());
        assert!(hit(DVec3::new(-1.0, 0.2, 0.0), DVec3::X).is_none());
        assert!(hit(DVec3::new(0.6, 0.6, 1.0), DVec3::NEG_Z).is_none());
    }
}
