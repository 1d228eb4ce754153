//! Edges of three or more faces: which two faces there are of one part.
//!
//! Two faces that name the same vertices in the file are of one part: exporters write each part with vertices of its own. Of those that
//! this leaves, neighbours by angle around the edge are, between which the part's material lies: parts that share vertices touch along the
//! edge, or overlap there, and are told apart like brackets.

use glam::DVec3;

use super::connect::Edges;

/// Faces closer together than this angle, in radians, lie on each other.
const SAME_ANGLE: f64 = 1e-9;

/// A half-edge on a crowded edge.
#[derive(Debug, Clone, Copy)]
struct Spoke {
    half_edge: u32,
    /// Around the edge, in units of [`SAME_ANGLE`].
    angle: i64,
    /// Whether the face runs from the edge's lower vertex to its higher: then its material lies before it, by angle.
    ends_material: bool,
}

/// Finds the partners on all crowded edges. `faces` are welded corners, `triangles` the file's own.
pub(super) fn find(edges: &mut Edges, faces: &[[u32; 3]], triangles: &[[u32; 3]], positions: &[DVec3]) {
    let ends = |list: &[[u32; 3]], half_edge: u32| {
        let (face, k) = ((half_edge / 3) as usize, (half_edge % 3) as usize);
        (list[face][k], list[face][(k + 1) % 3])
    };
    let mut found = Vec::new();
    for crowd in &edges.crowds {
        let mut named: Vec<((u32, u32), u32)> = (crowd.iter())
            .map(|&half_edge| {
                let (a, b) = ends(triangles, half_edge);
                ((a.min(b), a.max(b)), half_edge)
            })
            .collect();
        named.sort_unstable();
        let mut left = Vec::new();
        for same in named.chunk_by(|a, b| a.0 == b.0) {
            match *same {
                [(_, a), (_, b)] => found.push((a, b)),
                _ => left.extend(same.iter().map(|(_, half_edge)| *half_edge)),
            }
        }
        if left.len() < 2 {
            continue;
        }
        let (a, b) = ends(faces, left[0]);
        let (low, high) = (positions[a.min(b) as usize], positions[a.max(b) as usize]);
        let Some(axis) = (high - low).try_normalize() else { continue };
        let (u, v) = axis.any_orthonormal_pair();
        let mut spokes: Vec<Spoke> = (left.iter())
            .map(|&half_edge| {
                let opposite = faces[(half_edge / 3) as usize][(half_edge as usize + 2) % 3];
                let out = positions[opposite as usize] - low;
                let angle = (out.dot(v).atan2(out.dot(u)) / SAME_ANGLE).round() as i64;
                let (from, to) = ends(faces, half_edge);
                Spoke { half_edge, angle, ends_material: from < to }
            })
            .collect();
        // Where faces lie on each other, material ends before other material begins.
        spokes.sort_unstable_by_key(|spoke| (spoke.angle, !spoke.ends_material, spoke.half_edge));
        found.extend(brackets(&spokes));
    }
    for (a, b) in found {
        edges.partners.insert(a, b);
        edges.partners.insert(b, a);
        // Partners that run the same way look different ways.
        edges.is_mixed |= ends(faces, a) == ends(faces, b);
    }
}

/// Pairs each face at which material begins with the one at which it ends, around the circle.
fn brackets(spokes: &[Spoke]) -> Vec<(u32, u32)> {
    // Where the fewest are open nothing that began earlier is still to be closed.
    let (mut depth, mut least, mut first) = (0, 0, 0);
    for (index, spoke) in spokes.iter().enumerate() {
        depth += if spoke.ends_material { -1 } else { 1 };
        if depth < least {
            (least, first) = (depth, index + 1);
        }
    }
    let mut open: Vec<u32> = Vec::new();
    let mut pairs = Vec::new();
    for index in 0..spokes.len() {
        let spoke = spokes[(first + index) % spokes.len()];
        if !spoke.ends_material {
            open.push(spoke.half_edge);
        } else if let Some(begin) = open.pop() {
            pairs.push((begin, spoke.half_edge));
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spokes named by their place; `(` is where material begins.
    fn pairs(brackets_around: &str) -> Vec<(u32, u32)> {
        let spokes: Vec<Spoke> = (brackets_around.chars().zip(0..))
            .map(|(c, index)| Spoke { half_edge: index, angle: i64::from(index), ends_material: c == ')' })
            .collect();
        brackets(&spokes)
    }

    #[test]
    fn material_begins_and_ends_around_the_edge() {
        assert_eq!(pairs("()()"), [(0, 1), (2, 3)]);
        assert_eq!(pairs(")()("), [(1, 2), (3, 0)]);
        assert_eq!(pairs("(())"), [(1, 2), (0, 3)]);
        assert_eq!(pairs("())"), [(0, 1)]);
        assert_eq!(pairs("(("), []);
    }
}
