//! A face cut along the curves where other surfaces cross it, and along the edges of those that coincide with it: between the cuts nothing can
//! change.
//!
//! Which edge goes through which triangle is decided exactly (Shewchuk 1997), and where a cut meets an edge of the face depends on that
//! edge and on the other triangle alone. So two faces that share an edge are cut at the same points of it, bit for bit: pieces fit together.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D, orient2d, orient3d};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Points nearer to each other than this share of the face's size are one.
const SAME: f64 = 1e-9;

/// How another triangle meets the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meeting {
    Crosses,
    /// It lies in the same plane, up to rounding.
    Coincides,
}

/// Cuts the face with these corners. What is given back covers the face, each piece with the winding of the face; `None` where nothing cuts it.
pub fn cut(face: [DVec3; 3], others: &[(Meeting, [DVec3; 3])]) -> Option<Vec<[DVec3; 3]>> {
    let plane = Plane::of(face)?;
    let mut segments: Vec<[Point; 2]> = (others.iter())
        .flat_map(|(meeting, other)| match meeting {
            Meeting::Crosses => plane.crossing(other).into_iter().collect::<Vec<_>>(),
            Meeting::Coincides => plane.edges_of(other),
        })
        .collect();
    // A segment that is a corner of the face cuts nothing.
    segments.retain(|[a, b]| a.position != b.position || a.on_edges.count_ones() == 1);
    if segments.is_empty() {
        return None;
    }
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point>::new();
    let mut insert = |point: Point| triangulation.insert(point).ok();
    let corners: Vec<_> = (0..3).filter_map(|corner| insert(plane.corner(corner))).collect();
    let ends: Vec<_> = segments.iter().filter_map(|[a, b]| Some([insert(*a)?, insert(*b)?])).collect();
    // The outline, point by point along each edge, so that what lies beside it is not joined across it.
    for edge in 0..3 {
        let mut along: Vec<(f64, _)> = (segments.iter().flatten().zip(ends.iter().flatten()))
            .filter(|(point, _)| point.on_edges >> edge & 1 == 1)
            .map(|(point, handle)| (plane.along(edge, point.position), *handle))
            .collect();
        along.push((0.0, *corners.get(edge)?));
        along.push((1.0, *corners.get((edge + 1) % 3)?));
        along.sort_by(|a, b| a.0.total_cmp(&b.0));
        for pair in along.windows(2).filter(|pair| pair[0].1 != pair[1].1) {
            triangulation.add_constraint_and_split(pair[0].1, pair[1].1, |at| plane.at(at));
        }
    }
    for [a, b] in ends.into_iter().filter(|[a, b]| a != b) {
        triangulation.add_constraint_and_split(a, b, |at| plane.at(at));
    }
    let pieces = (triangulation.inner_faces())
        .filter_map(|piece| {
            let points = piece.vertices().map(|vertex| *vertex.data());
            // Beside an edge, not within the face.
            let is_sliver = points.iter().fold(0b111, |edges, point| edges & point.on_edges) != 0;
            let [a, b, c] = points.map(|point| point.position);
            let turned = if (b - a).cross(c - a).dot(plane.normal) < 0.0 { [a, c, b] } else { [a, b, c] };
            (!is_sliver).then_some(turned)
        })
        .collect();
    Some(pieces)
}

/// A point of the face.
#[derive(Debug, Clone, Copy)]
struct Point {
    at: Point2<f64>,
    position: DVec3,
    /// A bit for each edge of the face that it lies on.
    on_edges: u8,
}

impl HasPosition for Point {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// The plane of a face, with the two coordinates in which it is triangulated.
struct Plane {
    corners: [DVec3; 3],
    /// Unit.
    normal: DVec3,
    /// The longest extent of the face.
    size: f64,
    /// The axis that is dropped, and the two that are kept.
    axes: [usize; 3],
}

impl Plane {
    /// `None` for a face without area.
    fn of(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).try_normalize()?;
        let size = (b - a).abs().max((c - a).abs()).max_element();
        let steepness = normal.abs().to_array();
        let dropped = (0..3).max_by(|&i, &j| steepness[i].total_cmp(&steepness[j]))?;
        Some(Self { corners, normal, size, axes: [dropped, (dropped + 1) % 3, (dropped + 2) % 3] })
    }

    fn project(&self, position: DVec3) -> Point2<f64> {
        let p = (position - self.corners[0]) / self.size;
        Point2::new(p[self.axes[1]], p[self.axes[2]])
    }

    /// The point of the plane at a place in two coordinates.
    fn at(&self, at: Point2<f64>) -> Point {
        let [dropped, first, second] = self.axes;
        let mut p = DVec3::ZERO;
        (p[first], p[second]) = (at.x, at.y);
        p[dropped] = -(p[first] * self.normal[first] + p[second] * self.normal[second]) / self.normal[dropped];
        Point { at, position: self.corners[0] + p * self.size, on_edges: 0 }
    }

    fn corner(&self, corner: usize) -> Point {
        let position = self.corners[corner];
        Point { at: self.project(position), position, on_edges: 1 << corner | 1 << ((corner + 2) % 3) }
    }

    /// A point on an edge, or the corner that it all but is.
    fn on_edge(&self, edge: usize, position: DVec3) -> Point {
        let near = |corner: &usize| self.corners[*corner].distance(position) <= SAME * self.size;
        match [edge, (edge + 1) % 3].into_iter().find(near) {
            Some(corner) => self.corner(corner),
            None => Point { at: self.project(position), position, on_edges: 1 << edge },
        }
    }

    fn inner(&self, position: DVec3) -> Point {
        Point { at: self.project(position), position, on_edges: 0 }
    }

    fn edge(&self, edge: usize) -> [DVec3; 2] {
        [self.corners[edge], self.corners[(edge + 1) % 3]]
    }

    /// How far along an edge a point lies, 0 at its start and 1 at its end.
    fn along(&self, edge: usize, position: DVec3) -> f64 {
        let [a, b] = self.edge(edge);
        (position - a).dot(b - a) / (b - a).length_squared()
    }

    /// The segment in which another triangle that lies in another plane crosses the face; where it does no more than touch an edge, a point of that.
    fn crossing(&self, other: &[DVec3; 3]) -> Option<[Point; 2]> {
        let mut points: Vec<Point> = Vec::new();
        let mut add = |point: Point| {
            if points.iter().all(|known| known.position.distance(point.position) > SAME * self.size) {
                points.push(point);
            }
        };
        for edge in 0..3 {
            if let Some((position, _)) = through(self.edge(edge), other) {
                add(self.on_edge(edge, position));
            }
            // A corner of the face in the other's plane.
            if volume(other, self.corners[edge]) == 0.0 && covers(other, self.corners[edge]) {
                add(self.corner(edge));
            }
        }
        for k in 0..3 {
            let [a, b] = [other[k], other[(k + 1) % 3]];
            match through([a, b], &self.corners) {
                None => {}
                Some((position, [])) => add(self.inner(position)),
                // Most have been found as points of the face's edges; one that lies in the other's plane has not.
                Some((_, edges)) => {
                    for &edge in edges {
                        if self.edge(edge).iter().all(|end| volume(other, *end) == 0.0)
                            && let Some(position) = nearest_on(self.edge(edge), [a, b])
                        {
                            add(self.on_edge(edge, position));
                        }
                    }
                }
            }
            if volume(&self.corners, a) == 0.0 && covers(&self.corners, a) {
                add(self.inner_or_on_edge(a));
            }
        }
        // More than two are the same two but for rounding.
        if let [only] = points[..] {
            return (only.on_edges != 0).then_some([only, only]);
        }
        let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
        let length = |[i, j]: &[usize; 2]| points[*i].position.distance_squared(points[*j].position);
        pairs.max_by(|a, b| length(a).total_cmp(&length(b))).map(|pair| pair.map(|index| points[index]))
    }

    /// The edge that a point lies on.
    fn edge_at(&self, position: DVec3) -> Option<usize> {
        (0..3).find(|edge| distance_to(position, self.edge(*edge)) <= SAME * self.size)
    }

    fn inner_or_on_edge(&self, position: DVec3) -> Point {
        match self.edge_at(position) {
            Some(edge) => self.on_edge(edge, position),
            None => self.inner(position),
        }
    }

    /// The parts of a coincident triangle's edges that lie in the face.
    fn edges_of(&self, other: &[DVec3; 3]) -> Vec<[Point; 2]> {
        let inside = |p: DVec3| {
            let at = self.project(p);
            let sides = [0, 1, 2].map(|edge| {
                let [a, b] = self.edge(edge).map(|p| self.project(p));
                (DVec2::new(b.x - a.x, b.y - a.y)).perp_dot(DVec2::new(at.x - a.x, at.y - a.y))
            });
            sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
        };
        (0..3)
            .filter_map(|k| {
                let [a, b] = [other[k], other[(k + 1) % 3]];
                let is_here = |p: &DVec3| inside(*p) || self.edge_at(*p).is_some();
                let mut points: Vec<Point> =
                    [a, b].into_iter().filter(is_here).map(|p| self.inner_or_on_edge(p)).collect();
                let is_passed = |corner: &usize| distance_to(self.corners[*corner], [a, b]) <= SAME * self.size;
                points.extend((0..3).filter(is_passed).map(|corner| self.corner(corner)));
                for edge in 0..3 {
                    if let Some(position) = self.meeting_of_edges(edge, [a, b]) {
                        points.push(self.on_edge(edge, position));
                    }
                }
                let first = *points.first()?;
                let far = |point: &Point| point.position.distance(first.position);
                let last = *points.iter().max_by(|p, q| far(p).total_cmp(&far(q)))?;
                (far(&last) > SAME * self.size).then_some([first, last])
            })
            .collect()
    }

    /// Where an edge of the face meets another edge beside it, as a point of the face's edge.
    fn meeting_of_edges(&self, edge: usize, [c, d]: [DVec3; 2]) -> Option<DVec3> {
        let [a, b] = ordered(self.edge(edge));
        let [pa, pb, pc, pd] = [a, b, c, d].map(|p| self.project(p)).map(|p| Coord { x: p.x, y: p.y });
        let is_apart = |s: f64, t: f64| s * t >= 0.0;
        if is_apart(orient2d(pa, pb, pc), orient2d(pa, pb, pd)) || is_apart(orient2d(pc, pd, pa), orient2d(pc, pd, pb))
        {
            return None;
        }
        nearest_on([a, b], [c, d])
    }
}

/// The place on an edge that is nearest to another one: the same whichever face's plane is looked at. `None` where they run side by side.
fn nearest_on(edge: [DVec3; 2], other: [DVec3; 2]) -> Option<DVec3> {
    let ([a, b], [c, d]) = (ordered(edge), ordered(other));
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let determinant = uu * vv - uv * uv;
    let t = (uv * v.dot(w) - vv * u.dot(w)) / determinant;
    t.is_finite().then(|| a + u * t.clamp(0.0, 1.0))
}

fn distance_to(point: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = (point - a).dot(b - a) / (b - a).length_squared();
    point.distance(a + (b - a) * if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 })
}

/// Both ends in an order that does not depend on which comes first.
fn ordered([a, b]: [DVec3; 2]) -> [DVec3; 2] {
    let is_later = a.to_array().iter().zip(b.to_array()).find_map(|(a, b)| (*a != b).then_some(*a > b));
    if is_later == Some(true) { [b, a] } else { [a, b] }
}

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// Six times the volume over a triangle and a point; its sign is exact.
fn volume(triangle: &[DVec3; 3], point: DVec3) -> f64 {
    orient3d(coord(triangle[0]), coord(triangle[1]), coord(triangle[2]), coord(point))
}

/// Where an edge goes from one side of a triangle to the other, through it or its outline, and which of the triangle's edges it goes through.
fn through(edge: [DVec3; 2], triangle: &[DVec3; 3]) -> Option<(DVec3, &'static [usize])> {
    let [a, b] = ordered(edge);
    let (below, above) = (volume(triangle, a), volume(triangle, b));
    if !(below < 0.0 && above > 0.0 || below > 0.0 && above < 0.0) {
        return None;
    }
    let around = [0, 1, 2].map(|k| orient3d(coord(a), coord(b), coord(triangle[k]), coord(triangle[(k + 1) % 3])));
    let is_inside = around.iter().all(|side| *side >= 0.0) || around.iter().all(|side| *side <= 0.0);
    let met: &[usize] = match around.map(|side| side == 0.0) {
        [false, false, false] => &[],
        [true, false, false] => &[0],
        [false, true, false] => &[1],
        [false, false, true] => &[2],
        [true, true, false] => &[0, 1],
        [false, true, true] => &[1, 2],
        [true, false, true] => &[0, 2],
        [true, true, true] => &[0, 1, 2],
    };
    is_inside.then(|| (a + (b - a) * (below / (below - above)), met))
}

/// Whether a point in the plane of a triangle lies in it or on its outline.
fn covers(triangle: &[DVec3; 3], point: DVec3) -> bool {
    let Some(plane) = Plane::of(*triangle) else { return false };
    let flat = |p: DVec3| Coord { x: p[plane.axes[1]], y: p[plane.axes[2]] };
    let sides = [0, 1, 2].map(|k| orient2d(flat(triangle[k]), flat(triangle[(k + 1) % 3]), flat(point)));
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area([a, b, c]: [DVec3; 3]) -> f64 {
        0.5 * (b - a).cross(c - a).length()
    }

    fn irregular(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // As coordinates are: f32.
        f64::from((*state >> 40) as f32 / (1 << 24) as f32)
    }

    fn triangle(state: &mut u64) -> [DVec3; 3] {
        [0; 3].map(|_| DVec3::new(irregular(state), irregular(state), irregular(state)))
    }

    /// The pieces cover the face once, look where it looks, and lie each on one side of everything that cuts it.
    #[test]
    fn pieces_cover_the_face_and_are_on_one_side() {
        let mut state = 1;
        let mut pieces_of_all = 0;
        for _ in 0..500 {
            let face = triangle(&mut state);
            let others: Vec<_> = (0..4).map(|_| (Meeting::Crosses, triangle(&mut state))).collect();
            let Some(pieces) = cut(face, &others) else { continue };
            pieces_of_all += pieces.len();
            let sum: f64 = pieces.iter().map(|piece| area(*piece)).sum();
            assert!((sum / area(face) - 1.0).abs() < 1e-9, "{sum} of {}", area(face));
            let normal = (face[1] - face[0]).cross(face[2] - face[0]);
            for piece in pieces.iter().filter(|piece| area(**piece) > 1e-12) {
                assert!((piece[1] - piece[0]).cross(piece[2] - piece[0]).dot(normal) > 0.0);
                let middle = (piece[0] + piece[1] + piece[2]) / 3.0;
                for (_, other) in &others {
                    // A segment from the middle to anywhere in the piece does not go through the other triangle.
                    for corner in piece {
                        let near = middle + (*corner - middle) * 0.999;
                        let lift = normal.normalize() * 1e-9;
                        assert!(
                            through([middle + lift, near - lift], other).is_none()
                                || through([middle, near], other).is_none()
                        );
                    }
                }
            }
        }
        assert!(pieces_of_all > 1000, "{pieces_of_all}");
    }

    /// Two faces that share an edge have the same points on it.
    #[test]
    fn neighbours_are_cut_at_the_same_points() {
        let mut state = 7;
        let mut shared = 0;
        for _ in 0..500 {
            let [a, b, c] = triangle(&mut state);
            let d = triangle(&mut state)[0];
            let others: Vec<_> = (0..3).map(|_| (Meeting::Crosses, triangle(&mut state))).collect();
            let on_edge = |face: [DVec3; 3]| {
                let pieces = cut(face, &others).unwrap_or_else(|| vec![face]);
                let mut found: Vec<[u64; 3]> = (pieces.iter().flatten())
                    .filter(|p| (**p - a).cross(b - a).length() < 1e-12 && (**p - a).dot(b - a) > 0.0)
                    .map(|p| p.to_array().map(f64::to_bits))
                    .collect();
                found.sort_unstable();
                found.dedup();
                found
            };
            let (one, other) = (on_edge([a, b, c]), on_edge([b, a, d]));
            assert_eq!(one, other);
            shared += one.len() - 1;
        }
        assert!(shared > 100, "{shared}");
    }

    /// A smaller triangle in the same plane, given the wrong way round and shifted by a rounding, is cut out.
    #[test]
    fn a_coincident_triangle_is_cut_out() {
        let face = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let lift = DVec3::Z * 1e-8;
        let inner = [DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.5, 1.5, 0.0), DVec3::new(1.5, 0.5, 0.0)].map(|p| p + lift);
        let pieces = cut(face, &[(Meeting::Coincides, inner)]).unwrap();
        let is_in = |p: DVec3| p.x > 0.5 && p.y > 0.5 && p.x + p.y < 2.0;
        let of_inner: f64 = (pieces.iter())
            .filter(|piece| is_in((piece[0] + piece[1] + piece[2]) / 3.0))
            .map(|piece| area(*piece))
            .sum();
        assert!((of_inner - 0.5).abs() < 1e-6, "{of_inner}");
        let all: f64 = pieces.iter().map(|piece| area(*piece)).sum();
        assert!((all - 8.0).abs() < 1e-9);
        // One that reaches beyond the face, or covers it.
        let beyond = [DVec3::new(1.0, -1.0, 0.0), DVec3::new(3.0, 1.0, 0.0), DVec3::new(1.0, 5.0, 0.0)];
        let sum: f64 = cut(face, &[(Meeting::Coincides, beyond)]).unwrap().iter().map(|piece| area(*piece)).sum();
        assert!((sum - 8.0).abs() < 1e-9);
        let whole = face.map(|p| p * 3.0 - DVec3::ONE.with_z(0.0));
        assert!(cut(face, &[(Meeting::Coincides, whole)]).is_none());
        assert!(cut([DVec3::ZERO; 3], &[(Meeting::Crosses, face)]).is_none());
    }
}
