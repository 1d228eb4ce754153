//! Outlines in the (r, y) half-plane, to be revolved about the y axis.

use glam::DVec2;

use super::unit_circle;

/// One straight piece of an outline, with the normals that interpolation should have at its two ends. Normals are to the right of
/// the direction of travel: outward where the outline runs counter-clockwise with r to the right and y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub points: [DVec2; 2],
    pub normals: [DVec2; 2],
}

/// Pieces that meet at a lesser angle than this are parts of one smooth curve; others are kept apart by a crease.
const SMOOTH_UP_TO_DEGREES: f64 = 40.0;

/// The points that count, and whether the last joins the first. Repeated points go; so does an explicit return to the first.
pub(super) fn clean(points: &[[f64; 2]]) -> (Vec<DVec2>, bool) {
    let mut kept: Vec<DVec2> = points.iter().copied().map(DVec2::from).collect();
    kept.dedup();
    let ends_on_axis = kept.len() > 1 && kept[0].x == 0.0 && kept[kept.len() - 1].x == 0.0;
    if !ends_on_axis && kept.len() > 1 && kept[0] == kept[kept.len() - 1] {
        kept.pop();
    }
    (kept, !ends_on_axis)
}

/// The outline through `points`: closed by the axis if both ends lie on it, else by a piece from the last point to the first.
pub(super) fn from_points(points: &[[f64; 2]]) -> Vec<Piece> {
    let (points, is_loop) = clean(points);
    let count = if is_loop { points.len() } else { points.len().saturating_sub(1) };
    let mut pieces: Vec<Piece> = (0..count)
        .map(|i| {
            let (a, b) = (points[i], points[(i + 1) % points.len()]);
            let along = (b - a).normalize_or_zero();
            let right = DVec2::new(along.y, -along.x);
            Piece { points: [a, b], normals: [right, right] }
        })
        .collect();
    let faces: Vec<DVec2> = pieces.iter().map(|piece| piece.normals[0]).collect();
    let joints = if is_loop { count } else { count.saturating_sub(1) };
    for i in 0..joints {
        let next = (i + 1) % count;
        if faces[i].dot(faces[next]) > SMOOTH_UP_TO_DEGREES.to_radians().cos() {
            let between = (faces[i] + faces[next]).normalize();
            pieces[i].normals[1] = between;
            pieces[next].normals[0] = between;
        }
    }
    pieces
}

/// A torus's tube: a circle about (major, 0), counter-clockwise, with the circle's own normals.
pub(super) fn circle(major: f64, minor: f64, rings: u32) -> Vec<Piece> {
    let normal = |k: u32| unit_circle(k % rings, rings);
    let point = |k: u32| DVec2::new(major, 0.0) + normal(k) * minor;
    (0..rings).map(|k| Piece { points: [point(k), point(k + 1)], normals: [normal(k), normal(k + 1)] }).collect()
}

/// Whether two pieces that are not meant to meet do. `is_joint` says that the end of `a` is the start of `b`; then only running back
/// along itself counts.
pub(super) fn pieces_cross(a: [DVec2; 2], b: [DVec2; 2], is_joint: bool) -> bool {
    if is_joint {
        let (u, v) = (a[1] - a[0], b[1] - b[0]);
        return turn(a[0], a[1], b[1]) == 0.0 && u.dot(v) < 0.0;
    }
    let bounds = |p: [DVec2; 2]| (p[0].min(p[1]), p[0].max(p[1]));
    let ((low_a, high_a), (low_b, high_b)) = (bounds(a), bounds(b));
    if (high_a.cmplt(low_b) | high_b.cmplt(low_a)).any() {
        return false;
    }
    // Touching counts: a turn of 0 has its end on the other's line, and the boxes above already overlap.
    let is_apart = |p: [DVec2; 2], q: [DVec2; 2]| {
        let turns = q.map(|end| turn(p[0], p[1], end));
        turns.iter().all(|turn| *turn > 0.0) || turns.iter().all(|turn| *turn < 0.0)
    };
    !is_apart(a, b) && !is_apart(b, a)
}

/// Twice the signed area of the triangle a, b, c: positive for a left turn.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(ax: f64, ay: f64, bx: f64, by: f64) -> [DVec2; 2] {
        [DVec2::new(ax, ay), DVec2::new(bx, by)]
    }

    #[test]
    fn crossing_touching_and_apart() {
        let a = piece(0.0, 0.0, 2.0, 2.0);
        assert!(pieces_cross(a, piece(0.0, 2.0, 2.0, 0.0), false));
        assert!(pieces_cross(a, piece(1.0, 1.0, 2.0, 0.0), false), "an end on the other piece");
        assert!(pieces_cross(a, piece(1.0, 1.0, 3.0, 3.0), false), "one along the other");
        assert!(!pieces_cross(a, piece(1.0, 0.0, 2.0, 1.0), false));
        assert!(!pieces_cross(a, piece(3.0, 3.0, 4.0, 4.0), false), "on one line, apart");
        assert!(!pieces_cross(a, piece(1.5, 0.0, 1.5, 1.0), false));
    }

    #[test]
    fn a_joint_may_turn_but_not_run_back() {
        assert!(!pieces_cross(piece(0.0, 0.0, 1.0, 0.0), piece(1.0, 0.0, 1.0, 1.0), true));
        assert!(!pieces_cross(piece(0.0, 0.0, 1.0, 0.0), piece(1.0, 0.0, 2.0, 0.0), true));
        assert!(pieces_cross(piece(0.0, 0.0, 1.0, 0.0), piece(1.0, 0.0, 0.5, 0.0), true));
    }

    #[test]
    fn shallow_joints_are_smooth_and_sharp_ones_are_not() {
        let bend = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            from_points(&[[0.0, 0.0], [1.0, 0.0], [1.0 + cos, sin], [0.0, 5.0]])
        };
        let gentle = bend(20.0);
        assert_eq!(gentle[0].normals[1], gentle[1].normals[0]);
        assert!((gentle[0].normals[1].angle_to(gentle[0].normals[0]).abs().to_degrees() - 10.0).abs() < 1e-9);
        let sharp = bend(60.0);
        assert_eq!(sharp[0].normals[1], DVec2::new(0.0, -1.0));
        assert_ne!(sharp[0].normals[1], sharp[1].normals[0]);
    }
}
