//! The walk of a ray through a tree, the nearest child of each node first.
//!
//! What is still to be visited is kept in single numbers, *entries*: a distance's bits above a child. Distances are ≥ 0, so entries compare as
//! their distances do.

use std::hint::select_unpredictable;

use glam::DVec3;

use super::bvh::{BOX_MARGIN, LEAF, Node, Tree, WIDTH};
use super::kernel::Kernel;
use super::ray::Ray;
use super::triangle::TrianglePack;

/// Relative growth of the range in which boxes are met: covers the rounding of its ends.
const LIMIT_MARGIN: f32 = 1e-6;

/// Every entry is less than this.
pub(super) const NOTHING: u64 = (u32::MAX as u64) << 32;

/// Lies under all entries: a leaf that no tree has.
pub(super) const END: u64 = u32::MAX as u64;

/// A child at a distance (≥ 0).
#[inline(always)]
pub(super) fn entry(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

/// A ray as boxes are tested against it: in f32, from a point moved next to the tree, so that a far origin costs no precision.
///
/// The distance to a side at p is computed as p·i − o·i from the rounded reciprocal i of the direction's component and the product o·i, rounded
/// once. Let P be the largest coordinate of the box and O that of the (moved) origin. In space, the side then is off by
///
/// - |o|·2⁻²⁴ ≤ O·2⁻²⁴ for the rounding of o·i, and as much for that of what is added to it, so that the box is larger;
/// - |p|·2⁻²⁴ ≤ P·2⁻²⁴ for that of p·i, where it is not fused with the subtraction, and as much for that of p itself, once it is moved;
/// - |p − o|·3·2⁻²⁴ ≤ (P + O)·3·2⁻²⁴ for i, rounded, and for the difference;
/// - the distance along the ray, < 2·(P + O), times [`Self::SMALLEST`] where a component is taken to be larger than it is: < (P + O)·2⁻³⁹;
///
/// together less than (P + O)·8·2⁻²⁴, what the products of these leave included. So every box is grown by P·2⁻²¹, and by O·2⁻²¹ where a ray meets
/// it: each is entered no later and left no earlier than it is. Neither depends on what else is in the tree, however large or far away.
pub(super) struct BoxRay {
    pub inverse: [f32; 3],
    /// Origin times `inverse`, with the other sign, for the sides at which the ray enters, moved outwards, and for those at which it leaves.
    pub near_offset: [f32; 3],
    pub far_offset: [f32; 3],
    /// Where in a node's rows the sides are at which the ray enters, in numbers from its beginning. The sides at which it leaves are in the other row of
    /// the same axis, where the bit [`WIDTH`] is turned.
    pub near_sides: [u32; 3],
    /// ≥ 0.
    pub near_limit: f32,
    /// Distances here are shorter than along the ray, by this much.
    shift: f64,
}

impl BoxRay {
    /// Components of a direction are taken to be at least this large: 2⁻⁴⁰.
    const SMALLEST: f64 = 1.0 / (1_u64 << 40) as f64;

    #[inline(always)]
    pub fn new(ray: &Ray, center: DVec3, radius: f64) -> Self {
        let shift = ((center - ray.origin).dot(ray.direction) - radius).max(0.0);
        let origin = ray.at(shift);
        let margin = Self::margin(origin) as f32;
        let origin = origin.to_array();
        let direction = ray.direction.to_array();
        let mut boxes = Self {
            inverse: [0.0; 3],
            near_offset: [0.0; 3],
            far_offset: [0.0; 3],
            near_sides: [0; 3],
            near_limit: lower((ray.t_min - shift) as f32).max(0.0),
            shift,
        };
        for axis in 0..3 {
            // −0 goes with the negative numbers, here and in the choice of rows.
            let inverse = (1.0 / direction[axis].abs().max(Self::SMALLEST).copysign(direction[axis])) as f32;
            boxes.inverse[axis] = inverse;
            let (offset, more) = (-(origin[axis] * f64::from(inverse)) as f32, margin * inverse.abs());
            boxes.near_offset[axis] = offset - more;
            boxes.far_offset[axis] = offset + more;
            boxes.near_sides[axis] = (2 * axis as u32 + u32::from(inverse.is_sign_negative())) * WIDTH as u32;
        }
        boxes
    }

    /// By how much boxes are larger for rays that begin at `origin`, moved next to the tree.
    #[inline(always)]
    pub fn margin(origin: DVec3) -> f64 {
        f64::from(BOX_MARGIN) * origin.abs().max_element()
    }

    /// The distance along the ray as one to boxes, not too short and ≥ 0.
    #[inline(always)]
    pub fn far_limit(&self, t_max: f64) -> f32 {
        Self::far_limit_behind(self.shift, t_max)
    }

    /// The same for a ray that is `shift` longer.
    #[inline(always)]
    pub fn far_limit_behind(shift: f64, t_max: f64) -> f32 {
        upper((t_max - shift) as f32).max(0.0)
    }

    /// How much shorter distances to boxes are than along the ray.
    #[inline(always)]
    pub fn shift(&self) -> f64 {
        self.shift
    }
}

impl Tree {
    /// The next leaf slot whose box a ray meets between its `t_min` and `t_max`, which may become less from call to call; the nearest child of each
    /// node first. `stack` is [`Stack::at_root`] before the first call. Where there are `packs`, those are fetched ahead.
    #[inline(always)]
    pub(super) fn next_leaf<K: Kernel>(
        &self,
        boxes: &BoxRay,
        t_max: f64,
        stack: &mut Stack,
        packs: Option<&[TrianglePack]>,
    ) -> Option<u32> {
        let far_limit = boxes.far_limit(t_max);
        let mut current = stack.pop_within(far_limit);
        loop {
            while current as u32 & LEAF == 0 {
                current = self.step::<K>(current as u32, boxes, far_limit, stack);
                if let Some(packs) = packs {
                    self.fetch::<K>(packs, stack.fixed[stack.length - 1] as u32);
                }
            }
            if current != END {
                return Some(current as u32 & !LEAF);
            }
            if !stack.refill() {
                return None;
            }
            current = stack.pop_within(far_limit);
        }
    }

    /// Opens a node; returns what to visit next.
    #[inline(always)]
    pub(super) fn step<K: Kernel>(&self, node: u32, boxes: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        stack.make_room();
        let other = stack.fixed[stack.length - 1];
        let nearest = K::open(&self.nodes[node as usize], boxes, far_limit, stack);
        // Without a branch, because whether anything is met can hardly be foretold.
        let is_nothing = nearest >= NOTHING;
        stack.length -= usize::from(is_nothing);
        let next = select_unpredictable(is_nothing, other, nearest);
        if next <= entry(far_limit, u32::MAX) { next } else { stack.pop_within(far_limit) }
    }

    /// Has the processor fetch a node or pack that will be visited soon.
    #[inline(always)]
    pub(super) fn fetch<K: Kernel>(&self, packs: &[TrianglePack], child: u32) {
        let is_node = child & LEAF == 0;
        let size = select_unpredictable(is_node, size_of::<Node>(), size_of::<TrianglePack>());
        let start = select_unpredictable(is_node, self.nodes.as_ptr().cast::<u8>(), packs.as_ptr().cast::<u8>());
        K::fetch(start.wrapping_add((child & !LEAF) as usize * size));
    }
}

#[inline]
fn upper(t: f32) -> f32 {
    t + t.abs() * LIMIT_MARGIN
}

#[inline]
fn lower(t: f32) -> f32 {
    t - t.abs() * LIMIT_MARGIN
}

/// What is still to be visited: fixed room for ordinary trees, more on the heap for degenerate ones. [`END`] lies at the bottom.
pub(super) struct Stack {
    pub fixed: [u64; Self::ROOM],
    /// Where the next entry goes in `fixed`.
    pub length: usize,
    more: Vec<u64>,
}

impl Stack {
    const ROOM: usize = 104;

    /// Where the first entry above [`END`] is. There are more of these below, because eight entries are read at once, and again at the end.
    const FIRST: usize = 2 * WIDTH;

    #[inline(always)]
    pub const fn new() -> Self {
        let mut fixed = [0; Self::ROOM];
        let mut k = 0;
        while k < Self::FIRST {
            fixed[k] = END;
            k += 1;
        }
        Self { fixed, length: Self::FIRST, more: Vec::new() }
    }

    /// Holds the root of a tree that is not empty.
    #[inline(always)]
    pub fn at_root() -> Self {
        let mut stack = Self::new();
        stack.push(entry(0.0, 0));
        stack
    }

    /// Makes it as good as new.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.length = Self::FIRST;
        self.more.clear();
    }

    /// The eight entries below `length`, which is at least eight.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub fn eight_below(&self, length: usize) -> &[u64; WIDTH] {
        self.fixed[length - WIDTH..].first_chunk().unwrap_or(&[END; WIDTH])
    }

    /// Makes room for the children of a node.
    #[inline(always)]
    pub fn make_room(&mut self) {
        if self.length > Self::ROOM - WIDTH {
            self.spill();
        }
    }

    #[cold]
    fn spill(&mut self) {
        self.more.extend_from_slice(&self.fixed[Self::FIRST..self.length]);
        self.length = Self::FIRST;
    }

    /// Adds an entry where there is room.
    #[inline(always)]
    pub fn push(&mut self, entry: u64) {
        self.fixed[self.length] = entry;
        self.length += 1;
    }

    /// Adds the first `count` entries where there is room for all eight.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub fn push_many(&mut self, entries: [u64; WIDTH], count: u32) {
        self.fixed[self.length..self.length + WIDTH].copy_from_slice(&entries);
        self.length += count as usize;
    }

    /// Takes the uppermost entry that is not farther than `far_limit`, and drops those above it.
    #[inline(always)]
    pub fn pop_within(&mut self, far_limit: f32) -> u64 {
        let farthest = entry(far_limit, u32::MAX);
        loop {
            self.length -= 1;
            let entry = self.fixed[self.length];
            if entry <= farthest {
                return entry;
            }
        }
    }

    /// At [`END`]: whether there is more, which is brought back.
    #[inline(always)]
    pub fn refill(&mut self) -> bool {
        !self.more.is_empty() && self.bring_back()
    }

    #[cold]
    fn bring_back(&mut self) -> bool {
        let kept = self.more.len().saturating_sub(Self::ROOM / 2);
        let back = self.more.len() - kept;
        self.fixed[Self::FIRST..Self::FIRST + back].copy_from_slice(&self.more[kept..]);
        self.more.truncate(kept);
        self.length = Self::FIRST + back;
        true
    }
}
