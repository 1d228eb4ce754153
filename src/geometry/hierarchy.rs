//! A binary tree over triangles in the order of a Morton curve: quicker to build than the tree that rays walk, and good enough for
//! questions that are asked once.
//!
//! Leaves hold up to [`LEAF`] triangles that follow each other on the curve; every level above joins two neighbours. So a node is
//! known by its level and its index, and two nodes of one level that are not the same share nothing.

use glam::DVec3;
use rayon::prelude::*;

/// Triangles in a leaf.
pub(super) const LEAF: usize = 8;

/// Bits of the curve for each axis.
const CURVE_BITS: u32 = 21;

/// Lowest and highest coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub min: DVec3,
    pub max: DVec3,
}

impl Extent {
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |e, p| Self { min: e.min.min(p), max: e.max.max(p) })
    }

    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Hierarchy {
    /// Triangle indices along the curve.
    pub order: Vec<u32>,
    /// Boxes of the nodes, leaves first; the last level is the root alone. No level where there are no triangles.
    pub levels: Vec<Vec<Extent>>,
}

impl Hierarchy {
    /// Over `count` triangles, whose corners are all finite.
    pub fn build(count: usize, corners: impl Fn(u32) -> [DVec3; 3] + Sync) -> Self {
        let all = (0..count as u32)
            .into_par_iter()
            .map(|face| Extent::of(corners(face)))
            .reduce(|| Extent::EMPTY, Extent::union);
        let cells = f64::from((1_u32 << CURVE_BITS) - 1);
        // A flat mesh has no extent along one axis: all its cells there are 0.
        let scale = (all.max - all.min).recip() * cells;
        let scale = DVec3::select(scale.is_finite_mask(), scale, DVec3::ZERO);
        let mut keys: Vec<(u64, u32)> = (0..count as u32)
            .into_par_iter()
            .map(|face| {
                let [a, b, c] = corners(face);
                let cell = ((a + b + c) / 3.0 - all.min) * scale;
                let [x, y, z] = cell.to_array().map(|x| spread(x as u64));
                (x | y << 1 | z << 2, face)
            })
            .collect();
        keys.par_sort_unstable();
        let order: Vec<u32> = keys.into_iter().map(|(_, face)| face).collect();

        let mut levels: Vec<Vec<Extent>> = Vec::new();
        if count > 0 {
            levels.push(
                order.par_chunks(LEAF).map(|faces| Extent::of(faces.iter().flat_map(|&face| corners(face)))).collect(),
            );
        }
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let next = below.chunks(2).map(|pair| pair.iter().copied().fold(Extent::EMPTY, Extent::union)).collect();
            levels.push(next);
        }
        Self { order, levels }
    }

    /// Triangles of a leaf.
    pub fn leaf(&self, index: usize) -> &[u32] {
        &self.order[self.leaf_range(index)]
    }

    /// Where the triangles of a leaf stand in the order.
    pub fn leaf_range(&self, index: usize) -> std::ops::Range<usize> {
        index * LEAF..self.order.len().min((index + 1) * LEAF)
    }

    /// Indices, one level below, of the children of the node `index` of `level` (> 0).
    pub fn children(&self, level: usize, index: usize) -> std::ops::Range<usize> {
        2 * index..self.levels[level - 1].len().min(2 * index + 2)
    }
}

/// The lowest 21 bits, two zeros between each and the next.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread(0b1011), 0b1_000_001_001);
        assert_eq!(spread(u64::MAX), 0x1249_2492_4924_9249);
    }

    /// Every triangle lies in exactly one leaf, and every node's box holds what is below it.
    #[test]
    fn nothing_is_lost() {
        for count in [0, 1, 3, 4, 5, 37, 1000] {
            let corners = |face: u32| {
                let p = DVec3::new(f64::from(face * 37 % 101), f64::from(face * 53 % 89), 0.0);
                [p, p + DVec3::X, p + DVec3::Y]
            };
            let tree = Hierarchy::build(count, corners);
            let mut seen = tree.order.clone();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..count as u32));
            assert_eq!(tree.levels.last().map_or(1, Vec::len), 1);
            for level in 1..tree.levels.len() {
                let mut below = 0;
                for (index, node) in tree.levels[level].iter().enumerate() {
                    for child in tree.children(level, index) {
                        let inner = tree.levels[level - 1][child];
                        assert!(node.min.cmple(inner.min).all() && node.max.cmpge(inner.max).all());
                        below += 1;
                    }
                }
                assert_eq!(below, tree.levels[level - 1].len());
            }
        }
    }
}
