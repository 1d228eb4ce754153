//! Moving the camera: orbit, pan, dolly. Pure functions from one camera to the next.

use glam::{DQuat, DVec2, DVec3};

use crate::scene::description::CameraDescription;

/// Turns per picture height of dragging.
const TURN_PER_HEIGHT: f64 = 0.5;
/// The camera keeps this angle from looking straight along `up`, in radians.
const POLE_MARGIN: f64 = 0.02;

/// Right and true up of a camera, or `None` if it has no direction.
fn frame(camera: &CameraDescription) -> Option<(DVec3, DVec3, DVec3)> {
    let forward = (camera.target - camera.position).try_normalize()?;
    let right = forward.cross(camera.up).try_normalize()?;
    Some((forward, right, right.cross(forward)))
}

/// Turns the camera around its target. `drag` is in picture heights, y down.
#[must_use]
pub fn orbit(camera: &CameraDescription, drag: DVec2) -> CameraDescription {
    let Some((forward, right, _)) = frame(camera) else { return *camera };
    let Some(up) = camera.up.try_normalize() else { return *camera };
    let angles = -drag * TURN_PER_HEIGHT * std::f64::consts::TAU;
    // The angle between the view and the pole decides how far the camera may still tilt.
    let to_pole = forward.angle_between(up);
    let tilt = angles.y.clamp(to_pole - std::f64::consts::PI + POLE_MARGIN, to_pole - POLE_MARGIN);
    let tilt = if to_pole > POLE_MARGIN && to_pole < std::f64::consts::PI - POLE_MARGIN { tilt } else { 0.0 };
    let rotation = DQuat::from_axis_angle(up, angles.x) * DQuat::from_axis_angle(right, tilt);
    CameraDescription { position: camera.target + rotation * (camera.position - camera.target), ..*camera }
}

/// Moves camera and target in the picture's plane, so that what is at the target's distance follows the pointer.
#[must_use]
pub fn pan(camera: &CameraDescription, drag: DVec2) -> CameraDescription {
    let Some((_, right, up)) = frame(camera) else { return *camera };
    let distance = camera.target.distance(camera.position);
    let height = 2.0 * distance * (camera.vertical_fov.to_radians() / 2.0).tan();
    let shift = (-right * drag.x + up * drag.y) * height;
    CameraDescription { position: camera.position + shift, target: camera.target + shift, ..*camera }
}

/// Moves the camera towards its target (`steps` > 0) or away. It may pass through anything; close to the target it pushes the target
/// ahead, so that it never gets stuck. `near` is the distance at which that begins.
#[must_use]
pub fn dolly(camera: &CameraDescription, steps: f64, near: f64) -> CameraDescription {
    let Some((forward, _, _)) = frame(camera) else { return *camera };
    let distance = camera.target.distance(camera.position);
    let wanted = distance * 0.9_f64.powf(steps);
    if wanted >= near || steps < 0.0 {
        CameraDescription { position: camera.target - forward * wanted.max(near.min(distance)), ..*camera }
    } else {
        let step = forward * (near * (1.0 - 0.9_f64.powf(steps)));
        CameraDescription { position: camera.position + step, target: camera.target + step, ..*camera }
    }
}

/// Looks in the same direction at a sphere of `radius` around `center` from so far that it takes about 70 % of the picture's shorter
/// side, whose half-angle has the tangent `tan_half`.
#[must_use]
pub fn framed(camera: &CameraDescription, center: DVec3, radius: f64, tan_half: f64) -> CameraDescription {
    const SHARE: f64 = 0.7;
    let Some((forward, _, _)) = frame(camera) else { return *camera };
    // A tangent cone of tan(half-angle) = SHARE × tan_half touches the sphere.
    let sine = SHARE * tan_half / (1.0 + (SHARE * tan_half).powi(2)).sqrt();
    let distance = radius / sine;
    if !(distance > 0.0 && distance.is_finite() && center.is_finite()) {
        return *camera;
    }
    // What was in focus was at the old distance.
    CameraDescription { position: center - forward * distance, target: center, focus_distance: None, ..*camera }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> CameraDescription {
        CameraDescription {
            position: DVec3::new(0.0, 0.0, 4.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 90.0,
            aperture_radius: 0.0,
            focus_distance: None,
        }
    }

    #[test]
    fn orbit_keeps_the_distance_and_stops_short_of_the_poles() {
        let mut c = camera();
        for _ in 0..100 {
            c = orbit(&c, DVec2::new(0.01, 0.05));
            assert!((c.position.distance(c.target) - 4.0).abs() < 1e-9);
            assert!((c.target - c.position).normalize().cross(DVec3::Y).length() > 0.01);
        }
        // Dragging down looks from above.
        assert!(c.position.y > 3.9);
    }

    #[test]
    fn dragging_right_moves_the_camera_left() {
        assert!(orbit(&camera(), DVec2::new(0.1, 0.0)).position.x < 0.0);
    }

    #[test]
    fn pan_by_one_height_moves_by_what_is_seen() {
        // At 90 degrees and distance 4 the picture is 8 high.
        let c = pan(&camera(), DVec2::new(0.0, 1.0));
        assert!((c.position.y - 8.0).abs() < 1e-12 && (c.target.y - 8.0).abs() < 1e-12);
    }

    #[test]
    fn dolly_passes_through_the_target() {
        let mut c = camera();
        for _ in 0..200 {
            c = dolly(&c, 1.0, 0.5);
        }
        assert!(c.position.z < -1.0 && c.target.z < c.position.z);
        assert!(dolly(&camera(), -1.0, 0.5).position.z > 4.0);
    }

    #[test]
    fn a_framed_sphere_takes_its_share_of_the_picture() {
        let center = DVec3::new(5.0, -2.0, 1.0);
        let c = framed(&camera(), center, 0.3, 1.0);
        assert_eq!((c.target, (c.target - c.position).normalize()), (center, -DVec3::Z));
        // The outline's angle: its sine is radius over distance.
        let outline = (0.3 / c.position.distance(center)).asin().tan();
        assert!((outline - 0.7).abs() < 1e-12);
        assert_eq!(framed(&camera(), center, 0.0, 1.0), camera());
    }

    #[test]
    fn a_camera_without_direction_stays() {
        let c = CameraDescription { target: DVec3::new(0.0, 0.0, 4.0), ..camera() };
        assert_eq!(orbit(&c, DVec2::ONE), c);
        assert_eq!(pan(&c, DVec2::ONE), c);
        assert_eq!(dolly(&c, 1.0, 0.1), c);
    }
}
