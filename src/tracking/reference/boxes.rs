//! A binary tree over boxes: split at the median along the longest side, again and again.

use glam::DVec3;

/// Items in a leaf at the most.
const LEAF: usize = 4;

/// Lowest and highest coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether `point` lies in the box, or no farther from it than `margin` along any axis.
    #[inline]
    pub fn contains(&self, point: DVec3, margin: f64) -> bool {
        point.cmpge(self.min - margin).all() && point.cmple(self.max + margin).all()
    }

    pub fn has(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Below {
    /// Where the second of two nodes stands; the first stands right behind this one.
    Nodes(u32),
    /// Items, by their places in [`Tree::order`].
    Items { first: u32, count: u32 },
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub bounds: Bounds,
    pub below: Below,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Tree {
    /// The root first, each node before those below it. None where there are no items.
    pub nodes: Vec<Node>,
    /// Items as they stand in the leaves.
    pub order: Vec<u32>,
}

impl Tree {
    pub fn build(boxes: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            tree.split(boxes, 0, boxes.len());
        }
        tree
    }

    fn split(&mut self, boxes: &[Bounds], first: usize, last: usize) {
        let items = &mut self.order[first..last];
        let bounds = items.iter().fold(Bounds::EMPTY, |b, &i| b.union(boxes[i as usize]));
        let node = self.nodes.len();
        let below = Below::Items { first: first as u32, count: items.len() as u32 };
        self.nodes.push(Node { bounds, below });
        if items.len() <= LEAF {
            return;
        }
        let middle = |item: u32| boxes[item as usize].min + boxes[item as usize].max;
        let spread = Bounds::of(items.iter().map(|&item| middle(item)));
        let sides = spread.max - spread.min;
        let axis = if sides.x >= sides.max_element() {
            0
        } else if sides.y >= sides.max_element() {
            1
        } else {
            2
        };
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
        self.split(boxes, first, first + half);
        self.nodes[node].below = Below::Nodes(self.nodes.len() as u32);
        self.split(boxes, first + half, last);
    }

    /// Calls `visit` with the place in [`Tree::order`] of every item in a leaf whose nodes all pass `may_matter`.
    #[inline]
    pub fn walk(&self, may_matter: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(usize)) {
        let mut open = [0_u32; 64];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let index = open[count];
            let node = &self.nodes[index as usize];
            if !may_matter(&node.bounds) {
                continue;
            }
            match node.below {
                Below::Nodes(second) => {
                    // Halving 2³² items takes 32 steps, so the room is enough.
                    (open[count], open[count + 1]) = (second, index + 1);
                    count += 2;
                }
                Below::Items { first, count } => {
                    (first as usize..(first + count) as usize).for_each(&mut visit);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_found_where_it_is_and_nowhere_else() {
        for count in [0_u32, 1, 4, 5, 9, 300] {
            let place = |i: u32| DVec3::new(f64::from(i * 37 % 101), f64::from(i * 53 % 89), f64::from(i % 3));
            let boxes: Vec<Bounds> = (0..count).map(|i| Bounds { min: place(i), max: place(i) + 2.0 }).collect();
            let tree = Tree::build(&boxes);
            for i in 0..count {
                let point = place(i) + 1.0;
                let mut found = Vec::new();
                tree.walk(
                    |b| b.contains(point, 0.0),
                    |place| {
                        let item = tree.order[place];
                        if boxes[item as usize].contains(point, 0.0) {
                            found.push(item);
                        }
                    },
                );
                found.sort_unstable();
                let expected: Vec<u32> = (0..count).filter(|&j| boxes[j as usize].contains(point, 0.0)).collect();
                assert_eq!(found, expected);
            }
        }
    }
}
