//! A perfect mirror.

use glam::DVec3;

use super::normals::Normals;
use crate::optics::fresnel::reflected;
use crate::spectrum::Spectrum;

/// A mirror that tints what it reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    pub albedo: Spectrum,
}

/// Unit direction of the ray that a mirror sends back, above the face. Where the interpolated normal looks away, as at a silhouette, the ray
/// grazes the mirror.
#[inline]
pub fn reflect(direction: DVec3, normals: &Normals) -> DVec3 {
    let cosine = (-direction.dot(normals.shading)).clamp(0.0, 1.0);
    let mirrored = reflected(direction, normals.shading, cosine);
    if normals.is_flat() { mirrored } else { normals.keep_reflected(direction, mirrored) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_normal_sends_a_ray_into_the_mirror() {
        for (degrees_in, degrees_tilt) in (1..180).flat_map(|i| (-89..90).map(move |t| (f64::from(i), f64::from(t)))) {
            let (sin, cos) = degrees_in.to_radians().sin_cos();
            let (x, y) = degrees_tilt.to_radians().sin_cos();
            let direction = DVec3::new(cos, -sin, 0.0);
            let r = reflect(direction, &Normals { face: DVec3::Y, shading: DVec3::new(x, y, 0.0) });
            assert!(r.y > 0.0 && (r.length() - 1.0).abs() < 1e-14, "{degrees_in} {degrees_tilt}: {r}");
        }
        let d = DVec3::new(0.6, -0.8, 0.0);
        assert!((reflect(d, &Normals::flat(DVec3::Y)) - DVec3::new(0.6, 0.8, 0.0)).length() < 1e-15);
    }
}
