//! A smooth interface between two dielectrics.

use glam::DVec3;

use crate::optics::Interface;
use crate::optics::fresnel::{Refraction, reflected};

/// Which way to go on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Choice {
    /// By comparing the reflectance with a uniform random number in [0, 1).
    Sample(f64),
    /// Through, except where reflection is total.
    Transmit,
    Reflect,
}

/// How a ray goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattered {
    /// Unit.
    pub direction: DVec3,
    /// 1 where reflection is total.
    pub reflectance: f64,
    pub is_transmitted: bool,
    pub is_total: bool,
}

/// Scatters unit `direction` at an interface that bends light. `normal` is the unit geometric normal and `shading_normal` the
/// interpolated one, both facing the side that the ray comes from.
///
/// An interpolated normal never flips an interface: where it would send the ray to the wrong geometric side, the event is done again
/// with the geometric normal.
#[inline]
pub fn scatter(
    interface: &Interface,
    direction: DVec3,
    normal: DVec3,
    shading_normal: DVec3,
    choice: Choice,
) -> Scattered {
    if shading_normal != normal && direction.dot(shading_normal) < 0.0 {
        let scattered = scatter_about(interface, direction, shading_normal, choice);
        if (scattered.direction.dot(normal) < 0.0) == scattered.is_transmitted {
            return scattered;
        }
    }
    scatter_about(interface, direction, normal, choice)
}

#[inline]
fn scatter_about(interface: &Interface, direction: DVec3, normal: DVec3, choice: Choice) -> Scattered {
    // The facing is known from the hit; at grazing angles rounding may leave the cosine a hair below zero.
    let c = (-direction.dot(normal)).clamp(0.0, 1.0);
    let reflect = |reflectance, is_total| Scattered {
        direction: reflected(direction, normal, c),
        reflectance,
        is_transmitted: false,
        is_total,
    };
    match interface.refraction(c) {
        Refraction::TotalReflection => reflect(1.0, true),
        Refraction::Partial { reflectance, b } => {
            let is_reflected = match choice {
                Choice::Sample(u) => u < reflectance,
                Choice::Transmit => false,
                Choice::Reflect => true,
            };
            if is_reflected {
                return reflect(reflectance, false);
            }
            let direction = interface.transmitted(direction, normal, c, b);
            Scattered { direction, reflectance, is_transmitted: true, is_total: false }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snell_at_45_degrees_into_glass() {
        let interface = Interface::new(0.0, 0.5);
        let d = DVec3::new(1.0, -1.0, 0.0).normalize();
        let s = scatter(&interface, d, DVec3::Y, DVec3::Y, Choice::Transmit);
        assert!(s.is_transmitted && (s.direction.x - d.x / 1.5).abs() < 1e-15);
        assert!((s.direction.length() - 1.0).abs() < 1e-15);
    }

    /// A shading normal tilted away so far that the refracted ray would stay outside.
    #[test]
    fn interpolated_normals_never_flip_an_interface() {
        let interface = Interface::new(0.0, 0.5);
        let d = DVec3::new(1.0, -0.02, 0.0).normalize();
        for degrees in -80..=80 {
            let tilt = f64::from(degrees).to_radians();
            let shading = DVec3::new(tilt.sin(), tilt.cos(), 0.0);
            for choice in [Choice::Transmit, Choice::Reflect] {
                let s = scatter(&interface, d, DVec3::Y, shading, choice);
                assert_eq!(s.direction.y < 0.0, s.is_transmitted, "tilt {degrees}");
            }
        }
    }
}
