//! An eight-wide bounding volume hierarchy, collapsed from the binary one that obvhs builds, and the walk over it.
//!
//! Boxes are f32 and slightly too large; rays are f64. The walk only ever errs towards visiting a box, never towards missing one,
//! so what is hit is decided by the primitives alone.

use std::time::Duration;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::kernel::Kernel;
use super::ray::Ray;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Relative growth of distances to box sides that covers the rounding of three f32 operations and of the f32 direction.
pub(super) const DISTANCE_MARGIN: f32 = 1e-6;

/// Growth of boxes, relative to the tree's largest coordinate: covers the rounding of ray origins to f32 (half a unit in the last
/// place, at up to twice that coordinate), with room.
const BOX_MARGIN: f32 = 1.0 / (1 << 21) as f32;

/// Box of a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}

/// Eight children. Those at the end may be unused: `used` has a bit for each that is not.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `[axis][child]`
    pub(super) min: [[f32; WIDTH]; 3],
    pub(super) max: [[f32; WIDTH]; 3],
    /// Node index of an inner child, first leaf slot of a leaf.
    first: [u32; WIDTH],
    /// Leaf slots; 0 for inner children.
    count: [u32; WIDTH],
    pub(super) used: u32,
}

impl Node {
    /// No child.
    const EMPTY: Self =
        Self { min: [[0.0; WIDTH]; 3], max: [[0.0; WIDTH]; 3], first: [0; WIDTH], count: [0; WIDTH], used: 0 };
}

/// The tree. Leaves are ranges of *slots*; the builder says which primitives each slot holds.
#[derive(Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// For each child of each node the object that all primitives below it belong to; [`MANY`] if there are several.
    objects: Vec<[u32; WIDTH]>,
    center: DVec3,
    /// Of a sphere around everything.
    radius: f64,
}

/// Primitives of more than one object.
const MANY: u32 = u32::MAX;

/// Up to `per_slot` primitives for each leaf slot.
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
        let all = bounds.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let margin = all.min.abs().max(all.max.abs()).max_element() * BOX_MARGIN;
        let mut tree = Self {
            nodes: Vec::with_capacity(bounds.len() / 4 + 1),
            objects: Vec::new(),
            center: (all.min.as_dvec3() + all.max.as_dvec3()) / 2.0,
            radius: (all.max.as_dvec3() - all.min.as_dvec3()).length() / 2.0,
        };
        tree.nodes.push(Node::EMPTY);
        // (node of the wide tree to fill, node of the binary tree that it stands for)
        let mut open = vec![(0usize, 0usize)];
        while let Some((wide, root)) = open.pop() {
            let children = widen(&binary, root);
            for (lane, &child) in children.iter().enumerate() {
                let source = &binary.nodes[child];
                let (first, count) = if source.is_leaf() {
                    let start = source.first_index as usize;
                    slots.push(&binary.primitive_indices[start..start + source.prim_count as usize])
                } else {
                    tree.nodes.push(Node::EMPTY);
                    open.push((tree.nodes.len() - 1, child));
                    (tree.nodes.len() as u32 - 1, 0)
                };
                let node = &mut tree.nodes[wide];
                for axis in 0..3 {
                    node.min[axis][lane] = source.aabb().min[axis] - margin;
                    node.max[axis][lane] = source.aabb().max[axis] + margin;
                }
                node.first[lane] = first;
                node.count[lane] = count;
                node.used |= 1 << lane;
            }
        }
        tree.find_objects(&slots, object_of);
        (tree, slots)
    }

    /// Fills in `objects`, from the leaves up: a node comes before its children.
    fn find_objects(&mut self, slots: &Slots, object_of: &[u32]) {
        fn common(mut objects: impl Iterator<Item = u32>) -> u32 {
            let first = objects.next().unwrap_or(MANY);
            if objects.all(|object| object == first) { first } else { MANY }
        }
        self.objects = vec![[MANY; WIDTH]; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            let node = &self.nodes[index];
            for lane in (0..WIDTH).filter(|lane| node.used & 1 << lane != 0) {
                let first = node.first[lane] as usize;
                self.objects[index][lane] = if node.count[lane] == 0 {
                    let child = &self.nodes[first];
                    common((0..WIDTH).filter(|l| child.used & 1 << l != 0).map(|l| self.objects[first][l]))
                } else {
                    let end = first + node.count[lane] as usize;
                    let primitives = &slots.primitives[first * slots.per_slot..end * slots.per_slot];
                    common(primitives.iter().filter(|p| **p != u32::MAX).map(|p| object_of[*p as usize]))
                };
            }
        }
    }

    /// Visits the leaf slots whose boxes meet the box from `min` to `max`, in no particular order. Subtrees that hold nothing but the object
    /// `except` are passed over.
    pub fn visit_box(&self, min: DVec3, max: DVec3, except: u32, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        // Rounded outwards.
        let min = min.as_vec3().to_array().map(f32::next_down);
        let max = max.as_vec3().to_array().map(f32::next_up);
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let (node, objects) = (&self.nodes[index as usize], &self.objects[index as usize]);
            let mut met = [true; WIDTH];
            for axis in 0..3 {
                for (lane, met) in met.iter_mut().enumerate() {
                    *met &= (node.min[axis][lane] <= max[axis]) & (node.max[axis][lane] >= min[axis]);
                }
            }
            for lane in (0..WIDTH).filter(|lane| met[*lane] && node.used & 1 << lane != 0) {
                if objects[lane] == except && except != MANY {
                    continue;
                }
                if node.count[lane] == 0 {
                    open.push(node.first[lane]);
                } else {
                    (node.first[lane]..node.first[lane] + node.count[lane]).for_each(&mut visit);
                }
            }
        }
    }

    /// Visits the leaf slots whose boxes `ray` meets between `ray.t_min` and `*t_max`, the nearest child of each node first. `visit` gets a slot
    /// and may lower `t_max`; it ends the walk by returning `true`.
    #[inline(always)]
    pub(super) fn walk<K: Kernel>(&self, ray: &Ray, t_max: &mut f64, mut visit: impl FnMut(u32, &mut f64) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        // Boxes are tested in f32 from a point moved next to the tree, so that a far origin costs no precision.
        let shift = ((self.center - ray.origin).dot(ray.direction) - self.radius).max(0.0);
        let origin = ray.at(shift).as_vec3();
        let inverse = Vec3::from_array(ray.direction.to_array().map(inverse_of));
        let near_limit = lower((ray.t_min - shift) as f32).max(0.0);
        let mut far_limit = upper((*t_max - shift) as f32);

        let mut stack = Stack::new();
        let mut current = Entry { near: near_limit, first: 0, count: 0 };
        loop {
            if current.count == 0 {
                let node = &self.nodes[current.first as usize];
                let (near, mut met) = K::meet_boxes(node, origin, inverse, near_limit, far_limit);
                if met != 0 {
                    // The nearest child is next; the others wait, in no order: what has become too far is dropped when its turn comes.
                    current = node.entry(&near, &mut met);
                    while met != 0 {
                        let other = node.entry(&near, &mut met);
                        if other.near < current.near {
                            stack.push(current);
                            current = other;
                        } else {
                            stack.push(other);
                        }
                    }
                    continue;
                }
            } else {
                for slot in current.first..current.first + current.count {
                    if visit(slot, t_max) {
                        return;
                    }
                }
                far_limit = upper((*t_max - shift) as f32);
            }
            match stack.pop_nearer_than(far_limit) {
                Some(next) => current = next,
                None => return,
            }
        }
    }
}

impl Node {
    /// Takes the lowest bit off `met` and returns that child.
    #[inline(always)]
    fn entry(&self, near: &[f32; WIDTH], met: &mut u32) -> Entry {
        let lane = met.trailing_zeros() as usize % WIDTH;
        *met &= *met - 1;
        Entry { near: near[lane], first: self.first[lane], count: self.count[lane] }
    }
}

/// Reciprocal of a direction's component, finite even for ±0.
#[inline]
fn inverse_of(component: f64) -> f32 {
    const SMALLEST: f32 = 1e-20;
    let c = component as f32;
    1.0 / if c.abs() < SMALLEST { SMALLEST.copysign(c) } else { c }
}

#[inline]
fn upper(t: f32) -> f32 {
    t + t.abs() * DISTANCE_MARGIN
}

#[inline]
fn lower(t: f32) -> f32 {
    t - t.abs() * DISTANCE_MARGIN
}

/// A child that is still to be visited: `first` and `count` as in [`Node`].
#[derive(Clone, Copy)]
struct Entry {
    near: f32,
    first: u32,
    count: u32,
}

/// What is still to be visited: fixed room for ordinary trees, more on the heap for degenerate ones.
struct Stack {
    fixed: [Entry; Self::ROOM],
    length: usize,
    more: Vec<Entry>,
}

impl Stack {
    const ROOM: usize = 64;

    #[inline(always)]
    fn new() -> Self {
        Self { fixed: [Entry { near: 0.0, first: 0, count: 0 }; Self::ROOM], length: 0, more: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        if self.length == Self::ROOM {
            self.more.extend_from_slice(&self.fixed);
            self.length = 0;
        }
        self.fixed[self.length] = entry;
        self.length += 1;
    }

    #[inline(always)]
    fn pop_nearer_than(&mut self, far_limit: f32) -> Option<Entry> {
        loop {
            let entry = if self.length > 0 {
                self.length -= 1;
                self.fixed[self.length % Self::ROOM]
            } else {
                self.more.pop()?
            };
            if entry.near <= far_limit {
                return Some(entry);
            }
        }
    }
}

impl Slots {
    /// Adds slots for `primitives`; returns the first and how many.
    fn push(&mut self, primitives: &[u32]) -> (u32, u32) {
        let first = self.primitives.len() / self.per_slot;
        for chunk in primitives.chunks(self.per_slot) {
            self.primitives.extend_from_slice(chunk);
            self.primitives.extend(std::iter::repeat_n(u32::MAX, self.per_slot - chunk.len()));
        }
        (first as u32, (self.primitives.len() / self.per_slot - first) as u32)
    }
}

/// The binary tree: PLOC, reinsertion, leaves collapsed by cost.
fn build_binary(bounds: &[Bounds]) -> Bvh2 {
    let boxes: Vec<Aabb> = bounds.iter().map(|b| Aabb::new(Vec3A::from(b.min), Vec3A::from(b.max))).collect();
    build_bvh2(
        &boxes,
        BvhBuildParams { max_prims_per_leaf: 4, ..BvhBuildParams::medium_build() },
        &mut Duration::default(),
    )
}

/// Up to eight nodes that together stand for `root`: the inner one of largest surface is opened until there are enough.
fn widen(binary: &Bvh2, root: usize) -> Vec<usize> {
    if binary.nodes[root].is_leaf() {
        return vec![root];
    }
    let left = binary.nodes[root].first_index as usize;
    let mut children = vec![left, left + 1];
    while children.len() < WIDTH {
        let Some(widest) = (0..children.len())
            .filter(|&i| !binary.nodes[children[i]].is_leaf())
            .max_by(|&a, &b| area(binary, children[a]).total_cmp(&area(binary, children[b])))
        else {
            break;
        };
        let left = binary.nodes[children[widest]].first_index as usize;
        children[widest] = left;
        children.push(left + 1);
    }
    children
}

fn area(binary: &Bvh2, node: usize) -> f32 {
    binary.nodes[node].aabb().half_area()
}
