//! A triangle mesh in object space.

use glam::DVec3;

/// Indexed triangles, counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Object space; every coordinate finite.
    pub positions: Vec<DVec3>,
    /// Empty, or one unit normal per position.
    pub normals: Vec<DVec3>,
    /// Indices into `positions`, all in range.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Enclosed volume by the divergence theorem: positive when the faces look outward, meaningful for closed meshes.
    pub fn signed_volume(&self) -> f64 {
        // Relative to one vertex, so that a mesh far from the origin keeps its digits.
        let origin = self.positions.first().copied().unwrap_or_default();
        let corner = |i: u32| self.positions[i as usize] - origin;
        self.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f64>() / 6.0
    }

    /// Turns every face over.
    pub fn reverse(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
    }

    /// Fills in vertex normals, each the angle-weighted mean of the faces around its vertex (Thürmer and Wüthrich 1998), where the
    /// mesh has none.
    pub fn ensure_normals(&mut self) {
        if self.normals.len() == self.positions.len() {
            return;
        }
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            let p = triangle.map(|i| self.positions[i as usize]);
            let face = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
            for corner in 0..3 {
                let to_next = p[(corner + 1) % 3] - p[corner];
                let to_previous = p[(corner + 2) % 3] - p[corner];
                let angle = to_next.angle_between(to_previous);
                if angle.is_finite() {
                    normals[triangle[corner] as usize] += face * angle;
                }
            }
        }
        self.normals = normals.into_iter().map(|n| n.normalize_or(DVec3::Y)).collect();
    }
}
