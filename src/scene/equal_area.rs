//! The equal-area octahedral map of the sphere onto the unit square, as pbrt-v4 has it for its environments. Clarberg 2008, *Fast Equal-Area
//! Mapping of the (Hemi)Sphere using SIMD*.
//!
//! The middle of the square is +z, its corners are −z; +x is the middle of the right side, −y that of the first row.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use glam::DVec3;

/// The direction of a place in [0, 1]², row 0 at v = 0.
pub fn direction(place: [f64; 2]) -> DVec3 {
    let [u, v] = place.map(|x| 2.0 * x - 1.0);
    let (across, down) = (u.abs(), v.abs());
    let from_edge = 1.0 - (across + down);
    let r = 1.0 - from_edge.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((down - across) / r + 1.0) * FRAC_PI_4 };
    let z = (1.0 - r * r).copysign(from_edge);
    let ring = r * (2.0 - r * r).sqrt();
    DVec3::new(phi.cos().copysign(u) * ring, phi.sin().copysign(v) * ring, z)
}

/// The place of a unit direction in [0, 1]².
pub fn place(direction: DVec3) -> [f64; 2] {
    let [x, y, z] = direction.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    // The angle from the x axis as a share of a quarter turn.
    let phi = y.atan2(x) * FRAC_2_PI;
    let mut v = phi * r;
    let mut u = r - v;
    if direction.z < 0.0 {
        // The lower half is folded outward.
        (u, v) = (1.0 - v, 1.0 - u);
    }
    [u.copysign(direction.x), v.copysign(direction.y)].map(|x| (0.5 * (x + 1.0)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal areas: the mean of x², y² and z² over the square is a third each. And its marked places; and the way back.
    #[test]
    fn the_map_is_of_equal_areas() {
        let side = 200;
        let mut sum = DVec3::ZERO;
        for y in 0..side {
            for x in 0..side {
                let at = [x, y].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                let d = direction(at);
                assert!((d.length() - 1.0).abs() < 1e-12);
                let back = place(d);
                assert!((0..2).all(|k| (back[k] - at[k]).abs() < 1e-9), "{at:?} {back:?}");
                sum += d * d;
            }
        }
        let mean = sum / f64::from(side * side);
        assert!((mean - 1.0 / 3.0).abs().max_element() < 1e-3, "{mean}");
        assert!(direction([0.5, 0.5]).abs_diff_eq(DVec3::Z, 1e-12));
        assert!(direction([0.0, 0.0]).abs_diff_eq(DVec3::NEG_Z, 1e-12));
        assert!(direction([1.0, 0.5]).abs_diff_eq(DVec3::X, 1e-12));
        assert!(direction([0.5, 0.0]).abs_diff_eq(DVec3::NEG_Y, 1e-12));
    }
}
