//! Surfaces of revolution about the y axis.

use glam::{DVec2, DVec3};

use super::profile::Piece;
use super::uvs::OfPiece;
use super::{push_quad, unit_circle};
use crate::geometry::Mesh;

/// An end of a piece that lies on the axis has one smooth normal, along it, if the piece meets the axis as squarely as this; else it
/// is the tip of a cone.
const FLAT_AT_AXIS_UP_TO_DEGREES: f64 = 40.0;

/// Revolves an outline about y. Vertex k of a ring stands at angle 2πk/segments from +x towards +z. The result is turned outward by
/// the sign of its volume. `uvs` are how each piece has texture coordinates, if it shall have some.
pub(super) fn revolve(outline: &[Piece], segments: u32, uvs: Option<Vec<OfPiece>>) -> Mesh {
    let mut rings = Rings { mesh: Mesh::default(), segments, made: [None; 2] };
    for (index, piece) in outline.iter().enumerate() {
        // A piece along the axis has no surface.
        if piece.points.iter().all(|p| p.x == 0.0) {
            continue;
        }
        let middle_normal = (piece.normals[0] + piece.normals[1]).normalize_or_zero();
        let [a, b] = [0, 1].map(|end| rings.ring(piece.points[end], piece.normals[end], middle_normal));
        rings.join(&a, &b);
        if let Some(of_piece) = uvs.as_ref().and_then(|uvs| uvs.get(index)) {
            rings.add_uvs(&a, &b, *of_piece);
        }
    }
    let mut mesh = rings.mesh;
    if mesh.signed_volume() < 0.0 {
        mesh.reverse();
        // Nor shall images be mirrored.
        mesh.uvs.iter_mut().flatten().for_each(|[_, v]| *v = 1.0 - *v);
    }
    mesh
}

struct Rings {
    mesh: Mesh,
    segments: u32,
    /// The rings made first and last, used again where the outline goes on smoothly.
    made: [Option<(DVec2, DVec2, Ring)>; 2],
}

/// The vertices that one end of a piece becomes.
#[derive(Debug, Clone, Copy)]
enum Ring {
    /// `segments` vertices from this index on.
    Around(u32),
    /// One vertex on the axis.
    Pole(u32),
    /// On the axis, `segments` vertices at one place, each with the normal of its sector.
    Tip(u32),
}

impl Rings {
    fn ring(&mut self, point: DVec2, normal: DVec2, piece_normal: DVec2) -> Ring {
        let same = |made: &&(DVec2, DVec2, Ring)| made.0 == point && made.1 == normal && point.x != 0.0;
        if let Some((_, _, ring)) = self.made.iter().flatten().find(same) {
            return *ring;
        }
        let first = self.mesh.positions.len() as u32;
        let ring = if point.x != 0.0 {
            for k in 0..self.segments {
                let direction = unit_circle(k, self.segments);
                self.push(point, direction, normal);
            }
            Ring::Around(first)
        } else if piece_normal.y.abs() > FLAT_AT_AXIS_UP_TO_DEGREES.to_radians().cos() {
            self.push(point, DVec2::X, DVec2::new(0.0, piece_normal.y.signum()));
            Ring::Pole(first)
        } else {
            for k in 0..self.segments {
                // The middle of the sector between k and k + 1.
                let direction = unit_circle(2 * k + 1, 2 * self.segments);
                self.push(point, direction, piece_normal);
            }
            Ring::Tip(first)
        };
        let made = (point, normal, ring);
        self.made = [self.made[0].or(Some(made)), Some(made)];
        ring
    }

    fn push(&mut self, point: DVec2, direction: DVec2, normal: DVec2) {
        let around = |p: DVec2| DVec3::new(p.x * direction.x, p.y, p.x * direction.y);
        self.mesh.positions.push(around(point));
        self.mesh.normals.push(around(normal).normalize());
    }

    fn join(&mut self, a: &Ring, b: &Ring) {
        use Ring::{Around, Pole, Tip};
        for k in 0..self.segments {
            let next = (k + 1) % self.segments;
            let triangles = &mut self.mesh.triangles;
            match (*a, *b) {
                (Around(a), Around(b)) => push_quad(triangles, [a + k, b + k, b + next, a + next]),
                (Pole(a), Around(b)) => triangles.push([a, b + k, b + next]),
                (Tip(a), Around(b)) => triangles.push([a + k, b + k, b + next]),
                (Around(a), Pole(b)) => triangles.push([a + k, b, a + next]),
                (Around(a), Tip(b)) => triangles.push([a + k, b + k, a + next]),
                (Pole(_) | Tip(_), Pole(_) | Tip(_)) => {}
            }
        }
    }

    /// The texture coordinates of the triangles that [`Self::join`] has just made.
    fn add_uvs(&mut self, a: &Ring, b: &Ring, of_piece: OfPiece) {
        use Ring::Around;
        let segments = self.segments;
        for k in 0..segments {
            // Not wrapped around: the last sector ends a turn after the first began.
            let at = |end: usize, steps: f64| of_piece.at(end, f64::from(k) + steps, segments);
            let [a_here, a_next, b_here, b_next] = [at(0, 0.0), at(0, 1.0), at(1, 0.0), at(1, 1.0)];
            match (*a, *b) {
                (Around(_), Around(_)) => {
                    self.mesh.uvs.extend([[a_here, b_here, b_next], [a_here, b_next, a_next]]);
                }
                (_, Around(_)) => self.mesh.uvs.push([at(0, 0.5), b_here, b_next]),
                (Around(_), _) => self.mesh.uvs.push([a_here, at(1, 0.5), a_next]),
                _ => {}
            }
        }
    }
}
