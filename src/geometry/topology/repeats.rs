//! Faces over the same corners as others.
//!
//! A surface with repeats is read in the way that leaves the least boundary: a face that somebody wrote twice is dropped, a part that was
//! written twice is dropped as a whole, and a wall that two parts have in common stays with both, since each would be open without it.
//! Two faces that look opposite ways enclose nothing between them.

use std::collections::HashMap;

/// What becomes of each face.
#[derive(Debug, Clone, Default)]
pub(super) struct Repeats {
    pub is_kept: Vec<bool>,
    /// Faces that repeat another and are not kept.
    pub duplicates: Vec<u32>,
    /// Faces of pairs that look opposite ways and of which not both are kept, in pairs.
    pub doubles: Vec<[u32; 2]>,
}

/// Faces over the same three corners.
struct Group {
    /// Those that run along the sorted corners, and those that run the other way.
    faces: [Vec<u32>; 2],
    corners: [u32; 3],
}

/// A group in a patch, read by the faces on side `side`.
#[derive(Clone, Copy)]
struct Member {
    group: usize,
    side: usize,
}

/// Decides about all faces, three different vertices each.
pub(super) fn decide(faces: &[[u32; 3]]) -> Repeats {
    let groups = groups(faces);
    let mut repeats = Repeats { is_kept: vec![true; faces.len()], ..Repeats::default() };
    // A mesh that is written twice, once for each side, is one surface.
    if groups.iter().all(|group| group.faces.iter().all(|side| !side.is_empty())) {
        for group in &groups {
            let side = usize::from(group.faces[0][0] > group.faces[1][0]);
            repeats.keep(group, side, 1);
        }
        repeats.sort();
        return repeats;
    }
    let repeated: Vec<usize> =
        (0..groups.len()).filter(|&g| groups[g].faces.iter().map(Vec::len).sum::<usize>() > 1).collect();
    let mut at_edge: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
    for &g in &repeated {
        for (low, high, _) in groups[g].edges(0) {
            at_edge.entry((low, high)).or_default().push(g);
        }
    }
    let excess = excess(faces, &at_edge);
    let mut is_seen = vec![false; groups.len()];
    for &first in &repeated {
        if !is_seen[first] {
            let patch = patch(first, &groups, &at_edge, &mut is_seen);
            settle(&patch, &groups, &excess, &mut repeats);
        }
    }
    repeats.sort();
    repeats
}

/// All groups, by their corners.
fn groups(faces: &[[u32; 3]]) -> Vec<Group> {
    let mut keys: Vec<([u32; 3], bool, u32)> = (faces.iter().zip(0..))
        .map(|(&[a, b, c], index)| {
            let mut sorted = [a, b, c];
            sorted.sort_unstable();
            let is_even = sorted == [a, b, c] || sorted == [b, c, a] || sorted == [c, a, b];
            (sorted, !is_even, index)
        })
        .collect();
    keys.sort_unstable();
    keys.chunk_by(|a, b| a.0 == b.0)
        .map(|twins| {
            let of_side = |is_odd| twins.iter().filter(|twin| twin.1 == is_odd).map(|twin| twin.2).collect();
            Group { faces: [of_side(false), of_side(true)], corners: twins[0].0 }
        })
        .collect()
}

impl Group {
    /// The edges of its faces on `side`, each with 1 where it runs from the lower vertex to the higher, else −1.
    fn edges(&self, side: usize) -> [(u32, u32, i32); 3] {
        let [a, b, c] = self.corners;
        let sign = if side == 0 { 1 } else { -1 };
        [(a, b, sign), (b, c, sign), (a, c, -sign)]
    }

    /// Faces on `side` beyond those on the other.
    fn net(&self, side: usize) -> i32 {
        self.faces[side].len() as i32 - self.faces[1 - side].len() as i32
    }

    /// The side of the most faces, or of the first.
    fn main_side(&self) -> usize {
        usize::from(self.net(0) < 0 || (self.net(0) == 0 && self.faces[1][0] < self.faces[0][0]))
    }

    /// How many faces it has on its sides, the most first.
    fn counts(&self) -> (usize, usize) {
        let main = self.main_side();
        (self.faces[main].len(), self.faces[1 - main].len())
    }
}

/// By how many more half-edges run up each of those edges than down it.
fn excess(faces: &[[u32; 3]], at_edge: &HashMap<(u32, u32), Vec<usize>>) -> HashMap<(u32, u32), i32> {
    let mut excess: HashMap<(u32, u32), i32> = at_edge.keys().map(|edge| (*edge, 0)).collect();
    for face in faces {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            if let Some(sum) = excess.get_mut(&(a.min(b), a.max(b))) {
                *sum += if a < b { 1 } else { -1 };
            }
        }
    }
    excess
}

/// The groups that hang together with the one given and have as many faces, sides chosen so that neighbours look the same way.
fn patch(
    first: usize,
    groups: &[Group],
    at_edge: &HashMap<(u32, u32), Vec<usize>>,
    is_seen: &mut [bool],
) -> Vec<Member> {
    let counts = groups[first].counts();
    let mut members = vec![Member { group: first, side: groups[first].main_side() }];
    is_seen[first] = true;
    let mut next = 0;
    while let Some(&Member { group, side }) = members.get(next) {
        next += 1;
        for (low, high, sign) in groups[group].edges(side) {
            for &other in &at_edge[&(low, high)] {
                let group = &groups[other];
                if is_seen[other] || group.counts() != counts {
                    continue;
                }
                let against = |side: usize| group.edges(side).contains(&(low, high, -sign));
                let side = if counts.0 == counts.1 { usize::from(!against(0)) } else { group.main_side() };
                if against(side) {
                    is_seen[other] = true;
                    members.push(Member { group: other, side });
                }
            }
        }
    }
    members
}

/// Keeps as many of a patch's faces as leave the least boundary.
fn settle(patch: &[Member], groups: &[Group], excess: &HashMap<(u32, u32), i32>, repeats: &mut Repeats) {
    let mut own: HashMap<(u32, u32), i32> = HashMap::new();
    for member in patch {
        for (low, high, sign) in groups[member.group].edges(member.side) {
            *own.entry((low, high)).or_default() += sign;
        }
    }
    let net = groups[patch[0].group].net(patch[0].side);
    let has_both_sides = groups[patch[0].group].counts().1 > 0;
    let boundary =
        |count: i32| -> i32 { own.iter().map(|(edge, sign)| (excess[edge] + (count - net) * sign).abs()).sum() };
    let count = if own.values().all(|sign| *sign == 0) {
        // A part of its own, written more than once.
        1
    } else {
        // Of equals the first: as it stands.
        let choices = [net, 1, -1].into_iter().take(if has_both_sides { 3 } else { 2 });
        choices.min_by_key(|&count| boundary(count)).unwrap_or(net)
    };
    for member in patch {
        let side = if count < 0 { 1 - member.side } else { member.side };
        repeats.keep(&groups[member.group], side, count.unsigned_abs() as usize);
    }
}

impl Repeats {
    /// Keeps the first `count` faces of a side and drops the others of the group.
    fn keep(&mut self, group: &Group, side: usize, count: usize) {
        let (kept, dropped) = group.faces[side].split_at(count.min(group.faces[side].len()));
        let other = &group.faces[1 - side];
        if dropped.is_empty() && other.is_empty() {
            return;
        }
        // Of the pairs that look opposite ways one face is kept, or none.
        let pairs = other.len().min(group.faces[side].len());
        self.doubles.extend((0..pairs).map(|i| [group.faces[side][i], other[i]]));
        self.duplicates.extend(dropped.iter().skip(if kept.is_empty() { pairs } else { pairs.saturating_sub(1) }));
        self.duplicates.extend(other.iter().skip(pairs));
        for &face in dropped.iter().chain(other) {
            self.is_kept[face as usize] = false;
        }
    }

    fn sort(&mut self) {
        self.duplicates.sort_unstable();
        self.doubles.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron over those vertices.
    fn tetrahedron([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 4] {
        [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
    }

    fn kept(faces: &[[u32; 3]]) -> (Vec<usize>, usize, usize) {
        let repeats = decide(faces);
        let kept = (0..faces.len()).filter(|&face| repeats.is_kept[face]).collect();
        (kept, repeats.duplicates.len(), repeats.doubles.len())
    }

    #[test]
    fn a_wall_in_common_stays_with_both_parts() {
        // The same wall, the same way round: the smaller lies in the larger.
        let faces = [tetrahedron([0, 1, 2, 3]), tetrahedron([0, 1, 2, 4])].concat();
        assert_eq!(kept(&faces), ((0..8).collect(), 0, 0));
        // The other way round: they stand side by side, and nothing is between them.
        let faces = [tetrahedron([0, 1, 2, 3]), tetrahedron([1, 0, 2, 4])].concat();
        assert_eq!(kept(&faces), (vec![1, 2, 3, 5, 6, 7], 0, 1));
    }

    #[test]
    fn stray_repeats_and_whole_parts_are_dropped() {
        let part = tetrahedron([0, 1, 2, 3]);
        for stray in [vec![part[1]], vec![part[1], part[1]], vec![part[0], part[2]]] {
            let faces = [&part[..], &stray].concat();
            assert_eq!(kept(&faces), ((0..4).collect(), stray.len(), 0));
        }
        let other = tetrahedron([4, 5, 6, 7]);
        assert_eq!(kept(&[part, other, part].concat()), ((0..8).collect(), 4, 0));
        // One face turned over beside the right one, and the wrong one alone.
        let [a, b, c] = part[1];
        assert_eq!(kept(&[&part[..], &[[a, c, b]]].concat()), ((0..4).collect(), 0, 1));
        // Written for both sides.
        let back = part.map(|[a, b, c]| [a, c, b]);
        assert_eq!(kept(&[part, back].concat()), ((0..4).collect(), 0, 4));
        assert_eq!(kept(&[part, other, back].concat()), ((0..8).collect(), 0, 4));
    }

    #[test]
    fn a_flap_goes() {
        let part = tetrahedron([0, 1, 2, 3]);
        let faces = [&part[..], &[[0, 1, 5], [1, 0, 5]]].concat();
        assert_eq!(kept(&faces), ((0..4).collect(), 0, 1));
    }
}
