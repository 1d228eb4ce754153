//! A smooth interface between two dielectrics.

use glam::DVec3;

use super::normals::Normals;
use crate::optics::Interface;
use crate::optics::fresnel::{Refraction, reflected};

/// The interface, seen along the ray that meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    pub interface: Interface,
    /// Number of the path's segment that ends here, from 1: see [`scatter`].
    pub segment: u32,
}

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

/// Segments of a path for which the interpolated normal alone says where reflection is total.
///
/// Reflection about interpolated normals does not keep the volume of the rays' phase space as reflection at real faces does: it has attractors,
/// paths that are reflected totally for ever. So on a path that is longer than this, at a hit where the interpolated normal lets nothing
/// through, the face's own normal decides. Before, the borders of total reflection are as smooth as the normals.
const TRUSTED_SEGMENTS: u32 = 16;

/// Scatters unit `direction` at an interface that bends light, where a path's `segment` ends (counted from 1).
///
/// How much is reflected is asked of the interpolated normal, which never flips an interface: what it would send to the wrong side of the face is
/// bent back. Where it looks away from the ray, as at the silhouettes of coarse meshes, the ray grazes the surface and all is reflected.
#[inline]
pub fn scatter(interface: &Interface, direction: DVec3, normals: &Normals, segment: u32, choice: Choice) -> Scattered {
    // The facing is known from the hit; at grazing angles rounding may leave the cosine a hair below zero.
    let c = (-direction.dot(normals.face)).clamp(0.0, 1.0);
    if normals.is_flat() {
        return scatter_about(interface, direction, normals.face, c, interface.refraction(c), choice);
    }
    let shading_c = -direction.dot(normals.shading);
    let refraction =
        if shading_c > 0.0 { interface.refraction(shading_c.min(1.0)) } else { Refraction::TotalReflection };
    if segment > TRUSTED_SEGMENTS && refraction == Refraction::TotalReflection {
        return scatter_about(interface, direction, normals.face, c, interface.refraction(c), choice);
    }
    let scattered = scatter_about(interface, direction, normals.shading, shading_c.clamp(0.0, 1.0), refraction, choice);
    let direction = if scattered.is_transmitted {
        normals.keep_transmitted(scattered.direction, || interface.cosine_behind(c))
    } else {
        normals.keep_reflected(direction, scattered.direction)
    };
    Scattered { direction, ..scattered }
}

/// Scatters `direction`, at cosine `c` to `normal`, given what the interface does there.
#[inline]
fn scatter_about(
    interface: &Interface,
    direction: DVec3,
    normal: DVec3,
    c: f64,
    refraction: Refraction,
    choice: Choice,
) -> Scattered {
    let reflect = |reflectance, is_total| Scattered {
        direction: reflected(direction, normal, c),
        reflectance,
        is_transmitted: false,
        is_total,
    };
    match refraction {
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
        let s = scatter(&interface, d, &Normals::flat(DVec3::Y), 1, Choice::Transmit);
        assert!(s.is_transmitted && (s.direction.x - d.x / 1.5).abs() < 1e-15);
        assert!((s.direction.length() - 1.0).abs() < 1e-15);
    }

    fn at_degrees(degrees: f64) -> DVec3 {
        let (x, y) = degrees.to_radians().sin_cos();
        DVec3::new(x, y, 0.0)
    }

    /// Both ways through the interface, at every angle, about every normal that is on the right side of the face.
    #[test]
    fn interpolated_normals_never_flip_an_interface() {
        for (interface, segment) in [(0.0, 0.5), (0.5, 0.0), (0.333, 0.5), (1.4, 0.0)]
            .into_iter()
            .flat_map(|(from, to)| [1, TRUSTED_SEGMENTS + 1].map(|segment| (Interface::new(from, to), segment)))
        {
            for (incidence, tilt) in (-89..=89).flat_map(|i| (-89..=89).map(move |t| (f64::from(i), f64::from(t)))) {
                let d = -at_degrees(incidence);
                let normals = Normals { face: DVec3::Y, shading: at_degrees(tilt) };
                let [through, back] =
                    [Choice::Transmit, Choice::Reflect].map(|choice| scatter(&interface, d, &normals, segment, choice));
                for s in [through, back] {
                    assert_eq!(s.direction.y < 0.0, s.is_transmitted, "incidence {incidence} tilt {tilt}: {s:?}");
                    assert!((s.direction.length() - 1.0).abs() < 1e-12, "incidence {incidence} tilt {tilt}: {s:?}");
                }
                // Shares of one whole, or a path could not be split here.
                assert_eq!(through.reflectance, back.reflectance);
                assert!(!back.is_transmitted && through.is_transmitted != through.is_total);
            }
        }
    }

    /// At a silhouette the ray grazes; on a path that has been caught, the face decides.
    #[test]
    fn a_normal_that_looks_away_reflects_all_but_does_not_catch_a_path() {
        let interface = Interface::new(0.0, 0.5);
        let d = -at_degrees(80.0);
        let normals = Normals { face: DVec3::Y, shading: at_degrees(-20.0) };
        assert!(scatter(&interface, d, &normals, TRUSTED_SEGMENTS, Choice::Transmit).is_total);
        let late = scatter(&interface, d, &normals, TRUSTED_SEGMENTS + 1, Choice::Transmit);
        assert_eq!(late, scatter(&interface, d, &Normals::flat(DVec3::Y), 1, Choice::Transmit));
    }

    /// With an interpolated normal next to the face's own, all is as with the face's.
    #[test]
    fn nearly_equal_normals_scatter_alike() {
        let tilt = 1e-9f64;
        for (interface, incidence) in [Interface::new(0.0, 0.5), Interface::new(0.5, 0.0)]
            .into_iter()
            .flat_map(|interface| (0..900).map(move |i| (interface, f64::from(i) / 10.0)))
        {
            let d = -at_degrees(incidence);
            let normals = Normals { face: DVec3::Y, shading: DVec3::new(tilt, 1.0, 0.0) };
            for choice in [Choice::Transmit, Choice::Reflect] {
                let (a, b) = (
                    scatter(&interface, d, &normals, 1, choice),
                    scatter(&interface, d, &Normals::flat(DVec3::Y), 1, choice),
                );
                assert!((a.direction - b.direction).length() < 1e-6, "{incidence}: {a:?} {b:?}");
            }
        }
    }
}
