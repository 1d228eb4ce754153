//! A node of the tree, as it lies in memory.

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

    pub(super) fn is_used(&self, lane: usize) -> bool {
        self.rows[0][lane] <= self.rows[1][lane]
    }
}
