//! The walk of a ray through a tree, the nearest child of each node first.
//!
//! What is still to be visited is kept in single numbers, *entries*: a distance's bits above a child. Distances are ≥ 0, so entries compare as
//! their distances do.

use std::hint::select_unpredictable;

use glam::DVec3;

use super::bvh::{LEAF, Tree, WIDTH};
use super::kernel::Kernel;
use super::ray::Ray;

/// Relative growth of distances to box sides that covers the rounding of the reciprocal direction and of what is computed with it.
const DISTANCE_MARGIN: f32 = 1e-6;

/// Farther than every entry.
pub(super) const NOTHING: u64 = u64::MAX;

/// Lies under all entries: a leaf that no tree has.
pub(super) const END: u64 = u32::MAX as u64;

/// A child at a distance (≥ 0).
#[inline(always)]
pub(super) fn entry(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

/// A ray as boxes are tested against it: in f32, from a point moved next to the tree, so that a far origin costs no precision.
///
/// The distance to a side at `p` is computed as p·i − o·i from the rounded reciprocal i of the direction's component and the product o·i,
/// rounded once. In space, that is off by
///
/// - at most |o|·2⁻²⁴ for the rounding of o·i. Where the ray meets the sphere around the tree, the origin lies within √2 radii of its middle,
///   and with m for the tree's largest coordinate, the middle within m and the radius within √3·m: |o| < 3.5·m, together less than
///   m·2⁻²²;
/// - at most the distance along the ray, < 7·m, times [`Self::SMALLEST`] where a component is taken to be larger than it is: < m·2⁻³⁷;
///
/// less than the m·2⁻²¹ by which all boxes are grown. The rest is relative to the distance: twice 2⁻²⁴ for i, and 2⁻²⁴ each for the product (where it
/// is not fused: its rounding is at most m·|i|·2⁻²⁴, in space m·2⁻²⁴, and has room in the first bound) and the difference; far sides are moved away by
/// four times that.
pub(super) struct BoxRay {
    pub inverse: [f32; 3],
    /// Origin times `inverse`, with the other sign.
    pub offset: [f32; 3],
    /// Rows of a node that hold the sides where the ray enters. Those where it leaves are the other ones of the same axis: the number with its
    /// lowest bit turned.
    pub near_rows: [u32; 3],
    /// ≥ 0.
    pub near_limit: f32,
    /// Distances here are shorter than along the ray, by this much.
    shift: f64,
}

impl BoxRay {
    /// Components of a direction are taken to be at least this large: 2⁻⁴⁰.
    const SMALLEST: f64 = 1.0 / (1_u64 << 40) as f64;

    /// Far sides are grown by this factor: it covers the rounding of both distances that are compared.
    pub const FAR_GROWTH: f32 = 1.0 + 2.0 * DISTANCE_MARGIN;

    #[inline(always)]
    pub fn new(ray: &Ray, center: DVec3, radius: f64) -> Self {
        let shift = ((center - ray.origin).dot(ray.direction) - radius).max(0.0);
        let origin = ray.at(shift).to_array();
        let direction = ray.direction.to_array();
        let mut boxes = Self {
            inverse: [0.0; 3],
            offset: [0.0; 3],
            near_rows: [0; 3],
            near_limit: lower((ray.t_min - shift) as f32).max(0.0),
            shift,
        };
        for axis in 0..3 {
            // −0 goes with the negative numbers, here and in the choice of rows.
            let inverse = (1.0 / direction[axis].abs().max(Self::SMALLEST).copysign(direction[axis])) as f32;
            boxes.inverse[axis] = inverse;
            boxes.offset[axis] = -(origin[axis] * f64::from(inverse)) as f32;
            boxes.near_rows[axis] = 2 * axis as u32 + u32::from(inverse.is_sign_negative());
        }
        boxes
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
    /// Visits the leaf slots whose boxes `ray` meets between `ray.t_min` and `*t_max`, the nearest child of each node first. `visit` gets a slot
    /// and may lower `t_max`; it ends the walk by returning `true`.
    #[inline(always)]
    pub(super) fn walk<K: Kernel>(&self, ray: &Ray, t_max: &mut f64, mut visit: impl FnMut(u32, &mut f64) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        let boxes = BoxRay::new(ray, self.center, self.radius);
        let mut far_limit = boxes.far_limit(*t_max);
        let mut stack = Stack::new();
        let mut current = entry(0.0, 0);
        loop {
            let child = current as u32;
            if child & LEAF == 0 {
                current = self.step::<K>(child, &boxes, far_limit, &mut stack);
            } else {
                if current == END {
                    if !stack.refill() {
                        return;
                    }
                } else {
                    if visit(child & !LEAF, t_max) {
                        return;
                    }
                    far_limit = boxes.far_limit(*t_max);
                }
                let (next, length) = K::top(&stack, far_limit);
                (current, stack.length) = (next, length);
            }
        }
    }

    /// Opens a node; returns what to visit next.
    #[inline(always)]
    pub(super) fn step<K: Kernel>(&self, node: u32, boxes: &BoxRay, far_limit: f32, stack: &mut Stack) -> u64 {
        stack.make_room();
        // Without a branch, because whether anything is met can hardly be foretold.
        let (other, length) = K::top(stack, far_limit);
        let nearest = K::open(&self.nodes[node as usize], boxes, far_limit, stack);
        let is_nothing = nearest == NOTHING;
        stack.length = select_unpredictable(is_nothing, length, stack.length);
        select_unpredictable(is_nothing, other, nearest)
    }
}

#[inline]
fn upper(t: f32) -> f32 {
    t + t.abs() * DISTANCE_MARGIN
}

#[inline]
fn lower(t: f32) -> f32 {
    t - t.abs() * DISTANCE_MARGIN
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
