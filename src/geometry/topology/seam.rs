//! Seams: where a surface was cut open and its two rims written a few roundings apart, as generators do at the angle 2π and exporters at the
//! borders of texture coordinates.
//!
//! Only free edges are joined, those along which more faces run one way than the other, and only with one that runs the other way between
//! the same two places. So two closed surfaces are never drawn together, however near they are, and a hole stays a hole. Besides, edges of
//! no length but rounding, as around the pole of a sphere whose last row is computed vertex by vertex, become points. How far apart the
//! same place may lie follows from the mesh: a few roundings of its coordinates, then a few roundings of single precision at its size, but
//! always little beside the faces that meet there.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;

use super::NONE;
use super::connect::Edges;
use crate::geometry::hierarchy::Extent;
use crate::geometry::sets::Sets;

/// Vertices farther apart than this share of the longest edge of the faces around them are different places.
const SHARE_OF_FACES: f64 = 1.0 / 16.0;
/// Roundings that two computations of the same place differ by.
const ROUNDINGS: f64 = 8.0;
/// Unit roundoff of f64 and of f32.
const UNIT_64: f64 = f64::EPSILON / 2.0;
const UNIT_32: f64 = f32::EPSILON as f64 / 2.0;
/// Representatives of one cell that a vertex is compared with.
const MOST_COMPARED: usize = 32;

/// How far a computation in f64 may miss a vertex, in units of the mesh.
pub(super) fn rounding(extent: Extent) -> f64 {
    ROUNDINGS * UNIT_64 * extent.min.abs().max(extent.max.abs()).max_element()
}

/// The distances within which rims are looked for, ascending, in units of the mesh.
pub(super) fn reaches(positions: &[DVec3], extent: Extent) -> Vec<f64> {
    let size = (extent.max - extent.min).max_element();
    let farthest = extent.min.abs().max(extent.max.abs()).max_element();
    let is_single = |x: f64| f64::from(x as f32) == x;
    let mut reaches = vec![rounding(extent), ROUNDINGS * UNIT_32 * size];
    if positions.iter().all(|p| p.to_array().into_iter().all(is_single)) {
        reaches.push(ROUNDINGS * UNIT_32 * farthest);
    }
    reaches.retain(|reach| *reach > 0.0 && reach.is_finite());
    reaches.sort_by(f64::total_cmp);
    reaches
}

/// Which vertices are the same place, the ends of edges no longer than `rounding`: what stands for each. `None` where there are no such edges.
pub(super) fn short_edges(faces: &[[u32; 3]], positions: &[DVec3], rounding: f64) -> Option<Vec<u32>> {
    let is_short = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= rounding;
    let short: Vec<[u32; 3]> = (faces.par_iter().copied())
        .filter(|face| {
            let [a, b, c] = face.map(|v| positions[v as usize]);
            is_short(a, b) || is_short(b, c) || is_short(c, a)
        })
        .collect();
    if short.is_empty() {
        return None;
    }
    let mut joined = Sets::new(positions.len());
    for face in short {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            if is_short(positions[a as usize], positions[b as usize]) {
                joined.join(a, b);
            }
        }
    }
    joined.joined()
}

/// One side of an edge whose faces do not cancel.
#[derive(Debug, Clone, Copy)]
struct FreeEdge {
    from: u32,
    to: u32,
}

/// Which vertices are the same place, the endpoints of free edges that lie on each other within `reach`, and of free edges that are no longer
/// than it: what stands for each. `None` where there are none.
pub(super) fn joints(faces: &[[u32; 3]], edges: &Edges, positions: &[DVec3], reach: f64) -> Option<Vec<u32>> {
    let (free, scales) = free_edges(faces, edges, positions);
    if free.is_empty() {
        return None;
    }
    let places = places(&free, &scales, positions, reach);
    let mut joined = Sets::new(positions.len());
    let mut sides: Vec<(u32, u32, bool, FreeEdge)> = Vec::with_capacity(free.len());
    for edge in free {
        let (from, to) = (places[&edge.from], places[&edge.to]);
        if from == to {
            joined.join(edge.from, edge.to);
        } else {
            sides.push((from.min(to), from.max(to), from > to, edge));
        }
    }
    sides.sort_unstable_by_key(|(low, high, is_down, edge)| (*low, *high, *is_down, edge.from, edge.to));
    for side in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        // Sheets on each other have rims that run the same way; those stay apart.
        if side[0].2 == side[side.len() - 1].2 {
            continue;
        }
        let (low, high) = ends(&side[0]);
        for edge in &side[1..] {
            let (other_low, other_high) = ends(edge);
            joined.join(low, other_low);
            joined.join(high, other_high);
        }
    }
    joined.joined()
}

/// The vertices of a free edge at the lower and at the higher of its places.
fn ends((_, _, is_down, edge): &(u32, u32, bool, FreeEdge)) -> (u32, u32) {
    if *is_down { (edge.to, edge.from) } else { (edge.from, edge.to) }
}

/// The free edges, and for each vertex on one the longest edge of the faces that it bounds.
fn free_edges(faces: &[[u32; 3]], edges: &Edges, positions: &[DVec3]) -> (Vec<FreeEdge>, HashMap<u32, f64>) {
    let mut free = Vec::new();
    let mut scales: HashMap<u32, f64> = HashMap::new();
    let balanced = balanced_crowds(faces, edges);
    for (index, (face, across)) in faces.iter().zip(&edges.neighbours).enumerate() {
        for (k, &other) in across.iter().enumerate() {
            if other != NONE || balanced.contains(&((3 * index + k) as u32)) {
                continue;
            }
            let [a, b, c] = face.map(|v| positions[v as usize]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let edge = FreeEdge { from: face[k], to: face[(k + 1) % 3] };
            for vertex in [edge.from, edge.to] {
                let scale = scales.entry(vertex).or_insert(0.0);
                *scale = scale.max(longest);
            }
            free.push(edge);
        }
    }
    (free, scales)
}

/// The half-edges on edges of three or more faces of which as many run one way as the other.
fn balanced_crowds(faces: &[[u32; 3]], edges: &Edges) -> HashSet<u32> {
    let runs_up = |half_edge: u32| {
        let (face, k) = (faces[(half_edge / 3) as usize], half_edge as usize % 3);
        face[k] < face[(k + 1) % 3]
    };
    (edges.crowds.iter())
        .filter(|crowd| 2 * crowd.iter().filter(|half_edge| runs_up(**half_edge)).count() == crowd.len())
        .flatten()
        .copied()
        .collect()
}

/// The vertex that stands for the place of each vertex of a free edge.
fn places(free: &[FreeEdge], scales: &HashMap<u32, f64>, positions: &[DVec3], reach: f64) -> HashMap<u32, u32> {
    let mut vertices: Vec<u32> = free.iter().flat_map(|edge| [edge.from, edge.to]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let cell_of = |p: DVec3| (p / reach).floor().to_array().map(|x| x as i64);
    let mut standing: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(vertices.len());
    let mut of_vertex = HashMap::with_capacity(vertices.len());
    for vertex in vertices {
        let position = positions[vertex as usize];
        let own_reach = |v: u32| reach.min(SHARE_OF_FACES * scales[&v]);
        let cell = cell_of(position);
        let mut nearest: Option<(f64, u32)> = None;
        for shift in 0..27 {
            let near = std::array::from_fn(|axis| cell[axis].saturating_add(shift / 3_i64.pow(axis as u32) % 3 - 1));
            for &other in standing.get(&near).into_iter().flatten().take(MOST_COMPARED) {
                let distance = position.distance(positions[other as usize]);
                let is_near = distance <= own_reach(vertex).min(own_reach(other));
                if is_near && nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, other));
                }
            }
        }
        let stands = nearest.map_or(vertex, |(_, other)| other);
        if stands == vertex {
            standing.entry(cell).or_default().push(vertex);
        }
        of_vertex.insert(vertex, stands);
    }
    of_vertex
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::connect::connect;

    /// A strip of three squares, bent into a ring whose last edge lies `gap` beside the first.
    fn ring(gap: f64) -> (Vec<[u32; 3]>, Vec<DVec3>) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [gap, gap]];
        let positions = corners.iter().flat_map(|&[x, z]| [0.0, 1.0].map(|y| DVec3::new(x, y, z))).collect();
        let faces = (0..3).flat_map(|k| {
            let [a, b, c, d] = [0, 1, 3, 2].map(|corner| 2 * k + corner);
            [[a, b, c], [a, c, d]]
        });
        (faces.collect(), positions)
    }

    fn joints_of(gap: f64, reach: f64) -> Option<Vec<u32>> {
        let (faces, positions) = ring(gap);
        joints(&faces, &connect(&faces, positions.len()), &positions, reach)
    }

    #[test]
    fn rims_within_reach_are_joined_and_others_not() {
        assert_eq!(joints_of(1e-9, 1e-8), Some(vec![0, 1, 2, 3, 4, 5, 0, 1]));
        assert_eq!(joints_of(1e-9, 1e-10), None);
        assert_eq!(joints_of(0.3, 1.0), None, "a gap as wide as a face is a gap");
    }

    #[test]
    fn edges_of_no_length_become_points() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1e-16, 0.0), DVec3::Y, DVec3::new(1.0, 1e-9, 0.0)];
        assert_eq!(short_edges(&[[0, 1, 2], [0, 2, 3]], &positions, 1e-15), Some(vec![0, 1, 1, 3, 4]));
        assert_eq!(short_edges(&[[0, 1, 4]], &positions, 1e-15), None);
    }

    #[test]
    fn sheets_on_each_other_stay_two() {
        let (mut faces, mut positions) = ring(0.5);
        faces.extend(faces.clone().iter().map(|face| face.map(|v| v + 8)));
        positions.extend(positions.clone().iter().map(|p| p + DVec3::splat(1e-12)));
        let edges = connect(&faces, positions.len());
        assert_eq!(joints(&faces, &edges, &positions, 1e-9), None);
    }

    #[test]
    fn how_far_apart_one_place_may_lie() {
        let extent = |p: &[DVec3]| Extent::of(p.iter().copied());
        let near = [DVec3::ZERO, DVec3::new(1.0, 0.3, 0.1)];
        let reaches_near = reaches(&near, extent(&near));
        assert!(reaches_near.len() == 2 && reaches_near[1] < 5e-7 && reaches_near[0] < 1e-15);
        // A file of f32 far from the origin has f32's roundings, one of f64 has not.
        let far = near.map(|p| (p * 8.0 + 1e6).as_vec3().as_dvec3());
        assert!(*reaches(&far, extent(&far)).last().unwrap() > 0.1);
        let far = near.map(|p| p + 1e6);
        assert!(*reaches(&far, extent(&far)).last().unwrap() < 1e-6);
    }
}
