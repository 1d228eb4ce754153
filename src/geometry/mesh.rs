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
    /// Texture coordinates (u, v) at the corners of each triangle, in their order; v goes up the image. Empty where there are none.
    pub uvs: Vec<CornerUvs>,
}

/// Texture coordinates at the three corners of a triangle.
pub type CornerUvs = [[f32; 2]; 3];

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
        self.turn_triangles();
        self.normals.iter_mut().for_each(|n| *n = -*n);
    }

    /// Turns the order of every face's corners about, and leaves the normals.
    pub fn turn_triangles(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.uvs.iter_mut().for_each(|uv| uv.swap(1, 2));
    }

    /// Whether each triangle has texture coordinates.
    pub fn has_uvs(&self) -> bool {
        !self.uvs.is_empty() && self.uvs.len() == self.triangles.len()
    }

    /// The same without texture coordinates.
    pub fn without_uvs(&self) -> Self {
        let Self { positions, normals, triangles, uvs: _ } = self;
        Self { positions: positions.clone(), normals: normals.clone(), triangles: triangles.clone(), uvs: Vec::new() }
    }

    /// The same surface with one pair of texture coordinates for each position, as most files have them: positions at which triangles
    /// differ are split. Pairs are empty where the mesh has none.
    pub fn with_uv_of_positions(&self) -> (Self, Vec<[f32; 2]>) {
        if !self.has_uvs() {
            return (self.without_uvs(), Vec::new());
        }
        const UNUSED: u32 = u32::MAX;
        // The copies of each position, as a list that is linked from the position's number.
        let mut first = vec![UNUSED; self.positions.len()];
        let mut next: Vec<u32> = Vec::new();
        let (mut mesh, mut pairs) = (Self::default(), Vec::new());
        let has_normals = self.normals.len() == self.positions.len();
        for (triangle, corners) in self.triangles.iter().zip(&self.uvs) {
            let triangle = [0, 1, 2].map(|k| {
                let (old, uv) = (triangle[k] as usize, corners[k]);
                let mut copy = first[old];
                while copy != UNUSED && pairs[copy as usize] != uv {
                    copy = next[copy as usize];
                }
                if copy == UNUSED {
                    copy = mesh.positions.len() as u32;
                    mesh.positions.push(self.positions[old]);
                    mesh.normals.extend(has_normals.then(|| self.normals[old]));
                    pairs.push(uv);
                    next.push(std::mem::replace(&mut first[old], copy));
                }
                copy
            });
            mesh.triangles.push(triangle);
        }
        (mesh, pairs)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_split_where_texture_coordinates_differ() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        let normals = vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X];
        let triangles = vec![[0, 1, 2], [2, 1, 3]];
        // The triangles agree at position 1 and differ at 2.
        let uvs = vec![[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0.5, 1.0], [1.0, 0.0], [1.0, 1.0]]];
        let mesh = Mesh { positions, normals, triangles, uvs };
        let (split, pairs) = mesh.with_uv_of_positions();
        assert_eq!((split.positions.len(), pairs.len()), (5, 5));
        for (index, (old, new)) in mesh.triangles.iter().zip(&split.triangles).enumerate() {
            for k in 0..3 {
                let (old, new) = (old[k] as usize, new[k] as usize);
                assert_eq!(split.positions[new], mesh.positions[old]);
                assert_eq!(split.normals[new], mesh.normals[old]);
                assert_eq!(pairs[new], mesh.uvs[index][k]);
            }
        }
        assert_eq!(split.triangles[0][1], split.triangles[1][1]);
        let mut turned = mesh.clone();
        turned.reverse();
        assert_eq!((turned.triangles[1], turned.uvs[1]), ([2, 3, 1], [[0.5, 1.0], [1.0, 1.0], [1.0, 0.0]]));
        assert_eq!(mesh.without_uvs().with_uv_of_positions().1, Vec::<[f32; 2]>::new());
    }
}
