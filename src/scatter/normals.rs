//! The two normals of a hit, and directions that are kept on their side of the face.
//!
//! About an interpolated normal a ray may be reflected into the solid or refracted out of it again. Such a direction is raised until it is just
//! above the face, which is what bending the normal as little as needed does (A. Keller et al., *The Iray Light Transport Simulation and
//! Rendering System*, 2017, on local shading coordinate frames). So it changes smoothly over the surface, and no light is lost.

use glam::DVec3;

/// Least cosine between a bent direction and the face's normal. Large enough for the ray to get away from the face, too small to be seen.
const LEAST_COSINE: f64 = 1e-3;

/// The normals of a hit, unit, on the side that the ray comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normals {
    /// The face's own normal, which says on which side a direction lies.
    pub face: DVec3,
    /// The interpolated normal; the face's where there is none. On the same side of the face, but it may look away from the ray.
    pub shading: DVec3,
}

impl Normals {
    /// Those of a face without interpolated normals.
    pub fn flat(face: DVec3) -> Self {
        Self { face, shading: face }
    }

    #[inline]
    pub fn is_flat(&self) -> bool {
        self.shading == self.face
    }

    /// Factor on importance that is scattered about an interpolated normal s at a face with normal g,
    /// |wo·s| |wi·g| / (|wo·g| |wi·s|), which makes scattering the adjoint of that of radiance (Veach 1997, section 5.3.2). 0 where it has no
    /// value: along the surface no light flows.
    #[inline]
    pub fn importance_factor(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.is_flat() {
            return 1.0;
        }
        let factor = (wo.dot(self.shading) * wi.dot(self.face) / (wo.dot(self.face) * wi.dot(self.shading))).abs();
        if factor.is_finite() { factor } else { 0.0 }
    }

    /// Keeps the mirrored ray of unit `direction` on the side that it came from.
    #[inline]
    pub fn keep_reflected(&self, direction: DVec3, reflected: DVec3) -> DVec3 {
        let height = reflected.dot(self.face);
        if height >= LEAST_COSINE {
            return reflected;
        }
        // Not above the face's own mirrored ray, so that grazing rays are not lifted off a surface whose two normals agree.
        let mirrored = (-direction.dot(self.face)).max(0.0);
        raised(reflected, self.face, height, LEAST_COSINE.min(0.9 * mirrored))
    }

    /// Keeps a transmitted ray on the other side. `cosine_through_face` gives the cosine, behind the face, of the ray refracted about the face's
    /// own normal, if it is.
    #[inline]
    pub fn keep_transmitted(&self, transmitted: DVec3, cosine_through_face: impl FnOnce() -> Option<f64>) -> DVec3 {
        let depth = -transmitted.dot(self.face);
        if depth >= LEAST_COSINE {
            return transmitted;
        }
        let least = cosine_through_face().map_or(LEAST_COSINE, |cosine| LEAST_COSINE.min(0.9 * cosine));
        raised(transmitted, -self.face, depth, least)
    }
}

/// Unit `direction`, whose cosine to unit `normal` is `height`, turned towards the normal until the cosine is `least`.
#[inline]
fn raised(direction: DVec3, normal: DVec3, height: f64, least: f64) -> DVec3 {
    if height >= least { direction } else { (direction + normal * (least - height)).normalize() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bent_directions_are_just_above_the_face_and_others_are_left_alone() {
        let d = DVec3::new(0.8, -0.6, 0.0);
        let normals = Normals { face: DVec3::Y, shading: DVec3::new(0.8, 0.6, 0.0) };
        let up = DVec3::new(0.6, 0.8, 0.0);
        assert_eq!(normals.keep_reflected(d, up), up);
        assert_eq!(normals.keep_transmitted(-up, || None), -up);
        for degrees in 0..=60 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let below = DVec3::new(cos, -sin, 0.0);
            let (reflected, transmitted) =
                (normals.keep_reflected(d, below), normals.keep_transmitted(DVec3::new(cos, sin, 0.0), || None));
            assert!(reflected.y > 0.0 && reflected.y < 3e-3 && (reflected.length() - 1.0).abs() < 1e-14, "{degrees}");
            assert!(transmitted.y < 0.0 && transmitted.y > -3e-3 && (transmitted.length() - 1.0).abs() < 1e-14);
        }
    }

    /// Where a grazing ray's two normals nearly agree, nothing is bent.
    #[test]
    fn grazing_rays_stay_grazing() {
        let d = DVec3::new(1.0, -1e-5, 0.0).normalize();
        let mirrored = DVec3::new(d.x, -d.y, 0.0);
        let normals = Normals { face: DVec3::Y, shading: DVec3::new(1e-7, 1.0, 0.0).normalize() };
        assert_eq!(normals.keep_reflected(d, mirrored), mirrored);
        assert_eq!(normals.keep_transmitted(d, || Some(1e-5)), d);
    }
}
