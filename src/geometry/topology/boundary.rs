//! Where a surface ends: its boundary as a chain of directed edges, and the loops that these form.

use std::collections::HashMap;

use glam::DVec3;

use crate::geometry::hierarchy::Extent;

/// One side of an edge whose faces do not cancel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfEdge {
    pub component: u32,
    pub from: u32,
    pub to: u32,
}

/// A closed way along the boundary.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    /// In the order in which the boundary runs.
    pub vertices: Vec<u32>,
    pub extent: Extent,
}

/// The boundary of a chain of faces: what is left of `half_edges` when opposite ones cancel. As the boundary of any chain, it enters every
/// vertex as often as it leaves it. Sorted by `from`.
pub(super) fn uncancelled(half_edges: &[HalfEdge]) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32, i32)> =
        (half_edges.iter()).map(|h| if h.from < h.to { (h.from, h.to, 1) } else { (h.to, h.from, -1) }).collect();
    edges.sort_unstable();
    let mut left: Vec<(u32, u32)> = Vec::new();
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (low, high, _) = edge[0];
        let excess: i32 = edge.iter().map(|e| e.2).sum();
        let way = if excess > 0 { (low, high) } else { (high, low) };
        left.extend(std::iter::repeat_n(way, excess.unsigned_abs() as usize));
    }
    left.sort_unstable();
    left
}

/// Takes `edges`, sorted by their starts, apart into loops that meet no vertex twice.
pub(super) fn loops(edges: &[(u32, u32)], positions: &[DVec3]) -> Vec<Loop> {
    let mut used = vec![false; edges.len()];
    // Where the search for an unused edge from a vertex goes on.
    let mut next_of: HashMap<u32, usize> = HashMap::with_capacity(edges.len());
    for (index, &(from, _)) in edges.iter().enumerate() {
        next_of.entry(from).or_insert(index);
    }
    let mut found = Vec::new();
    let mut way: Vec<u32> = Vec::new();
    let mut place_on_way: HashMap<u32, usize> = HashMap::new();
    for first in 0..edges.len() {
        if used[first] {
            continue;
        }
        way.clear();
        place_on_way.clear();
        let mut at = edges[first].0;
        loop {
            if let Some(&place) = place_on_way.get(&at) {
                let vertices = way.split_off(place);
                for vertex in &vertices {
                    place_on_way.remove(vertex);
                }
                let extent = Extent::of(vertices.iter().map(|&vertex| positions[vertex as usize]));
                found.push(Loop { vertices, extent });
            }
            let Some(next) = next_of.get_mut(&at) else { break };
            while *next < edges.len() && edges[*next].0 == at && used[*next] {
                *next += 1;
            }
            // All ways from here are used: back at the start.
            if *next >= edges.len() || edges[*next].0 != at {
                break;
            }
            used[*next] = true;
            place_on_way.insert(at, way.len());
            way.push(at);
            at = edges[*next].1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_edges(list: &[(u32, u32)]) -> Vec<HalfEdge> {
        list.iter().map(|&(from, to)| HalfEdge { component: 0, from, to }).collect()
    }

    #[test]
    fn opposite_edges_cancel() {
        assert_eq!(uncancelled(&half_edges(&[(1, 2), (2, 1), (2, 3), (3, 2), (3, 2)])), [(3, 2)]);
        assert_eq!(uncancelled(&half_edges(&[(1, 2), (1, 2)])), [(1, 2), (1, 2)]);
    }

    /// Two triangles that touch in a corner are two loops, whatever the order in which they are walked.
    #[test]
    fn loops_that_touch_are_taken_apart() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let edges = uncancelled(&half_edges(&[(0, 1), (1, 2), (2, 0), (0, 3), (3, 4), (4, 0)]));
        let found = loops(&edges, &positions);
        let mut sets: Vec<Vec<u32>> = found.into_iter().map(|l| l.vertices).collect();
        sets.iter_mut().for_each(|vertices| vertices.sort_unstable());
        sets.sort_unstable();
        assert_eq!(sets, [[0, 1, 2], [0, 3, 4]]);
    }
}
