//! A node of the tree, as it lies in memory.

use glam::Vec3;

use super::bounds::Bounds;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Set in references to leaves; the rest is a slot.
pub(super) const LEAF: u32 = 1 << 31;

/// Growth of boxes, relative to the largest coordinate of each: covers the rounding of distances to its sides, as
/// [`super::walk::BoxRay`] proves.
pub(super) const BOX_MARGIN: f32 = 1.0 / (1 << 21) as f32;

/// Primitives of more than one object.
pub(super) const MANY: u32 = u32::MAX;

/// Eight children. Unused ones have boxes that nothing meets.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lowest coordinates along x, highest ones along x, then the same of y and z: `[row][child]`.
    pub(super) rows: [[f32; WIDTH]; 6],
    /// Node index, or leaf slot with [`LEAF`].
    pub(super) children: [u32; WIDTH],
    /// For each child the object that all primitives below it belong to; [`MANY`] if there are several.
    pub(super) objects: [u32; WIDTH],
}

impl Node {
    /// No child.
    pub(super) const EMPTY: Self = {
        let (above, below) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { rows: [above, below, above, below, above, below], children: [LEAF; WIDTH], objects: [MANY; WIDTH] }
    };

    /// Gives a child the box `bounds`, grown by the margin.
    pub(super) fn set_box(&mut self, lane: usize, bounds: Bounds) {
        let margin = bounds.min.abs().max(bounds.max.abs()).max_element() * BOX_MARGIN;
        for axis in 0..3 {
            self.rows[2 * axis][lane] = bounds.min[axis] - margin;
            self.rows[2 * axis + 1][lane] = bounds.max[axis] + margin;
        }
    }

    /// The children that there are, with their boxes.
    pub(super) fn boxes(&self) -> impl Iterator<Item = (usize, Bounds)> + '_ {
        (0..WIDTH).filter(|lane| self.is_used(*lane)).map(|lane| {
            let corner = |first: usize| Vec3::from_array([0, 2, 4].map(|row| self.rows[row + first][lane]));
            (lane, Bounds { min: corner(0), max: corner(1) })
        })
    }

    pub(super) fn is_used(&self, lane: usize) -> bool {
        self.rows[0][lane] <= self.rows[1][lane]
    }
}
