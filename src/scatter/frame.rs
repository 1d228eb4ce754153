//! Frames about a direction.

use glam::DVec3;

/// Two unit vectors that make a right-handed frame with unit `normal` (Duff et al. 2017).
#[inline]
pub fn frame(normal: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in [DVec3::X, DVec3::NEG_Z, DVec3::Z, DVec3::new(0.6, -0.48, -0.64)] {
            let (t, b) = frame(n);
            assert!((t.cross(b) - n).length() < 1e-14 && (t.length() - 1.0).abs() < 1e-14);
        }
    }
}
