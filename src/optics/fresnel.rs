//! Fresnel's equations and Snell's law between two dielectrics, in a form that keeps its digits.
//!
//! The usual formulas cancel where nested dielectrics live: nearly equal indices, total internal reflection, grazing angles. Here
//! everything follows from E = η² − 1, computed from n − 1 without cancellation, through r_s = −E/(c + b)² and
//! r_p/r_s = cos(θi + θt)/cos(θi − θt), where c = cos θi and b = η cos θt.
//!
//! Symbols: n1 is the index on the ray's side, n2 the one behind the interface, η = n2/n1.

use glam::DVec3;

/// An ordered pair of media.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// η = n2/n1, and n1/n2.
    eta: f64,
    inverse_eta: f64,
    /// E = η² − 1.
    e: f64,
}

/// What an interface does with a ray that meets it at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refraction {
    /// Nothing gets through.
    TotalReflection,
    Partial {
        /// Unpolarised reflectance, in [0, 1].
        reflectance: f64,
        /// η cos θt, which [`Interface::transmitted`] wants.
        b: f64,
    },
}

impl Interface {
    /// From a medium of index `1 + from_minus_one` into one of `1 + to_minus_one`; both indices positive and finite.
    #[inline]
    pub fn new(from_minus_one: f64, to_minus_one: f64) -> Self {
        let (m1, m2) = (from_minus_one, to_minus_one);
        let (n1, n2) = (1.0 + m1, 1.0 + m2);
        Self { eta: n2 / n1, inverse_eta: n1 / n2, e: (m2 - m1) * (2.0 + m1 + m2) / (n1 * n1) }
    }

    /// η, 1/η, and E = η² − 1.
    pub fn numbers(&self) -> [f64; 3] {
        [self.eta, self.inverse_eta, self.e]
    }

    /// Whether both media have the same index: the ray goes straight on and nothing is reflected.
    #[inline]
    pub fn is_matched(&self) -> bool {
        self.e == 0.0
    }

    /// (n1/n2)², the factor on radiance of a transmission seen along a camera path (Veach 1997, chapter 5).
    #[inline]
    pub fn radiance_factor(&self) -> f64 {
        self.inverse_eta * self.inverse_eta
    }

    /// Reflectance at `c` = cos θi in (0, 1].
    #[inline]
    pub fn refraction(&self, c: f64) -> Refraction {
        let q = (1.0 - c) * (1.0 + c);
        let eta_squared = self.eta * self.eta;
        // Two ways to η² − sin²θi. The first cancels less when η is small, the second when η is near 1.
        let b_squared = if eta_squared < 0.5 { eta_squared - q } else { self.e + c * c };
        if b_squared <= 0.0 {
            return Refraction::TotalReflection;
        }
        let b = b_squared.sqrt();
        let rs = self.e / ((c + b) * (c + b));
        let rp_over_rs = (c * b - q) / (c * b + q);
        Refraction::Partial { reflectance: 0.5 * rs * rs * (1.0 + rp_over_rs * rp_over_rs), b }
    }

    /// Cosine of the transmitted ray to the normal behind the interface, for one that comes at `c`; `None` where reflection is total.
    #[inline]
    pub fn cosine_behind(&self, c: f64) -> Option<f64> {
        match self.refraction(c) {
            Refraction::TotalReflection => None,
            Refraction::Partial { b, .. } => Some(b * self.inverse_eta),
        }
    }

    /// Transmittance at `c`, given `b` from [`Self::refraction`]. More exact near grazing than one minus the reflectance.
    #[inline]
    pub fn transmittance(&self, c: f64, b: f64) -> f64 {
        let q = (1.0 - c) * (1.0 + c);
        let tp_over_ts = self.eta / (c * b + q);
        2.0 * c * b / ((c + b) * (c + b)) * (1.0 + tp_over_ts * tp_over_ts)
    }

    /// Unit direction of the transmitted ray, for unit `direction`, unit `normal` facing the incident side, and `b` from
    /// [`Self::refraction`].
    #[inline]
    pub fn transmitted(&self, direction: DVec3, normal: DVec3, c: f64, b: f64) -> DVec3 {
        let t = (direction - normal * (self.e / (c + b))) * self.inverse_eta;
        // One Newton step towards unit length, so that errors do not grow over thousands of interfaces.
        t * (0.5 * (3.0 - t.length_squared()))
    }
}

/// Unit direction of the mirrored ray.
#[inline]
pub fn reflected(direction: DVec3, normal: DVec3, c: f64) -> DVec3 {
    let r = direction + normal * (2.0 * c);
    r * (0.5 * (3.0 - r.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reflects(n1: f64, n2: f64, expected: f64) {
        let refraction = Interface::new(n1 - 1.0, n2 - 1.0).refraction(1.0);
        let Refraction::Partial { reflectance, .. } = refraction else { panic!("total") };
        assert!((reflectance / expected - 1.0).abs() <= 1e-8, "{reflectance} is not {expected}");
    }

    /// Expected values to nine digits, by 50-digit arithmetic on Fresnel's textbook equations. (Other angles: `tests/optics.rs`;
    /// reciprocity and closure: `tests/properties.rs`.)
    #[test]
    fn reflectance_at_normal_incidence() {
        for (n, r0) in [
            (1.31, 0.0180094076),
            (1.333, 0.0203731878),
            (1.5, 0.04),
            (2.417, 0.171968833),
            (4.0, 0.36),
            (0.5, 1.0 / 9.0),
        ] {
            reflects(1.0, n, r0);
            reflects(n, 1.0, r0);
        }
        reflects(1.0, 1.000277, 1.91769376e-8);
        reflects(1.333, 1.5, 0.00347487985);
    }

    /// 1.333001 → 1.333: the decision over ±200 units in the last place of f32 around the critical cosine, which is
    /// sqrt(1 − (1.333/1.333001)²) = 1.22489730403453e-3 (50 digits).
    #[test]
    fn total_reflection_is_decided_right_next_to_the_critical_angle() {
        const CRITICAL: f64 = 0.001_224_897_304_034_532_4;
        let interface = Interface::new(0.333001, 0.333);
        let center = (CRITICAL as f32).to_bits();
        let wrong = (center - 200..=center + 200)
            .map(|bits| f64::from(f32::from_bits(bits)))
            .filter(|&c| (interface.refraction(c) == Refraction::TotalReflection) != (c <= CRITICAL))
            .count();
        assert_eq!(wrong, 0);
    }

    #[test]
    fn matched_media_change_nothing() {
        let interface = Interface::new(0.5, 0.5);
        assert!(interface.is_matched());
        for c in [1e-7, 1e-4, 0.3, 1.0] {
            let Refraction::Partial { reflectance, b } = interface.refraction(c) else { panic!("total") };
            assert_eq!((reflectance, b), (0.0, c));
        }
    }

    /// Through 1000 interfaces of 1.5 and 1.5001 in turn and back into 1.5, a ray leaves as it came.
    #[test]
    fn a_thousand_layers_keep_the_direction() {
        let normal = DVec3::Y;
        for degrees in [0.0, 30.0, 60.0, 85.0, 89.0f64] {
            let start = DVec3::new(degrees.to_radians().sin(), -degrees.to_radians().cos(), 0.0);
            let mut direction = start;
            for layer in 0..1000 {
                let (from, to) = if layer % 2 == 0 { (0.5, 0.5001) } else { (0.5001, 0.5) };
                let interface = Interface::new(from, to);
                let c = -direction.dot(normal);
                let Refraction::Partial { b, .. } = interface.refraction(c) else { panic!("total at {degrees}") };
                direction = interface.transmitted(direction, normal, c, b);
            }
            assert!(direction.angle_between(start) < 1e-10);
        }
    }
}
