//! Which numbers make a shape.

use glam::DVec3;

use super::limits::{MAX_LENGTH, MAX_SEGMENTS, MAX_SUBDIVISIONS, MAX_TRIANGLES, MIN_LENGTH, SUN_ANGLES};
use super::profile::{clean, from_points, pieces_cross};
use crate::geometry::topology::MAX_FACES;
use crate::scene::description::Shape;
use crate::scene::error::Fault;

/// Most points of a profile: every piece is tested against every other.
const MAX_PROFILE_POINTS: usize = 4096;

type Checked = Result<(), Fault>;

/// Checks a shape without making its mesh.
///
/// # Errors
/// Names the number that is to blame and its valid range.
pub fn validate(shape: &Shape) -> Checked {
    match shape {
        Shape::Sphere { center, radius } => place("center", *center).and(length("radius", *radius)),
        Shape::Icosphere { center, radius, subdivisions } => {
            place("center", *center)?;
            length("radius", *radius)?;
            if *subdivisions <= MAX_SUBDIVISIONS {
                return Ok(());
            }
            Fault::at("subdivisions", format!("subdivisions is {subdivisions}, must be 0 to {MAX_SUBDIVISIONS}"))
        }
        Shape::Box { min, max } => {
            place("min", *min)?;
            place("max", *max)?;
            let Some(axis) = (0..3).find(|&axis| min[axis] >= max[axis]) else { return Ok(()) };
            let along = format!("along {} min is {} and max is {}", ["x", "y", "z"][axis], min[axis], max[axis]);
            Fault::at("max", format!("max must be greater than min on every axis, but {along}"))
        }
        Shape::Cylinder { center, radius, height, segments } => {
            place("center", *center)?;
            length("radius", *radius)?;
            length("height", *height)?;
            count("segments", *segments, 4)
        }
        Shape::Torus { center, major, minor, segments, rings } => {
            place("center", *center)?;
            length("major", *major)?;
            length("minor", *minor)?;
            if minor >= major {
                let must = format!("must be less than major ({major}), or the tube crosses itself");
                return Fault::at("minor", format!("minor is {minor}, {must}"));
            }
            count("segments", *segments, 2 * u64::from(*rings))?;
            count("rings", *rings, 2 * u64::from(*segments))
        }
        Shape::Lathe { profile, segments } => {
            check_profile(profile)?;
            count("segments", *segments, 2 * profile.len() as u64)
        }
        Shape::Quad { center, edge_u, edge_v } => {
            place("center", *center)?;
            place("edge_u", *edge_u)?;
            place("edge_v", *edge_v)?;
            for (key, edge) in [("edge_u", edge_u), ("edge_v", edge_v)] {
                if edge.length() == 0.0 {
                    return Fault::at(key, format!("{key} has no length"));
                }
            }
            if edge_u.normalize().cross(edge_v.normalize()).length() < 1e-12 {
                return Fault::at("edge_v", "edge_u and edge_v are parallel, so the quad has no area");
            }
            Ok(())
        }
        Shape::Mesh { mesh, .. } => {
            let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
            if mesh.triangles.is_empty() {
                Fault::at("", "the mesh has no triangles")
            } else if !mesh.normals.is_empty() && mesh.normals.len() != vertices {
                Fault::at("", "the mesh must have one normal for each vertex, or none")
            } else if triangles.max(vertices) > MAX_FACES {
                let most = format!("at most {MAX_FACES} of each are allowed");
                Fault::at("", format!("the mesh has {triangles} triangles and {vertices} vertices, {most}"))
            } else if mesh.triangles.iter().flatten().any(|&i| i as usize >= vertices) {
                Fault::at("", "a triangle of the mesh names a vertex that does not exist")
            } else if mesh.positions.iter().any(|p| !p.is_finite() || p.abs().max_element() > MAX_LENGTH) {
                Fault::at("", format!("a vertex of the mesh is not finite, or beyond {MAX_LENGTH:e}"))
            } else {
                Ok(())
            }
        }
        Shape::Point { position } => place("position", *position),
        Shape::Spot { position, target, inner_angle, outer_angle } => {
            place("position", *position)?;
            place("target", *target)?;
            if (*target - *position).length() < MIN_LENGTH {
                return Fault::at("target", "target and position are the same, so the light has no direction");
            }
            angle("inner_angle", *inner_angle)?;
            angle("outer_angle", *outer_angle)?;
            if *outer_angle == 0.0 {
                return Fault::at("outer_angle", "outer_angle is 0, must be greater: it is the cone's half angle");
            }
            if inner_angle > outer_angle {
                let why = format!("is less than inner_angle ({inner_angle}): the light is dark beyond outer_angle");
                return Fault::at("outer_angle", format!("outer_angle is {outer_angle}, which {why}"));
            }
            Ok(())
        }
        Shape::Directional { direction, angle } => {
            place("direction", *direction)?;
            if direction.length() < MIN_LENGTH {
                return Fault::at("direction", "direction has no length");
            }
            if *angle == 0.0 || SUN_ANGLES.contains(angle) {
                return Ok(());
            }
            let (least, most) = (SUN_ANGLES.start(), SUN_ANGLES.end());
            Fault::at("angle", format!("angle is {angle}, must be 0, or from {least} to {most} degrees"))
        }
    }
}

fn place(key: &'static str, p: DVec3) -> Checked {
    let bad = |why: &str| Fault::at(key, format!("{key} is {:?}, {why}", p.to_array()));
    if !p.is_finite() {
        return bad("must be finite");
    }
    if p.abs().max_element() > MAX_LENGTH {
        return bad(&format!("too large: use a scale with numbers below {MAX_LENGTH:e}"));
    }
    Ok(())
}

/// A cone's half angle.
fn angle(key: &'static str, value: f64) -> Checked {
    if (0.0..=180.0).contains(&value) {
        return Ok(());
    }
    Fault::at(key, format!("{key} is {value}, must be from 0 to 180 degrees"))
}

fn length(key: &'static str, value: f64) -> Checked {
    if !(value > 0.0 && value <= MAX_LENGTH) {
        return Fault::at(key, format!("{key} is {value}, must be greater than 0 (and at most {MAX_LENGTH:e})"));
    }
    if value < MIN_LENGTH {
        let must = format!("must be at least {MIN_LENGTH:e}");
        return Fault::at(key, format!("{key} is {value:e}, too small to be computed with: {must}"));
    }
    Ok(())
}

/// A number of parts around, each of which becomes `triangles_each`.
fn count(key: &'static str, value: u32, triangles_each: u64) -> Checked {
    let bad = |why: String| Fault::at(key, format!("{key} is {value}, {why}"));
    let triangles = u64::from(value) * triangles_each;
    if !(3..=MAX_SEGMENTS).contains(&value) {
        bad(format!("must be 3 to {MAX_SEGMENTS}"))
    } else if triangles > MAX_TRIANGLES {
        bad(format!("which makes {triangles} triangles; at most {MAX_TRIANGLES} are allowed"))
    } else {
        Ok(())
    }
}

fn check_profile(points: &[[f64; 2]]) -> Checked {
    let bad = |message: String| Fault::at("profile", message);
    if points.len() > MAX_PROFILE_POINTS {
        return bad(format!("the profile has {} points, at most {MAX_PROFILE_POINTS} are allowed", points.len()));
    }
    for (&[r, y], number) in points.iter().zip(1..) {
        if !(r.is_finite() && y.is_finite() && r.max(y.abs()) <= MAX_LENGTH) {
            return bad(format!(
                "point {number} of the profile is [{r}, {y}], must be finite and below {MAX_LENGTH:e}"
            ));
        }
        if r < 0.0 {
            return bad(format!("point {number} of the profile has r = {r}, must be 0 or more"));
        }
    }
    let (kept, is_loop) = clean(points);
    if kept.len() < 3 {
        return bad(format!("the profile has {} distinct points, must have 3 or more", kept.len()));
    }
    let pieces = from_points(points);
    for i in 0..pieces.len() {
        for j in i + 1..pieces.len() {
            let (a, b) = (pieces[i].points, pieces[j].points);
            // Two pieces of a loop of three meet at one joint only, like any others.
            let is_next = j == i + 1;
            let is_around_the_end = !is_next && is_loop && i == 0 && j + 1 == pieces.len();
            let (first, second) = if is_around_the_end { (b, a) } else { (a, b) };
            if pieces_cross(first, second, is_next || is_around_the_end) {
                return bad(format!(
                    "the profile crosses or touches itself: the piece from [{}, {}] to [{}, {}] meets the one from [{}, {}] to [{}, {}]",
                    a[0].x, a[0].y, a[1].x, a[1].y, b[0].x, b[0].y, b[1].x, b[1].y
                ));
            }
        }
    }
    // Twice the area that the outline encloses with the axis.
    let area: f64 = (0..kept.len()).map(|i| kept[i].perp_dot(kept[(i + 1) % kept.len()])).sum();
    if area == 0.0 {
        return bad("the profile encloses nothing: its points lie on one line".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Mesh;
    use std::path::PathBuf;
    use std::sync::Arc;

    fn lathe(profile: &[[f64; 2]]) -> Shape {
        Shape::Lathe { profile: profile.to_vec(), segments: 16 }
    }

    fn spot(position: DVec3, target: DVec3, inner_angle: f64, outer_angle: f64) -> Shape {
        Shape::Spot { position, target, inner_angle, outer_angle }
    }

    #[test]
    fn lights_without_a_surface() {
        for shape in [
            Shape::Point { position: DVec3::ONE },
            spot(DVec3::ONE, DVec3::ZERO, 0.0, 180.0),
            spot(DVec3::ONE, DVec3::ZERO, 30.0, 30.0),
            Shape::Directional { direction: DVec3::X * 1e-9, angle: 0.0 },
            Shape::Directional { direction: DVec3::X, angle: 0.53 },
            Shape::Directional { direction: DVec3::X, angle: 180.0 },
        ] {
            assert_eq!(validate(&shape), Ok(()), "{shape:?}");
        }
    }

    #[test]
    fn each_impossible_number_is_named() {
        let o = DVec3::ZERO;
        let nan = DVec3::new(0.0, f64::NAN, 0.0);
        for (shape, key) in [
            (Shape::Sphere { center: o, radius: f64::NAN }, "radius"),
            (Shape::Sphere { center: o, radius: f64::INFINITY }, "radius"),
            (Shape::Sphere { center: nan, radius: 1.0 }, "center"),
            (Shape::Icosphere { center: o, radius: 1.0, subdivisions: 9 }, "subdivisions"),
            (Shape::Cylinder { center: o, radius: 1.0, height: 0.0, segments: 8 }, "height"),
            (Shape::Torus { center: o, major: 1.0, minor: 1.0, segments: 8, rings: 8 }, "minor"),
            (Shape::Torus { center: o, major: 1.0, minor: 0.5, segments: 8, rings: 2 }, "rings"),
            (Shape::Torus { center: o, major: 1.0, minor: 0.5, segments: 8000, rings: 8000 }, "segments"),
            (Shape::Quad { center: o, edge_u: DVec3::X, edge_v: DVec3::X * 3.0 }, "edge_v"),
            (Shape::Quad { center: o, edge_u: o, edge_v: DVec3::X }, "edge_u"),
            (Shape::mesh(PathBuf::new(), Arc::new(Mesh::default())), ""),
            (Shape::Point { position: nan }, "position"),
            (spot(o, o, 10.0, 20.0), "target"),
            (spot(o, nan, 10.0, 20.0), "target"),
            (spot(o, DVec3::X, 20.0, 10.0), "outer_angle"),
            (spot(o, DVec3::X, -1.0, 10.0), "inner_angle"),
            (spot(o, DVec3::X, 10.0, 181.0), "outer_angle"),
            (spot(o, DVec3::X, 0.0, 0.0), "outer_angle"),
            (spot(o, DVec3::X, 0.0, f64::NAN), "outer_angle"),
            (Shape::Directional { direction: o, angle: 0.0 }, "direction"),
            (Shape::Directional { direction: DVec3::X, angle: -1.0 }, "angle"),
            (Shape::Directional { direction: DVec3::X, angle: 181.0 }, "angle"),
            (Shape::Directional { direction: DVec3::X, angle: 1e-9 }, "angle"),
            (Shape::Directional { direction: DVec3::X, angle: f64::NAN }, "angle"),
        ] {
            assert_eq!(validate(&shape).unwrap_err().key, key, "{shape:?}");
        }
    }

    #[test]
    fn profiles_that_make_no_solid() {
        for (profile, word) in [
            (&[[0.0, 0.0], [1.0, 1.0]][..], "3 or more"),
            (&[[1.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "3 or more"),
            (&[[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]], "r = -1"),
            (&[[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]], "finite"),
            (&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "crosses"),
            (&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]], "crosses"),
            (&[[0.0, 0.0], [0.0, 1.0], [0.0, 2.0]], "encloses nothing"),
        ] {
            let error = validate(&lathe(profile)).unwrap_err();
            assert!(error.message.contains(word), "{}", error.message);
        }
        assert!(validate(&lathe(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])).is_ok());
        assert!(validate(&lathe(&[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]])).is_ok());
    }
}
