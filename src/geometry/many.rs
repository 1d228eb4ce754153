//! Many rays at once: each waits while others go on.
//!
//! A ray alone waits most of the time, for the node that it goes to next and for the processor to have guessed wrong what that is. Here a group of rays
//! goes through the tree together, a step of each in turn: those at nodes, then those at leaves. Steps of different rays do not wait for each
//! other, and which rays take which kind of step is written into lists, not asked by branches.

use std::array::from_fn;

use super::bvh::{LEAF, Tree};
use super::geometry::Geometry;
use super::kernel::Kernel;
use super::ray::Ray;
use super::search::Search;
use super::triangle::{PackTest, ShearedRay};
use super::walk::{BoxRay, END, Stack, entry};

/// Rays in a group.
const GROUP: usize = 16;

/// A ray on its way.
struct Walker<S> {
    ray: Ray,
    boxes: BoxRay,
    sheared: ShearedRay,
    t_max: f64,
    far_limit: f32,
    /// The entry to visit next.
    current: u64,
    search: S,
    /// Of the ray among all.
    index: usize,
}

impl<S> Walker<S> {
    #[inline(always)]
    fn new(tree: &Tree, index: usize, ray: Ray, t_max: f64, search: S) -> Self {
        let boxes = BoxRay::new(&ray, tree.center, tree.radius);
        let far_limit = boxes.far_limit(t_max);
        Self { ray, boxes, sheared: ShearedRay::new(&ray), t_max, far_limit, current: entry(0.0, 0), search, index }
    }
}

/// Numbers of walkers.
struct List {
    members: [u8; GROUP],
    length: usize,
}

impl List {
    const fn new() -> Self {
        Self { members: [0; GROUP], length: 0 }
    }

    /// Adds a walker if `condition`.
    #[inline(always)]
    fn push_if(&mut self, walker: u8, condition: bool) {
        self.members[self.length % GROUP] = walker;
        self.length += usize::from(condition);
    }
}

impl Geometry {
    /// Searches along those of `rays` that `members` lists, up to `t_max`, for what `start` makes; `finish` gets that back with the ray's index.
    #[inline(always)]
    pub(super) fn search_others<K: Kernel, S: Search>(
        &self,
        rays: &[Ray],
        members: &[u16],
        t_max: impl Fn(usize) -> f64,
        start: impl Fn() -> S,
        mut finish: impl FnMut(usize, &mut S),
    ) {
        if members.is_empty() {
            return;
        }
        let tree = &self.triangle_tree;
        let begin = |member: usize| {
            let index = usize::from(members[member]);
            Walker::new(tree, index, rays[index], t_max(index), start())
        };
        let count = members.len().min(GROUP);
        // With fewer rays than members, some stand for none.
        let mut walkers: [Walker<S>; GROUP] = from_fn(|k| begin(k.min(count - 1)));
        let mut stacks = [const { Stack::new() }; GROUP];
        let mut next_ray = count;
        let mut test = PackTest::EMPTY;
        let [mut at_nodes, mut at_leaves, mut at_end] = [const { List::new() }; 3];
        (0..count).for_each(|k| at_nodes.push_if(k as u8, true));
        while at_nodes.length + at_leaves.length > 0 {
            let length = std::mem::take(&mut at_nodes.length);
            for k in 0..length {
                let number = at_nodes.members[k % GROUP] as usize % GROUP;
                let (walker, stack) = (&mut walkers[number], &mut stacks[number]);
                let current = tree.step::<K>(walker.current as u32, &walker.boxes, walker.far_limit, stack);
                walker.current = current;
                tree.fetch::<K>(&self.packs, current as u32);
                at_nodes.push_if(number as u8, current as u32 & LEAF == 0);
                at_leaves.push_if(number as u8, current as u32 & LEAF != 0);
            }
            let length = std::mem::take(&mut at_leaves.length);
            for k in 0..length {
                let number = at_leaves.members[k % GROUP] as usize % GROUP;
                let (walker, stack) = (&mut walkers[number], &mut stacks[number]);
                let is_over = if walker.current == END {
                    !stack.refill()
                } else {
                    let slot = walker.current as u32 & !LEAF;
                    let Walker { ray, sheared, t_max, search, .. } = walker;
                    let before = *t_max;
                    let is_over = self.test_pack::<K>(slot, ray, sheared, t_max, &mut test, search);
                    if *t_max != before {
                        walker.far_limit = walker.boxes.far_limit(walker.t_max);
                    }
                    is_over
                };
                let (current, length) = K::top(stack, walker.far_limit);
                (walker.current, stack.length) = (current, length);
                tree.fetch::<K>(&self.packs, current as u32);
                at_nodes.push_if(number as u8, !is_over & (current as u32 & LEAF == 0));
                at_leaves.push_if(number as u8, !is_over & (current as u32 & LEAF != 0));
                at_end.push_if(number as u8, is_over);
            }
            for k in 0..std::mem::take(&mut at_end.length) {
                let number = at_end.members[k % GROUP] as usize % GROUP;
                let walker = &mut walkers[number];
                self.search_spheres::<K>(&walker.ray, walker.t_max, &mut walker.search);
                finish(walker.index, &mut walker.search);
                if next_ray < members.len() {
                    *walker = begin(next_ray);
                    stacks[number].clear();
                    next_ray += 1;
                    at_nodes.push_if(number as u8, true);
                }
            }
        }
    }
}
