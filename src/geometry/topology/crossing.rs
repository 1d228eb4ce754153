//! Whether a surface crosses itself: pairs of triangles that are not neighbours.
//!
//! Signs of volumes are trusted only beyond their rounding error (Shewchuk 1997, the static bound of `orient3d`), so a crossing that is
//! reported is one, and touching neighbours are none.

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
}

/// Nodes at which the search is cut into independent parts; a constant, so that the result is the same on any number of threads.
const PARTS: usize = 256;
/// Crossings that each part reports at the most.
const MOST_PAIRS: usize = 64;
/// Pairs of nodes that each part looks at: so many, and so many for each leaf of the tree over all parts.
const PATIENCE: (usize, usize) = (5_000, 100);

/// Searches the faces in `tree`. `faces` are welded corners.
pub(super) fn crossings(tree: &Hierarchy, faces: &[[u32; 3]], positions: &[DVec3]) -> Crossings {
    let Some(leaves) = tree.levels.first().map(Vec::len) else { return Crossings::default() };
    let level = tree.levels.iter().position(|level| level.len() <= PARTS).unwrap_or(0);
    let parts = tree.levels[level].len();
    let (faces, positions) = along_the_curve(tree, faces, positions);
    let boxes = Boxes::new(tree, &faces, &positions);
    let patience = PATIENCE.0 + PATIENCE.1 * leaves / parts;
    let found: Vec<Crossings> = (0..parts)
        .into_par_iter()
        .map(|part| {
            let mut search = Search {
                tree,
                boxes: &boxes,
                faces: &faces,
                positions: &positions,
                found: Crossings::default(),
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
    fn new(tree: &Hierarchy, faces: &[[u32; 3]], positions: &[DVec3]) -> Self {
        let all = tree.levels.last().and_then(|level| level.first()).copied().unwrap_or(Extent::EMPTY);
        let center = (all.min + all.max) / 2.0;
        let size = ((all.max - all.min) / 2.0).max_element();
        let rounded = |e: Extent| {
            let (min, max) = ((e.min - center) / size, (e.max - center) / size);
            Box32 {
                min: Vec3A::from_array(min.to_array().map(|x| (x as f32).next_down())),
                max: Vec3A::from_array(max.to_array().map(|x| (x as f32).next_up())),
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
    found: Crossings,
    patience: usize,
}

impl Search<'_> {
    /// Whether there is nothing more to look for.
    fn is_over(&mut self) -> bool {
        if self.patience == 0 {
            self.found.is_given_up = true;
        } else {
            self.patience -= 1;
        }
        self.found.is_given_up || self.found.pairs.len() >= MOST_PAIRS
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
        let mut joints = (0..3).filter_map(|i| Some((i, b.iter().position(|&v| v == a[i])?)));
        let contact = match (joints.next(), joints.next()) {
            (None, _) => meet(corners(a), corners(b)),
            (Some((i, j)), None) => meet_at_a_vertex(corners(a), i, corners(b), j),
            // Neighbours meet along their edge and, both being flat, nowhere else, unless one is folded onto the other.
            (Some(_), Some(_)) => Contact::None,
        };
        match contact {
            Contact::None => {}
            Contact::Touch => self.found.touches = true,
            Contact::Cross => {
                let mut ids = places.map(|place| self.tree.order[place]);
                ids.sort_unstable();
                self.found.pairs.push(ids);
            }
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

/// Two triangles that share corner `i` of `a`, which is corner `j` of `b`: whether they meet elsewhere too. Flat on one another is not
/// looked for.
fn meet_at_a_vertex(a: Triangle<'_>, i: usize, b: Triangle<'_>, j: usize) -> Contact {
    if is_pierced(b, a[i], a[(i + 1) % 3], a[(i + 2) % 3]) || is_pierced(a, a[i], b[(j + 1) % 3], b[(j + 2) % 3]) {
        Contact::Cross
    } else {
        Contact::None
    }
}

/// Whether the edge from `p` to `q` certainly goes through the inside of a triangle, one corner of which is `shared`.
fn is_pierced(triangle: Triangle<'_>, shared: &DVec3, p: &DVec3, q: &DVec3) -> bool {
    let [a, b, c] = triangle;
    // A first look, which need not be exact: what is a matter of rounding is no certain crossing.
    let normal = (*b - *a).cross(*c - *a);
    if normal.dot(*p - *shared) * normal.dot(*q - *shared) >= 0.0 {
        return false;
    }
    orientation(a, b, c, p) * orientation(a, b, c, q) < 0 && goes_through(p, q, triangle) == Contact::Cross
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

/// Whether some axis certainly separates two triangles: their normals, the products of their edges, and, for triangles of one plane, the
/// normals of their edges in it (the separating axis theorem).
fn are_apart(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    /// Gaps smaller than this share of the largest projection may be rounding.
    const ROUNDING: f64 = 1e-14;
    // Relative to one corner, so that far triangles keep their digits.
    let origin = a[0];
    let (a, b) = (a.map(|p| p - origin), b.map(|p| p - origin));
    let edges = |t: [DVec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (edges_a, edges_b) = (edges(a), edges(b));
    let normals = [edges_a[0].cross(edges_a[1]), edges_b[0].cross(edges_b[1])];
    let is_axis = |axis: DVec3| {
        let (a, b) = (a.map(|p| p.dot(axis)), b.map(|p| p.dot(axis)));
        let low = |v: [f64; 3]| v[0].min(v[1]).min(v[2]);
        let high = |v: [f64; 3]| v[0].max(v[1]).max(v[2]);
        let size = high(a).abs().max(high(b).abs()).max(low(a).abs()).max(low(b).abs());
        (low(b) - high(a)).max(low(a) - high(b)) > ROUNDING * size
    };
    normals.into_iter().any(is_axis)
        || edges_a.iter().any(|&u| edges_b.iter().any(|&v| is_axis(u.cross(v))))
        || edges_a.iter().any(|&u| is_axis(normals[0].cross(u)))
        || edges_b.iter().any(|&v| is_axis(normals[1].cross(v)))
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
        super::meet_at_a_vertex(a.each_ref(), i, b.each_ref(), j)
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
}
