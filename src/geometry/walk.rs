//! The walk of a ray through a tree, the nearest child of each node first.

use std::hint::select_unpredictable;

use super::box_ray::{BoxRay, END, NOTHING, Stack, entry};
use super::bvh::Tree;
use super::kernel::Kernel;
use super::node::{LEAF, Node};
use super::triangle::TrianglePack;

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
