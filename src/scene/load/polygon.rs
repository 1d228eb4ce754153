//! Polygons cut into triangles, by clipping ears (Meisters 1975).

use glam::{DVec2, DVec3};

/// Triangles over the corners of a simple polygon of three or more corners, flat or nearly so, that keep its orientation. A polygon
/// that crosses itself still gives n − 2 triangles.
pub(super) fn triangulate(points: &[DVec3]) -> Vec<[usize; 3]> {
    let flat = flatten(points);
    let mut remaining: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len().saturating_sub(2));
    while remaining.len() > 3 {
        let n = remaining.len();
        let corner = |i: usize| [remaining[(i + n - 1) % n], remaining[i], remaining[(i + 1) % n]];
        // Of the ears the best shaped one: a quad is cut along its better diagonal. Corners on a straight edge are no ears, so that
        // they end up inside triangles with area.
        let best = (0..n)
            .filter(|&i| is_ear(&flat, corner(i), &remaining))
            .max_by(|&i, &j| quality(&flat, corner(i)).total_cmp(&quality(&flat, corner(j))))
            .unwrap_or(1);
        triangles.push(corner(best));
        remaining.remove(best);
    }
    if let [a, b, c] = remaining[..] {
        triangles.push([a, b, c]);
    }
    triangles
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

fn is_ear(flat: &[DVec2], [a, b, c]: [usize; 3], remaining: &[usize]) -> bool {
    let [p, q, r] = [a, b, c].map(|i| flat[i]);
    turn(p, q, r) > 0.0
        && remaining.iter().filter(|i| ![a, b, c].contains(i)).all(|&i| {
            let x = flat[i];
            // On the new edge counts as inside, unless it is one of its ends met again, as where a hole is bridged.
            x == p || x == r || turn(p, q, x) < 0.0 || turn(q, r, x) < 0.0 || turn(r, p, x) < 0.0
        })
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

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
        triangles.iter().map(|t| t.map(|i| points[i])).map(|[a, b, c]| (b - a).cross(c - a) / 2.0).sum()
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
    fn a_comb() {
        let mut points: Vec<DVec3> =
            (0..20).map(|i| DVec3::new(f64::from(i), f64::from(i % 2) * 5.0 + 1.0, 0.0)).collect();
        points.extend([DVec3::new(19.0, 0.0, 0.0), DVec3::ZERO]);
        points.reverse();
        let exact =
            points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() / 2.0;
        let triangles = triangulate(&points);
        assert_eq!(triangles.len(), points.len() - 2);
        assert!((area(&points, &triangles).z - exact).abs() < 1e-9 && exact > 0.0);
        assert!(least_area(&points, &triangles, DVec3::Z) > 0.0);
    }
}
