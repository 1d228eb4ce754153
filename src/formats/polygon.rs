//! Polygons cut into triangles, by clipping ears (Meisters 1975).

use glam::{DVec2, DVec3};

/// Most corners of a polygon: clipping ears can take the square of their number.
pub(super) const MAX_CORNERS: usize = 1 << 14;

/// What is said of a polygon of more than [`MAX_CORNERS`].
pub(super) fn too_many_corners(corners: usize) -> String {
    format!("a face has {corners} corners, at most {MAX_CORNERS} are read: cut it into triangles")
}

/// Polygons of more corners than this are cut ear by ear as they come, without choosing the best: that can take the cube of their number.
const MOST_TO_CHOOSE_FROM: usize = 48;

/// How many corners may be looked at in search of ears of such polygons: a few seconds' work for one mesh.
pub(super) const PATIENCE: usize = 1 << 30;

/// Triangles over the corners of a simple polygon of three or more corners, flat or nearly so, that keep its orientation. A polygon
/// that crosses itself still gives n − 2 triangles. `None` when patience, what is left of [`PATIENCE`], ends.
pub(super) fn triangulate(points: &[DVec3], patience: &mut usize) -> Option<Vec<[usize; 3]>> {
    let flat = flatten(points);
    if points.len() > MOST_TO_CHOOSE_FROM {
        return clip_any(&flat, patience);
    }
    let mut remaining: Vec<usize> = (0..points.len()).collect();
    let mut known = [Corner::Unknown; MOST_TO_CHOOSE_FROM];
    let mut triangles = Vec::with_capacity(points.len().saturating_sub(2));
    while remaining.len() > 3 {
        let n = remaining.len();
        let corner = |i: usize| [remaining[(i + n - 1) % n], remaining[i], remaining[(i + 1) % n]];
        for i in 0..n {
            let known = &mut known[remaining[i]];
            if matches!(known, Corner::Unknown | Corner::Blocked) {
                *known = Corner::of(&flat, corner(i), &remaining);
            }
        }
        let ear = |i: usize| match known[remaining[i]] {
            Corner::Ear(quality) => Some((i, quality)),
            _ => None,
        };
        // Of the ears the best shaped one: a quad is cut along its better diagonal. Corners on a straight edge are no ears, so that
        // they end up inside triangles with area.
        let best = (0..n).filter_map(ear).max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(1, |(i, _)| i);
        let [before, clipped, after] = corner(best);
        triangles.push([before, clipped, after]);
        known[before] = Corner::Unknown;
        known[after] = Corner::Unknown;
        remaining.remove(best);
    }
    if let [a, b, c] = remaining[..] {
        triangles.push([a, b, c]);
    }
    Some(triangles)
}

/// Clips one ear after the other around the polygon, leaving out every second corner, so that a round polygon gives no fan of needles. Only
/// reflex corners can lie in an ear (and corners that are clipped never become reflex), so convex polygons take linear time.
fn clip_any(flat: &[DVec2], patience: &mut usize) -> Option<Vec<[usize; 3]>> {
    let n = flat.len();
    let mut next: Vec<usize> = (1..=n).map(|i| i % n).collect();
    let mut previous: Vec<usize> = (0..n).map(|i| (i + n - 1) % n).collect();
    let is_reflex = |corner: [usize; 3]| {
        let [p, q, r] = corner.map(|i| flat[i]);
        turn(p, q, r) <= 0.0
    };
    let mut reflex = Set::new(n, |i| is_reflex([previous[i], i, next[i]]));
    let mut triangles = Vec::with_capacity(n - 2);
    let (mut left, mut at, mut failures) = (n, 0, 0);
    while left > 3 {
        let corner = [previous[at], at, next[at]];
        // A polygon that crosses itself may have no ear: then any corner goes.
        if failures < left {
            let is_ear = !is_reflex(corner) && {
                let within = reflex.members.iter().position(|&i| is_in_ear(flat, corner, i));
                *patience = patience.checked_sub(within.unwrap_or(reflex.members.len()))?;
                within.is_none()
            };
            if !is_ear {
                at = next[at];
                failures += 1;
                continue;
            }
        }
        triangles.push(corner);
        let [before, _, after] = corner;
        next[before] = after;
        previous[after] = before;
        left -= 1;
        reflex.remove(at);
        for neighbour in [before, after] {
            if !is_reflex([previous[neighbour], neighbour, next[neighbour]]) {
                reflex.remove(neighbour);
            }
        }
        // Where ears are rare, the next is likely to be beside this one.
        at = if failures == 0 { next[after] } else { before };
        failures = 0;
    }
    triangles.push([previous[at], at, next[at]]);
    Some(triangles)
}

/// Some of the numbers below n, in any order.
struct Set {
    members: Vec<usize>,
    /// Where each stands in `members`; `usize::MAX`: nowhere.
    places: Vec<usize>,
}

impl Set {
    fn new(n: usize, is_member: impl Fn(usize) -> bool) -> Self {
        let members: Vec<usize> = (0..n).filter(|&i| is_member(i)).collect();
        let mut places = vec![usize::MAX; n];
        members.iter().enumerate().for_each(|(place, &i)| places[i] = place);
        Self { members, places }
    }

    fn remove(&mut self, i: usize) {
        let place = std::mem::replace(&mut self.places[i], usize::MAX);
        if place != usize::MAX {
            self.members.swap_remove(place);
            if let Some(&moved) = self.members.get(place) {
                self.places[moved] = place;
            }
        }
    }
}

/// The polygon seen along its normal (Newell's), from where it runs counter-clockwise.
fn flatten(points: &[DVec3]) -> Vec<DVec2> {
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| (*a - points[0]).cross(*b - points[0])).sum();
    let (u, v) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    points.iter().map(|p| *p - points[0]).map(|p| DVec2::new(p.dot(u), p.dot(v))).collect()
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// What is known of a corner: an ear stays one while others are clipped, unless they are its neighbours.
#[derive(Debug, Clone, Copy)]
enum Corner {
    Unknown,
    /// With its quality.
    Ear(f64),
    Reflex,
    /// Another corner lies in its triangle.
    Blocked,
}

impl Corner {
    fn of(flat: &[DVec2], corner: [usize; 3], remaining: &[usize]) -> Self {
        let [p, q, r] = corner.map(|i| flat[i]);
        let is_convex = turn(p, q, r) > 0.0;
        if is_convex && remaining.iter().any(|&i| is_in_ear(flat, corner, i)) {
            Self::Blocked
        } else if is_convex {
            Self::Ear(quality(flat, corner))
        } else {
            Self::Reflex
        }
    }
}

/// Whether corner `i` is another than those of a triangle, and lies in it.
fn is_in_ear(flat: &[DVec2], corner: [usize; 3], i: usize) -> bool {
    let [p, q, r] = corner.map(|i| flat[i]);
    let x = flat[i];
    // On the new edge counts as inside, unless it is one of its ends met again, as where a hole is bridged.
    let is_outside = x == p || x == r || turn(p, q, x) < 0.0 || turn(q, r, x) < 0.0 || turn(r, p, x) < 0.0;
    !is_outside && !corner.contains(&i)
}

/// Area over the square of the longest edge.
fn quality(flat: &[DVec2], corners: [usize; 3]) -> f64 {
    let [p, q, r] = corners.map(|i| flat[i]);
    let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
    turn(p, q, r) / longest.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(points: &[DVec3]) -> Vec<[usize; 3]> {
        super::triangulate(points, &mut { PATIENCE }).unwrap()
    }

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
        triangles.iter().map(|t| t.map(|i| points[i])).map(|[a, b, c]| (b - a).cross(c - a) / 2.0).sum()
    }

    /// The area of a polygon in the xy plane.
    fn enclosed(points: &[DVec3]) -> f64 {
        points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() / 2.0
    }

    fn least_area(points: &[DVec3], triangles: &[[usize; 3]], normal: DVec3) -> f64 {
        triangles.iter().map(|t| area(points, std::slice::from_ref(t)).dot(normal)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_concave_polygon() {
        // An arrowhead whose fan from the first corner would turn a triangle over.
        let points = [(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 3.0));
        for turn in 0..4 {
            let mut points = points;
            points.rotate_left(turn);
            let triangles = triangulate(&points);
            assert_eq!(triangles.len(), 2);
            assert!(area(&points, &triangles).distance(DVec3::Z * 0.5) < 1e-15);
            assert!(least_area(&points, &triangles, DVec3::Z) > 0.0);
        }
    }

    #[test]
    fn corners_on_a_straight_edge() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (0.0, 3.0)].map(|(x, z)| DVec3::new(x, 0.0, -z));
        let triangles = triangulate(&points);
        assert_eq!(triangles.len(), 3);
        assert!(area(&points, &triangles).distance(DVec3::Y * 4.5) < 1e-14);
        assert!(least_area(&points, &triangles, DVec3::Y) > 0.0);
    }

    #[test]
    fn combs() {
        for teeth in [20, 100, 2000] {
            let mut points: Vec<DVec3> =
                (0..teeth).map(|i| DVec3::new(f64::from(i), f64::from(i % 2) * 5.0 + 1.0, 0.0)).collect();
            points.extend([DVec3::new(f64::from(teeth - 1), 0.0, 0.0), DVec3::ZERO]);
            points.reverse();
            let exact = enclosed(&points);
            let triangles = triangulate(&points);
            assert_eq!(triangles.len(), points.len() - 2);
            assert!((area(&points, &triangles).z - exact).abs() < 1e-9 * exact && exact > 0.0);
            assert!(least_area(&points, &triangles, DVec3::Z) > 0.0);
        }
    }

    /// As many corners as there may be: round, and crossing itself everywhere.
    #[test]
    fn the_largest_polygons() {
        let n = MAX_CORNERS as u32;
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let circle: Vec<DVec3> = (0..n).map(|i| DVec3::new(angle(i).cos(), angle(i).sin(), 0.0)).collect();
        let triangles = triangulate(&circle);
        assert_eq!(triangles.len(), circle.len() - 2);
        assert!((area(&circle, &triangles).z / (f64::from(n) / 2.0 * angle(1).sin()) - 1.0).abs() < 1e-9);
        assert!(least_area(&circle, &triangles, DVec3::Z) > 0.0);
        // Not a fan: no corner is in more than a few triangles for each time that half of the corners are gone.
        let mut uses = vec![0; circle.len()];
        triangles.iter().flatten().for_each(|&i| uses[i] += 1);
        assert!(uses.iter().all(|&uses| uses < 60), "{:?}", uses.iter().max());
        let star = |i: u32| angle(i * 7 % n) + angle(i) * 0.01;
        let tangle: Vec<DVec3> = (0..n).map(|i| DVec3::new(star(i).cos(), star(i).sin(), 0.0)).collect();
        assert_eq!(triangulate(&tangle).len(), tangle.len() - 2);
        // A spiral: a strip that winds about itself, eight times. (Of the largest, not every ear is found.)
        let n = 2048;
        let arm = |i: u32, out: f64| {
            let turn = f64::from(i) * 0.05;
            DVec3::new(turn.cos(), turn.sin(), 0.0) * (1.0 + turn + out)
        };
        let spiral: Vec<DVec3> = (0..n / 2).map(|i| arm(i, 2.0)).chain((0..n / 2).rev().map(|i| arm(i, 0.0))).collect();
        let triangles = triangulate(&spiral);
        assert!((area(&spiral, &triangles).z / enclosed(&spiral) - 1.0).abs() < 1e-9);
        assert!(least_area(&spiral, &triangles, DVec3::Z) > 0.0);
    }
}
