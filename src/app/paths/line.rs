//! A path as straight legs in scene space.

use glam::DVec3;

use crate::geometry::Ray;
use crate::scene::{MediumId, ObjectId, Scene};
use crate::transport::inspect::{TracedPath, Vertex, VertexEvent};

/// Parts of a leg that are hidden or not, each by itself.
pub const PIECES: usize = 24;
/// Legs whose pieces are looked at one by one; later ones count as seen.
const MOST_LEGS: usize = 40;
/// Share of the distance by which something must be nearer than a place to hide it.
const NEARER: f64 = 1e-4;

/// One straight part of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Scene coordinates.
    pub from: DVec3,
    pub to: DVec3,
    /// What the path takes itself to be in.
    pub medium: MediumId,
    /// Product of Fresnel's shares and of the colours of mirrors before this leg, in [0, 1].
    pub share: f64,
    /// Product of the transmittances up to its start and up to its end: mean over the bands.
    pub light: [f64; 2],
    /// Bit k: something opaque stands between the camera and the middle of piece k.
    pub hidden: u32,
}

impl Leg {
    pub fn is_hidden(&self, piece: usize) -> bool {
        self.hidden & (1 << piece) != 0
    }

    /// A point of the leg; `part` in [0, 1].
    pub fn at(&self, part: f64) -> DVec3 {
        self.from.lerp(self.to, part)
    }
}

/// A path with its legs; leg k ends at vertex k, and one more leads out of the scene if the path does.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    pub path: TracedPath,
    pub legs: Vec<Leg>,
}

impl Line {
    /// Looks at what is hidden from `eye` (scene coordinates) if there is one.
    pub fn new(path: TracedPath, scene: &Scene, eye: Option<DVec3>) -> Self {
        let mut from = DVec3::from(path.origin);
        let (mut share, mut light) = (1.0, 1.0);
        let mut legs = Vec::with_capacity(path.vertices.len() + 1);
        for vertex in &path.vertices {
            let to = DVec3::from(vertex.position);
            let after = light * mean(vertex.transmittance);
            legs.push(Leg { from, to, medium: vertex.ids.medium, share, light: [light, after], hidden: 0 });
            from = to;
            light = after;
            share *= share_of(vertex);
        }
        if path.escaped {
            let reach = 2.0 * scene.geometry.bounding_sphere().map_or(1.0, |sphere| sphere.radius);
            let to = from + DVec3::from(path.final_direction) * reach;
            legs.push(Leg { from, to, medium: path.final_medium_id, share, light: [light; 2], hidden: 0 });
        }
        if let Some(eye) = eye {
            for leg in legs.iter_mut().take(MOST_LEGS) {
                for piece in 0..PIECES {
                    let middle = leg.at((piece as f64 + 0.5) / PIECES as f64);
                    leg.hidden |= u32::from(is_hidden(scene, eye, middle)) << piece;
                }
            }
        }
        Self { path, legs }
    }
}

/// Share of the light that goes on from a vertex in the way that the path does.
fn share_of(vertex: &Vertex) -> f64 {
    let Some(reflectance) = vertex.fresnel else { return 1.0 };
    match vertex.event {
        VertexEvent::Transmit => 1.0 - reflectance,
        VertexEvent::Reflect | VertexEvent::TotalReflection => reflectance,
        VertexEvent::Skip | VertexEvent::Scatter | VertexEvent::Emit => 1.0,
    }
}

fn mean(rgb: [f64; 3]) -> f64 {
    rgb.iter().sum::<f64>() / 3.0
}

/// Whether something opaque stands between two points. Refractors hide nothing: one looks through them.
fn is_hidden(scene: &Scene, eye: DVec3, place: DVec3) -> bool {
    let to = place - eye;
    let distance = to.length();
    if !(distance > 0.0 && distance.is_finite()) {
        return false;
    }
    let mut ray = Ray::new(eye - scene.geometry.origin, to / distance);
    while let Some(hit) = scene.geometry.closest(&ray).filter(|hit| hit.t < distance * (1.0 - NEARER)) {
        if !scene.is_refractor(ObjectId(scene.geometry.object_of(hit.primitive))) {
            return true;
        }
        ray = ray.beyond(&hit);
    }
    false
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::formats;
    use crate::tracking::{Mode, prepare};
    use crate::transport::inspect::{Follow, trace};

    /// A glass ball that absorbs, seen along z, and a screen behind it; what is behind the screen is hidden, what is in the ball is not.
    #[test]
    fn legs_carry_shares_and_light_and_know_what_hides_them() {
        let text = "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n\
            [[medium]]\nname = \"glass\"\nior = 1.5\nabsorption = [0.5, 0.5, 0.5]\n\
            [[refractor]]\nname = \"ball\"\nmedium = \"glass\"\nshape = { sphere = { center = [0, 0, 0], radius = 1 } }\n\
            [[solid]]\nname = \"screen\"\nshape = { box = { min = [-0.2, -5, 2], max = [5, 5, 2.1] } }\n";
        let description = formats::parse(text, Path::new("test.toml"), &formats::Disk).unwrap();
        let prepared = prepare(Arc::new(description), None).unwrap();
        // Along x through the ball's middle.
        let ray = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
        let path = trace(&prepared, Mode::Rectified, ray, Follow::Transmit, 0, None);
        let line = Line::new(path, &prepared.scene, Some(DVec3::new(0.0, 0.0, 9.0)));
        assert_eq!(line.legs.len(), 3);
        let [before, inside, behind] = &line.legs[..] else { unreachable!() };
        // 4 % are reflected at each surface, and 2 units of glass let exp(−1) through.
        assert_eq!((before.share, before.light), (1.0, [1.0, 1.0]));
        assert!((inside.share - 0.96).abs() < 1e-12 && (behind.share - 0.96 * 0.96).abs() < 1e-12);
        assert!((inside.light[1] - (-1.0_f64).exp()).abs() < 1e-12 && behind.light == [inside.light[1]; 2]);
        assert_eq!((before.medium, inside.medium), (MediumId::WORLD, MediumId(2)));
        // The screen's edge is seen at x = −0.2·9/7 in the ball's plane.
        let edge = -0.2 * 9.0 / 7.0;
        for leg in &line.legs {
            for piece in 0..PIECES {
                let x = leg.at((piece as f64 + 0.5) / PIECES as f64).x;
                let is_behind = x > edge && x < 5.0 * 9.0 / 7.0;
                assert_eq!(leg.is_hidden(piece), is_behind, "{x}");
            }
        }
    }
}
