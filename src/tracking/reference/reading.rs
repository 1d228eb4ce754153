//! A mesh as it was loaded, read anew: which of its triangles belong together, which way they look, and what they enclose.
//!
//! A *part* is what hangs together by edges. Where just two triangles share an edge they are neighbours, and one looks the way the other
//! does. Where more share it, the file's own vertices may tell which of them belong together; if not, all do. Parts that touch in a corner,
//! or with vertices of their own, stay apart.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use super::boxes::{Bounds, Tree};
use super::vertices::clustered;
use super::winding::{Allowed, PointInPlane, Winding};
use crate::geometry::Mesh;

/// A surface encloses nothing if closing it would take more than this share of its own area.
const LARGEST_GAP: f64 = 1.0 / 3.0;

/// What a mesh encloses, in local coordinates.
pub(super) struct Reading {
    pub triangles: Vec<[DVec3; 3]>,
    /// By triangle.
    pub parts: Vec<u32>,
    /// By part: whether no edge of it has more than two triangles.
    pub is_simple: Vec<bool>,
    /// The same triangles as the mesh has them: not yet turned, each corner where it stands.
    pub as_written: Vec<[DVec3; 3]>,
    /// The area that would close the surface, over its own.
    pub gap: f64,
    /// Of all parts together, cavities less; infinite where nothing is enclosed.
    pub volume: f64,
}

/// A triangle on its way.
#[derive(Debug, Clone, Copy)]
struct Face {
    /// Corners as clusters of vertices.
    corners: [u32; 3],
    /// Where the mesh has it.
    index: u32,
}

/// An edge of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    ends: [u32; 2],
    /// The mesh's own vertices there.
    written: [u32; 2],
    face: u32,
    is_forward: bool,
}

/// Faces in sets, each face known to look as the first of its set does or the other way (union–find with parity).
struct Sets {
    above: Vec<(u32, bool)>,
}

impl Sets {
    fn root(&mut self, face: u32) -> (u32, bool) {
        let (mut root, mut is_opposite) = (face, false);
        while self.above[root as usize].0 != root {
            let (above, opposite) = self.above[root as usize];
            (root, is_opposite) = (above, is_opposite ^ opposite);
        }
        // Shorter ways for the next time.
        let (mut below, mut rest) = (face, is_opposite);
        while below != root {
            let (above, opposite) = std::mem::replace(&mut self.above[below as usize], (root, rest));
            (below, rest) = (above, rest ^ opposite);
        }
        (root, is_opposite)
    }

    fn join(&mut self, a: u32, b: u32, is_opposite: bool) {
        let ((root_a, a_is_opposite), (root_b, b_is_opposite)) = (self.root(a), self.root(b));
        // What disagrees on its way round, as a Möbius strip does, is left as it is.
        if root_a != root_b {
            self.above[root_b as usize] = (root_a, a_is_opposite ^ b_is_opposite ^ is_opposite);
        }
    }
}

impl Reading {
    /// In coordinates relative to `origin`, which is given in scene coordinates.
    pub fn new(mesh: &Mesh, scene_from_object: &DAffine3, origin: DVec3) -> Self {
        let first_of = clustered(&mesh.positions, &mesh.triangles);
        let mut faces: Vec<Face> = (mesh.triangles.iter().zip(0..))
            .map(|(triangle, index)| Face { corners: triangle.map(|i| first_of[i as usize]), index })
            .filter(|face| {
                let [a, b, c] = face.corners;
                a != b && b != c && c != a
            })
            .collect();
        drop_second_sides(&mut faces);
        drop_strays(&mut faces);
        let sides = sides_of(&faces, &mesh.triangles);
        let (part_of_face, is_turned, is_simple) = connected(&sides, faces.len());
        let at = |corner: u32| mesh.positions[corner as usize];
        let mut triangles: Vec<[DVec3; 3]> = (faces.iter().zip(&is_turned))
            .map(|(face, turned)| {
                let [a, b, c] = face.corners.map(at);
                if *turned { [a, c, b] } else { [a, b, c] }
            })
            .collect();
        let count = is_simple.len();
        let bodies = measured(&triangles, &part_of_face, count, &faces, &is_turned);
        let is_over = judged(&bodies, &triangles, &part_of_face);
        for (triangle, &part) in triangles.iter_mut().zip(&part_of_face) {
            if is_over[part as usize] {
                triangle.swap(1, 2);
            }
        }
        let is_turned: Vec<bool> =
            is_turned.iter().zip(&part_of_face).map(|(turned, &part)| *turned != is_over[part as usize]).collect();
        // Of all together: where parts meet at an edge, their boundaries may cancel.
        let boundary = boundary_of(&faces, &is_turned, &vec![0; faces.len()], 1, &at);
        let area: f64 = bodies.iter().map(|body| body.area).sum();
        let gap = if boundary[0].area > 0.0 { boundary[0].area / area } else { 0.0 };
        let volume: f64 =
            bodies.iter().zip(&is_over).map(|(b, over)| if *over { -b.volume } else { b.volume }).sum::<f64>().abs();
        let mirrors = scene_from_object.matrix3.determinant() < 0.0;
        let scale = scene_from_object.matrix3.determinant().abs();
        // As the scene's geometry has them, which rays meet: rounded to f32.
        let rounded = |p: DVec3| (scene_from_object.transform_point3(p) - origin).as_vec3().as_dvec3();
        let as_written =
            faces.iter().map(|face| mesh.triangles[face.index as usize].map(|i| rounded(mesh.positions[i as usize])));
        let encloses = gap <= LARGEST_GAP && volume > 0.0;
        Self {
            as_written: as_written.collect(),
            triangles: triangles
                .into_iter()
                .map(|[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] }.map(rounded))
                .collect(),
            parts: part_of_face,
            is_simple,
            gap,
            volume: if encloses { volume * scale } else { f64::INFINITY },
        }
    }

    pub fn is_sheet(&self) -> bool {
        self.triangles.is_empty() || self.gap > LARGEST_GAP
    }
}

/// A triangle's corners in ascending order, and whether their order has to be reversed for that.
fn in_order(corners: [u32; 3]) -> ([u32; 3], bool) {
    let mut sorted = corners;
    sorted.sort_unstable();
    let [a, b, c] = sorted;
    (sorted, ![[a, b, c], [b, c, a], [c, a, b]].contains(&corners))
}

/// A mesh that has every triangle twice, once for each side, is the surface of the first ones.
fn drop_second_sides(faces: &mut Vec<Face>) {
    let mut seen: HashMap<[u32; 3], [u32; 2]> = HashMap::with_capacity(faces.len());
    for face in faces.iter() {
        let (corners, is_reversed) = in_order(face.corners);
        seen.entry(corners).or_default()[usize::from(is_reversed)] += 1;
    }
    if seen.values().any(|counts| counts.contains(&0)) {
        return;
    }
    // The surface may be twisted, so what comes first on each place stays.
    let mut is_taken: HashMap<[u32; 3], ()> = HashMap::with_capacity(faces.len());
    faces.retain(|face| is_taken.insert(in_order(face.corners).0, ()).is_none());
}

/// Triangles that are written twice though nothing goes on at their edges are dropped once: a repeated patch of a closed surface. Where a
/// repeated patch belongs to a closed part of its own, its edges cancel, and it stays.
fn drop_strays(faces: &mut Vec<Face>) {
    let mut seen: HashMap<([u32; 3], bool), ()> = HashMap::with_capacity(faces.len());
    let is_repeated: Vec<bool> = faces.iter().map(|face| seen.insert(in_order(face.corners), ()).is_some()).collect();
    if !is_repeated.contains(&true) {
        return;
    }
    let sides_of_face = |face: &Face| {
        let [a, b, c] = face.corners;
        [[a, b], [b, c], [c, a]].map(|[from, to]| if from < to { ([from, to], 1) } else { ([to, from], -1) })
    };
    let mut excess: HashMap<[u32; 2], i32> = HashMap::new();
    for face in faces.iter() {
        for (ends, way) in sides_of_face(face) {
            *excess.entry(ends).or_default() += way;
        }
    }
    // Patches of repeated triangles, joined by their edges.
    let mut sets = Sets { above: (0..faces.len() as u32).map(|face| (face, false)).collect() };
    let mut face_at: HashMap<[u32; 2], u32> = HashMap::new();
    for (index, face) in faces.iter().enumerate().filter(|(index, _)| is_repeated[*index]) {
        for (ends, _) in sides_of_face(face) {
            let other = *face_at.entry(ends).or_insert(index as u32);
            sets.join(other, index as u32, false);
        }
    }
    let mut patches: HashMap<u32, Vec<usize>> = HashMap::new();
    for index in (0..faces.len()).filter(|&index| is_repeated[index]) {
        patches.entry(sets.root(index as u32).0).or_default().push(index);
    }
    let mut is_dropped = vec![false; faces.len()];
    for patch in patches.values() {
        let mut change: HashMap<[u32; 2], i32> = HashMap::new();
        for (ends, way) in patch.iter().flat_map(|&index| sides_of_face(&faces[index])) {
            *change.entry(ends).or_default() += way;
        }
        let gain: i32 = change.iter().map(|(ends, way)| excess[ends].abs() - (excess[ends] - way).abs()).sum();
        if gain > 0 {
            patch.iter().for_each(|&index| is_dropped[index] = true);
        }
    }
    let mut index = 0;
    faces.retain(|_| {
        index += 1;
        !is_dropped[index - 1]
    });
}

/// All edges, those of the same ends together.
fn sides_of(faces: &[Face], written: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * faces.len());
    for (face, index) in faces.iter().zip(0..) {
        let vertices = written[face.index as usize];
        for k in 0..3 {
            let next = (k + 1) % 3;
            let is_forward = face.corners[k] < face.corners[next];
            let (low, high) = if is_forward { (k, next) } else { (next, k) };
            let (ends, written) = ([face.corners[low], face.corners[high]], [vertices[low], vertices[high]]);
            sides.push(Side { ends, written, face: index, is_forward });
        }
    }
    sides.sort_unstable();
    sides
}

/// The part of each face, whether it must be turned to look as its neighbours do, and which parts are simple.
fn connected(sides: &[Side], faces: usize) -> (Vec<u32>, Vec<bool>, Vec<bool>) {
    let mut sets = Sets { above: (0..faces as u32).map(|face| (face, false)).collect() };
    let join_pair = |sets: &mut Sets, pair: &[Side]| {
        sets.join(pair[0].face, pair[1].face, pair[0].is_forward == pair[1].is_forward);
    };
    let mut crowded: Vec<&[Side]> = Vec::new();
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        match edge {
            [_, _] => join_pair(&mut sets, edge),
            [_] => {}
            _ => crowded.push(edge),
        }
    }
    let mut is_crowded = vec![false; faces];
    for edge in crowded {
        let mut left: Vec<u32> = Vec::new();
        for own in edge.chunk_by(|a, b| a.written == b.written) {
            match own {
                [a, b] if a.is_forward != b.is_forward => join_pair(&mut sets, own),
                _ => left.extend(own.iter().map(|side| side.face)),
            }
        }
        for pair in left.windows(2) {
            let is_opposite = sets.root(pair[0]).1 != sets.root(pair[1]).1;
            sets.join(pair[0], pair[1], is_opposite);
        }
        left.iter().for_each(|&face| is_crowded[face as usize] = true);
    }
    let mut number_of: HashMap<u32, u32> = HashMap::new();
    let mut parts = Vec::with_capacity(faces);
    let mut is_turned = Vec::with_capacity(faces);
    for face in 0..faces as u32 {
        let (root, is_opposite) = sets.root(face);
        let next = number_of.len() as u32;
        parts.push(*number_of.entry(root).or_insert(next));
        is_turned.push(is_opposite);
    }
    let mut is_simple = vec![true; number_of.len()];
    for (face, _) in is_crowded.iter().enumerate().filter(|(_, crowded)| **crowded) {
        is_simple[parts[face] as usize] = false;
    }
    (parts, is_turned, is_simple)
}

/// What is left open: the area of flat fans that would close it, and what they would add to the volume about the origin.
#[derive(Debug, Clone, Copy, Default)]
struct Opening {
    area: f64,
    volume: f64,
}

/// The openings of each part.
fn boundary_of(
    faces: &[Face],
    is_turned: &[bool],
    parts: &[u32],
    count: usize,
    at: &impl Fn(u32) -> DVec3,
) -> Vec<Opening> {
    // Edges by part, with how many more faces run along them one way than the other.
    let mut runs: Vec<(u32, [u32; 2], i32)> = Vec::with_capacity(3 * faces.len());
    for ((face, turned), &part) in faces.iter().zip(is_turned).zip(parts) {
        let [a, b, c] = face.corners;
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let way = if (from < to) != *turned { 1 } else { -1 };
            runs.push((part, [from.min(to), from.max(to)], way));
        }
    }
    runs.sort_unstable();
    let mut open: Vec<(u32, u32, u32)> = Vec::new();
    for edge in runs.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (part, [low, high], _) = edge[0];
        let excess: i32 = edge.iter().map(|run| run.2).sum();
        // Closed by what runs the other way.
        let (from, to) = if excess > 0 { (high, low) } else { (low, high) };
        open.extend(std::iter::repeat_n((part, from, to), excess.unsigned_abs() as usize));
    }
    let mut openings = vec![Opening::default(); count];
    for of_part in open.chunk_by(|a, b| a.0 == b.0) {
        // Edges that hang together go around one hole.
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        for &(_, from, to) in of_part {
            for vertex in [from, to] {
                let next = numbers.len() as u32;
                numbers.entry(vertex).or_insert(next);
            }
        }
        let mut sets = Sets { above: (0..numbers.len() as u32).map(|vertex| (vertex, false)).collect() };
        of_part.iter().for_each(|(_, from, to)| sets.join(numbers[from], numbers[to], false));
        let mut middles: HashMap<u32, (DVec3, f64)> = HashMap::new();
        for (_, from, _) in of_part {
            let middle = middles.entry(sets.root(numbers[from]).0).or_default();
            *middle = (middle.0 + at(*from), middle.1 + 1.0);
        }
        let opening = &mut openings[of_part[0].0 as usize];
        for &(_, from, to) in of_part {
            let (sum, count) = middles[&sets.root(numbers[&from]).0];
            let (a, b, c) = (sum / count, at(from), at(to));
            opening.area += (b - a).cross(c - a).length() / 2.0;
            opening.volume += a.dot(b.cross(c)) / 6.0;
        }
    }
    openings
}

/// A part as a body.
#[derive(Debug, Clone, Copy)]
struct Body {
    area: f64,
    /// > 0 where it looks outward; 0 where it encloses nothing.
    volume: f64,
    bounds: Bounds,
}

fn measured(triangles: &[[DVec3; 3]], parts: &[u32], count: usize, faces: &[Face], is_turned: &[bool]) -> Vec<Body> {
    let mut bodies = vec![Body { area: 0.0, volume: 0.0, bounds: Bounds::EMPTY }; count];
    for (corners, &part) in triangles.iter().zip(parts) {
        let body = &mut bodies[part as usize];
        body.area += (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / 2.0;
        body.bounds = body.bounds.union(Bounds::of(*corners));
    }
    // Volumes about the middle of all, so that a far mesh keeps its digits.
    let Bounds { min, max } = bodies.iter().fold(Bounds::EMPTY, |all, body| all.union(body.bounds));
    let middle = (min + max) / 2.0;
    for (corners, &part) in triangles.iter().zip(parts) {
        let [a, b, c] = corners.map(|p| p - middle);
        bodies[part as usize].volume += a.dot(b.cross(c)) / 6.0;
    }
    let at: HashMap<u32, DVec3> = (faces.iter().zip(triangles).zip(is_turned))
        .flat_map(|((face, corners), turned)| {
            let [a, b, c] = *corners;
            face.corners.into_iter().zip(if *turned { [a, c, b] } else { [a, b, c] })
        })
        .collect();
    let openings = boundary_of(faces, is_turned, parts, count, &|vertex| at[&vertex] - middle);
    for (body, opening) in bodies.iter_mut().zip(openings) {
        body.volume += opening.volume;
        let rounding = 1e-14 * body.area * (max - min).length();
        if opening.area > LARGEST_GAP * body.area || body.volume.abs() <= rounding {
            body.volume = 0.0;
        }
    }
    bodies
}

/// How often a surface winds around places on a triangle: in its middle and near its corners. Halfway where the two coincide.
fn numbers_on(&[a, b, c]: &[DVec3; 3], winding: &Winding) -> [f64; 4] {
    let middle = (a + b + c) / 3.0;
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
    let bounds = winding.bounds();
    let allowed = |_| Allowed { length: (bounds.max - bounds.min).length() / 2.0, is_of_one_surface: false };
    [middle, a.lerp(middle, 0.01), b.lerp(middle, 0.01), c.lerp(middle, 0.01)].map(|point| {
        let sides = winding.beside(&PointInPlane::new(point, normal, DVec3::ZERO), allowed);
        (sides.front + sides.back).abs() / 2.0
    })
}

/// Which parts must be turned over.
///
/// - One that lies in no other and looks inward; and with it all that lies in it, if that alternates: then the whole was inside out.
/// - One that would make the surface wind less than zero times around what it encloses.
///
/// What remains inward lies in something outward: a cavity.
fn judged(bodies: &[Body], triangles: &[[DVec3; 3]], parts: &[u32]) -> Vec<bool> {
    let mut is_over = vec![false; bodies.len()];
    if bodies.iter().all(|body| body.volume >= 0.0) {
        return is_over;
    }
    let mut order: Vec<usize> = (0..bodies.len()).filter(|&b| bodies[b].volume != 0.0).collect();
    order.sort_by(|&a, &b| bodies[b].volume.abs().total_cmp(&bodies[a].volume.abs()).then(a.cmp(&b)));
    // Faces of each part together.
    let mut by_part: Vec<(u32, u32)> = parts.iter().copied().zip(0..).collect();
    by_part.sort_unstable();
    let faces_of = |part: usize| {
        let first = by_part.partition_point(|(p, _)| (*p as usize) < part);
        let last = by_part.partition_point(|(p, _)| *p as usize <= part);
        by_part[first..last].iter().map(|&(_, face)| triangles[face as usize]).collect::<Vec<_>>()
    };
    // The parts whose boxes lie in that of each.
    let boxes: Vec<Bounds> = order.iter().map(|&part| bodies[part].bounds).collect();
    let tree = Tree::build(&boxes);
    let mut candidates: Vec<Vec<usize>> = vec![Vec::new(); order.len()];
    for (place, &inner) in order.iter().enumerate() {
        tree.walk(
            |all| all.has(&boxes[place]),
            |found| {
                let outer = tree.order[found] as usize;
                if outer < place && boxes[outer].has(&boxes[place]) {
                    candidates[outer].push(inner);
                }
            },
        );
    }
    // The containers of each part, the largest first.
    let mut containers: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
    for (&outer, candidates) in order.iter().zip(candidates).filter(|(_, candidates)| !candidates.is_empty()) {
        let faces = faces_of(outer);
        let winding = Winding::build(&faces, &vec![0; faces.len()]);
        for inner in candidates {
            // On the surface itself the number lies halfway: a part may touch its container from inside, and one that is written twice lies in none.
            let numbers: Vec<f64> = faces_of(inner).iter().flat_map(|face| numbers_on(face, &winding)).collect();
            if numbers.iter().all(|number| *number > 0.05) && numbers.iter().any(|number| *number > 0.75) {
                containers[inner].push(outer);
            }
        }
    }
    let is_outward = |part: usize| bodies[part].volume > 0.0;
    let root_of = |part: usize| containers[part].first().copied().unwrap_or(part);
    let mut is_inverted = vec![true; bodies.len()];
    for &part in &order {
        is_inverted[root_of(part)] &= is_outward(part) == (containers[part].len() % 2 == 1);
    }
    for &part in &order {
        is_over[part] = is_inverted[root_of(part)];
        let looks_outward = |part: usize, over: bool| is_outward(part) != over;
        let around: i32 = containers[part].iter().map(|&c| if looks_outward(c, is_over[c]) { 1 } else { -1 }).sum();
        if !looks_outward(part, is_over[part]) && around < 1 {
            is_over[part] = !is_over[part];
        }
    }
    // Scraps that enclose nothing go with the whole.
    let outermost = || order.iter().filter(|&&part| containers[part].is_empty());
    if outermost().next().is_some() && outermost().all(|&part| is_over[part]) {
        (0..bodies.len()).filter(|&part| bodies[part].volume == 0.0).for_each(|part| is_over[part] = true);
    }
    is_over
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid(min: DVec3, max: DVec3) -> Mesh {
        let at = |k: u32| {
            let pick = |bit: u32, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Mesh {
            positions: (0..8).map(at).collect(),
            normals: Vec::new(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            uvs: Vec::new(),
        }
    }

    fn cube(center: DVec3, side: f64) -> Mesh {
        cuboid(center - side / 2.0, center + side / 2.0)
    }

    fn both(mut a: Mesh, b: &Mesh) -> Mesh {
        let first = a.positions.len() as u32;
        a.positions.extend(&b.positions);
        a.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + first)));
        a
    }

    fn reversed(mut mesh: Mesh) -> Mesh {
        mesh.reverse();
        mesh
    }

    fn read(mesh: &Mesh) -> Reading {
        Reading::new(mesh, &DAffine3::IDENTITY, DVec3::ZERO)
    }

    fn winding(reading: &Reading, point: DVec3) -> f64 {
        Winding::build(&reading.triangles, &reading.parts).around(point)
    }

    /// The gap, the volume, the number of parts, and whether points are wound around once, not at all, and so on.
    fn expect(mesh: &Mesh, volume: f64, parts: usize, points: &[(DVec3, f64)]) {
        let reading = read(mesh);
        assert!(reading.gap < 1e-12, "{}", reading.gap);
        assert!((reading.volume - volume).abs() < 1e-9, "{}", reading.volume);
        assert_eq!(reading.is_simple.len(), parts);
        for (point, number) in points {
            assert!((winding(&reading, *point) - number).abs() < 0.02, "{point}: {}", winding(&reading, *point));
        }
    }

    #[test]
    fn a_cube_however_it_looks() {
        let points = [(DVec3::ZERO, 1.0), (DVec3::X, 0.0)];
        expect(&cube(DVec3::ZERO, 1.0), 1.0, 1, &points);
        expect(&reversed(cube(DVec3::ZERO, 1.0)), 1.0, 1, &points);
        let mut mixed = cube(DVec3::ZERO, 1.0);
        mixed.triangles[3].swap(0, 1);
        mixed.triangles[8].swap(0, 1);
        expect(&mixed, 1.0, 1, &points);
        let mirror = DAffine3::from_scale(DVec3::new(-2.0, 1.0, 1.0));
        let reading = Reading::new(&cube(DVec3::ZERO, 1.0), &mirror, DVec3::ZERO);
        assert_eq!(reading.volume, 2.0);
        assert!((winding(&reading, DVec3::X * 0.9) - 1.0).abs() < 0.02);
    }

    #[test]
    fn each_triangle_for_itself_with_noise() {
        let whole = cube(DVec3::new(1.0, 0.5, 0.5), 1.0);
        let mut soup = Mesh::default();
        for (index, triangle) in whole.triangles.iter().enumerate() {
            for (k, &vertex) in triangle.iter().enumerate() {
                let noise = [1e-33, -2e-16, 0.0, 2e-16][(index + 2 * k) % 4];
                soup.positions.push(whole.positions[vertex as usize] + DVec3::new(noise, -noise, noise));
            }
            let first = 3 * index as u32;
            soup.triangles.push([first, first + 1, first + 2]);
        }
        expect(&soup, 1.0, 1, &[(DVec3::new(1.0, 0.5, 0.5), 1.0), (DVec3::ZERO - 0.1, 0.0)]);
    }

    #[test]
    fn cavities_and_what_only_looks_like_one() {
        let outer = || cube(DVec3::ZERO, 2.0);
        let inner = || cube(DVec3::ZERO, 1.0);
        let core = || cube(DVec3::ZERO, 0.5);
        let shell = [(DVec3::ZERO, 0.0), (DVec3::X * 0.75, 1.0), (DVec3::X * 3.0, 0.0)];
        expect(&both(outer(), &reversed(inner())), 7.0, 2, &shell);
        expect(&reversed(both(outer(), &reversed(inner()))), 7.0, 2, &shell);
        let with_core = [(DVec3::ZERO, 1.0), (DVec3::X * 0.4, 0.0), (DVec3::X * 0.75, 1.0)];
        expect(&both(both(outer(), &reversed(inner())), &core()), 7.125, 3, &with_core);
        expect(&both(outer(), &inner()), 9.0, 2, &[(DVec3::ZERO, 2.0), (DVec3::X * 0.75, 1.0)]);
        // Inward, and in nothing: apart, or across the other's surface.
        for at in [DVec3::X * 4.0, DVec3::X * 1.1] {
            let mesh = both(outer(), &reversed(cube(at, 1.0)));
            expect(&mesh, 9.0, 2, &[(DVec3::ZERO, 1.0), (at + DVec3::X * 0.4, 1.0)]);
        }
    }

    #[test]
    fn parts_that_share_vertices_faces_or_everything() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let unit = || cuboid(DVec3::ZERO, DVec3::ONE);
        // A lower one within, with the floor in common and two walls: nothing is dropped.
        let lower = cuboid(DVec3::ZERO, at(1.0, 0.5, 1.0));
        expect(&both(unit(), &lower), 1.5, 2, &[(at(0.5, 0.25, 0.5), 2.0), (at(0.5, 0.75, 0.5), 1.0)]);
        // The same twice, in either way.
        for mesh in [both(unit(), &unit()), reversed(both(unit(), &unit()))] {
            expect(&mesh, 2.0, 2, &[(DVec3::splat(0.5), 2.0), (DVec3::splat(-0.5), 0.0)]);
        }
        // Two that share an edge, with the same vertices there.
        let mut edge = both(unit(), &cuboid(at(1.0, 1.0, 0.0), at(2.0, 2.0, 1.0)));
        let first_at: Vec<u32> =
            (edge.positions.iter()).map(|p| edge.positions.iter().position(|q| p == q).unwrap() as u32).collect();
        edge.triangles.iter_mut().for_each(|t| *t = t.map(|i| first_at[i as usize]));
        expect(&edge, 2.0, 1, &[(DVec3::splat(0.5), 1.0), (at(1.5, 1.5, 0.5), 1.0), (at(1.5, 0.5, 0.5), 0.0)]);
    }

    #[test]
    fn strays_and_second_sides() {
        let points = [(DVec3::ZERO, 1.0), (DVec3::X, 0.0)];
        let mut stray = cube(DVec3::ZERO, 1.0);
        stray.triangles.push(stray.triangles[4]);
        expect(&stray, 1.0, 1, &points);
        let whole = cube(DVec3::ZERO, 1.0);
        let mut second = whole.clone();
        second.triangles.extend(whole.triangles.iter().map(|&[a, b, c]| [a, c, b]));
        expect(&second, 1.0, 1, &points);
    }

    #[test]
    fn what_is_open() {
        let mut lidless = cube(DVec3::ZERO, 1.0);
        lidless.triangles.truncate(10);
        let reading = read(&lidless);
        assert!((reading.gap - 0.2).abs() < 1e-12 && !reading.is_sheet());
        assert!((reading.volume - 1.0).abs() < 1e-9);
        let mut sheet = cube(DVec3::ZERO, 1.0);
        sheet.triangles.truncate(2);
        let reading = read(&sheet);
        assert!(reading.is_sheet() && reading.volume == f64::INFINITY);
        // Nothing at all.
        let nothing = Mesh { triangles: vec![[0, 0, 1]], ..cube(DVec3::ZERO, 1.0) };
        assert!(read(&nothing).is_sheet());
    }
}
