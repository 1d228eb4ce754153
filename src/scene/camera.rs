//! The camera, ready to make rays.

use glam::{DVec2, DVec3};

use super::description::CameraDescription;
use super::error::SceneError;
use super::shapes::{MAX_LENGTH, MIN_LENGTH};
use crate::geometry::Ray;

/// A thin-lens camera with its frame worked out. Right-handed: image right = forward × up; pixel (0, 0) is top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    pub position: DVec3,
    pub forward: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    /// tan of half the vertical field of view.
    pub tan_half_fov: f64,
    pub aperture_radius: f64,
    pub focus_distance: f64,
}

impl Camera {
    /// # Errors
    /// When the camera has no direction, `up` lies along the view, or a number is not finite or out of range.
    pub fn new(d: &CameraDescription) -> Result<Self, SceneError> {
        let all_finite = d.position.is_finite() && d.target.is_finite() && d.up.is_finite();
        if !all_finite {
            return Err(SceneError::new("camera: position, target and up must be finite numbers"));
        }
        for (key, point) in [("position", d.position), ("target", d.target)] {
            if point.abs().max_element() > MAX_LENGTH {
                let at = point.to_array();
                return Err(SceneError::new(format!("camera: {key} is {at:?}, must be within {MAX_LENGTH:e}")));
            }
        }
        let to_target = d.target - d.position;
        let forward = to_target.try_normalize().ok_or_else(|| {
            SceneError::new("camera: `position` and `target` are the same point, so it has no direction; move one")
        })?;
        let right = forward
            .cross(d.up.normalize_or_zero())
            .try_normalize()
            .filter(|_| forward.cross(d.up.normalize_or_zero()).length() > 1e-9)
            .ok_or_else(|| SceneError::new("camera: `up` is zero or points along the view; choose another"))?;
        if !(d.vertical_fov > 0.0 && d.vertical_fov < 180.0) {
            return Err(SceneError::new(format!(
                "camera: vertical_fov is {}, must be between 0 and 180 degrees",
                d.vertical_fov
            )));
        }
        if !(d.aperture_radius >= 0.0 && d.aperture_radius <= MAX_LENGTH) {
            return Err(SceneError::new(format!(
                "camera: aperture_radius is {}, must be 0 or more, and at most {MAX_LENGTH:e}",
                d.aperture_radius
            )));
        }
        let focus_distance = d.focus_distance.unwrap_or(to_target.length());
        if !(MIN_LENGTH..=4.0 * MAX_LENGTH).contains(&focus_distance) {
            return Err(SceneError::new(format!(
                "camera: focus_distance is {focus_distance:e}, must be from {MIN_LENGTH:e} to {:e}",
                4.0 * MAX_LENGTH
            )));
        }
        Ok(Self {
            position: d.position,
            forward,
            right,
            up: right.cross(forward),
            tan_half_fov: (d.vertical_fov.to_radians() / 2.0).tan(),
            aperture_radius: d.aperture_radius,
            focus_distance,
        })
    }

    /// The ray through `pixel` (continuous, in [0, width) × [0, height), y down) of an image of `size` pixels, from the point of
    /// the lens at `lens` (in the unit disc).
    #[inline]
    pub fn ray(&self, pixel: DVec2, size: DVec2, lens: DVec2) -> Ray {
        let scale = 2.0 * self.tan_half_fov / size.y;
        let x = (pixel.x - 0.5 * size.x) * scale;
        let y = (0.5 * size.y - pixel.y) * scale;
        let through = self.forward + self.right * x + self.up * y;
        if self.aperture_radius == 0.0 {
            return Ray::new(self.position, through.normalize());
        }
        let offset = (self.right * lens.x + self.up * lens.y) * self.aperture_radius;
        Ray::new(self.position + offset, (through * self.focus_distance - offset).normalize())
    }
}
