//! From a shape's few numbers to a mesh.
//!
//! Faces are counter-clockwise seen from outside. Every closed shape is closed bit for bit: vertices that are split, so that a
//! crease stays sharp when normals are interpolated, have bit-equal positions.
//!
//! Where a texture asks for them, shapes have texture coordinates, so that an image is seen upright and not mirrored from outside:
//!
//! - a quad: (0, 0) at its corner against both edges, u along `edge_u` and v along `edge_v`;
//! - a box: the whole image on each side, upright where the side is, on top and bottom with u along x;
//! - what is round: u around the y axis, ½ towards +z and growing counter-clockwise seen from above. v goes from pole to pole of a sphere, up the
//!   wall of a cylinder, whose ends have the image's inscribed circle, around the tube of a torus from its outside upwards, and along the profile
//!   of a lathe, upwards on its outside.

mod icosphere;
mod limits;
mod profile;
mod revolve;
mod uvs;
mod validate;

use glam::{DVec2, DVec3};

use super::description::Shape;
use super::error::SceneError;
use crate::geometry::Mesh;

pub use limits::*;
pub use validate::validate;

/// The mesh of a shape in object space, with unit normals except for meshes from files that have none; `None` for the analytic
/// sphere, which has no mesh.
///
/// # Errors
/// When the shape's numbers make no shape, as [`validate`] says.
pub fn tessellate(shape: &Shape) -> Result<Option<Mesh>, SceneError> {
    tessellate_as(shape, false)
}

/// The same with texture coordinates, except for meshes from files that have none.
///
/// # Errors
/// As [`tessellate`].
pub fn tessellate_with_uvs(shape: &Shape) -> Result<Option<Mesh>, SceneError> {
    tessellate_as(shape, true)
}

fn tessellate_as(shape: &Shape, with_uvs: bool) -> Result<Option<Mesh>, SceneError> {
    validate(shape).map_err(|error| SceneError::new(error.to_string()))?;
    let mut mesh = match shape {
        Shape::Sphere { .. } => return Ok(None),
        &Shape::Icosphere { center, radius, subdivisions } => icosphere::icosphere(center, radius, subdivisions),
        &Shape::Box { min, max } => cuboid(min, max),
        &Shape::Cylinder { center, radius, height, segments } => {
            let half = 0.5 * height;
            let outline = profile::from_points(&[[0.0, -half], [radius, -half], [radius, half], [0.0, half]]);
            moved(revolve::revolve(&outline, segments, with_uvs.then(uvs::of_cylinder)), center)
        }
        &Shape::Torus { center, major, minor, segments, rings } => {
            let outline = profile::circle(major, minor, rings);
            moved(revolve::revolve(&outline, segments, with_uvs.then(|| uvs::along(&outline))), center)
        }
        Shape::Lathe { profile, segments } => {
            let outline = profile::from_points(profile);
            revolve::revolve(&outline, *segments, with_uvs.then(|| uvs::along(&outline)))
        }
        &Shape::Quad { center, edge_u, edge_v } => quad(center, edge_u, edge_v),
        Shape::Mesh { mesh, .. } if with_uvs => (**mesh).clone(),
        Shape::Mesh { mesh, .. } => mesh.without_uvs(),
        Shape::Point { .. } | Shape::Spot { .. } | Shape::Directional { .. } => Mesh::default(),
    };
    if with_uvs && !mesh.has_uvs() {
        mesh.uvs = uvs::of_shape(shape, &mesh);
    }
    if mesh.positions.iter().all(|p| p.is_finite()) {
        Ok(Some(mesh))
    } else {
        Err(SceneError::new("the shape is too large: its vertices are not finite numbers"))
    }
}

fn moved(mut mesh: Mesh, by: DVec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// Four vertices on each side, each with its side's normal.
fn cuboid(min: DVec3, max: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        // (axis, u, v) is right-handed, so u × v points along the axis.
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for is_upper in [false, true] {
            let first = mesh.positions.len() as u32;
            for (at_u, at_v) in [(false, false), (true, false), (true, true), (false, true)] {
                let mut p = if is_upper { max } else { min };
                p[u] = if at_u { max[u] } else { min[u] };
                p[v] = if at_v { max[v] } else { min[v] };
                mesh.positions.push(p);
                let mut normal = DVec3::ZERO;
                normal[axis] = if is_upper { 1.0 } else { -1.0 };
                mesh.normals.push(normal);
            }
            let corners = if is_upper { [0, 1, 2, 3] } else { [0, 3, 2, 1] };
            push_quad(&mut mesh.triangles, corners.map(|c| first + c));
        }
    }
    mesh
}

fn quad(center: DVec3, edge_u: DVec3, edge_v: DVec3) -> Mesh {
    let (u, v) = (edge_u * 0.5, edge_v * 0.5);
    // Scaled first: the product of two tiny edges would lose its digits.
    let normal = edge_u.normalize().cross(edge_v.normalize()).normalize();
    Mesh {
        positions: vec![center - u - v, center + u - v, center + u + v, center - u + v],
        normals: vec![normal; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: Vec::new(),
    }
}

/// Two triangles over four corners in order.
fn push_quad(triangles: &mut Vec<[u32; 3]>, [a, b, c, d]: [u32; 4]) {
    triangles.push([a, b, c]);
    triangles.push([a, c, d]);
}

/// The point at angle 2πk/n from +x towards +y, exact at quarter turns.
fn unit_circle(k: u32, n: u32) -> DVec2 {
    let quarters = 4 * u64::from(k);
    let n = u64::from(n);
    let rest = (quarters % n) as f64 / n as f64 * std::f64::consts::FRAC_PI_2;
    let (sin, cos) = rest.sin_cos();
    match quarters / n % 4 {
        0 => DVec2::new(cos, sin),
        1 => DVec2::new(-sin, cos),
        2 => DVec2::new(-cos, -sin),
        _ => DVec2::new(sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::f64::consts::PI;

    fn mesh(shape: &Shape) -> Mesh {
        tessellate(shape).unwrap().unwrap()
    }

    /// Asserts that every edge, by bit-equal positions, is shared by exactly two faces that run along it in opposite directions.
    fn assert_closed(mesh: &Mesh) {
        // −0.0 is 0.0 as a position.
        let key = |i: u32| mesh.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut edges: HashMap<_, u32> = HashMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                *edges.entry((key(t[k]), key(t[(k + 1) % 3]))).or_default() += 1;
            }
        }
        for (&(a, b), &count) in &edges {
            assert_eq!(count, 1, "an edge is used twice in one direction");
            assert_eq!(edges.get(&(b, a)), Some(&1), "an edge lacks its opposite");
        }
    }

    fn assert_normals_look_outward(mesh: &Mesh, least_cosine: f64) {
        assert_eq!(mesh.normals.len(), mesh.positions.len());
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let face = (b - a).cross(c - a).normalize();
            for n in t.map(|i| mesh.normals[i as usize]) {
                assert!((n.length() - 1.0).abs() < 1e-12);
                assert!(n.dot(face) > least_cosine, "normal {n} against face {face}");
            }
        }
    }

    fn assert_volume(mesh: &Mesh, exact: f64, relative: f64) {
        let volume = mesh.signed_volume();
        assert!((volume / exact - 1.0).abs() <= relative, "volume {volume}, exact {exact}");
    }

    /// Asserts all three, of a volume that is known to a few roundings.
    fn assert_solid(mesh: &Mesh, volume: f64, least_cosine: f64) {
        assert_closed(mesh);
        assert_volume(mesh, volume, 1e-12);
        assert_normals_look_outward(mesh, least_cosine);
    }

    /// Volume of a regular n-gon prism over that of its cylinder.
    fn polygon_share(n: u32) -> f64 {
        let angle = 2.0 * PI / f64::from(n);
        angle.sin() / angle
    }

    #[test]
    fn an_icosphere() {
        for subdivisions in 0..=4 {
            let shape = Shape::Icosphere { center: DVec3::new(3.0, -1.0, 2.0), radius: 0.5, subdivisions };
            let mesh = mesh(&shape);
            let faces = 20 * 4_usize.pow(subdivisions);
            assert_eq!((mesh.triangles.len(), mesh.positions.len()), (faces, faces / 2 + 2));
            assert_closed(&mesh);
            for p in &mesh.positions {
                assert!((p.distance(DVec3::new(3.0, -1.0, 2.0)) - 0.5).abs() < 1e-15);
            }
        }
        let shape = Shape::Icosphere { center: DVec3::ZERO, radius: 2.0, subdivisions: 0 };
        // A regular icosahedron: edge a = R / sin(2π/5), volume 5(3 + √5)a³/12.
        let edge = 2.0 / (2.0 * PI / 5.0).sin();
        assert_volume(&mesh(&shape), 5.0 / 12.0 * (3.0 + 5.0_f64.sqrt()) * edge.powi(3), 1e-12);
        let fine = mesh(&Shape::Icosphere { center: DVec3::ZERO, radius: 2.0, subdivisions: 5 });
        assert_volume(&fine, 4.0 / 3.0 * PI * 8.0, 2e-3);
        assert_normals_look_outward(&fine, 0.999);
    }

    #[test]
    fn a_box() {
        let mesh = mesh(&Shape::Box { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(1.0, 0.5, 5.0) });
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 24));
        assert_solid(&mesh, 3.0, 0.999_999);
    }

    #[test]
    fn a_cylinder() {
        let shape = Shape::Cylinder { center: DVec3::new(1.0, 2.0, 3.0), radius: 0.5, height: 2.0, segments: 24 };
        let mesh = mesh(&shape);
        assert_eq!(mesh.triangles.len(), 4 * 24);
        // The rim is a crease: caps face along y, the wall across it.
        assert_solid(&mesh, PI * 0.25 * 2.0 * polygon_share(24), (PI / 24.0).cos() - 1e-9);
        assert!(mesh.normals.iter().all(|n| n.y == 0.0 || n.y.abs() == 1.0));
        // The first vertex of the wall stands at angle 0, on +x; the next is turned towards +z.
        assert!(mesh.positions.contains(&DVec3::new(1.5, 1.0, 3.0)));
        assert!(mesh.positions.contains(&DVec3::new(1.0, 1.0, 3.5)));
    }

    #[test]
    fn a_torus() {
        let shape = Shape::Torus { center: DVec3::Y, major: 2.0, minor: 0.5, segments: 96, rings: 48 };
        let mesh = mesh(&shape);
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (2 * 96 * 48, 96 * 48));
        assert_solid(&mesh, 2.0 * PI * PI * 2.0 * 0.25 * polygon_share(96) * polygon_share(48), 0.99);
    }

    #[test]
    fn a_lathe_in_either_direction() {
        // A tumbler: solid bottom, open top. Its ends lie on the axis.
        let tumbler = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.9, 3.0], [0.9, 0.2], [0.0, 0.2]];
        let exact = PI * (3.0 - 0.81 * 2.8) * polygon_share(64);
        for profile in [tumbler.clone(), tumbler.into_iter().rev().collect()] {
            assert_solid(&mesh(&Shape::Lathe { profile, segments: 64 }), exact, 0.99);
        }
    }

    #[test]
    fn a_lathe_that_closes_on_itself() {
        // A square ring: no end on the axis, so the last point joins the first.
        let profile = vec![[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        let ring = mesh(&Shape::Lathe { profile: profile.clone(), segments: 40 });
        assert_eq!(ring.triangles.len(), 2 * 4 * 40);
        assert_solid(&ring, PI * 3.0 * polygon_share(40), 0.99);
        // A repeated first point changes nothing.
        let repeated = profile.iter().chain(&profile[..1]).copied().collect();
        assert_eq!(mesh(&Shape::Lathe { profile: repeated, segments: 40 }), ring);
        // A cone: one end on the axis, joined by the last point.
        let cone = mesh(&Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]], segments: 40 });
        assert_eq!(cone.triangles.len(), 80);
        assert_solid(&cone, PI * 2.0 / 3.0 * polygon_share(40), 0.99);
        // One end on the axis: the last point joins the first, here as the slanted side.
        let funnel = mesh(&Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0]], segments: 40 });
        assert_solid(&funnel, PI * 2.0 / 3.0 * polygon_share(40), 0.99);
    }

    #[test]
    fn a_quad() {
        let mesh = mesh(&Shape::Quad { center: DVec3::Y, edge_u: DVec3::X * 2.0, edge_v: DVec3::Z * 4.0 });
        assert_eq!(mesh.triangles.len(), 2);
        assert_eq!(mesh.normals, vec![DVec3::NEG_Y; 4]);
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        assert_eq!((b - a).cross(c - a).normalize(), DVec3::NEG_Y);
        assert!(mesh.positions.contains(&DVec3::new(-1.0, 1.0, -2.0)));
        assert!(mesh.positions.contains(&DVec3::new(1.0, 1.0, 2.0)));
    }

    #[test]
    fn an_analytic_sphere_has_no_mesh() {
        assert_eq!(tessellate(&Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }).unwrap(), None);
    }

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(unit_circle(3, 12), DVec2::Y);
        assert_eq!(unit_circle(6, 12), DVec2::NEG_X);
        assert_eq!(unit_circle(9, 12), DVec2::NEG_Y);
        let p = unit_circle(1, 12);
        assert!((p - DVec2::new(0.75_f64.sqrt(), 0.5)).length() < 1e-15);
    }
}
