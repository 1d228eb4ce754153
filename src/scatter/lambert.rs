//! Lambertian reflection about an interpolated normal.
//!
//! Half of the cosine lobe about the interpolated normal s would not be above the face, whose normal is g, and its light would be lost in the
//! solid. So the lobe is cut off there and raised by what is cut off: seen along s, the rest of the hemisphere is half a disc and half an
//! ellipse, whose area is (1 + s·g)/2 of the disc's. Its points are sampled as those of microfacets' visible normals are (Heitz 2018,
//! *Sampling the GGX Distribution of Visible Normals*, section 3). With s = g this is Lambert's law.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::frame;
use super::normals::Normals;
use crate::spectrum::Spectrum;

/// Normals that agree as well as this span no plane that rounding leaves alone; nothing worth counting is cut off.
const LEAST_TILT: f64 = 1e-12;

/// A white or coloured surface that looks equally bright from everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambert {
    pub albedo: Spectrum,
}

impl Lambert {
    /// Reflectance function times |cos| of `wi`: the albedo times [`pdf`].
    #[inline]
    pub fn evaluate(&self, normals: &Normals, wi: DVec3) -> Spectrum {
        self.albedo * pdf(normals, wi)
    }
}

/// A direction above the face, for `u` uniform in [0, 1)², and its probability per steradian.
#[inline]
pub fn sample(normals: &Normals, u: [f64; 2]) -> (DVec3, f64) {
    let Normals { face, shading } = *normals;
    let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
    let r = u[0].sqrt();
    let (across, along) = (r * cos_phi, r * sin_phi);
    let share = share_above(normals);
    if 1.0 - share < LEAST_TILT {
        let (tangent, bitangent) = frame(shading);
        let cosine = (1.0 - u[0]).max(0.0).sqrt();
        let direction = (tangent * across + bitangent * along + shading * cosine).normalize();
        return (direction, cosine / PI);
    }
    // The face's horizon crosses the disc along `axis`; on the side of `towards` nothing is cut off.
    let axis = face.cross(shading).normalize();
    let towards = shading.cross(axis);
    let reach = (1.0 - across * across).max(0.0).sqrt();
    let along = (1.0 - share) * reach + share * along;
    let cosine = (1.0 - across * across - along * along).max(0.0).sqrt();
    let direction = (axis * across + towards * along + shading * cosine).normalize();
    (direction, cosine / (PI * share))
}

/// Probability per steradian of unit `direction`, which is also the reflectance function times cosine of a white surface: its integral is 1.
#[inline]
pub fn pdf(normals: &Normals, direction: DVec3) -> f64 {
    if direction.dot(normals.face) <= 0.0 {
        return 0.0;
    }
    direction.dot(normals.shading).max(0.0) / (PI * share_above(normals))
}

/// Share of the cosine lobe about the interpolated normal that is above the face, in (½, 1].
#[inline]
fn share_above(normals: &Normals) -> f64 {
    if normals.is_flat() { 1.0 } else { 0.5 * (1.0 + normals.shading.dot(normals.face)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(degrees: f64) -> Normals {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Normals { face: DVec3::new(sin, 0.6 * cos, 0.8 * cos), shading: DVec3::new(0.0, 0.6, 0.8) }
    }

    /// Points of a grid in the unit square.
    fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
        (0..n * n).map(move |i| [f64::from(i / n) + 0.5, f64::from(i % n) + 0.5].map(|x| x / f64::from(n)))
    }

    #[test]
    fn nothing_goes_below_the_face_and_the_density_is_the_one_that_is_told() {
        for degrees in [0.0, 1e-7, 1.0, 18.0, 60.0, 89.0] {
            let normals = tilted(degrees);
            for u in grid(64) {
                let (direction, density) = sample(&normals, u);
                assert!(direction.dot(normals.face) > 0.0, "{degrees}");
                let told = pdf(&normals, direction);
                assert!((density - told).abs() < 1e-9, "{degrees}: {density} {told}");
            }
        }
    }

    /// The density integrates to 1, and moments of the samples are those of the density.
    #[test]
    fn no_light_is_lost_or_made() {
        for degrees in [0.0, 18.0, 60.0, 89.0] {
            let normals = tilted(degrees);
            let (mut total, mut mean) = (0.0, DVec3::ZERO);
            let n = 1000;
            for u in grid(n) {
                let (z, (sin, cos)) = (2.0 * u[0] - 1.0, (TAU * u[1]).sin_cos());
                let r = (1.0 - z * z).sqrt();
                let direction = DVec3::new(r * cos, r * sin, z);
                let weight = pdf(&normals, direction) * 2.0 * TAU / f64::from(n * n);
                total += weight;
                mean += direction * weight;
            }
            assert!((total - 1.0).abs() < 5e-4, "{degrees}: {total}");
            let sampled: DVec3 = grid(n).map(|u| sample(&normals, u).0).sum::<DVec3>() / f64::from(n * n);
            assert!((sampled - mean).length() < 5e-4, "{degrees}: {sampled} {mean}");
        }
    }
}
