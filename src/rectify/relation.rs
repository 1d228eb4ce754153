//! How two triangles meet: apart, touching, crossing, or in one plane. Closed separating-axis tests in f64.

use glam::DVec3;

use super::tolerance::Tolerance;

/// Normals of coincident faces differ by less than the angle of this cosine.
const PARALLEL: f64 = 0.9;

/// How another primitive meets a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// It may reach into the face's interior; `through` if it certainly goes through it.
    Crosses { through: bool },
    /// It meets the face at the face's own edges and corners only.
    Touches,
    /// It lies in the face's plane (or is the same sphere) and shares a part of it; whether with the same normal.
    Coincides { same: bool },
}

/// Two triangles, `f` and `t`, with their unit normals.
pub(super) struct TrianglePair<'a> {
    pub f: &'a [DVec3; 3],
    pub nf: DVec3,
    pub t: &'a [DVec3; 3],
    pub nt: DVec3,
    /// Largest magnitude of each coordinate of both.
    pub reach: DVec3,
    pub tolerance: Tolerance,
}

impl TrianglePair<'_> {
    fn allowance(&self, axis: DVec3) -> f64 {
        self.tolerance.along(axis, self.reach)
    }

    /// How `t` meets `f`; `None` where it does not.
    pub fn relation(&self) -> Option<Relation> {
        let heights = self.t.map(|p| self.nf.dot(p - self.f[0]));
        let tolerance = self.allowance(self.nf);
        if heights.iter().all(|h| *h > tolerance) || heights.iter().all(|h| *h < -tolerance) {
            return None;
        }
        let heights_of_f = self.f.map(|p| self.nt.dot(p - self.t[0]));
        let tolerance_t = self.allowance(self.nt);
        if heights_of_f.iter().all(|h| *h > tolerance_t) || heights_of_f.iter().all(|h| *h < -tolerance_t) {
            return None;
        }
        let edges = |p: &[DVec3; 3]| [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
        let (edges_f, edges_t) = (edges(self.f), edges(self.t));
        for a in edges_f {
            if edges_t.iter().any(|b| self.gap_along(a.cross(*b), a.length() * b.length()) > 0.0) {
                return None;
            }
        }
        // For triangles in one plane the axes above are all normal to it, so the edges' normals in the plane are tested.
        let is_flat = |heights: &[f64; 3], tolerance: f64| heights.iter().all(|h| h.abs() <= tolerance);
        let larger = |a: &[DVec3; 3], b: &[DVec3; 3]| {
            let size = |p: &[DVec3; 3]| edges(p).iter().map(|e| e.length_squared()).fold(0.0, f64::max);
            size(a) >= size(b)
        };
        let cos = self.nf.dot(self.nt);
        let coplanar =
            if larger(self.f, self.t) { is_flat(&heights, tolerance) } else { is_flat(&heights_of_f, tolerance_t) };
        if coplanar && cos.abs() > PARALLEL {
            let (mut shares_area, mut is_apart) = (true, false);
            for axis in edges_f.map(|e| e.cross(self.nf)).into_iter().chain(edges_t.map(|e| e.cross(self.nt))) {
                let gap = self.gap_along(axis, 1.0);
                is_apart |= gap > 0.0;
                shares_area &= gap < -3.0 * self.allowance(axis.normalize_or_zero());
            }
            return if is_apart {
                None
            } else if shares_area {
                Some(Relation::Coincides { same: cos > 0.0 })
            } else {
                Some(Relation::Touches)
            };
        }
        let is_on_both_sides =
            |h: &[f64; 3], tolerance: f64| h.iter().any(|h| *h > tolerance) && h.iter().any(|h| *h < -tolerance);
        let through = is_on_both_sides(&heights, tolerance) && is_on_both_sides(&heights_of_f, tolerance_t);
        Some(if self.reaches_interior(&heights, tolerance) { Relation::Crosses { through } } else { Relation::Touches })
    }

    /// Distance of the two triangles' shadows on an axis beyond the tolerance: positive where the axis separates them. An axis too short
    /// for its `size` says nothing.
    fn gap_along(&self, axis: DVec3, size: f64) -> f64 {
        let length = axis.length();
        if length <= 1e-9 * size || length == 0.0 {
            return f64::NEG_INFINITY;
        }
        let axis = axis / length;
        let shadow = |p: &[DVec3; 3]| {
            let [a, b, c] = p.map(|p| axis.dot(p - self.f[0]));
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ((f_min, f_max), (t_min, t_max)) = (shadow(self.f), shadow(self.t));
        (t_min - f_max).max(f_min - t_max) - self.allowance(axis)
    }

    /// Whether `t` meets the plane of `f` within `f`, farther than the tolerance from the edges of `f`.
    fn reaches_interior(&self, heights: &[f64; 3], tolerance: f64) -> bool {
        // Where t meets the plane: corners in it, and points where edges go through.
        let mut points: Vec<DVec3> = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (heights[k], heights[(k + 1) % 3]);
            let (p, q) = (self.t[k], self.t[(k + 1) % 3]);
            if a.abs() <= tolerance {
                points.push(p);
            }
            if (a < -tolerance && b > tolerance) || (a > tolerance && b < -tolerance) {
                points.push(p + (q - p) * (a / (a - b)));
            }
        }
        let inward: [(DVec3, DVec3); 3] = std::array::from_fn(|k| {
            let inward = self.nf.cross(self.f[(k + 1) % 3] - self.f[k]).normalize_or_zero();
            (self.f[k] + inward * (2.0 * self.allowance(inward)), inward)
        });
        let reaches = |p: DVec3, q: DVec3| {
            let (mut from, mut to) = (0.0f64, 1.0f64);
            for (start, inward) in inward {
                let (a, b) = (inward.dot(p - start), inward.dot(q - start));
                if a < 0.0 && b < 0.0 {
                    return false;
                } else if a < 0.0 {
                    from = from.max(a / (a - b));
                } else if b < 0.0 {
                    to = to.min(a / (a - b));
                }
            }
            from <= to
        };
        match points[..] {
            [] => false,
            [p] => reaches(p, p),
            _ => (0..points.len()).any(|i| (i + 1..points.len()).any(|j| reaches(points[i], points[j]))),
        }
    }
}
