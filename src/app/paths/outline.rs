//! Objects as a few lines: silhouettes and sharp edges, seen from anywhere.

use std::collections::HashMap;

use glam::DVec3;

use crate::rectify::subjects::primitives_of;
use crate::scene::{ObjectId, Scene};

/// Triangles of an object up to which its edges are looked at; larger ones are told by their box.
const MOST_TRIANGLES: u32 = 60_000;
/// Triangles of all objects up to which edges are looked at.
const MOST_IN_ALL: u32 = 400_000;
/// Faces that meet at a larger angle than this have a sharp edge between them: its cosine.
const SHARP: f64 = 0.8;
/// Parts of a circle.
const CIRCLE: usize = 72;

/// A segment, in scene coordinates.
pub type Segment = [DVec3; 2];

/// What can be drawn of the objects of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outlines {
    pub objects: Vec<Outline>,
}

/// What can be drawn of one object.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// Edges with the normals of the faces on both sides; of a border the second is zero.
    Edges(Vec<Edge>),
    Box {
        min: DVec3,
        max: DVec3,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    pub ends: Segment,
    pub normals: [DVec3; 2],
}

impl Outlines {
    pub fn of(scene: &Scene) -> Self {
        let geometry = &*scene.geometry;
        let mut left = MOST_IN_ALL;
        let objects = (0..scene.objects.len() as u32).map(|object| {
            if let Some(sphere) = geometry.sphere_of(object) {
                return Outline::Ball { center: sphere.center + geometry.origin, radius: sphere.radius };
            }
            let count = geometry.face_count(object);
            if count > MOST_TRIANGLES.min(left) {
                let (min, max) = geometry.bounds_of(object);
                return Outline::Box { min: min + geometry.origin, max: max + geometry.origin };
            }
            left -= count;
            let triangles = primitives_of(geometry, ObjectId(object))
                .map(|face| geometry.corners(face).map(|p| p + geometry.origin));
            Outline::Edges(edges(triangles))
        });
        Self { objects: objects.collect() }
    }

    /// What is seen of the objects from `eye`.
    pub fn seen_from(&self, eye: DVec3) -> Vec<Segment> {
        self.objects.iter().flat_map(|object| object.seen_from(eye)).collect()
    }
}

impl Outline {
    fn seen_from(&self, eye: DVec3) -> Vec<Segment> {
        match self {
            Self::Ball { center, radius } => silhouette_of_ball(eye, *center, *radius),
            Self::Edges(edges) => edges.iter().filter(|edge| edge.is_seen_from(eye)).map(|edge| edge.ends).collect(),
            Self::Box { min, max } => edges_of_box(*min, *max),
        }
    }
}

impl Edge {
    /// Whether it is sharp, or a silhouette: one of its faces looks towards `eye` and the other does not.
    fn is_seen_from(&self, eye: DVec3) -> bool {
        let [a, b] = self.normals;
        let faces = |normal: DVec3| normal.dot(eye - self.ends[0]) > 0.0;
        b == DVec3::ZERO || a.dot(b) < SHARP || faces(a) != faces(b)
    }
}

/// The edges of triangles that share corners, bit for bit.
fn edges(triangles: impl Iterator<Item = [DVec3; 3]>) -> Vec<Edge> {
    let mut places: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    let mut edges: Vec<Edge> = Vec::new();
    for corners in triangles {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for k in 0..3 {
            let ends = [corners[k], corners[(k + 1) % 3]];
            let mut key = ends.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
            key.sort_unstable();
            match places.get(&key) {
                Some(&place) if edges[place].normals[1] == DVec3::ZERO => edges[place].normals[1] = normal,
                Some(_) => {}
                None => {
                    places.insert(key, edges.len());
                    edges.push(Edge { ends, normals: [normal, DVec3::ZERO] });
                }
            }
        }
    }
    edges
}

/// The circle in which rays from `eye` touch a ball; nothing from inside of it.
fn silhouette_of_ball(eye: DVec3, center: DVec3, radius: f64) -> Vec<Segment> {
    let to_eye = eye - center;
    let distance = to_eye.length();
    if distance <= radius {
        return Vec::new();
    }
    let axis = to_eye / distance;
    let along = radius * radius / distance;
    let across = (radius * radius - along * along).max(0.0).sqrt();
    let (u, v) = axis.any_orthonormal_pair();
    let point = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / CIRCLE as f64).sin_cos();
        center + axis * along + (u * cos + v * sin) * across
    };
    (0..CIRCLE).map(|k| [point(k), point(k + 1)]).collect()
}

fn edges_of_box(min: DVec3, max: DVec3) -> Vec<Segment> {
    let corner = |bits: usize| {
        let pick = |axis: usize| if bits & (1 << axis) == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let pairs = (0..8).flat_map(|from: usize| (0..3).map(move |axis| (from, from | (1 << axis))));
    pairs.filter(|(from, to)| from != to).map(|(from, to)| [corner(from), corner(to)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From outside every tangent point is as far from the centre as the radius, and the ray to it meets the radius at a right angle.
    #[test]
    fn a_ball_is_seen_as_the_circle_of_tangents() {
        let (eye, center, radius) = (DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.5, 0.0, 0.0), 0.8);
        let circle = silhouette_of_ball(eye, center, radius);
        assert_eq!(circle.len(), CIRCLE);
        for [p, _] in circle {
            assert!((p.distance(center) - radius).abs() < 1e-12);
            assert!((p - eye).dot(p - center).abs() < 1e-12);
        }
        assert!(silhouette_of_ball(center + DVec3::X * 0.5, center, radius).is_empty());
    }

    #[test]
    fn a_box_of_triangles_shows_its_twelve_edges_and_no_diagonal() {
        let [min, max] = [DVec3::ZERO, DVec3::ONE];
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let quad = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| [[a, b, c], [a, c, d]];
        let faces = [
            quad(p(0., 0., 0.), p(0., 1., 0.), p(1., 1., 0.), p(1., 0., 0.)),
            quad(p(0., 0., 1.), p(1., 0., 1.), p(1., 1., 1.), p(0., 1., 1.)),
            quad(p(0., 0., 0.), p(0., 0., 1.), p(0., 1., 1.), p(0., 1., 0.)),
            quad(p(1., 0., 0.), p(1., 1., 0.), p(1., 1., 1.), p(1., 0., 1.)),
            quad(p(0., 0., 0.), p(1., 0., 0.), p(1., 0., 1.), p(0., 0., 1.)),
            quad(p(0., 1., 0.), p(0., 1., 1.), p(1., 1., 1.), p(1., 1., 0.)),
        ];
        let all = Outline::Edges(edges(faces.into_iter().flatten()));
        let seen = all.seen_from(DVec3::new(5.0, 4.0, 3.0));
        assert_eq!(seen.len(), 12);
        for segment in &seen {
            assert_eq!((segment[1] - segment[0]).length(), 1.0);
        }
        assert_eq!(edges_of_box(min, max).len(), 12);
    }
}
