//! Shapes that other renderers have, as shapes of this one, with a matrix applied.

use glam::{DAffine3, DVec3};

use super::place::{Placed, made, transformed};
use crate::formats::gltf::transform;
use crate::geometry::Mesh;
use crate::scene::description::Shape;
use crate::scene::shapes::tessellate;

/// Around the axis of what is round and is a mesh here.
const SEGMENTS: u32 = 192;
/// Of a sphere that is stretched: 20 · 4⁶ triangles.
const SUBDIVISIONS: u32 = 6;
/// Scales that differ relatively by less are one.
const SAME: f64 = 1e-9;

/// A sphere; analytic unless it is stretched.
pub fn sphere(center: DVec3, radius: f64, matrix: &DAffine3) -> Placed {
    let columns = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis];
    let [x, y, z] = columns.map(DVec3::length);
    let dots = [columns[0].dot(columns[1]), columns[1].dot(columns[2]), columns[2].dot(columns[0])];
    let is_even =
        (x - y).abs() <= SAME * x && (x - z).abs() <= SAME * x && dots.iter().all(|d| d.abs() <= SAME * x * x);
    if is_even {
        return Placed::new(Shape::Sphere { center: matrix.transform_point3(center), radius: radius * x });
    }
    let shape = Shape::Icosphere { center, radius, subdivisions: SUBDIVISIONS };
    Placed { is_smooth: true, ..at(shape, matrix) }
}

/// From −1 to 1 along x and y, towards +z. The normal of a mirrored one points where the mirrored z axis does.
pub fn rectangle(matrix: &DAffine3) -> Placed {
    let [edge_u, edge_v] = [DVec3::X, DVec3::Y].map(|edge| 2.0 * (matrix.matrix3 * edge));
    let is_inward = matrix.matrix3.determinant() < 0.0;
    // Edges of a quad stand at right angles.
    if edge_u.dot(edge_v).abs() > SAME * edge_u.length() * edge_v.length() {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let positions = corners.map(|[x, y]| matrix.transform_point3(DVec3::new(x, y, 0.0))).to_vec();
        let mesh = Mesh { positions, normals: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] };
        return Placed { is_inward, ..made(mesh, false) };
    }
    let shape = Shape::Quad { center: matrix.translation, edge_u, edge_v };
    Placed { is_inward, ..Placed::new(shape) }
}

/// A box between two corners.
pub fn cuboid(min: DVec3, max: DVec3, matrix: &DAffine3) -> Placed {
    at(Shape::Box { min, max }, matrix)
}

/// A ring in the plane z = `height`, towards +z.
pub fn disk(height: f64, inner: f64, outer: f64, matrix: &DAffine3) -> Placed {
    let point = |angle: f64, radius: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(SEGMENTS);
    let mut mesh = Mesh::default();
    if inner > 0.0 {
        mesh.positions = (0..SEGMENTS).flat_map(|k| [point(angle(k), outer), point(angle(k), inner)]).collect();
        mesh.triangles = quads().collect();
    } else {
        mesh.positions = (0..SEGMENTS).map(|k| point(angle(k), outer)).chain([point(0.0, 0.0)]).collect();
        mesh.triangles = (0..SEGMENTS).map(|k| [k, (k + 1) % SEGMENTS, SEGMENTS]).collect();
    }
    let is_inward = matrix.matrix3.determinant() < 0.0;
    // Not so that the outside stays outside: an open surface has none.
    mesh.positions.iter_mut().for_each(|p| *p = matrix.transform_point3(*p));
    Placed { is_inward, ..made(mesh, false) }
}

/// The wall of a cylinder between two points, without its ends.
pub fn tube(from: DVec3, to: DVec3, radius: f64, matrix: &DAffine3) -> Placed {
    let along = (to - from).normalize_or(DVec3::Z);
    let (across, other) = along.any_orthonormal_pair();
    let normal = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(SEGMENTS);
        across * angle.cos() + other * angle.sin()
    };
    let mesh = Mesh {
        positions: (0..SEGMENTS).flat_map(|k| [from + normal(k) * radius, to + normal(k) * radius]).collect(),
        normals: (0..SEGMENTS).flat_map(|k| [normal(k); 2]).collect(),
        triangles: quads().map(|[a, b, c]| [b, a, c]).collect(),
    };
    let outward = |mesh: &Mesh| {
        let [a, b, c] = mesh.triangles[0].map(|corner| mesh.positions[corner as usize]);
        (b - a).cross(c - a).dot(mesh.normals[0]) > 0.0
    };
    let mesh = if outward(&mesh) { mesh } else { super::place::turned_over(&mesh) };
    let normals_kept = Mesh { normals: (0..SEGMENTS).flat_map(|k| [normal(k); 2]).collect(), ..mesh };
    made(transformed(&normals_kept, matrix), true)
}

/// Two triangles for each step around, between points that alternate between two circles.
fn quads() -> impl Iterator<Item = [u32; 3]> {
    (0..SEGMENTS).flat_map(|k| {
        let (here, next) = (2 * k, 2 * ((k + 1) % SEGMENTS));
        [[here, next, next + 1], [here, next + 1, here + 1]]
    })
}

/// A shape with a matrix: transformed by numbers where they can say it, or else a mesh.
fn at(shape: Shape, matrix: &DAffine3) -> Placed {
    match transform(matrix) {
        Some(transform) => Placed { transform, ..Placed::new(shape) },
        None => match tessellate(&shape) {
            Ok(Some(mesh)) => made(transformed(&mesh, matrix), false),
            _ => Placed::new(shape),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh_of(placed: &Placed) -> &Mesh {
        match &placed.shape {
            Shape::Mesh { mesh, .. } => mesh,
            other => panic!("no mesh: {other:?}"),
        }
    }

    fn normal(mesh: &Mesh, triangle: usize) -> DVec3 {
        let [a, b, c] = mesh.triangles[triangle].map(|corner| mesh.positions[corner as usize]);
        (b - a).cross(c - a)
    }

    #[test]
    fn round_shapes_face_outward() {
        for inner in [0.0, 0.5] {
            let disk = disk(1.0, inner, 2.0, &DAffine3::IDENTITY);
            let mesh = mesh_of(&disk);
            assert!((0..mesh.triangles.len()).all(|k| normal(mesh, k).z > 0.0), "{inner}");
        }
        for matrix in [DAffine3::IDENTITY, DAffine3::from_scale(DVec3::new(1.0, 1.0, -2.0))] {
            let tube = tube(DVec3::ZERO, DVec3::Z, 1.0, &matrix);
            let mesh = mesh_of(&tube);
            for (k, triangle) in mesh.triangles.iter().enumerate() {
                let radial = mesh.positions[triangle[0] as usize].with_z(0.0);
                assert!(normal(mesh, k).dot(radial) > 0.0 && mesh.normals[triangle[0] as usize].dot(radial) > 0.0);
            }
        }
    }

    #[test]
    fn a_stretched_sphere_is_a_mesh_or_an_icosphere() {
        let even = sphere(DVec3::X, 2.0, &DAffine3::from_scale(DVec3::new(3.0, -3.0, 3.0)));
        assert_eq!(even.shape, Shape::Sphere { center: DVec3::new(3.0, 0.0, 0.0), radius: 6.0 });
        let uneven = sphere(DVec3::X, 2.0, &DAffine3::from_scale(DVec3::new(3.0, 1.0, 3.0)));
        assert!(matches!(uneven.shape, Shape::Icosphere { .. }) && uneven.transform.scale.y == 1.0);
    }

    #[test]
    fn a_rectangle_is_a_quad_unless_it_is_sheared() {
        let quad = rectangle(&DAffine3::from_scale(DVec3::new(2.0, 3.0, 1.0)));
        assert_eq!(quad.shape, Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::X * 4.0, edge_v: DVec3::Y * 6.0 });
        let shear = glam::DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z);
        assert_eq!(mesh_of(&rectangle(&DAffine3::from_mat3(shear))).triangles.len(), 2);
    }
}
