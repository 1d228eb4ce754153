//! The tree as graphics processors walk it: binary, each node with the boxes of both children, over triangles and spheres together.
//!
//! It is made from the two wide trees, so that it is as good as they are and takes little time: the children of each wide node are divided
//! in two until each stands alone, where the surface area heuristic says.

use glam::Vec3;

use super::bounds::Bounds;
use super::bvh::Tree;
use super::geometry::Geometry;
use super::node::{LEAF as WIDE_LEAF, Node, WIDTH};
use super::ray::{NO_PRIMITIVE, PrimitiveId};
use super::triangle::PACK;

/// Set in references to leaves.
pub const LEAF: u32 = 1 << 31;
/// Set, next to [`LEAF`], in references to single spheres; the rest is the sphere's index.
pub const OF_SPHERE: u32 = 1 << 30;
/// Where in a reference to triangles their number less one stands; below is the first one's place in [`BinaryTree::triangles`].
pub const COUNT_SHIFT: u32 = 27;
/// Instead of the root of a tree over nothing.
pub const NOTHING: u32 = u32::MAX;

/// Triangles in a leaf, at the most.
const MOST_IN_LEAF: usize = 4;

/// A node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BinaryNode {
    /// Lowest and highest coordinates of each child.
    pub boxes: [(Vec3, Vec3); 2],
    /// Index of a node, or a leaf: see [`LEAF`].
    pub children: [u32; 2],
}

/// The tree.
#[derive(Debug, Clone, PartialEq)]
pub struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    /// In the order of the leaves.
    pub triangles: Vec<PrimitiveId>,
    /// A node, a leaf, or [`NOTHING`].
    pub root: u32,
    /// Nodes on the longest way down: as many may be waiting to be visited.
    pub depth: u32,
}

/// What is still to be put into the tree, with its box.
#[derive(Clone, Copy)]
struct Item {
    what: What,
    bounds: Bounds,
}

#[derive(Clone, Copy)]
enum What {
    /// A wide node of the tree over triangles, or of that over spheres.
    Wide {
        index: u32,
        of_spheres: bool,
    },
    Pack(u32),
    Triangle(PrimitiveId),
    Sphere(u32),
}

/// What is to be put below a node, on which side of it, and how deep; below none: at the root.
struct Open {
    items: Items,
    parent: Option<(usize, usize)>,
    depth: u32,
}

/// Up to eight of them.
#[derive(Clone, Copy)]
struct Items {
    list: [Item; WIDTH],
    length: usize,
}

impl Items {
    fn new(items: impl IntoIterator<Item = Item>) -> Self {
        let nothing = Item { what: What::Triangle(NO_PRIMITIVE), bounds: Bounds::EMPTY };
        let mut all = Self { list: [nothing; WIDTH], length: 0 };
        for item in items.into_iter().take(WIDTH) {
            all.list[all.length] = item;
            all.length += 1;
        }
        all
    }

    fn get(&self) -> &[Item] {
        &self.list[..self.length]
    }

    fn bounds(&self) -> Bounds {
        self.get().iter().fold(Bounds::EMPTY, |bounds, item| bounds.union(item.bounds))
    }

    /// Whether they are few enough triangles for a leaf.
    fn are_leaf(&self) -> bool {
        self.length <= MOST_IN_LEAF && self.get().iter().all(|item| matches!(item.what, What::Triangle(_)))
    }

    /// In two, where areas times numbers are least.
    fn halves(mut self) -> [Self; 2] {
        let mut best = (f32::INFINITY, 0, 1);
        for axis in 0..3 {
            self.sort(axis);
            for at in 1..self.length {
                let cost = [&self.get()[..at], &self.get()[at..]]
                    .map(|half| Self::new(half.iter().copied()))
                    .iter()
                    .map(|half| half.bounds().half_area() * half.length as f32)
                    .sum();
                if cost < best.0 {
                    best = (cost, axis, at);
                }
            }
        }
        let (_, axis, at) = best;
        self.sort(axis);
        [&self.get()[..at], &self.get()[at..]].map(|half| Self::new(half.iter().copied()))
    }

    fn sort(&mut self, axis: usize) {
        let middle = |item: &Item| item.bounds.min[axis] + item.bounds.max[axis];
        self.list[..self.length].sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    }
}

impl Geometry {
    /// The tree over all that there is (local coordinates). Boxes are larger than what is in them by at least 2⁻²¹ of their largest coordinate.
    pub fn binary_tree(&self) -> BinaryTree {
        let mut tree = BinaryTree { nodes: Vec::new(), triangles: Vec::new(), root: NOTHING, depth: 0 };
        tree.nodes.reserve(self.triangle_count() / 2 + self.sphere_count());
        tree.triangles.reserve_exact(self.triangle_count());
        let roots = [(&self.triangle_tree, false), (&self.sphere_tree, true)];
        let all = Items::new(roots.into_iter().filter(|(wide, _)| !wide.nodes.is_empty()).map(|(wide, of_spheres)| {
            let bounds = children(&wide.nodes[0]).fold(Bounds::EMPTY, |bounds, (_, child)| bounds.union(child));
            Item { what: What::Wide { index: 0, of_spheres }, bounds }
        }));
        if all.length == 0 {
            return tree;
        }
        let mut open = vec![Open { items: all, parent: None, depth: 0 }];
        while let Some(Open { items, parent, depth }) = open.pop() {
            let items = self.opened(items);
            let reference = if let [Item { what: What::Sphere(index), .. }] = items.get() {
                LEAF | OF_SPHERE | *index
            } else if items.are_leaf() {
                let first = tree.triangles.len() as u32;
                let triangles = items.get().iter().filter_map(|item| match item.what {
                    What::Triangle(id) => Some(id),
                    _ => None,
                });
                tree.triangles.extend(triangles);
                LEAF | ((items.length as u32 - 1) << COUNT_SHIFT) | first
            } else {
                let halves = items.halves();
                let node = tree.nodes.len();
                let boxes = [0, 1].map(|side: usize| halves[side].bounds()).map(|bounds| (bounds.min, bounds.max));
                tree.nodes.push(BinaryNode { boxes, children: [NOTHING; 2] });
                tree.depth = tree.depth.max(depth + 1);
                for side in [1, 0] {
                    open.push(Open { items: halves[side], parent: Some((node, side)), depth: depth + 1 });
                }
                node as u32
            };
            match parent {
                Some((node, side)) => tree.nodes[node].children[side] = reference,
                None => tree.root = reference,
            }
        }
        tree
    }

    /// What stands alone and can be taken apart is replaced by its parts.
    fn opened(&self, mut items: Items) -> Items {
        while let [Item { what, .. }] = items.get() {
            items = match *what {
                What::Wide { index, of_spheres } => {
                    let wide: &Tree = if of_spheres { &self.sphere_tree } else { &self.triangle_tree };
                    Items::new(children(&wide.nodes[index as usize]).map(|(child, bounds)| {
                        let what = match (child & WIDE_LEAF == 0, of_spheres) {
                            (true, _) => What::Wide { index: child, of_spheres },
                            (false, false) => What::Pack(child & !WIDE_LEAF),
                            (false, true) => What::Sphere(self.sphere_slots[(child & !WIDE_LEAF) as usize]),
                        };
                        Item { what, bounds }
                    }))
                }
                What::Pack(slot) => {
                    let ids = self.packs[slot as usize].ids;
                    Items::new(ids.into_iter().take(PACK).filter(|id| *id != NO_PRIMITIVE).map(|id| {
                        let corners = self.triangles[id as usize].map(|i| self.positions[i as usize]);
                        Item { what: What::Triangle(id), bounds: grown(Bounds::of(corners)) }
                    }))
                }
                What::Triangle(_) | What::Sphere(_) => break,
            };
        }
        items
    }
}

/// The used children of a wide node, with their boxes.
fn children(node: &Node) -> impl Iterator<Item = (u32, Bounds)> + '_ {
    node.boxes().map(|(lane, bounds)| (node.children[lane], bounds))
}

/// Larger as the boxes of the wide trees are.
fn grown(bounds: Bounds) -> Bounds {
    let margin = bounds.min.abs().max(bounds.max.abs()).max_element() * super::node::BOX_MARGIN;
    Bounds { min: bounds.min - margin, max: bounds.max + margin }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::{Mesh, Part};

    fn scene(triangles: usize, spheres: usize) -> Geometry {
        let at = |k: usize, step: f64| ((k as f64 + 0.5) * step).fract() * 10.0;
        let place = |k: usize| DVec3::new(at(k, 0.618_034), at(k, 0.754_878), at(k, 0.569_84));
        let mut mesh = Mesh::default();
        for k in 0..triangles {
            mesh.positions.extend([place(3 * k), place(3 * k) + DVec3::X * 0.3, place(3 * k) + place(k) * 0.05]);
            mesh.triangles.push([0, 1, 2].map(|corner| (3 * k + corner) as u32));
        }
        let ball = |k: usize| Part::Sphere { center: place(k), radius: 0.1 + 0.01 * k as f64 };
        let mut parts: Vec<Part> = (0..spheres).map(ball).collect();
        if triangles > 0 {
            parts.push(Part::Mesh { mesh, smooth: false });
        }
        Geometry::build(parts)
    }

    /// Every primitive lies in one leaf, and in the boxes of all nodes on the way to it.
    #[test]
    fn nothing_is_lost_and_boxes_hold_what_is_below_them() {
        for (triangles, spheres) in [(0, 0), (1, 0), (0, 1), (1, 1), (5, 0), (37, 9), (1000, 100)] {
            let geometry = scene(triangles, spheres);
            let tree = geometry.binary_tree();
            let all = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
            let mut open = vec![(tree.root, all, 0)];
            let mut met = vec![0; triangles + spheres];
            while let Some((reference, within, depth)) = open.pop() {
                if reference == NOTHING {
                    assert_eq!(triangles + spheres, 0);
                } else if reference & LEAF == 0 {
                    assert!(depth < tree.depth);
                    let node = &tree.nodes[reference as usize];
                    for (child, (min, max)) in node.children.into_iter().zip(node.boxes) {
                        open.push((child, Bounds { min: min.max(within.min), max: max.min(within.max) }, depth + 1));
                    }
                } else if reference & OF_SPHERE != 0 {
                    let index = (reference & !(LEAF | OF_SPHERE)) as usize;
                    let sphere = geometry.spheres[index];
                    let (min, max) = (sphere.center - sphere.radius, sphere.center + sphere.radius);
                    assert!(within.min.as_dvec3().cmple(min).all() && within.max.as_dvec3().cmpge(max).all());
                    met[triangles + index] += 1;
                } else {
                    let first = (reference & ((1 << COUNT_SHIFT) - 1)) as usize;
                    let count = ((reference >> COUNT_SHIFT & 7) + 1) as usize;
                    assert!(count <= MOST_IN_LEAF);
                    for &id in &tree.triangles[first..first + count] {
                        for corner in geometry.corners(id) {
                            let corner = corner.as_vec3();
                            assert!(within.min.cmplt(corner).all() && within.max.cmpgt(corner).all());
                        }
                        met[id as usize] += 1;
                    }
                }
            }
            assert!(met.iter().all(|times| *times == 1), "{triangles} {spheres}: {met:?}");
        }
    }
}
