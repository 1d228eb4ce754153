//! Beams: rays that lie close together, such as those of one pixel, go through the tree as one. Boxes are tested once for all of them, triangles for each.

use glam::DVec3;

use super::bvh::{LEAF, Node, Tree, WIDTH};
use super::geometry::Geometry;
use super::kernel::Kernel;
use super::ray::Ray;
use super::search::Search;
use super::triangle::{PackTest, ShearedRay};
use super::walk::{BoxRay, END, Stack, entry};

/// Most rays of a beam.
pub(super) const MOST: usize = 32;
/// Fewer rays are not worth a beam.
const FEWEST: usize = 4;
/// Beams that are being gathered at a time.
const OPEN: usize = 4;
/// How far the directions of a beam's rays may lie from those of its first in each component, and their origins, relative to the tree's radius.
const SPREAD: [f64; 2] = [0.004, 0.004];

/// Intervals that hold what is known of all rays of a beam.
struct Bounds {
    /// Of the origins, rounded outwards: along each axis the one from which entering sides, and leaving sides, are measured.
    origin_near: [f32; 3],
    origin_far: [f32; 3],
    /// Least and greatest reciprocal of the direction's components, rounded outwards.
    inverse: [[f32; 2]; 3],
    near_rows: [u32; 3],
    near_limit: f32,
}

impl Bounds {
    /// Distances from the origins to the boxes of a node's children: not too long, and a bit for each that some ray may meet up to
    /// `far_limit`.
    ///
    /// The origin's coordinate o and the reciprocal i are rounded outwards, so the distance (p − o)·i has two roundings that count, together less than
    /// |p − o|·2⁻²² in space: boxes are grown by more, and so are the origins, as [`BoxRay`] says.
    #[inline(always)]
    fn meet(&self, node: &Node, far_limit: f32) -> ([f32; WIDTH], u32) {
        let mut near = [self.near_limit; WIDTH];
        let mut far = [f32::INFINITY; WIDTH];
        for axis in 0..3 {
            let row = self.near_rows[axis] as usize % 6;
            let (entering, leaving) = (&node.rows[row], &node.rows[row ^ 1]);
            let [low, high] = self.inverse[axis];
            for lane in 0..WIDTH {
                let to_near = entering[lane] - self.origin_near[axis];
                let to_far = leaving[lane] - self.origin_far[axis];
                near[lane] = larger(smaller(to_near * low, to_near * high), near[lane]);
                far[lane] = smaller(larger(to_far * low, to_far * high), far[lane]);
            }
        }
        let mut met = 0;
        for lane in 0..WIDTH {
            met |= u32::from(near[lane] <= smaller(far[lane], far_limit)) << lane;
        }
        (near, met)
    }
}

/// As the processor's instructions compare: the second where one is NaN.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A ray's origin and direction as numbers; within a beam no number differs by more than 1.
#[derive(Clone, Copy)]
struct RayKey {
    numbers: [f32; 8],
    octant: u8,
}

impl RayKey {
    const NOWHERE: Self = Self { numbers: [0.0; 8], octant: u8::MAX };

    /// `scale`: what to multiply directions and origins by.
    #[inline(always)]
    fn new(ray: &Ray, scale: [f64; 2]) -> Self {
        let [turn, shift] = scale;
        let mut key = Self { numbers: [0.0; 8], octant: 0 };
        for k in 0..3 {
            key.numbers[k] = (ray.direction[k] * turn) as f32;
            key.numbers[4 + k] = (ray.origin[k] * shift) as f32;
            key.octant |= u8::from(ray.direction[k].is_sign_negative()) << k;
        }
        key
    }

    #[inline(always)]
    fn is_near(&self, other: &Self) -> bool {
        // A loop: closures would not be compiled for the processor that the kernel is for.
        let mut is_near = self.octant == other.octant;
        for k in 0..8 {
            is_near &= (self.numbers[k] - other.numbers[k]).abs() <= 1.0;
        }
        is_near
    }
}

/// Rays that may become a beam.
#[derive(Clone, Copy)]
pub(super) struct Bundle {
    members: [u16; MOST],
    length: usize,
}

impl Bundle {
    const EMPTY: Self = Self { members: [0; MOST], length: 0 };

    pub(super) fn members(&self) -> impl Iterator<Item = usize> + '_ {
        self.members[..self.length].iter().map(|&index| usize::from(index))
    }
}

/// Rays that are looked at together: indices are short, and lists have fixed lengths.
pub(super) const GATHERED: usize = 256;

/// What has become of a chunk of rays.
pub(super) struct Gathered {
    beams: [Bundle; GATHERED / FEWEST],
    beam_count: usize,
    others: [u16; GATHERED],
    other_count: usize,
}

impl Gathered {
    /// Divides `rays`, at most [`GATHERED`], into beams and others, in an order that depends on the rays alone.
    #[inline(always)]
    pub(super) fn new(tree: &Tree, rays: &[Ray]) -> Self {
        let mut gathered =
            Self { beams: [Bundle::EMPTY; GATHERED / FEWEST], beam_count: 0, others: [0; GATHERED], other_count: 0 };
        let mut open = [Bundle::EMPTY; OPEN];
        let mut keys = [RayKey::NOWHERE; OPEN];
        let mut oldest = 0;
        let [turn, shift] = SPREAD;
        let scale = [1.0 / turn, 1.0 / (shift * tree.radius)];
        for (index, ray) in rays.iter().enumerate() {
            let key = RayKey::new(ray, scale);
            let mut takers = 0;
            for (k, other) in keys.iter().enumerate() {
                takers |= u32::from(other.is_near(&key)) << k;
            }
            let number = if takers != 0 {
                takers.trailing_zeros() as usize
            } else {
                let number = oldest;
                oldest = (oldest + 1) % OPEN;
                gathered.take(&mut open[number]);
                keys[number] = key;
                number
            };
            let bundle = &mut open[number % OPEN];
            bundle.members[bundle.length % MOST] = index as u16;
            bundle.length += 1;
            if bundle.length == MOST {
                gathered.take(bundle);
                keys[number % OPEN] = RayKey::NOWHERE;
            }
        }
        open.iter_mut().for_each(|bundle| gathered.take(bundle));
        gathered
    }

    /// Empties a bundle.
    fn take(&mut self, bundle: &mut Bundle) {
        if bundle.length >= FEWEST {
            self.beams[self.beam_count] = *bundle;
            self.beam_count += 1;
        } else {
            for &member in &bundle.members[..bundle.length] {
                self.others[self.other_count] = member;
                self.other_count += 1;
            }
        }
        bundle.length = 0;
    }

    pub(super) fn beams(&self) -> &[Bundle] {
        &self.beams[..self.beam_count]
    }

    /// Indices of the rays that are in no beam.
    pub(super) fn others(&self) -> &[u16] {
        &self.others[..self.other_count]
    }
}

/// A ray of a beam.
struct Member<S> {
    ray: Ray,
    sheared: ShearedRay,
    t_max: f64,
    /// As a distance to boxes.
    far_limit: f32,
    search: S,
    index: usize,
}

impl Geometry {
    /// As [`Self::search_others`], for the rays of one beam.
    #[inline(always)]
    pub(super) fn search_beam<K: Kernel, S: Search>(
        &self,
        rays: &[Ray],
        bundle: &Bundle,
        t_max: impl Fn(usize) -> f64,
        start: impl Fn() -> S,
        mut finish: impl FnMut(usize, &mut S),
    ) {
        let tree = &self.triangle_tree;
        let mut bounds = Bounds {
            origin_near: [0.0; 3],
            origin_far: [0.0; 3],
            inverse: [[f32::INFINITY, f32::NEG_INFINITY]; 3],
            near_rows: [0; 3],
            near_limit: f32::INFINITY,
        };
        let mut origins = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let mut shifts = [0.0; MOST];
        let mut members: [Option<Member<S>>; MOST] = [const { None }; MOST];
        for ((index, slot), kept) in bundle.members().zip(&mut members).zip(&mut shifts) {
            let ray = rays[index];
            let boxes = BoxRay::new(&ray, tree.center, tree.radius);
            let origin = ray.at(boxes.shift());
            for axis in 0..3 {
                let [low, high] = &mut origins[axis];
                (*low, *high) = (low.min(origin[axis]), high.max(origin[axis]));
                let [low, high] = &mut bounds.inverse[axis];
                (*low, *high) = (low.min(boxes.inverse[axis]), high.max(boxes.inverse[axis]));
            }
            bounds.near_rows = boxes.near_sides.map(|side| side / WIDTH as u32);
            bounds.near_limit = bounds.near_limit.min(boxes.near_limit);
            *kept = boxes.shift();
            let t_max = t_max(index);
            let far_limit = boxes.far_limit(t_max);
            *slot = Some(Member { ray, sheared: ShearedRay::new(&ray), t_max, far_limit, search: start(), index });
        }
        let largest = origins.map(|[low, high]| low.abs().max(high.abs()));
        let margin = BoxRay::margin(DVec3::from(largest));
        for (axis, [low, high]) in origins.into_iter().enumerate() {
            let (low, high) = (((low - margin) as f32).next_down(), ((high + margin) as f32).next_up());
            let is_negative = bounds.near_rows[axis] & 1 == 1;
            (bounds.origin_near[axis], bounds.origin_far[axis]) = if is_negative { (low, high) } else { (high, low) };
            let [low, high] = bounds.inverse[axis];
            bounds.inverse[axis] = [low.next_down(), high.next_up()];
        }
        let members = &mut members[..bundle.length];
        let farthest = |members: &[Option<Member<S>>]| {
            members.iter().flatten().fold(f32::NEG_INFINITY, |most, member| most.max(member.far_limit))
        };
        let mut far_limit = farthest(members);
        let mut stack = Stack::new();
        let mut test = PackTest::EMPTY;
        let mut current = entry(0.0, 0);
        loop {
            let child = current as u32;
            if current == END {
                if !stack.refill() {
                    break;
                }
            } else if child & LEAF == 0 {
                stack.make_room();
                let node = &tree.nodes[child as usize];
                let (near, mut met) = bounds.meet(node, far_limit);
                if met != 0 {
                    let mut next = || {
                        let lane = met.trailing_zeros() as usize % WIDTH;
                        met &= met - 1;
                        (entry(near[lane], node.children[lane]), met != 0)
                    };
                    let (mut nearest, mut goes_on) = next();
                    while goes_on {
                        let other;
                        (other, goes_on) = next();
                        stack.push(nearest.max(other));
                        nearest = nearest.min(other);
                    }
                    current = nearest;
                    continue;
                }
            } else {
                let mut is_nearer = false;
                for (member, shift) in members.iter_mut().flatten().zip(&shifts) {
                    let Member { ray, sheared, t_max, search, .. } = member;
                    let before = *t_max;
                    let is_over = self.test_pack::<K>(child & !LEAF, ray, sheared, t_max, &mut test, search);
                    if is_over {
                        // Nothing is nearer than nowhere.
                        member.t_max = f64::NEG_INFINITY;
                    }
                    if member.t_max != before {
                        member.far_limit = BoxRay::far_limit_behind(*shift, member.t_max);
                        is_nearer = true;
                    }
                }
                if is_nearer {
                    far_limit = farthest(members);
                }
            }
            let (next, length) = K::top(&stack, far_limit);
            (current, stack.length) = (next, length);
        }
        for member in members.iter_mut().flatten() {
            self.search_spheres::<K>(&member.ray, member.t_max, &mut member.search);
            finish(member.index, &mut member.search);
        }
    }
}
