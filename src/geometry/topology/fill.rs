//! How much surface is missing in a hole: the least area that was found to close its boundary.
//!
//! A loop is filled by cutting off the corner with the shortest new edge, again and again, which zips up slits and cracks, however long they
//! are; a fan from its middle is the better filling of some. Where a strip is missing all round a surface, two loops bound it, and are
//! filled as one, along a bridge between their nearest vertices, if that takes less.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::boundary::Loop;
use crate::geometry::hierarchy::Extent;

/// Loops among which those that belong together are looked for. Where there are more, holes are many and each is small.
const MOST_LOOPS: usize = 64;
/// Vertices of a loop at which the nearest one of another loop is looked for.
const MOST_ENDS: usize = 128;

/// The area that closes all `loops`, and what that adds to the volume measured from `reference`.
pub(super) fn fill(loops: &[Loop], positions: &[DVec3], reference: DVec3) -> Filling {
    let alone: Vec<Filling> = loops.iter().map(|l| fill_loop(&l.vertices, positions, reference)).collect();
    let mut all = Filling::default();
    let mut is_used = vec![false; loops.len()];
    if loops.len() <= MOST_LOOPS {
        for (saved, a, b) in bridged(loops, &alone, positions, reference) {
            if !is_used[a] && !is_used[b] {
                (is_used[a], is_used[b]) = (true, true);
                all = all.plus(saved);
            }
        }
    }
    (alone.iter().zip(is_used)).filter(|(_, used)| !used).fold(all, |all, (filling, _)| all.plus(*filling))
}

/// What closes a hole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Filling {
    pub area: f64,
    /// Of the tetrahedra from the reference point to its triangles.
    pub volume: f64,
}

impl Filling {
    fn plus(self, other: Self) -> Self {
        Self { area: self.area + other.area, volume: self.volume + other.volume }
    }

    /// With a triangle that looks the way of the missing face, corners relative to the reference point.
    fn with(self, [a, b, c]: [DVec3; 3]) -> Self {
        Self { area: self.area + (b - a).cross(c - a).length() / 2.0, volume: self.volume + a.dot(b.cross(c)) / 6.0 }
    }
}

/// Pairs of loops that take less area as one hole, those that save most first.
fn bridged(loops: &[Loop], alone: &[Filling], positions: &[DVec3], reference: DVec3) -> Vec<(Filling, usize, usize)> {
    let mut found: Vec<(f64, Filling, usize, usize)> = Vec::new();
    for a in 0..loops.len() {
        for b in a + 1..loops.len() {
            if !are_near(&loops[a].extent, &loops[b].extent) {
                continue;
            }
            let both = alone[a].area + alone[b].area;
            let way = bridge(&loops[a].vertices, &loops[b].vertices, positions);
            let filling = fill_loop(&way, positions, reference);
            if filling.area < both {
                found.push((both - filling.area, filling, a, b));
            }
        }
    }
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    found.into_iter().map(|(_, filling, a, b)| (filling, a, b)).collect()
}

/// Whether two loops are no farther apart than the lesser of them is wide: beyond that, lids take less than a strip between them.
fn are_near(a: &Extent, b: &Extent) -> bool {
    let apart = (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length();
    let width = |e: &Extent| (e.max - e.min).length();
    apart <= width(a).min(width(b))
}

/// One way along both loops, over the nearest two of their vertices.
fn bridge(a: &[u32], b: &[u32], positions: &[DVec3]) -> Vec<u32> {
    let some = |list: &[u32]| (0..list.len()).step_by(list.len().div_ceil(MOST_ENDS)).collect::<Vec<_>>();
    let distance = |i: usize, j: usize| positions[a[i] as usize].distance_squared(positions[b[j] as usize]);
    let pairs = some(a).into_iter().flat_map(|i| some(b).into_iter().map(move |j| (i, j)));
    let (i, j) = pairs.min_by(|x, y| distance(x.0, x.1).total_cmp(&distance(y.0, y.1))).unwrap_or((0, 0));
    let around = |list: &[u32], first: usize| -> Vec<u32> {
        list.iter().cycle().skip(first).take(list.len() + 1).copied().collect()
    };
    let mut way = around(a, i);
    way.extend(around(b, j));
    way
}

/// The lesser of two fillings of one loop of boundary edges, which run along the faces that are there.
fn fill_loop(way: &[u32], positions: &[DVec3], reference: DVec3) -> Filling {
    let points: Vec<DVec3> = way.iter().map(|&vertex| positions[vertex as usize] - reference).collect();
    let (fan, zip) = (fan(&points), zip(&points));
    if zip.area < fan.area { zip } else { fan }
}

/// Triangles from the middle of all corners.
fn fan(points: &[DVec3]) -> Filling {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let next = points.iter().cycle().skip(1);
    // The face runs from a to b, so the closing triangle runs from b to a.
    points.iter().zip(next).fold(Filling::default(), |filling, (a, b)| filling.with([*b, *a, middle]))
}

/// Corners cut off by ever the shortest new edge.
fn zip(points: &[DVec3]) -> Filling {
    let count = points.len();
    let mut before: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let mut after: Vec<usize> = (0..count).map(|i| (i + 1) % count).collect();
    let length = |i: usize, j: usize| points[i].distance_squared(points[j]).to_bits();
    // Squared lengths are not negative, and the bits of such numbers are in their order.
    let mut corners: BinaryHeap<Reverse<(u64, usize, usize, usize)>> =
        (0..count).map(|i| Reverse((length(before[i], after[i]), before[i], i, after[i]))).collect();
    let mut is_cut = vec![false; count];
    let mut filling = Filling::default();
    let mut left = count;
    while let Some(Reverse((_, a, corner, b))) = corners.pop() {
        if left < 3 {
            break;
        }
        if is_cut[corner] || before[corner] != a || after[corner] != b {
            continue;
        }
        filling = filling.with([points[b], points[corner], points[a]]);
        is_cut[corner] = true;
        (after[a], before[b]) = (b, a);
        left -= 1;
        for i in [a, b] {
            corners.push(Reverse((length(before[i], after[i]), before[i], i, after[i])));
        }
    }
    filling
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(count: u32, y: f64, is_reversed: bool) -> Vec<DVec3> {
        let turn =
            |k: u32| std::f64::consts::TAU * f64::from(if is_reversed { count - k } else { k }) / f64::from(count);
        (0..count).map(|k| DVec3::new(turn(k).cos(), y, turn(k).sin())).collect()
    }

    fn missing(loops: &[Vec<DVec3>]) -> Filling {
        let positions: Vec<DVec3> = loops.iter().flatten().copied().collect();
        let mut first = 0;
        let loops: Vec<Loop> = (loops.iter())
            .map(|l| {
                let vertices = (first..first + l.len() as u32).collect();
                first += l.len() as u32;
                Loop { extent: Extent::of(l.iter().copied()), vertices }
            })
            .collect();
        fill(&loops, &positions, DVec3::new(0.3, 0.2, -0.4))
    }

    #[test]
    fn a_square_is_closed_by_its_area() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let filling = missing(&[square]);
        assert!((filling.area - 1.0).abs() < 1e-15);
        // The lid looks down, and the reference lies 0.4 below it: a pyramid.
        assert!((filling.volume + 0.4 / 3.0).abs() < 1e-15, "{}", filling.volume);
    }

    #[test]
    fn a_long_slit_is_little() {
        // Up along a half circle and back beside it.
        let arc = |radius: f64, k: u32| {
            let angle = std::f64::consts::PI * f64::from(k) / 100.0;
            DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let slit: Vec<DVec3> = (0..=100).map(|k| arc(1.0, k)).chain((0..=100).rev().map(|k| arc(1.001, k))).collect();
        let area = missing(&[slit]).area;
        assert!((area / (std::f64::consts::PI * 0.001) - 1.0).abs() < 0.01, "{area}");
    }

    #[test]
    fn a_missing_strip_is_not_two_lids() {
        let strip = |height: f64| missing(&[circle(64, 0.0, false), circle(64, height, true)]).area;
        assert!((strip(0.1) / (0.1 * std::f64::consts::TAU) - 1.0).abs() < 0.02, "{}", strip(0.1));
        // Far apart, lids take less.
        let lids = 2.0 * std::f64::consts::PI;
        assert!((strip(3.0) / lids - 1.0).abs() < 0.01, "{}", strip(3.0));
        // Rims that run the same way bound no strip.
        let area = missing(&[circle(64, 0.0, false), circle(64, 0.1, false)]).area;
        assert!((area / lids - 1.0).abs() < 0.01, "{area}");
    }
}
