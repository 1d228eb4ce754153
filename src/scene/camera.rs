//! The camera, ready to make rays.

use std::f64::consts::{FRAC_PI_4, PI};

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

    /// Where on an image of `size` pixels the ray from `origin`, on the lens, along unit `direction` is seen: the inverse of [`Self::ray`]. `None`
    /// beside the image and behind the camera.
    pub fn pixel(&self, origin: DVec3, direction: DVec3, size: DVec2) -> Option<DVec2> {
        let cosine = direction.dot(self.forward);
        if cosine <= 0.0 {
            return None;
        }
        // All rays of a pixel meet in the plane in focus.
        let in_focus = origin - self.position + direction * (self.focus_distance / cosine);
        let per_unit = size.y / (2.0 * self.tan_half_fov * self.focus_distance);
        let pixel = DVec2::new(
            0.5 * size.x + in_focus.dot(self.right) * per_unit,
            0.5 * size.y - in_focus.dot(self.up) * per_unit,
        );
        (pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(size).all()).then_some(pixel)
    }

    /// Densities of the rays of an image of `size` pixels: of starts, per area of the lens, and of unit `direction`, per steradian. The density of
    /// starts of a pinhole is 1: it has one.
    pub fn pdf_ray(&self, direction: DVec3, size: DVec2) -> [f64; 2] {
        let cosine = direction.dot(self.forward);
        let area_at_distance_1 = 4.0 * self.tan_half_fov * self.tan_half_fov * size.x / size.y;
        [1.0 / self.lens_area(), 1.0 / (area_at_distance_1 * cosine * cosine * cosine)]
    }

    /// Importance of a ray that is seen on an image of `size` pixels: what the mean over all pixels gains from radiance along it, per area of
    /// the lens, steradian and cosine (Veach 1997, section 4.6). Its integral over all that is seen is 1.
    pub fn importance(&self, direction: DVec3, size: DVec2) -> f64 {
        let [starts, directions] = self.pdf_ray(direction, size);
        starts * directions / direction.dot(self.forward)
    }

    /// Where a point is seen from the point of the lens at `lens` (in the unit disc); `None` where it is not, whatever lies between.
    pub fn sample_direct(&self, from: DVec3, size: DVec2, lens: DVec2) -> Option<CameraSample> {
        let origin = self.position + (self.right * lens.x + self.up * lens.y) * self.aperture_radius;
        let from_lens = from - origin;
        let distance = from_lens.length();
        let direction = from_lens.try_normalize()?;
        let pixel = self.pixel(origin, direction, size)?;
        let cosine = direction.dot(self.forward);
        Some(CameraSample {
            origin,
            direction: -direction,
            distance,
            pixel,
            importance: self.importance(direction, size),
            pdf: distance * distance / (cosine * self.lens_area()),
        })
    }

    /// A point of the unit disc, uniform by area (Shirley and Chiu 1997), for `u` uniform in [0, 1)², which a pinhole does not ask for.
    #[inline]
    pub fn lens_point(&self, u: impl FnOnce() -> [f64; 2]) -> DVec2 {
        if self.aperture_radius == 0.0 {
            return DVec2::ZERO;
        }
        let u = DVec2::from(u()) * 2.0 - 1.0;
        if u == DVec2::ZERO {
            return u;
        }
        let (r, angle) = if u.x.abs() > u.y.abs() {
            (u.x, FRAC_PI_4 * u.y / u.x)
        } else {
            (u.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * u.x / u.y)
        };
        DVec2::from_angle(angle) * r
    }

    /// Of a pinhole 1.
    fn lens_area(&self) -> f64 {
        if self.aperture_radius == 0.0 { 1.0 } else { PI * self.aperture_radius * self.aperture_radius }
    }
}

/// A connection from a point to the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSample {
    /// On the lens.
    pub origin: DVec3,
    /// Unit, from the point to `origin`.
    pub direction: DVec3,
    pub distance: f64,
    /// Where on the image the point is seen.
    pub pixel: DVec2,
    pub importance: f64,
    /// Per steradian at the point, if `lens` is uniform over the disc.
    pub pdf: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DVec2 = DVec2::new(96.0, 54.0);

    fn camera(aperture_radius: f64) -> Camera {
        Camera::new(&CameraDescription {
            position: DVec3::new(1.0, 2.0, 3.0),
            target: DVec3::new(0.0, 0.5, -1.0),
            up: DVec3::Y,
            vertical_fov: 50.0,
            aperture_radius,
            focus_distance: Some(2.5),
        })
        .unwrap()
    }

    /// Numbers that look random, in [0, 1)⁴.
    fn numbers(index: u32) -> [f64; 4] {
        [0.856_674_883_9, 0.733_891_856_6, 0.628_706_721_3, 0.538_597_239_5]
            .map(|step| (f64::from(index) * step + 0.5).fract())
    }

    fn disc(u: f64, v: f64) -> DVec2 {
        DVec2::from_angle(v * 2.0 * PI) * u.sqrt()
    }

    #[test]
    fn a_ray_is_seen_in_the_pixel_that_it_came_from() {
        for camera in [camera(0.0), camera(0.2)] {
            for index in 0..1000 {
                let [x, y, u, v] = numbers(index);
                let at = DVec2::new(x, y) * SIZE;
                let ray = camera.ray(at, SIZE, disc(u, v));
                assert!((camera.pixel(ray.origin, ray.direction, SIZE).unwrap() - at).length() < 1e-9);
                // And so is any point along it.
                let sample = camera.sample_direct(ray.at(7.0 * u + 0.1), SIZE, disc(u, v)).unwrap();
                assert!((sample.pixel - at).length() < 1e-9 && (sample.direction + ray.direction).length() < 1e-12);
            }
        }
        let camera = camera(0.0);
        assert_eq!(camera.pixel(camera.position, -camera.forward, SIZE), None);
        assert_eq!(camera.pixel(camera.position, camera.up, SIZE), None);
    }

    /// Over all directions and the whole lens the importance times cosine integrates to 1, and so does the density of rays.
    #[test]
    fn importance_is_that_of_one_image() {
        for camera in [camera(0.0), camera(0.2)] {
            let count = 400_000;
            let (mut importance, mut density) = (0.0, 0.0);
            for index in 0..count {
                let [x, y, u, v] = numbers(index);
                // Uniform directions in the hemisphere in front.
                let (z, r) = (x, (1.0 - x * x).sqrt());
                let turned = DVec2::from_angle(y * 2.0 * PI) * r;
                let direction = camera.forward * z + camera.right * turned.x + camera.up * turned.y;
                let lens = disc(u, v);
                let origin = camera.position + (camera.right * lens.x + camera.up * lens.y) * camera.aperture_radius;
                if camera.pixel(origin, direction, SIZE).is_some() {
                    let per_sample = 2.0 * PI * camera.lens_area() / f64::from(count);
                    importance += camera.importance(direction, SIZE) * z * per_sample;
                    let [starts, directions] = camera.pdf_ray(direction, SIZE);
                    density += starts * directions * per_sample;
                }
            }
            assert!((importance - 1.0).abs() < 5e-3 && (density - 1.0).abs() < 5e-3, "{importance} {density}");
        }
    }

    /// A small bright disc that faces the camera: its light reaches the image as much whether rays are traced from the camera or points of
    /// the disc are connected with the lens.
    #[test]
    fn both_ways_of_seeing_a_point_agree() {
        for camera in [camera(0.0), camera(0.2)] {
            let (center, radius, count) = (camera.position + camera.forward * 4.0 + camera.right * 0.3, 1.4, 200_000);
            let (mut traced, mut connected) = (0.0, 0.0);
            for index in 0..count {
                let [x, y, u, v] = numbers(index);
                let ray = camera.ray(DVec2::new(x, y) * SIZE, SIZE, disc(u, v));
                let t = (center - ray.origin).dot(camera.forward) / ray.direction.dot(camera.forward);
                traced += f64::from(u8::from((ray.at(t) - center).length() < radius)) / f64::from(count);
                let place = disc(x, y) * radius;
                let point = center + camera.right * place.x + camera.up * place.y;
                if let Some(sample) = camera.sample_direct(point, SIZE, disc(u, v)) {
                    let (at_point, at_lens) =
                        (-sample.direction.dot(camera.forward), -sample.direction.dot(camera.forward));
                    let geometry = at_point * at_lens / (sample.distance * sample.distance);
                    let areas = PI * radius * radius * camera.lens_area();
                    connected += sample.importance * geometry * areas / f64::from(count);
                    let by_angle = sample.importance * at_point * PI * radius * radius / sample.pdf;
                    assert!((by_angle / (sample.importance * geometry * areas) - 1.0).abs() < 1e-9);
                }
            }
            // Random numbers would leave 0.4 % between them.
            assert!((traced / connected - 1.0).abs() < 1e-2, "{traced} {connected}");
        }
    }
}
