//! Connected parts of a surface, and faces that look the other way than their neighbours.

use super::NONE;
use super::connect::Edges;

pub(super) struct Components {
    pub count: u32,
    pub of_face: Vec<u32>,
    /// Faces that must be turned over so that all of a component look the same way; empty if there are none. In each component it is
    /// the lesser area that is turned.
    pub turned: Vec<bool>,
    /// By component: whether no way of turning faces makes them all agree, as on a Möbius strip; nothing is turned there, and some neighbours
    /// still run the same way along their edge.
    pub one_sided: Vec<bool>,
}

/// Components are joined by edges that exactly two faces share, and by partners on crowded edges, and numbered in the order of their first faces.
pub(super) fn components(faces: &[[u32; 3]], edges: &Edges, area: impl Fn(usize) -> f64) -> Components {
    let mut found =
        Components { count: 0, of_face: vec![NONE; faces.len()], turned: Vec::new(), one_sided: Vec::new() };
    if edges.is_mixed {
        found.turned = vec![false; faces.len()];
    }
    let mut open: Vec<u32> = Vec::new();
    let mut members: Vec<u32> = Vec::new();
    for first in 0..faces.len() {
        if found.of_face[first] != NONE {
            continue;
        }
        let component = found.count;
        found.count += 1;
        found.of_face[first] = component;
        open.push(first as u32);
        members.clear();
        let mut is_one_sided = false;
        while let Some(face) = open.pop() {
            let face = face as usize;
            if edges.is_mixed {
                members.push(face as u32);
            }
            for k in 0..3 {
                let other = edges.across(face, k);
                if other == NONE {
                    continue;
                }
                let other = other as usize;
                let is_new = found.of_face[other] == NONE;
                if is_new {
                    found.of_face[other] = component;
                    open.push(other as u32);
                }
                if edges.is_mixed {
                    let turned = found.turned[face] ^ run_the_same_way(faces, face, k, other);
                    if is_new {
                        found.turned[other] = turned;
                    } else {
                        is_one_sided |= found.turned[other] != turned;
                    }
                }
            }
        }
        found.one_sided.push(is_one_sided);
        if edges.is_mixed {
            found.settle(&members, is_one_sided, &area);
        }
    }
    found
}

impl Components {
    /// Of the two ways in which the faces of a component agree, the one that turns the lesser area.
    fn settle(&mut self, members: &[u32], is_one_sided: bool, area: impl Fn(usize) -> f64) {
        let (mut kept_area, mut turned_area) = (0.0, 0.0);
        for &face in members {
            let sum = if self.turned[face as usize] { &mut turned_area } else { &mut kept_area };
            *sum += area(face as usize);
        }
        let is_exchanged = turned_area > kept_area;
        for &face in members {
            let turned = &mut self.turned[face as usize];
            *turned = !is_one_sided && (*turned != is_exchanged);
        }
    }
}

/// Whether `face` and `other`, its neighbour across edge `k`, run along that edge in the same direction.
pub(super) fn run_the_same_way(faces: &[[u32; 3]], face: usize, k: usize, other: usize) -> bool {
    let (a, b) = (faces[face][k], faces[face][(k + 1) % 3]);
    (0..3).any(|j| (faces[other][j], faces[other][(j + 1) % 3]) == (a, b))
}
