//! Which vertices are the same and which faces meet at which edges.

use std::collections::HashMap;

use glam::DVec3;

use super::NONE;

/// For each position the index of the first that is bit-equal to it; −0 is 0.
pub(super) fn weld(positions: &[DVec3]) -> Vec<u32> {
    const FREE: u32 = u32::MAX;
    // Open addressing, at most half full.
    let size = (2 * positions.len()).next_power_of_two();
    let mut table = vec![FREE; size];
    let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    (positions.iter().enumerate())
        .map(|(index, &p)| {
            let bits = key(p);
            let mut slot = mix(bits) as usize & (size - 1);
            loop {
                match table[slot] {
                    FREE => {
                        table[slot] = index as u32;
                        return index as u32;
                    }
                    found if key(positions[found as usize]) == bits => return found,
                    _ => slot = (slot + 1) & (size - 1),
                }
            }
        })
        .collect()
}

/// Folded multiplications.
#[inline]
fn mix(bits: [u64; 3]) -> u64 {
    let fold = |a: u64, b: u64| {
        let product = u128::from(a) * u128::from(b);
        product as u64 ^ (product >> 64) as u64
    };
    let a = fold(bits[0] ^ 0x9E37_79B9_7F4A_7C15, bits[1] ^ 0xA076_1D64_78BD_642F);
    fold(a ^ 0xE703_7ED1_A0B4_28DB, bits[2] ^ 0x8EBC_6AF0_9C88_C6E3)
}

/// What meets at the edges.
#[derive(Default)]
pub(super) struct Edges {
    /// Face across each edge; [`NONE`] where it is not shared by exactly two faces.
    pub neighbours: Vec<[u32; 3]>,
    /// Whether two neighbours run along their edge in the same direction.
    pub is_mixed: bool,
    /// Whether two faces have the same three corners.
    pub has_twins: bool,
    /// The half-edges of each edge of three or more faces, as 3 · face + corner.
    pub crowds: Vec<Vec<u32>>,
    /// Half-edges on crowded edges that belong together: two faces of one part.
    pub partners: HashMap<u32, u32>,
}

/// Finds the neighbours of `faces`, three different vertices each, all below `vertices`.
pub(super) fn connect(faces: &[[u32; 3]], vertices: usize) -> Edges {
    // Half-edges by the lower of their two vertices, as (higher vertex, half-edge).
    let mut ends = vec![0_u32; vertices + 1];
    for face in faces {
        for k in 0..3 {
            ends[face[k].min(face[(k + 1) % 3]) as usize + 1] += 1;
        }
    }
    for vertex in 0..vertices {
        ends[vertex + 1] += ends[vertex];
    }
    // While it is filled, `ends[v]` is where the next half-edge of `v` goes; after that it is where those of `v` end.
    let mut half_edges = vec![0_u64; 3 * faces.len()];
    for (index, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let next = &mut ends[a.min(b) as usize];
            half_edges[*next as usize] = u64::from(a.max(b)) << 32 | (3 * index + k) as u64;
            *next += 1;
        }
    }

    let mut edges = Edges { neighbours: vec![[NONE; 3]; faces.len()], ..Edges::default() };
    let mut start = 0;
    for &end in &ends[..vertices] {
        let around = &mut half_edges[start..end as usize];
        start = end as usize;
        around.sort_unstable();
        for edge in around.chunk_by(|a, b| a >> 32 == b >> 32) {
            edges.add(faces, edge);
        }
    }
    edges
}

impl Edges {
    /// The face across edge `k` of a face: its neighbour, or on a crowded edge its partner; [`NONE`] if there is none.
    pub fn across(&self, face: usize, k: usize) -> u32 {
        match self.neighbours[face][k] {
            NONE if !self.partners.is_empty() => {
                self.partners.get(&((3 * face + k) as u32)).map_or(NONE, |partner| partner / 3)
            }
            neighbour => neighbour,
        }
    }

    /// The half-edges of one edge.
    fn add(&mut self, faces: &[[u32; 3]], edge: &[u64]) {
        let place = |half_edge: u64| {
            let id = half_edge as u32;
            ((id / 3) as usize, (id % 3) as usize)
        };
        let opposite = |half_edge: u64| {
            let (face, k) = place(half_edge);
            faces[face][(k + 2) % 3]
        };
        match *edge {
            [_] => {}
            [a, b] => {
                let ((f, i), (g, j)) = (place(a), place(b));
                self.neighbours[f][i] = g as u32;
                self.neighbours[g][j] = f as u32;
                self.is_mixed |= faces[f][i] == faces[g][j];
                self.has_twins |= opposite(a) == opposite(b);
            }
            _ => {
                let crowd: Vec<u32> = edge.iter().map(|&half_edge| half_edge as u32).collect();
                self.crowds.push(crowd);
                let mut opposites: Vec<u32> = edge.iter().map(|&half_edge| opposite(half_edge)).collect();
                opposites.sort_unstable();
                self.has_twins |= opposites.windows(2).any(|pair| pair[0] == pair[1]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_equal_bits_are_welded() {
        let tiny = f64::MIN_POSITIVE;
        let positions = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(-0.0, 0.0, -0.0),
            DVec3::new(tiny, 0.0, 0.0),
            DVec3::X,
            DVec3::new(1.0 + f64::EPSILON, 0.0, 0.0),
        ];
        assert_eq!(weld(&positions), [0, 1, 0, 3, 1, 5]);
        assert!(weld(&[]).is_empty());
    }

    #[test]
    fn neighbours_open_mixed_and_crowded() {
        let edges = connect(&[[0, 1, 2], [2, 1, 3]], 4);
        assert_eq!(edges.neighbours, [[NONE, 1, NONE], [0, NONE, NONE]]);
        assert!(!edges.is_mixed && !edges.has_twins && edges.crowds.is_empty());
        let turned = connect(&[[0, 1, 2], [1, 2, 3]], 4);
        assert!(turned.is_mixed && turned.neighbours[0][1] == 1);
        let fan = connect(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 5);
        assert_eq!((fan.crowds.len(), fan.neighbours[0][0], fan.has_twins), (1, NONE, false));
        assert!(connect(&[[0, 1, 2], [1, 2, 0]], 3).has_twins);
        assert!(connect(&[[0, 1, 2], [1, 0, 2], [0, 1, 3]], 4).has_twins);
    }
}
