//! Rays against analytic spheres, in f64.

use glam::DVec3;

use super::ray::Ray;

/// A sphere, outward-facing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub center: DVec3,
    /// > 0.
    pub radius: f64,
}

impl Sphere {
    /// Distances at which the ray's line enters and leaves, in this order. With `starts_here` the ray's origin lies on this sphere:
    /// one of the two is then the origin itself, known exactly and not reported, and there is no epsilon to choose.
    #[inline]
    pub fn intersect(&self, ray: &Ray, starts_here: bool) -> [Option<f64>; 2] {
        let from_center = ray.origin - self.center;
        let b = from_center.dot(ray.direction);
        if starts_here {
            return [None, (b < 0.0).then_some(-2.0 * b)];
        }
        // Discriminant from the line's distance to the centre (Haines et al., Ray Tracing Gems, chapter 7): b² − c would cancel for
        // small or far spheres.
        let distance = (from_center - ray.direction * b).length();
        let discriminant = (self.radius - distance) * (self.radius + distance);
        if discriminant < 0.0 {
            return [None, None];
        }
        let root = discriminant.sqrt();
        let from_center_length = from_center.length();
        let c = (from_center_length - self.radius) * (from_center_length + self.radius);
        // The root that does not cancel, then the other from the product of both.
        if b > 0.0 {
            let enter = -b - root;
            [Some(enter), Some(c / enter)]
        } else {
            let leave = -b + root;
            // A zero denominator needs b = root = 0: the line touches where the ray starts.
            let enter = if leave == 0.0 { 0.0 } else { c / leave };
            [Some(enter), Some(leave)]
        }
    }

    /// The point of the sphere nearest to `point`.
    #[inline]
    pub fn project(&self, point: DVec3) -> DVec3 {
        let from_center = point - self.center;
        let length = from_center.length();
        // Rounding of a hit seen from far away can put it at the centre of a small sphere, which is as near to one point as to another.
        if length == 0.0 {
            return self.center + DVec3::Y * self.radius;
        }
        self.center + from_center * (self.radius / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_small_sphere_keeps_its_digits() {
        let sphere = Sphere { center: DVec3::new(1e6, 0.0, 0.0), radius: 1e-3 };
        let [enter, leave] = sphere.intersect(&Ray::new(DVec3::ZERO, DVec3::X), false);
        assert!((enter.unwrap() - (1e6 - 1e-3)).abs() < 1e-9 && (leave.unwrap() - (1e6 + 1e-3)).abs() < 1e-9);
    }

    #[test]
    fn a_ray_that_leaves_the_sphere_itself_meets_only_the_far_side() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let inward = sphere.intersect(&Ray::new(DVec3::X, DVec3::NEG_X), true);
        assert_eq!(inward, [None, Some(2.0)]);
        assert_eq!(sphere.intersect(&Ray::new(DVec3::X, DVec3::X), true), [None, None]);
    }

    #[test]
    fn from_the_centre_any_point_is_the_nearest() {
        let sphere = Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius: 0.25 };
        let point = sphere.project(sphere.center);
        assert_eq!((point - sphere.center).length(), 0.25);
        assert_eq!(sphere.project(DVec3::new(1.0, 2.0, 7.0)), DVec3::new(1.0, 2.0, 3.25));
    }

    #[test]
    fn from_inside_the_entry_lies_behind() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 2.0 };
        let [enter, leave] = sphere.intersect(&Ray::new(DVec3::new(0.5, 0.0, 0.0), DVec3::X), false);
        assert_eq!((enter, leave), (Some(-2.5), Some(1.5)));
    }
}
