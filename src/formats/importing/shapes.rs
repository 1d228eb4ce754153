//! Shapes that other renderers have, as shapes of this one, with a matrix applied.

use glam::{DAffine2, DAffine3, DMat3, DVec2, DVec3};

use super::place::{Placed, made, transformed};
use crate::formats::gltf::transform;
use crate::geometry::{CornerUvs, Mesh};
use crate::scene::description::{Shape, Transform};
use crate::scene::shapes::{tessellate, tessellate_with_uvs};

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
    // Poles on z and u from x towards y: here they are on y, and u is ½ on z.
    let turned = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let center_here = turned.transpose() * center;
    let turned = *matrix * DAffine3::from_mat3(turned);
    let file_uv_from_uv = DAffine2::from_translation(DVec2::new(-0.5, 0.0));
    if is_even {
        let scale = x.copysign(matrix.matrix3.determinant());
        let only_turned = DAffine3 { matrix3: turned.matrix3 * scale.recip(), translation: turned.translation };
        let with_uvs = transform(&only_turned).map(|transform| {
            let transform = Transform { scale: DVec3::splat(scale), ..transform };
            Box::new((Shape::Sphere { center: center_here, radius }, transform))
        });
        let shape = Shape::Sphere { center: matrix.transform_point3(center), radius: radius * x };
        return Placed { with_uvs, file_uv_from_uv, ..Placed::new(shape) };
    }
    let shape = |center: DVec3| Shape::Icosphere { center, radius, subdivisions: SUBDIVISIONS };
    let Placed { shape: with_uvs, transform, .. } = at(shape(center_here), &turned);
    let with_uvs = Some(Box::new((with_uvs, transform)));
    Placed { is_smooth: true, with_uvs, file_uv_from_uv, ..at(shape(center), matrix) }
}

/// From −1 to 1 along x and y, towards +z. The normal of a mirrored one points where the mirrored z axis does.
pub fn rectangle(matrix: &DAffine3) -> Placed {
    let [edge_u, edge_v] = [DVec3::X, DVec3::Y].map(|edge| 2.0 * (matrix.matrix3 * edge));
    let is_inward = matrix.matrix3.determinant() < 0.0;
    // Edges of a quad stand at right angles.
    if edge_u.dot(edge_v).abs() > SAME * edge_u.length() * edge_v.length() {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let positions = corners.map(|[x, y]| matrix.transform_point3(DVec3::new(x, y, 0.0))).to_vec();
        let uvs = vec![[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
        let mesh = Mesh { positions, normals: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]], uvs };
        return Placed { is_inward, ..made(mesh, false) };
    }
    let shape = Shape::Quad { center: matrix.translation, edge_u, edge_v };
    Placed { is_inward, ..Placed::new(shape) }
}

/// A box between −1 and 1. Its texture coordinates are those of Mitsuba's `cube`.
pub fn cube(matrix: &DAffine3) -> Placed {
    let shape = Shape::Box { min: DVec3::NEG_ONE, max: DVec3::ONE };
    let with_uvs = tessellate(&shape).ok().flatten().map(|mut mesh| {
        let uv = |corner: u32| {
            let ([x, y, z], normal) = (mesh.positions[corner as usize].to_array(), mesh.normals[corner as usize]);
            let [u, v] = match normal.to_array().map(|component| component as i32) {
                [1, ..] => [y, -z],
                [-1, ..] => [y, z],
                [_, 1, _] => [-x, -z],
                [_, -1, _] => [z, x],
                [.., 1] => [y, x],
                _ => [-y, x],
            };
            [u, v].map(|x| (0.5 + 0.5 * x) as f32)
        };
        let uvs = mesh.triangles.iter().map(|triangle| triangle.map(uv)).collect();
        mesh.uvs = uvs;
        let Placed { shape, transform, .. } = made(transformed(&mesh, matrix), false);
        Box::new((shape, transform))
    });
    Placed { with_uvs, ..at(shape, matrix) }
}

/// A ring in the plane z = `height`, towards +z. u goes around from x to y, v from the outer edge to the inner one.
pub fn disk(height: f64, inner: f64, outer: f64, matrix: &DAffine3) -> Placed {
    let point = |angle: f64, radius: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(SEGMENTS);
    let mut mesh = Mesh::default();
    if inner > 0.0 {
        mesh.positions = (0..SEGMENTS).flat_map(|k| [point(angle(k), outer), point(angle(k), inner)]).collect();
        mesh.triangles = quads().collect();
        mesh.uvs = quad_uvs().collect();
    } else {
        mesh.positions = (0..SEGMENTS).map(|k| point(angle(k), outer)).chain([point(0.0, 0.0)]).collect();
        mesh.triangles = (0..SEGMENTS).map(|k| [k, (k + 1) % SEGMENTS, SEGMENTS]).collect();
        let uv = |k: f32, v: f32| [k / SEGMENTS as f32, v];
        mesh.uvs =
            (0..SEGMENTS as u16).map(f32::from).map(|k| [uv(k, 0.0), uv(k + 1.0, 0.0), uv(k + 0.5, 1.0)]).collect();
    }
    let is_inward = matrix.matrix3.determinant() < 0.0;
    // Not so that the outside stays outside: an open surface has none.
    mesh.positions.iter_mut().for_each(|p| *p = matrix.transform_point3(*p));
    Placed { is_inward, ..made(mesh, false) }
}

/// The wall of a cylinder between two points, without its ends. u goes around, v from one to the other.
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
        uvs: quad_uvs().map(|[a, b, c]| [b, a, c]).collect(),
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

/// Their texture coordinates: u around, v from the first circle to the second.
fn quad_uvs() -> impl Iterator<Item = CornerUvs> {
    (0..SEGMENTS as u16).map(f32::from).flat_map(|k| {
        let (here, next) = (k / SEGMENTS as f32, (k + 1.0) / SEGMENTS as f32);
        [[[here, 0.0], [next, 0.0], [next, 1.0]], [[here, 0.0], [next, 1.0], [here, 1.0]]]
    })
}

/// A shape with a matrix: transformed by numbers where they can say it, or else a mesh.
fn at(shape: Shape, matrix: &DAffine3) -> Placed {
    match transform(matrix) {
        Some(transform) => Placed { transform, ..Placed::new(shape) },
        None => match tessellate_with_uvs(&shape) {
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
