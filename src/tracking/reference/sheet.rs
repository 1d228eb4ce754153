//! What an open surface contains. It encloses nothing; all that can be said is on which side of it a point lies, as seen from there: rays in
//! all directions tell by the side from which they meet it first, unless something opaque is in the way, where the surface may end.

use glam::DVec3;

use super::winding::Winding;
use crate::geometry::Ray;
use crate::scene::{ObjectId, Scene};

/// Rays, evenly spread over the sphere.
const RAYS: u32 = 32;
/// Fewer votes than this share leave doubt.
const CLEAR_SHARE: f64 = 0.75;

/// Whether a sheet contains a point off it, and whether there is doubt.
pub(super) fn contains(scene: &Scene, sheet: &Winding, point: DVec3) -> (bool, bool) {
    let (mut inside, mut asked) = (0, 0);
    for direction in (0..RAYS).map(direction) {
        let Some((t, from_behind)) = sheet.first_met(point, direction) else { continue };
        let mut is_hidden = false;
        scene.geometry.for_each_hit(&Ray::new(point, direction), |hit| {
            let object = ObjectId(scene.geometry.object_of(hit.primitive));
            is_hidden |= hit.t < t && !scene.is_refractor(object);
        });
        if !is_hidden {
            asked += 1;
            inside += u32::from(from_behind);
        }
    }
    let is_inside = 2 * inside > asked;
    let majority = if is_inside { inside } else { asked - inside };
    (is_inside, f64::from(majority) < CLEAR_SHARE * f64::from(asked))
}

/// The k-th point of a spiral of Fibonacci: none of its directions lies in a plane that meshes have reason to be in.
fn direction(k: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(RAYS);
    let r = (1.0 - z * z).sqrt();
    let (sin, cos) = (2.399_963_229_728_653 * f64::from(k) + 0.3).sin_cos();
    // Turned, so that its axis is no axis of the scene.
    let (a, b, c) = (r * cos, r * sin, z);
    DVec3::new(0.36 * a + 0.48 * b - 0.8 * c, -0.8 * a + 0.6 * b, 0.48 * a + 0.64 * b + 0.6 * c)
}
