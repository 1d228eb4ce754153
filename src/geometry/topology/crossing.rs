//! Whether a surface crosses or touches itself: pairs of triangles, beyond the corners and edges that they share.
//!
//! Within one component signs of volumes are trusted only beyond their rounding error (Shewchuk 1997, the static bound of `orient3d`), so a
//! crossing that is reported is one. Different components touch if they are no farther apart than the rounding of vertices to single
//! precision, which would let rays miss what is between them.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::geometry::hierarchy::{Extent, Hierarchy, LEAF};

/// What is known of a surface's crossings with itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Crossings {
    /// Pairs of faces that certainly cross, in ascending order; not more than some hundreds for each part of the surface.
    pub pairs: Vec<[u32; 2]>,
    /// Whether faces that are no neighbours touch, or come so near that it cannot be told.
    pub touches: bool,
    /// Whether the search was given up, as it can be where countless long triangles lie side by side.
    pub is_given_up: bool,
    /// Components that meet, the lower first, and whether their faces cross there.
    pub meetings: BTreeMap<(u32, u32), bool>,
}

/// Nodes at which the search is cut into independent parts; a constant, so that the result is the same on any number of threads.
const PARTS: usize = 256;
/// Crossings that each part reports at the most.
const MOST_PAIRS: usize = 64;
/// Pairs of faces that meet in each part: with more of them, faces lie on each other without number, and the search is given up.
const MOST_TOUCHES: usize = 4096;
/// Pairs of nodes that each part looks at: so many, and so many for each leaf of the tree over all parts.
const PATIENCE: (usize, usize) = (5_000, 100);

/// Gaps smaller than this share of the largest coordinate may be rounding.
const ROUNDING: f64 = 1e-14;
/// Share of the mesh's size by which the rounding of vertices to f32 may move a surface: eight units in the last place.
const ROUNDING_32: f64 = 8.0 / (1u32 << 24) as f64;

/// Searches the faces in `tree`. `faces` are welded corners.
pub(super) fn crossings(
    tree: &Hierarchy,
    faces: &[[u32; 3]],
    positions: &[DVec3],
    component_of_face: &[u32],
) -> Crossings {
    let Some(leaves) = tree.levels.first().map(Vec::len) else { return Crossings::default() };
    let level = tree.levels.iter().position(|level| level.len() <= PARTS).unwrap_or(0);
    let parts = tree.levels[level].len();
    let (faces, positions) = along_the_curve(tree, faces, positions);
    let components: Vec<u32> = tree.order.iter().map(|&face| component_of_face[face as usize]).collect();
    let is_one = components.windows(2).all(|pair| pair[0] == pair[1]);
    let boxes = Boxes::new(tree, &faces, &positions, if is_one { 0.0 } else { 2.0 * ROUNDING_32 as f32 });
    let all = tree.levels.last().and_then(|level| level.first()).copied().unwrap_or(Extent::EMPTY);
    let size = (all.max - all.min).max_element();
    let patience = PATIENCE.0 + PATIENCE.1 * leaves / parts;
    let found: Vec<Crossings> = (0..parts)
        .into_par_iter()
        .map(|part| {
            let mut search = Search {
                tree,
                boxes: &boxes,
                faces: &faces,
                positions: &positions,
                components: &components,
                size,
                found: Crossings::default(),
                is_one,
                touches_left: MOST_TOUCHES,
                patience,
            };
            search.within(level, part);
            for other in part + 1..parts {
                search.between(level, part, other);
            }
            search.found
        })
        .collect();
    let mut all = Crossings::default();
    for part in found {
        all.pairs.extend(part.pairs);
        all.touches |= part.touches;
        all.is_given_up |= part.is_given_up;
        for (pair, crosses) in part.meetings {
            *all.meetings.entry(pair).or_default() |= crosses;
        }
    }
    all.pairs.sort_unstable();
    all
}

/// Faces and the positions that they name, both in the tree's order, so that what is near in space is near in memory.
fn along_the_curve(tree: &Hierarchy, faces: &[[u32; 3]], positions: &[DVec3]) -> (Vec<[u32; 3]>, Vec<DVec3>) {
    let mut new_ids = vec![u32::MAX; positions.len()];
    let mut moved = Vec::with_capacity(faces.len() / 2 + 3);
    let renumbered = (tree.order.iter())
        .map(|&face| {
            faces[face as usize].map(|v| {
                let id = &mut new_ids[v as usize];
                if *id == u32::MAX {
                    *id = moved.len() as u32;
                    moved.push(positions[v as usize]);
                }
                *id
            })
        })
        .collect();
    (renumbered, moved)
}

/// A box in single precision, rounded outward: half the room, and compared in two instructions.
#[derive(Clone, Copy)]
struct Box32 {
    min: Vec3A,
    max: Vec3A,
}

impl Box32 {
    #[inline]
    fn meets(&self, other: &Self) -> bool {
        (self.min.cmple(other.max) & other.min.cmple(self.max)).all()
    }
}

/// Boxes of faces and nodes, relative to the whole mesh, whose box has sides of at most 2.
struct Boxes {
    /// In the tree's order.
    of_faces: Vec<Box32>,
    /// As the tree's levels.
    of_nodes: Vec<Vec<Box32>>,
}

impl Boxes {
    /// Each grown by `room`.
    fn new(tree: &Hierarchy, faces: &[[u32; 3]], positions: &[DVec3], room: f32) -> Self {
        let all = tree.levels.last().and_then(|level| level.first()).copied().unwrap_or(Extent::EMPTY);
        let center = (all.min + all.max) / 2.0;
        let size = ((all.max - all.min) / 2.0).max_element();
        let rounded = |e: Extent| {
            let (min, max) = ((e.min - center) / size, (e.max - center) / size);
            Box32 {
                min: Vec3A::from_array(min.to_array().map(|x| (x as f32 - room).next_down())),
                max: Vec3A::from_array(max.to_array().map(|x| (x as f32 + room).next_up())),
            }
        };
        Self {
            of_faces: faces.par_iter().map(|f| rounded(Extent::of(f.map(|v| positions[v as usize])))).collect(),
            of_nodes: tree.levels.iter().map(|level| level.par_iter().map(|&e| rounded(e)).collect()).collect(),
        }
    }
}

struct Search<'a> {
    tree: &'a Hierarchy,
    boxes: &'a Boxes,
    /// Corners and positions, in the tree's order.
    faces: &'a [[u32; 3]],
    positions: &'a [DVec3],
    /// Of each face, in the tree's order.
    components: &'a [u32],
    /// The mesh's largest extent.
    size: f64,
    found: Crossings,
    /// Whether there is but one component: then nothing is to be found out beyond some crossings.
    is_one: bool,
    touches_left: usize,
    patience: usize,
}

impl Search<'_> {
    /// Whether there is nothing more to look for.
    fn is_over(&mut self) -> bool {
        if self.patience == 0 || self.touches_left == 0 {
            self.found.is_given_up = true;
        } else {
            self.patience -= 1;
        }
        self.found.is_given_up || (self.found.pairs.len() >= MOST_PAIRS && self.is_one)
    }

    /// Tests the faces below a node against each other.
    fn within(&mut self, level: usize, index: usize) {
        if level == 0 {
            let faces = self.tree.leaf_range(index);
            for a in faces.clone() {
                for b in a + 1..faces.end {
                    self.test(a, b);
                }
            }
            return;
        }
        let children = self.tree.children(level, index);
        for child in children.clone() {
            self.within(level - 1, child);
        }
        if children.len() == 2 {
            self.between(level - 1, children.start, children.start + 1);
        }
    }

    /// Tests the faces below one node against those below another of the same level.
    fn between(&mut self, level: usize, a: usize, b: usize) {
        let boxes = &self.boxes.of_nodes[level];
        if !boxes[a].meets(&boxes[b]) || self.is_over() {
            return;
        }
        if level == 0 {
            let (box_a, box_b) = (boxes[a], boxes[b]);
            let mut near_a = [0; LEAF];
            let mut count = 0;
            for y in self.tree.leaf_range(b) {
                near_a[count] = y;
                count += usize::from(self.boxes.of_faces[y].meets(&box_a));
            }
            if count == 0 {
                return;
            }
            for x in self.tree.leaf_range(a) {
                if self.boxes.of_faces[x].meets(&box_b) {
                    for &y in &near_a[..count] {
                        self.test(x, y);
                    }
                }
            }
            return;
        }
        for x in self.tree.children(level, a) {
            for y in self.tree.children(level, b) {
                self.between(level - 1, x, y);
            }
        }
    }

    /// Tests the faces at two places of the tree's order.
    fn test(&mut self, a: usize, b: usize) {
        if !self.boxes.of_faces[a].meets(&self.boxes.of_faces[b]) {
            return;
        }
        let places = [a, b];
        let [a, b] = places.map(|place| self.faces[place]);
        let corner = |v: u32| &self.positions[v as usize];
        let corners = |[i, j, k]: [u32; 3]| [corner(i), corner(j), corner(k)];
        let joints: [Option<usize>; 3] = std::array::from_fn(|i| b.iter().position(|&v| v == a[i]));
        let (a, b) = (corners(a), corners(b));
        let is_one_part = self.components[places[0]] == self.components[places[1]];
        let room = self.size * if is_one_part { ROUNDING } else { ROUNDING_32 };
        let contact = match joints {
            [None, None, None] if is_one_part => meet(a, b),
            [None, None, None] => meet_within(a, b, room),
            [Some(j), None, None] => meet_at_a_vertex(a, 0, b, j, room),
            [None, Some(j), None] => meet_at_a_vertex(a, 1, b, j, room),
            [None, None, Some(j)] => meet_at_a_vertex(a, 2, b, j, room),
            [Some(i), Some(j), None] => meet_at_an_edge(a, 0, b, 3 - i - j, room),
            [None, Some(i), Some(j)] => meet_at_an_edge(a, 1, b, 3 - i - j, room),
            [Some(i), None, Some(j)] => meet_at_an_edge(a, 2, b, 3 - i - j, room),
            [Some(_), Some(_), Some(_)] => Contact::Touch,
        };
        let crosses = contact == Contact::Cross;
        if !is_one_part && (contact != Contact::None || joints.iter().any(Option::is_some)) {
            let pair = places.map(|place| self.components[place]);
            *self.found.meetings.entry((pair[0].min(pair[1]), pair[0].max(pair[1]))).or_default() |= crosses;
        }
        if contact == Contact::None {
            return;
        }
        self.touches_left = self.touches_left.saturating_sub(1);
        self.found.touches |= !crosses;
        if crosses && self.found.pairs.len() < MOST_PAIRS {
            let mut ids = places.map(|place| self.tree.order[place]);
            ids.sort_unstable();
            self.found.pairs.push(ids);
        }
    }
}

/// How two triangles meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Contact {
    None,
    /// They touch, or it cannot be told.
    Touch,
    /// An edge of one certainly goes through the inside of the other.
    Cross,
}

/// A triangle in place: copying corners about costs more than most tests do.
type Triangle<'a> = [&'a DVec3; 3];

/// Two triangles without a common vertex.
fn meet(a: Triangle<'_>, b: Triangle<'_>) -> Contact {
    let sides_of_b = sides(a, b);
    if all_beyond(sides_of_b) {
        return Contact::None;
    }
    let sides_of_a = sides(b, a);
    if all_beyond(sides_of_a) {
        return Contact::None;
    }
    let mut is_clear = sides_of_a.iter().chain(&sides_of_b).all(|&side| side != 0);
    for (triangle, other, sides) in [(a, b, sides_of_b), (b, a, sides_of_a)] {
        for k in 0..3 {
            let next = (k + 1) % 3;
            if sides[k] * sides[next] < 0 {
                match goes_through(other[k], other[next], triangle) {
                    Contact::Cross => return Contact::Cross,
                    Contact::Touch => is_clear = false,
                    Contact::None => {}
                }
            }
        }
    }
    if is_clear || are_apart(a.map(|p| *p), b.map(|p| *p)) { Contact::None } else { Contact::Touch }
}

/// Two triangles of different parts: they touch if they are no farther apart than `room`, or reach no farther into each other.
fn meet_within(a: Triangle<'_>, b: Triangle<'_>, room: f64) -> Contact {
    let is_beyond = |triangle: Triangle<'_>, other: Triangle<'_>| {
        let normal = normal(triangle);
        let least = room * normal.length();
        let heights = other.map(|p| normal.dot(*p - *triangle[0]));
        heights.iter().all(|h| *h > least) || heights.iter().all(|h| *h < -least)
    };
    if is_beyond(a, b) || is_beyond(b, a) {
        return Contact::None;
    }
    match gap(a.map(|p| *p), b.map(|p| *p)) {
        gap if gap > room => Contact::None,
        gap if gap >= -room => Contact::Touch,
        _ => meet(a, b),
    }
}

/// Two triangles that share corner `i` of `a`, which is corner `j` of `b`: whether they meet elsewhere too.
fn meet_at_a_vertex(a: Triangle<'_>, i: usize, b: Triangle<'_>, j: usize, room: f64) -> Contact {
    let others = |t: Triangle<'_>, k: usize| [*t[(k + 1) % 3] - *t[k], *t[(k + 2) % 3] - *t[k]];
    let (of_a, of_b) = (others(a, i), others(b, j));
    let (heights_of_b, heights_of_a) = (heights_of(of_b, of_a), heights_of(of_a, of_b));
    let goes_through = |[p, q]: [f64; 2]| p * q < 0.0 && p.abs().min(q.abs()) > room;
    if goes_through(heights_of_b) && is_pierced(a, b[(j + 1) % 3], b[(j + 2) % 3])
        || goes_through(heights_of_a) && is_pierced(b, a[(i + 1) % 3], a[(i + 2) % 3])
    {
        return Contact::Cross;
    }
    // With one of its edges, or, where both lie along the other's, with what is between them.
    let lies_in = |heights: [f64; 2], edges: [DVec3; 2], triangle: [DVec3; 2]| {
        let is_flat = heights.map(|h| h.abs() <= room);
        (0..2).any(|k| is_flat[k] && is_inside_along(edges[k], triangle, room))
            || (is_flat == [true; 2] && is_inside_along(edges[0].normalize() + edges[1].normalize(), triangle, room))
    };
    if lies_in(heights_of_b, of_b, of_a) || lies_in(heights_of_a, of_a, of_b) { Contact::Touch } else { Contact::None }
}

/// Heights of two points over the plane through the origin and a triangle's two other corners.
#[inline]
fn heights_of(points: [DVec3; 2], triangle: [DVec3; 2]) -> [f64; 2] {
    let normal = triangle[0].cross(triangle[1]);
    let length = normal.length();
    points.map(|p| normal.dot(p) / length)
}

/// Whether a direction from the origin runs inside the triangle of the origin and two other corners, some way from the origin on.
fn is_inside_along(direction: DVec3, [p, q]: [DVec3; 2], room: f64) -> bool {
    // So far from the corner the third edge has not cut the triangle off.
    let reach = direction.length().min(p.cross(q).length() / p.distance(q)) / 2.0;
    let point = direction.normalize_or_zero() * reach;
    let normal = p.cross(q).normalize_or_zero();
    // Distances from the two edges at the origin, and from the plane. What is nearer to the origin than a few of `room` cannot be told from it.
    let from_edges = normal.cross(p).normalize_or_zero().dot(point).min(q.cross(normal).normalize_or_zero().dot(point));
    reach > 4.0 * room && from_edges > room && normal.dot(point).abs() <= room
}

/// Two triangles that share edge `edge` of `a`: whether one is folded onto the other. `third_of_b` is the corner of `b` that is not shared.
fn meet_at_an_edge(a: Triangle<'_>, edge: usize, b: Triangle<'_>, third_of_b: usize, room: f64) -> Contact {
    let (start, end) = (*a[edge], *a[(edge + 1) % 3]);
    let along = (end - start).normalize_or_zero();
    let away = |p: DVec3| (p - start) - along * along.dot(p - start);
    let (u, v) = (away(*a[(edge + 2) % 3]), away(*b[third_of_b]));
    // A face without width lies on nothing.
    let has_width = u.length().min(v.length()) > 4.0 * room;
    let is_folded = has_width && u.dot(v) > 0.0 && u.cross(v).length() <= room * u.length().max(v.length());
    if is_folded { Contact::Touch } else { Contact::None }
}

/// Whether the edge from `p` to `q` certainly goes through the inside of a triangle.
fn is_pierced(triangle: Triangle<'_>, p: &DVec3, q: &DVec3) -> bool {
    let [a, b, c] = triangle;
    orientation(a, b, c, p) * orientation(a, b, c, q) < 0 && goes_through(p, q, triangle) == Contact::Cross
}

fn normal([a, b, c]: Triangle<'_>) -> DVec3 {
    (*b - *a).cross(*c - *a)
}

/// On which side of a triangle's plane the corners of another lie.
#[inline]
fn sides([a, b, c]: Triangle<'_>, [p, q, r]: Triangle<'_>) -> [i32; 3] {
    [orientation(a, b, c, p), orientation(a, b, c, q), orientation(a, b, c, r)]
}

fn all_beyond(sides: [i32; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}

/// Whether the line through `p` and `q`, which lie on either side of the triangle's plane, meets the triangle.
fn goes_through(p: &DVec3, q: &DVec3, [a, b, c]: Triangle<'_>) -> Contact {
    let around = [orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a)];
    if all_beyond(around) {
        Contact::Cross
    } else if around.contains(&1) && around.contains(&-1) {
        Contact::None
    } else {
        Contact::Touch
    }
}

/// Sign of six times the volume of the tetrahedron a, b, c, d: 1 where d lies on the side from which a, b, c turn clockwise, 0 where
/// rounding leaves it open.
#[inline]
fn orientation(a: &DVec3, b: &DVec3, c: &DVec3, d: &DVec3) -> i32 {
    /// (7 + 56 ε) ε with ε = 2⁻⁵³.
    const BOUND: f64 = 7.771_561_172_376_103e-16;
    let (a, b, c) = (*a - *d, *b - *d, *c - *d);
    let [bc, cb] = [b.x * c.y, c.x * b.y];
    let [ca, ac] = [c.x * a.y, a.x * c.y];
    let [ab, ba] = [a.x * b.y, b.x * a.y];
    let determinant = a.z * (bc - cb) + b.z * (ca - ac) + c.z * (ab - ba);
    let permanent =
        a.z.abs() * (bc.abs() + cb.abs()) + b.z.abs() * (ca.abs() + ac.abs()) + c.z.abs() * (ab.abs() + ba.abs());
    if determinant > BOUND * permanent {
        1
    } else if determinant < -BOUND * permanent {
        -1
    } else {
        0
    }
}

/// Whether some axis certainly separates two triangles.
fn are_apart(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    // Relative to one corner, so that far triangles keep their digits.
    let size = a.iter().chain(&b).map(|p| (*p - a[0]).length_squared()).fold(0.0, f64::max).sqrt();
    gap(a, b) > ROUNDING * size
}

/// The widest gap between the shadows of two triangles on any of the axes that can separate them: their normals, the products of their
/// edges, and, for triangles of one plane, the normals of their edges in it (the separating axis theorem). Negative where they meet.
fn gap(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let origin = a[0];
    let (a, b) = (a.map(|p| p - origin), b.map(|p| p - origin));
    let edges = |t: [DVec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (edges_a, edges_b) = (edges(a), edges(b));
    let normals = [edges_a[0].cross(edges_a[1]), edges_b[0].cross(edges_b[1])];
    // `size` is the length that the axis would have if it were well known.
    let along = |axis: DVec3, size: f64| {
        let length = axis.length();
        if length <= 1e-12 * size || length == 0.0 {
            return f64::NEG_INFINITY;
        }
        let (a, b) = (a.map(|p| p.dot(axis)), b.map(|p| p.dot(axis)));
        let low = |v: [f64; 3]| v[0].min(v[1]).min(v[2]);
        let high = |v: [f64; 3]| v[0].max(v[1]).max(v[2]);
        (low(b) - high(a)).max(low(a) - high(b)) / length
    };
    let mut widest = f64::NEG_INFINITY;
    for (normal, edges) in [(normals[0], edges_a), (normals[1], edges_b)] {
        let size = edges[0].length() * edges[1].length();
        widest = widest.max(along(normal, size));
        for edge in edges {
            widest = widest.max(along(normal.cross(edge), size * edge.length()));
        }
    }
    for u in edges_a {
        for v in edges_b {
            widest = widest.max(along(u.cross(v), u.length() * v.length()));
        }
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orientation(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> i32 {
        super::orientation(&a, &b, &c, &d)
    }

    fn meet(a: [DVec3; 3], b: [DVec3; 3]) -> Contact {
        super::meet(a.each_ref(), b.each_ref())
    }

    fn meet_at_a_vertex(a: [DVec3; 3], i: usize, b: [DVec3; 3], j: usize) -> Contact {
        super::meet_at_a_vertex(a.each_ref(), i, b.each_ref(), j, 1e-12)
    }

    fn p(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    const FLAT: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn signs_beyond_rounding_only() {
        assert_eq!(orientation(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_Z), 1);
        assert_eq!(orientation(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z), -1);
        assert_eq!(orientation(DVec3::ZERO, DVec3::X, DVec3::Y, p(0.3, 0.4, 0.0)), 0);
        assert_eq!(orientation(DVec3::ZERO, DVec3::X, DVec3::Y, p(0.3, 0.4, 1e-300)), -1);
        // Four points of a plane that no coordinate can hold exactly.
        let plane = |u: f64, v: f64| p(0.1, 0.2, 0.3) + p(0.7, 0.1, 0.4) * u + p(-0.2, 0.9, 0.6) * v;
        assert_eq!(orientation(plane(0.1, 0.3), plane(0.7, 0.9), plane(0.4, -0.3), plane(0.9, 0.2)), 0);
    }

    #[test]
    fn crossing_touching_and_apart() {
        let through = [p(0.2, 0.2, -1.0), p(0.2, 0.2, 1.0), p(5.0, 5.0, 0.5)];
        assert_eq!(meet(FLAT, through), Contact::Cross);
        assert_eq!(meet(through, FLAT), Contact::Cross);
        let beside = through.map(|p| p + DVec3::X);
        assert_eq!(meet(FLAT, beside), Contact::None);
        assert_eq!(meet(FLAT, FLAT.map(|p| p + DVec3::Z * 1e-9)), Contact::None, "parallel");
        assert_eq!(meet(FLAT, [p(0.2, 0.2, 0.0), p(0.2, 0.2, 1.0), p(0.4, 0.3, 1.0)]), Contact::Touch, "a tip on it");
        assert_eq!(
            meet(FLAT, FLAT.map(|p| p * 0.1 + DVec3::splat(0.1) * p.z + DVec3::X * 0.2)),
            Contact::Touch,
            "flat on it"
        );
        assert_eq!(meet(FLAT, FLAT.map(|p| DVec3::X + DVec3::Y - p)), Contact::Touch, "along an edge");
        let far = FLAT.map(|p| p + DVec3::X + DVec3::Y * 0.001);
        assert_eq!(meet(FLAT, far), Contact::None, "in one plane, apart");
    }

    #[test]
    fn neighbours_at_a_vertex_cross_only_beyond_it() {
        let along = [DVec3::ZERO, p(1.0, 1.0, -1.0), p(1.0, 1.0, 1.0)];
        assert_eq!(meet_at_a_vertex(FLAT, 0, along, 0), Contact::Cross);
        let away = [DVec3::ZERO, p(-1.0, -1.0, -1.0), p(-1.0, -1.0, 1.0)];
        assert_eq!(meet_at_a_vertex(FLAT, 0, away, 0), Contact::None);
        assert_eq!(meet_at_a_vertex(FLAT, 0, [DVec3::ZERO, p(1.0, 1.0, 0.1), p(0.0, 1.0, 1.0)], 0), Contact::None);
    }

    #[test]
    fn parts_touch_within_the_rounding_of_vertices() {
        let at = |z: f64| super::meet_within(FLAT.each_ref(), FLAT.map(|p| p + DVec3::Z * z).each_ref(), 1e-6);
        assert_eq!([1e-5, 1e-7, 0.0, -1e-7].map(at), [Contact::None, Contact::Touch, Contact::Touch, Contact::Touch]);
        let through = |depth: f64| {
            let post = [p(0.2, 0.2, -depth), p(0.25, 0.2, 1.0), p(0.2, 0.25, 1.0)];
            super::meet_within(FLAT.each_ref(), post.each_ref(), 1e-6)
        };
        assert_eq!([1e-7, 1e-3].map(through), [Contact::Touch, Contact::Cross]);
    }

    #[test]
    fn neighbours_touch_beyond_what_they_share() {
        // Flat on it, with an edge along it, in its corner.
        for other in [
            [DVec3::ZERO, p(0.5, 0.1, 0.0), p(0.1, 0.5, 0.0)],
            [DVec3::ZERO, p(0.3, 0.3, 0.0), p(0.1, 0.2, 1.0)],
            [DVec3::ZERO, p(0.5, 0.0, 0.0), p(0.0, 0.5, 0.0)],
            [DVec3::ZERO, p(2.0, 0.0, 0.0), p(0.0, 0.5, 0.0)],
        ] {
            assert_eq!(meet_at_a_vertex(FLAT, 0, other, 0), Contact::Touch, "{other:?}");
            assert_eq!(meet_at_a_vertex(other, 0, FLAT, 0), Contact::Touch, "{other:?}");
        }
        // Beside it, and edge to edge.
        for other in [
            [DVec3::ZERO, p(1.0, -0.001, 0.0), p(1.0, -0.1, 0.0)],
            [DVec3::ZERO, p(0.5, 0.0, 0.0), p(0.5, 0.0, 1.0)],
            [DVec3::ZERO, p(2.0, 0.0, 0.0), p(0.5, -0.1, 0.0)],
        ] {
            assert_eq!(meet_at_a_vertex(FLAT, 0, other, 0), Contact::None, "{other:?}");
        }
        let at_an_edge = |third: DVec3| {
            let other = [DVec3::X, DVec3::ZERO, third];
            super::meet_at_an_edge(FLAT.each_ref(), 0, other.each_ref(), 2, 1e-12)
        };
        assert_eq!(at_an_edge(p(0.3, -0.5, 0.0)), Contact::None, "unfolded");
        assert_eq!(at_an_edge(p(0.3, 0.5, 1e-3)), Contact::None, "a thin wedge");
        assert_eq!(at_an_edge(p(0.3, 0.2, 0.0)), Contact::Touch, "folded");
    }
}
