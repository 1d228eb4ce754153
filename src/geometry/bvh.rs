//! An eight-wide bounding volume hierarchy, collapsed from the binary one that obvhs builds.
//!
//! Boxes are f32 and slightly too large; rays are f64. The walk only ever errs towards visiting a box, never towards missing one,
//! so what is hit is decided by the primitives alone.

use std::ops::ControlFlow;
use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::bounds::Bounds;
use super::collapse::Collapse;
use super::node::{LEAF, MANY, Node, WIDTH};

/// The tree. Each leaf is a *slot*; the builder says which primitives each slot holds.
#[derive(Debug, Default)]
pub struct Tree {
    /// The root first.
    pub(super) nodes: Vec<Node>,
    pub(super) center: DVec3,
    /// Of a sphere around everything.
    pub(super) radius: f64,
    /// [`Tree::cost`] when it was built.
    pub(super) cost_as_built: f64,
}

/// Up to `per_slot` primitives for each slot.
pub struct Slots {
    pub per_slot: usize,
    /// Primitive indices, `per_slot` to a slot, unused ones [`u32::MAX`].
    pub primitives: Vec<u32>,
}

impl Tree {
    /// Builds the tree over `bounds`, the boxes of primitives that belong to the objects `object_of`. Primitives are packed `per_slot` to
    /// a leaf slot.
    pub fn build(bounds: &[Bounds], object_of: &[u32], per_slot: usize) -> (Self, Slots) {
        let mut slots = Slots { per_slot, primitives: Vec::new() };
        if bounds.is_empty() {
            return (Self::default(), slots);
        }
        let binary = build_binary(bounds);
        let collapse = Collapse::new(&binary, per_slot);
        let all = bounds.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let mut tree = Self { nodes: Vec::with_capacity(bounds.len() / 4 + 1), ..Self::around(all) };
        tree.nodes.push(Node::EMPTY);
        // (node of the wide tree to fill, node of the binary tree that it stands for)
        let mut open = vec![(0usize, 0usize)];
        while let Some((wide, root)) = open.pop() {
            for (lane, child) in collapse.children(root).into_iter().enumerate() {
                let source = &binary.nodes[child];
                let reference = if collapse.is_leaf(child) {
                    slots.push(&collapse.primitives(child)) | LEAF
                } else {
                    tree.nodes.push(Node::EMPTY);
                    open.push((tree.nodes.len() - 1, child));
                    tree.nodes.len() as u32 - 1
                };
                let node = &mut tree.nodes[wide];
                node.set_box(lane, Bounds { min: source.aabb().min.into(), max: source.aabb().max.into() });
                node.children[lane] = reference;
            }
        }
        tree.find_objects(&slots, object_of);
        tree.cost_as_built = tree.cost();
        (tree, slots)
    }

    /// What a ray is expected to cost, by the surface area heuristic: the area of all boxes, up to a factor that depends on nothing but the rays.
    pub(super) fn cost(&self) -> f64 {
        let of_node = |node: &Node| node.boxes().map(|(_, bounds)| f64::from(bounds.half_area())).sum::<f64>();
        self.nodes.iter().map(of_node).sum()
    }

    /// A tree without nodes over all that lies in `all`.
    pub(super) fn around(all: Bounds) -> Self {
        let (min, max) = (all.min.as_dvec3(), all.max.as_dvec3());
        Self { center: (min + max) / 2.0, radius: (max - min).length() / 2.0, ..Self::default() }
    }

    /// Fills in `objects`, from the leaves up: a node comes before its children.
    fn find_objects(&mut self, slots: &Slots, object_of: &[u32]) {
        fn common(mut objects: impl Iterator<Item = u32>) -> u32 {
            let first = objects.next().unwrap_or(MANY);
            if objects.all(|object| object == first) { first } else { MANY }
        }
        for index in (0..self.nodes.len()).rev() {
            for lane in 0..WIDTH {
                let node = &self.nodes[index];
                if !node.is_used(lane) {
                    continue;
                }
                let child = node.children[lane];
                let object = if child & LEAF == 0 {
                    let child = &self.nodes[child as usize];
                    common((0..WIDTH).filter(|&l| child.is_used(l)).map(|l| child.objects[l]))
                } else {
                    common(slots.primitives_of(child & !LEAF).map(|primitive| object_of[primitive as usize]))
                };
                self.nodes[index].objects[lane] = object;
            }
        }
    }

    /// Visits the leaf slots whose boxes meet the box from `min` to `max`, in no particular order, until `visit` breaks. Subtrees that hold
    /// nothing but the object `except` are passed over.
    pub fn visit_box(
        &self,
        min: DVec3,
        max: DVec3,
        except: u32,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if self.nodes.is_empty() {
            return ControlFlow::Continue(());
        }
        // Rounded outwards.
        let min = min.as_vec3().to_array().map(f32::next_down);
        let max = max.as_vec3().to_array().map(f32::next_up);
        let mut open = Open::new();
        while let Some(index) = open.pop() {
            let node = &self.nodes[index as usize];
            let mut met = [true; WIDTH];
            for axis in 0..3 {
                for (lane, met) in met.iter_mut().enumerate() {
                    *met &= (node.rows[2 * axis][lane] <= max[axis]) & (node.rows[2 * axis + 1][lane] >= min[axis]);
                }
            }
            for lane in (0..WIDTH).filter(|lane| met[*lane] && node.is_used(*lane)) {
                if node.objects[lane] == except && except != MANY {
                    continue;
                }
                let child = node.children[lane];
                if child & LEAF == 0 {
                    open.push(child);
                } else {
                    visit(child & !LEAF)?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Nodes that are still to be visited, in memory of its own only where there are very many.
struct Open {
    first: [u32; 16],
    length: usize,
    more: Vec<u32>,
}

impl Open {
    /// The root.
    #[inline]
    fn new() -> Self {
        Self { first: [0; 16], length: 1, more: Vec::new() }
    }

    #[inline]
    fn push(&mut self, node: u32) {
        if self.length < self.first.len() {
            self.first[self.length] = node;
            self.length += 1;
        } else {
            self.more.push(node);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<u32> {
        if let Some(node) = self.more.pop() {
            return Some(node);
        }
        self.length = self.length.checked_sub(1)?;
        Some(self.first[self.length])
    }
}

impl Slots {
    /// Adds a slot for `primitives`, at most `per_slot`; returns it.
    fn push(&mut self, primitives: &[u32]) -> u32 {
        let slot = self.primitives.len() / self.per_slot;
        self.primitives.extend_from_slice(primitives);
        self.primitives.extend(std::iter::repeat_n(u32::MAX, self.per_slot - primitives.len()));
        slot as u32
    }

    pub fn primitives_of(&self, slot: u32) -> impl Iterator<Item = u32> {
        let start = slot as usize * self.per_slot;
        self.primitives[start..start + self.per_slot].iter().copied().filter(|primitive| *primitive != u32::MAX)
    }
}

/// Whether many of the boxes are at one place, as the triangles of repeated meshes are: more than a quarter of some that stand for all.
fn lie_on_each_other(bounds: &[Bounds]) -> bool {
    const SAMPLES: usize = 1024;
    /// Fewer than this are built in no time.
    const MANY_BOXES: usize = 4096;
    if bounds.len() < MANY_BOXES {
        return false;
    }
    let all = bounds.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
    let cell = (all.max - all.min).max_element() / 65_536.0;
    let stride = bounds.len() / SAMPLES;
    let place = |b: &Bounds| (((b.min + b.max) / 2.0 - all.min) / cell).to_array().map(|x| x as i64);
    let mut places: Vec<[i64; 3]> = bounds.iter().step_by(stride).map(place).collect();
    places.sort_unstable();
    places.chunk_by(|a, b| a == b).any(|same| 4 * same.len() > places.len())
}

/// The binary tree: PLOC, reinsertion. A primitive in each leaf.
fn build_binary(bounds: &[Bounds]) -> Bvh2 {
    let mut boxes: Vec<Aabb> = bounds.iter().map(|b| Aabb::new(Vec3A::from(b.min), Vec3A::from(b.max))).collect();
    if lie_on_each_other(bounds) {
        // Among equal boxes the builder finds no nearest ones, and joins them one by one: each is made a little larger by an amount of its own.
        for (index, aabb) in boxes.iter_mut().enumerate() {
            let irregular = (index as u32).wrapping_mul(0x9E37_79B9) as f32 / u32::MAX as f32;
            let more = (aabb.max - aabb.min).max_element() * 1e-4 * irregular;
            *aabb = Aabb::new(aabb.min - more, aabb.max + more);
        }
    }
    let parameters = BvhBuildParams {
        max_prims_per_leaf: 1,
        post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
        // Slower presets make trees that are no quicker to walk once they are collapsed.
        ..BvhBuildParams::fast_build()
    };
    build_bvh2(&boxes, parameters, &mut Duration::default())
}
