//! Texture coordinates of shapes: see [`super`].

use glam::DVec3;

use super::profile::Piece;
use super::unit_circle;
use crate::geometry::{CornerUvs, Mesh};
use crate::scene::description::Shape;
use crate::scene::texture::spherical_corners;

/// How a piece of a revolved outline has texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum OfPiece {
    /// Around the axis, with v at both ends.
    Around([f64; 2]),
    /// A disc in a plane across the axis: by x and z as shares of its diameter, up where −z is if it looks up and else where +z is.
    Disc {
        /// Of both ends, as shares of the disc's.
        radii: [f64; 2],
        looks_up: bool,
    },
}

impl OfPiece {
    /// At an end of the piece, 0 or 1, and `step` of `steps` around from +x towards +z.
    pub fn at(self, end: usize, step: f64, steps: u32) -> [f32; 2] {
        match self {
            Self::Around(v) => [0.75 - step / f64::from(steps), v[end]],
            Self::Disc { radii, looks_up } => {
                let direction = unit_circle((2.0 * step) as u32 % (2 * steps), 2 * steps);
                let up = if looks_up { -direction.y } else { direction.y };
                [0.5 + 0.5 * radii[end] * direction.x, 0.5 + 0.5 * radii[end] * up]
            }
        }
        .map(|x| x as f32)
    }
}

/// v along the whole outline, as a share of its length.
pub(super) fn along(outline: &[Piece]) -> Vec<OfPiece> {
    let length = |piece: &Piece| piece.points[0].distance(piece.points[1]);
    let whole: f64 = outline.iter().map(length).sum();
    let mut sum = 0.0;
    let share = |sum: f64| if whole > 0.0 { sum / whole } else { 0.0 };
    (outline.iter())
        .map(|piece| {
            let first = share(sum);
            sum += length(piece);
            OfPiece::Around([first, share(sum)])
        })
        .collect()
}

/// The bottom, the wall and the top.
pub(super) fn of_cylinder() -> Vec<OfPiece> {
    vec![
        OfPiece::Disc { radii: [0.0, 1.0], looks_up: false },
        OfPiece::Around([0.0, 1.0]),
        OfPiece::Disc { radii: [1.0, 0.0], looks_up: true },
    ]
}

/// Those of a shape that is not revolved, for its mesh.
pub(super) fn of_shape(shape: &Shape, mesh: &Mesh) -> Vec<CornerUvs> {
    let corners = |uv: &dyn Fn(usize) -> [f64; 2]| -> Vec<CornerUvs> {
        mesh.triangles.iter().map(|t| t.map(|corner| uv(corner as usize).map(|x| x as f32))).collect()
    };
    match *shape {
        Shape::Quad { .. } => corners(&|corner| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][corner % 4]),
        Shape::Box { min, max } => corners(&|corner| {
            let normal = mesh.normals[corner];
            let upper = mesh.positions[corner].cmpgt(0.5 * (min + max));
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(u8::from(upper.test(axis))));
            on_box(normal, [x, y, z])
        }),
        Shape::Icosphere { .. } => {
            mesh.triangles.iter().map(|t| spherical_corners(t.map(|i| mesh.normals[i as usize]))).collect()
        }
        _ => Vec::new(),
    }
}

/// At a corner of a side of a box that is 1 where a coordinate is the greater one.
fn on_box(normal: DVec3, [x, y, z]: [f64; 3]) -> [f64; 2] {
    match normal.to_array().map(|component| component as i32) {
        [1, ..] => [1.0 - z, y],
        [-1, ..] => [z, y],
        [_, 1, _] => [x, 1.0 - z],
        [_, -1, _] => [x, z],
        [_, _, 1] => [x, y],
        _ => [1.0 - x, y],
    }
}

#[cfg(test)]
mod tests {
    use super::super::tessellate_with_uvs;
    use super::*;

    /// Where a point of the surface is, by texture coordinates in each triangle that has them.
    fn places(mesh: &Mesh, u: f64, v: f64) -> Vec<(DVec3, DVec3)> {
        let mut found = Vec::new();
        for (t, uv) in mesh.triangles.iter().zip(&mesh.uvs) {
            let [a, b, c] = uv.map(|uv| glam::DVec2::from(uv.map(f64::from)));
            let area = (b - a).perp_dot(c - a);
            let p = glam::DVec2::new(u, v);
            let (s, t2) = ((p - a).perp_dot(c - a) / area, (b - a).perp_dot(p - a) / area);
            if s >= -1e-9 && t2 >= -1e-9 && s + t2 <= 1.0 + 1e-9 {
                let [pa, pb, pc] = t.map(|i| mesh.positions[i as usize]);
                found.push((pa * (1.0 - s - t2) + pb * s + pc * t2, (pb - pa).cross(pc - pa).normalize()));
            }
        }
        found
    }

    fn with_uvs(shape: &Shape) -> Mesh {
        let mesh = tessellate_with_uvs(shape).unwrap().unwrap();
        assert!(mesh.has_uvs(), "{shape:?}");
        mesh
    }

    /// Seen from outside an image is upright and not mirrored: u grows to the right of one who looks at it with v upwards.
    #[test]
    fn images_are_not_mirrored() {
        let center = DVec3::new(0.3, -1.0, 2.0);
        let shapes = [
            Shape::Box { min: -DVec3::ONE, max: DVec3::new(1.0, 2.0, 3.0) },
            Shape::Quad { center, edge_u: DVec3::X, edge_v: DVec3::Z * 2.0 },
            Shape::Cylinder { center, radius: 1.0, height: 3.0, segments: 12 },
            Shape::Torus { center, major: 2.0, minor: 0.5, segments: 16, rings: 8 },
            Shape::Icosphere { center, radius: 2.0, subdivisions: 2 },
            Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], segments: 12 },
        ];
        for shape in shapes {
            let mesh = with_uvs(&shape);
            for (t, uv) in mesh.triangles.iter().zip(&mesh.uvs) {
                let [a, b, c] = uv.map(|uv| glam::DVec2::from(uv.map(f64::from)));
                assert!((b - a).perp_dot(c - a) > 0.0, "{shape:?}: {t:?} {uv:?}");
            }
        }
    }

    #[test]
    fn the_middle_of_a_round_image_is_in_front() {
        let round = [
            Shape::Cylinder { center: DVec3::ZERO, radius: 1.0, height: 2.0, segments: 64 },
            Shape::Icosphere { center: DVec3::ZERO, radius: 1.0, subdivisions: 4 },
        ];
        for shape in round {
            let mesh = with_uvs(&shape);
            let at = |u: f64| places(&mesh, u, 0.5).into_iter().find(|(_, normal)| normal.y.abs() < 0.5).unwrap().0;
            assert!(at(0.5).distance(DVec3::Z) < 0.01, "{shape:?}");
            // A quarter of a turn counter-clockwise, seen from above.
            assert!(at(0.7499).distance(DVec3::X) < 0.02, "{shape:?}");
        }
    }

    #[test]
    fn sides_of_a_box_have_the_image_upright() {
        let mesh = with_uvs(&Shape::Box { min: DVec3::ZERO, max: DVec3::ONE });
        let top_right = places(&mesh, 0.9, 0.8);
        let expected = [
            (DVec3::X, DVec3::new(1.0, 0.8, 0.1)),
            (DVec3::NEG_X, DVec3::new(0.0, 0.8, 0.9)),
            (DVec3::Y, DVec3::new(0.9, 1.0, 0.2)),
            (DVec3::NEG_Y, DVec3::new(0.9, 0.0, 0.8)),
            (DVec3::Z, DVec3::new(0.9, 0.8, 1.0)),
            (DVec3::NEG_Z, DVec3::new(0.1, 0.8, 0.0)),
        ];
        for (normal, place) in expected {
            let there = top_right.iter().any(|(p, n)| p.distance(place) < 1e-6 && n.distance(normal) < 1e-6);
            assert!(there, "{normal}: {top_right:?}");
        }
    }

    #[test]
    fn a_lathe_has_v_along_its_profile() {
        // Of its length of 5.5, 1.65 end on the wall.
        let profile = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 1.5], [0.0, 1.5]];
        for profile in [profile.clone(), profile.into_iter().rev().collect()] {
            let mesh = with_uvs(&Shape::Lathe { profile, segments: 48 });
            let wall = places(&mesh, 0.5, 0.3);
            assert!(!wall.is_empty());
            assert!(wall.iter().all(|(p, _)| p.distance(DVec3::new(0.0, 0.65, 1.0)) < 1e-6), "{wall:?}");
        }
    }
}
