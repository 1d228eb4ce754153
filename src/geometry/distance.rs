//! How far a point lies from a surface, and how far that surface may lie from where it was meant to be.

use glam::DVec3;

use super::geometry::Geometry;
use super::ray::PrimitiveId;
use super::triangle;

impl Geometry {
    /// Distance from `point` (local coordinates) to a primitive, ≥ 0.
    pub fn distance(&self, primitive: PrimitiveId, point: DVec3) -> f64 {
        match self.sphere(primitive) {
            Some(sphere) => (point.distance(sphere.center) - sphere.radius).abs(),
            None => closest_point(self.corners(primitive), point).distance(point),
        }
    }

    /// Bound for the distance between a primitive and the surface that it stands for, from the rounding of its numbers: of vertices to f32,
    /// which counts only across the surface, and of arithmetic in f64, before and after the local origin was subtracted, with points about as
    /// far from it.
    pub fn rounding(&self, primitive: PrimitiveId) -> f64 {
        let origin = self.origin.abs().max_element();
        if let Some(sphere) = self.sphere(primitive) {
            return ROUNDINGS * f64::EPSILON * (sphere.center.abs().max_element() + sphere.radius + origin);
        }
        let corners = self.corners(primitive);
        let normal = triangle::area_vector(corners).normalize_or_zero();
        let largest = corners.into_iter().fold(DVec3::ZERO, |largest, p| largest.max(p.abs()));
        let of_vertices = f64::from(f32::EPSILON) * normal.abs().dot(largest);
        of_vertices + ROUNDINGS * f64::EPSILON * (largest.max_element() + origin)
    }
}

/// Transforming, subtracting and projecting a point costs no more roundings in f64.
const ROUNDINGS: f64 = 16.0;

/// The point of a triangle nearest to `p`, by the region of the triangle's plane that it lies over (Ericson, Real-Time Collision
/// Detection, section 5.1.5).
pub fn closest_point([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        return b + (c - b) * (along / (along + back));
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + ab * (vb / sum) + ac * (vc / sum) } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Mesh, Part, uniform_direction};

    /// Against the least distance to a dense set of points of the triangle, over all seven regions of its plane.
    #[test]
    fn the_nearest_point_of_a_triangle() {
        let triangle = [DVec3::new(0.2, 0.1, 0.0), DVec3::new(1.0, 0.3, 0.4), DVec3::new(0.1, 0.9, -0.3)];
        let point_at = |v: f64, w: f64| triangle[0] * (1.0 - v - w) + triangle[1] * v + triangle[2] * w;
        let mut regions = [0; 3];
        for k in 0..400 {
            let (i, j) = (f64::from(k % 20), f64::from(k / 20));
            let (v, w) = (i / 8.0 - 0.75, j / 8.0 - 0.75);
            let height = ((k % 7) as f64 - 3.0) * 0.1;
            let p = point_at(v, w) + triangle::area_vector(triangle).normalize() * height;
            let nearest = closest_point(triangle, p).distance(p);
            let steps = 300;
            let dense = (0..=steps)
                .flat_map(|a| (0..=steps - a).map(move |b| (a, b)))
                .map(|(a, b)| point_at(f64::from(a) / f64::from(steps), f64::from(b) / f64::from(steps)).distance(p))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= dense + 1e-15 && dense <= nearest + 4e-3, "at ({v}, {w}): {nearest}, {dense}");
            regions[usize::from(v < 0.0) + usize::from(w < 0.0)] += 1;
        }
        assert!(regions.iter().all(|&count| count > 20));
    }

    #[test]
    fn a_degenerate_triangle_is_as_far_as_its_corner() {
        let a = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(closest_point([a; 3], DVec3::ZERO), a);
    }

    #[test]
    fn rounding_counts_across_the_surface() {
        let quad = |normal_axis: usize, height: f64| {
            let mut positions =
                vec![DVec3::new(-1e5, -1e5, -1e5), DVec3::new(1e5, 1e5, -1e5), DVec3::new(1e5, -1e5, 1e5)];
            positions.iter_mut().for_each(|p| p[normal_axis] = height);
            let mesh = Mesh { positions, normals: Vec::new(), triangles: vec![[0, 1, 2]], uvs: Vec::new() };
            Geometry::build(&[Part::Mesh { mesh, smooth: false }])
        };
        // A wide floor at height 0 lies where it was put; one at 0.35 does not, by some 6e-9.
        assert!(quad(1, 0.0).rounding(0) < 1e-9);
        let shelf = quad(1, 0.35);
        let meant = DVec3::new(9.0, 0.35, -9.0);
        assert!(shelf.distance(0, meant) > 1e-9);
        assert!((shelf.distance(0, meant)..1e-7).contains(&shelf.rounding(0)));
    }

    #[test]
    fn from_either_side_of_a_sphere() {
        let geometry = Geometry::build(&[Part::Sphere { center: DVec3::X, radius: 2.0 }]);
        for k in 0..10 {
            let direction = uniform_direction([f64::from(k) / 10.0, 0.3]);
            for r in [0.0, 1.5, 2.0, 7.0] {
                let point = DVec3::X + direction * r - geometry.origin;
                assert!((geometry.distance(0, point) - (r - 2.0).abs()).abs() < 1e-14);
            }
        }
    }
}
