//! Parts put against each other: in a corner, along an edge, on a face, flush or not, from outside and from inside.

use glam::{DAffine3, DMat3, DVec3};

use super::Numbers;
use super::parts::{self, Part};
use super::truth::distance_to_triangle;

/// A place on a part that another one can be put against.
#[derive(Debug, Clone, Copy)]
pub struct Feature {
    pub point: DVec3,
    /// Unit, away from the part, which lies wholly behind the plane across it if it is convex.
    pub direction: DVec3,
    /// Unit, across `direction`: along an edge where there is one.
    pub along: DVec3,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Corner,
    Edge,
    Face,
}

/// A random corner, edge or face of a polyhedron.
pub fn feature(numbers: &mut Numbers, part: &Part, kind: Kind) -> Feature {
    let polygon = numbers.index(part.polygons.len());
    let corners = &part.polygons[polygon];
    let k = numbers.index(corners.len());
    let (first, second) = (corners[k], corners[(k + 1) % corners.len()]);
    let [a, b] = [first, second].map(|i| part.points[i as usize]);
    let sum_of_normals = |has: &dyn Fn(&[u32]) -> bool| {
        let meeting = (0..part.polygons.len()).filter(|&p| has(&part.polygons[p]));
        meeting.map(|p| part.normal(p)).sum::<DVec3>().normalize()
    };
    let (point, direction) = match kind {
        Kind::Corner => (a, sum_of_normals(&|polygon| polygon.contains(&first))),
        Kind::Edge => {
            let share = [0.5, numbers.between(0.1, 0.9)][numbers.index(2)];
            (a.lerp(b, share), sum_of_normals(&|polygon| polygon.contains(&first) && polygon.contains(&second)))
        }
        Kind::Face => {
            let outline = part.outline(polygon);
            let middle = outline.iter().sum::<DVec3>() / outline.len() as f64;
            (middle.lerp(a, numbers.between(0.0, 0.8)), part.normal(polygon))
        }
    };
    Feature { point, direction, along: (b - a).reject_from(direction).normalize() }
}

/// The lowest point of a surface of revolution: a flat end or a tip.
pub fn lower_end(part: &Part) -> Feature {
    let lowest = part.points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    Feature { point: DVec3::Y * lowest, direction: DVec3::NEG_Y, along: DVec3::X }
}

/// Moves `part` so that its feature meets `other` head on; turned so that their edges are parallel, or anyhow.
pub fn against(numbers: &mut Numbers, part: Part, own: Feature, other: Feature, is_aligned: bool) -> Part {
    let angle = if is_aligned {
        std::f64::consts::FRAC_PI_2 * numbers.index(4) as f64
    } else {
        numbers.between(0.0, std::f64::consts::TAU)
    };
    // Quarter turns are exact.
    let (sin, cos) = (angle.sin(), angle.cos());
    let [sin, cos] = [sin, cos].map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
    let basis = |d: DVec3, u: DVec3| DMat3::from_cols(d, u, d.cross(u));
    let along = other.along * cos + other.direction.cross(other.along) * sin;
    let turn = basis(-other.direction, along) * basis(own.direction, own.along).transpose();
    part.moved(&DAffine3::from_mat3_translation(turn, other.point - turn * own.point))
}

/// The mirror image in the plane through a feature: both share the corner, the edge or the face.
pub fn mirrored(part: &Part, feature: Feature) -> Part {
    let n = feature.direction;
    let mirror = DMat3::IDENTITY - DMat3::from_cols(n * (2.0 * n.x), n * (2.0 * n.y), n * (2.0 * n.z));
    part.clone().moved(&DAffine3::from_mat3_translation(mirror, n * (2.0 * n.dot(feature.point))))
}

/// The same, smaller or larger, with a point of it kept where it is: flush with the planes through that point.
pub fn scaled_about(part: &Part, point: DVec3, factor: f64) -> Part {
    let scale = DMat3::from_diagonal(DVec3::splat(factor));
    part.clone().moved(&DAffine3::from_mat3_translation(scale, point * (1.0 - factor)))
}

/// A prism or pyramid that grows from a face of `part` by `height` (inward where it is negative), over the face's own outline or over one that
/// is scaled about one of the face's corners, the middle of an edge or a point inside.
pub fn grown(numbers: &mut Numbers, part: &Part, height: f64, scale: f64) -> Part {
    let polygon = numbers.index(part.polygons.len());
    let outline = part.outline(polygon);
    let middle = outline.iter().sum::<DVec3>() / outline.len() as f64;
    let k = numbers.index(outline.len());
    let about = match numbers.index(3) {
        0 => outline[k],
        1 => outline[k].midpoint(outline[(k + 1) % outline.len()]),
        _ => middle.lerp(outline[k], numbers.between(0.0, 0.8)),
    };
    let base: Vec<DVec3> =
        if scale == 1.0 { outline } else { outline.iter().map(|p| about + (*p - about) * scale).collect() };
    let by = part.normal(polygon) * height;
    if numbers.index(2) == 0 {
        Part::prism_over(numbers, &base, by)
    } else {
        let middle = base.iter().sum::<DVec3>() / base.len() as f64;
        let tip = middle.lerp(base[0], numbers.between(0.0, 1.0)) + by;
        Part::pyramid_over(numbers, &base, tip)
    }
}

/// A tetrahedron that fills a corner of a polyhedron from inside, along the three edges that meet there: to their ends or less far.
pub fn in_the_corner(numbers: &mut Numbers, part: &Part) -> Part {
    let corner = numbers.index(part.points.len()) as u32;
    let at = |i: u32| part.points[i as usize];
    // After the corner, each of the three outlines there comes to another of its neighbours.
    let neighbours = part.polygons.iter().filter_map(|polygon| {
        let k = polygon.iter().position(|&i| i == corner)?;
        Some(polygon[(k + 1) % polygon.len()])
    });
    let legs: Vec<DVec3> = neighbours
        .map(|other| {
            let share = [1.0, 1.0, 0.5, numbers.between(0.2, 0.9)][numbers.index(4)];
            if share == 1.0 { at(other) } else { at(corner).lerp(at(other), share) }
        })
        .collect();
    Part::pyramid_over(numbers, &legs[..3], at(corner))
}

/// A tetrahedron over an edge of a polyhedron, or over a piece of it, outside.
pub fn on_an_edge(numbers: &mut Numbers, part: &Part) -> Part {
    let polygon = &part.polygons[numbers.index(part.polygons.len())];
    let k = numbers.index(polygon.len());
    let (first, second) = (polygon[k], polygon[(k + 1) % polygon.len()]);
    let [a, b] = [first, second].map(|i| part.points[i as usize]);
    let meeting: Vec<usize> = (0..part.polygons.len())
        .filter(|&p| part.polygons[p].contains(&first) && part.polygons[p].contains(&second))
        .collect();
    let out = meeting.iter().map(|&p| part.normal(p)).sum::<DVec3>().normalize() * a.distance(b);
    let side = out.cross(b - a).normalize() * a.distance(b) * numbers.between(0.2, 0.6);
    let [from, to] = [[0.0, 1.0], [0.0, 0.6], [0.2, 0.7], [-0.3, 1.4]][numbers.index(4)];
    let end = |share: f64| {
        if share == 0.0 {
            a
        } else if share == 1.0 {
            b
        } else {
            a.lerp(b, share)
        }
    };
    let foot = a.midpoint(b) + out;
    Part::pyramid_over(numbers, &[end(from), end(to), foot + side], foot - side)
}

/// Makes points of `part` that lie on points of `other` but for rounding the very same.
pub fn snap(part: &mut Part, other: &Part) {
    let reach = 1e-12 * (part.radius() + other.radius());
    for index in 0..part.points.len() {
        let Some(near) = other.points.iter().find(|p| p.distance(part.points[index]) <= reach) else { continue };
        part.points[index] = *near;
        let own = index as u32;
        part.written.iter_mut().filter(|written| written.0 == own).for_each(|written| written.1 = *near);
    }
}

/// Distance from a point to a part's surface.
pub fn room_around(part: &Part, point: DVec3) -> f64 {
    part.corners().map(|corners| distance_to_triangle(corners, point)).fold(f64::INFINITY, f64::min)
}

/// A polyhedron or round part of a size that fits a ball of `room` around `at`.
pub fn fitting(numbers: &mut Numbers, at: DVec3, room: f64) -> Part {
    let part = parts::any(numbers, 1.0);
    let scale = 0.9 * room / part.radius();
    let (turn, middle) = (turn(numbers), part.middle());
    let map = turn * DMat3::from_diagonal(DVec3::splat(scale));
    part.moved(&DAffine3::from_mat3_translation(map, at - map * middle))
}

/// A random rotation.
pub fn turn(numbers: &mut Numbers) -> DMat3 {
    DMat3::from_axis_angle(numbers.direction(), numbers.between(0.0, std::f64::consts::TAU))
}
