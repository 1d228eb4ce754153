//! Which faces of a mesh are neighbours, and sets of faces that are joined.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::{Geometry, PrimitiveId};

/// For each triangle of `range`, the triangles across its edges, by offset in the range; `u32::MAX` where an edge is not shared by
/// exactly two. Corners are the same where their coordinates are bit-equal.
pub fn neighbours(geometry: &Geometry, range: &Range<PrimitiveId>) -> Vec<[u32; 3]> {
    type Corner = [u32; 3];
    let bits = |p: glam::DVec3| -> Corner { (p + 0.0).as_vec3().to_array().map(f32::to_bits) };
    let mut edges: Vec<(Corner, Corner, u32)> = (range.clone())
        .into_par_iter()
        .flat_map_iter(|primitive| {
            let corners = geometry.corners(primitive).map(bits);
            let face = primitive - range.start;
            (0..3).map(move |k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                (a.min(b), a.max(b), face * 3 + k as u32)
            })
        })
        .collect();
    edges.par_sort_unstable();
    let mut neighbours = vec![[u32::MAX; 3]; range.len()];
    for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if let [(_, _, x), (_, _, y)] = *group {
            neighbours[(x / 3) as usize][(x % 3) as usize] = y / 3;
            neighbours[(y / 3) as usize][(y % 3) as usize] = x / 3;
        }
    }
    neighbours
}

/// Disjoint sets of faces (Tarjan 1975).
pub struct Sets {
    parents: Vec<u32>,
}

impl Sets {
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// The face that stands for the set of `face`: its smallest.
    pub fn find(&mut self, face: u32) -> u32 {
        let mut root = face;
        while self.parents[root as usize] != root {
            let parent = self.parents[root as usize];
            self.parents[root as usize] = self.parents[parent as usize];
            root = parent;
        }
        root
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_joined() {
        let mut sets = Sets::new(6);
        sets.join(4, 2);
        sets.join(5, 4);
        sets.join(1, 0);
        assert_eq!((0..6).map(|f| sets.find(f)).collect::<Vec<_>>(), [0, 0, 2, 3, 2, 2]);
    }
}
