//! What lies along a straight line through convex bodies: each body is cut out of the line by its half-spaces. Knows nothing of trees,
//! triangles or containment, and so can judge them.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::Ray;
use crate::scene::description::Shape;

/// Surfaces nearer than this along a ray are one: vertices are stored in f32, so that faces of one plane lie this far apart at grazing
/// angles.
pub(super) const TOGETHER: f64 = 1e-5;
/// Stretches and misses shorter than this are too close to an edge to call.
const MARGIN: f64 = 1e-3;

/// A convex body as a shape, and as the points p with normal · p ≤ offset for all its sides.
#[derive(Debug, Clone)]
pub(super) struct Convex {
    pub shape: Shape,
    sides: Vec<(DVec3, f64)>,
    volume: f64,
}

impl Convex {
    pub fn cuboid(min: DVec3, max: DVec3) -> Self {
        let sides =
            (DVec3::AXES.into_iter()).flat_map(|axis| [(axis, axis.dot(max)), (-axis, -axis.dot(min))]).collect();
        Self { shape: Shape::Box { min, max }, sides, volume: (max - min).element_product() }
    }

    /// A prism over a regular polygon with its corners on the circle, the first towards +x.
    pub fn cylinder(center: DVec3, radius: f64, height: f64, segments: u32) -> Self {
        let angle = TAU / f64::from(segments);
        let mut sides: Vec<_> = (0..segments)
            .map(|k| {
                let (sin, cos) = (angle * (f64::from(k) + 0.5)).sin_cos();
                let normal = DVec3::new(cos, 0.0, sin);
                (normal, normal.dot(center) + radius * (angle / 2.0).cos())
            })
            .collect();
        sides.extend([DVec3::Y, -DVec3::Y].map(|n| (n, n.dot(center) + height / 2.0)));
        let volume = 0.5 * f64::from(segments) * radius * radius * angle.sin() * height;
        Self { shape: Shape::Cylinder { center, radius, height, segments }, sides, volume }
    }

    /// Where the line of `ray` is inside; `None` where it misses. Clipping by Cyrus and Beck 1978.
    fn stretch(&self, ray: &Ray) -> Option<[f64; 2]> {
        let mut stretch = [f64::NEG_INFINITY, f64::INFINITY];
        for (normal, offset) in &self.sides {
            let (speed, room) = (normal.dot(ray.direction), offset - normal.dot(ray.origin));
            if speed > 0.0 {
                stretch[1] = stretch[1].min(room / speed);
            } else if speed < 0.0 {
                stretch[0] = stretch[0].max(room / speed);
            } else if room < 0.0 {
                return None;
            }
        }
        (stretch[0] < stretch[1]).then_some(stretch)
    }

    fn grown(&self, distance: f64) -> Self {
        let sides = self.sides.iter().map(|(normal, offset)| (*normal, offset + distance)).collect();
        Self { sides, ..self.clone() }
    }
}

/// Names of the media along a ray from outside, each different from the one before, where body `k` is filled with `object k` and overlaps
/// are resolved as for equal priorities: the smaller volume wins, then the later. `None` where the ray passes so close to an edge that
/// rounding decides.
pub(super) fn media_along(bodies: &[Convex], ray: &Ray) -> Option<Vec<String>> {
    let mut ends = Vec::new();
    for body in bodies {
        let (inner, outer) = (body.grown(-MARGIN).stretch(ray), body.grown(MARGIN).stretch(ray));
        if inner.is_some() != outer.is_some() {
            return None;
        }
        ends.extend(body.stretch(ray).into_iter().flatten());
    }
    ends.sort_by(f64::total_cmp);
    let mut names = vec!["world".to_owned()];
    for pair in ends.windows(2) {
        let length = pair[1] - pair[0];
        if length <= TOGETHER / 10.0 {
            continue;
        }
        if length < MARGIN {
            return None;
        }
        let middle = ray.at(0.5 * (pair[0] + pair[1]));
        let is_inside = |body: &&Convex| body.sides.iter().all(|(normal, offset)| normal.dot(middle) <= *offset);
        let top = (bodies.iter().enumerate())
            .filter(|(_, body)| is_inside(body))
            .min_by(|(i, a), (j, b)| a.volume.total_cmp(&b.volume).then(j.cmp(i)));
        let name = top.map_or("world".to_owned(), |(k, _)| format!("object {k}"));
        if names.last() != Some(&name) {
            names.push(name);
        }
    }
    if names.last().is_some_and(|name| name != "world") {
        names.push("world".to_owned());
    }
    Some(names)
}
