//! Which nodes of a binary tree become children of the nodes of a wide one: those for which rays are expected to cost least, by the surface
//! area heuristic (Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", 2017, section 3.1).
//!
//! What rays cost below a binary node, if it is to be represented by at most k children of a wide node, follows from the same of its two
//! children; so all is found in one pass upwards. Costs are areas, times those of a step.

use obvhs::bvh2::Bvh2;

use super::node::WIDTH;

/// Cost of testing a leaf, relative to that of opening a node. It is the same for one primitive as for as many as are tested at once.
const LEAF_COST: f32 = 1.0;

/// What is known of each node of the binary tree.
pub(super) struct Collapse<'a> {
    binary: &'a Bvh2,
    per_leaf: u32,
    /// For each node the cost if it becomes at most 1, 2, … 8 children.
    costs: Vec<[f32; WIDTH]>,
    /// Primitives below each node, as far as they count up to more than a leaf holds.
    counts: Vec<u32>,
}

impl<'a> Collapse<'a> {
    /// For leaves of up to `per_leaf` primitives. No leaf of the binary tree has more.
    pub fn new(binary: &'a Bvh2, per_leaf: usize) -> Self {
        let per_leaf = per_leaf as u32;
        let mut found = Self {
            binary,
            per_leaf,
            costs: vec![[0.0; WIDTH]; binary.nodes.len()],
            counts: vec![0; binary.nodes.len()],
        };
        for node in parents_first(binary).into_iter().rev() {
            found.weigh(node as usize);
        }
        found
    }

    fn weigh(&mut self, node: usize) {
        let source = &self.binary.nodes[node];
        let area = source.aabb().half_area();
        if source.is_leaf() {
            self.counts[node] = source.prim_count;
            self.costs[node] = [area * LEAF_COST; WIDTH];
            return;
        }
        let left = source.first_index as usize;
        let count = self.counts[left].saturating_add(self.counts[left + 1]);
        let (a, b) = (self.costs[left], self.costs[left + 1]);
        let mut costs = [f32::INFINITY; WIDTH];
        for children in 2..=WIDTH {
            for to_left in 1..children {
                costs[children - 1] = costs[children - 1].min(a[to_left - 1] + b[children - to_left - 1]);
            }
        }
        let inner = costs[WIDTH - 1] + area;
        costs[0] = if count <= self.per_leaf { inner.min(area * LEAF_COST) } else { inner };
        for children in 1..WIDTH {
            costs[children] = costs[children].min(costs[children - 1]);
        }
        self.costs[node] = costs;
        self.counts[node] = count;
    }

    /// Whether `node`, being one child, is a leaf.
    pub fn is_leaf(&self, node: usize) -> bool {
        let source = &self.binary.nodes[node];
        source.is_leaf()
            || self.counts[node] <= self.per_leaf && source.aabb().half_area() * LEAF_COST <= self.costs[node][0]
    }

    /// The nodes that are the children of a wide node in place of `node`, which is no leaf; or `node` itself where it is a leaf.
    pub fn children(&self, node: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(WIDTH);
        if self.binary.nodes[node].is_leaf() {
            return vec![node];
        }
        // (node, at most how many children it becomes)
        let mut open = self.split(node, WIDTH).to_vec();
        while let Some((node, most)) = open.pop() {
            // As few as cost no more.
            let costs = &self.costs[node];
            let few = (1..=most).find(|&k| costs[k - 1] <= costs[most - 1]).unwrap_or(most);
            if few == 1 {
                children.push(node);
            } else {
                open.extend(self.split(node, few));
            }
        }
        children
    }

    /// How `most` ≥ 2 children are best shared among the two below an inner node.
    fn split(&self, node: usize, most: usize) -> [(usize, usize); 2] {
        let left = self.binary.nodes[node].first_index as usize;
        let (a, b) = (&self.costs[left], &self.costs[left + 1]);
        let cost = |to_left: usize| a[to_left - 1] + b[most - to_left - 1];
        let to_left = (1..most).min_by(|&i, &j| cost(i).total_cmp(&cost(j))).unwrap_or(1);
        [(left, to_left), (left + 1, most - to_left)]
    }

    /// The primitives below `node`.
    pub fn primitives(&self, node: usize) -> Vec<u32> {
        let mut primitives = Vec::with_capacity(self.per_leaf as usize);
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            let source = &self.binary.nodes[node];
            let first = source.first_index as usize;
            if source.is_leaf() {
                primitives.extend_from_slice(&self.binary.primitive_indices[first..first + source.prim_count as usize]);
            } else {
                open.extend([first + 1, first]);
            }
        }
        primitives
    }
}

/// The nodes, each before those below it.
fn parents_first(binary: &Bvh2) -> Vec<u32> {
    let mut order = Vec::with_capacity(binary.nodes.len());
    order.push(0);
    let mut next = 0;
    while next < order.len() {
        let node = &binary.nodes[order[next] as usize];
        if !node.is_leaf() {
            order.extend([node.first_index, node.first_index + 1]);
        }
        next += 1;
    }
    order
}
