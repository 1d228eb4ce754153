//! Numbers of about 32 digits, as unevaluated sums of two f64 ("double-double": Dekker 1971; Hida, Li and Bailey 2001), and Fresnel's
//! equations in them. The truth that shorter formulas are held against: written as in textbooks, on n and not on n − 1, so that it shares
//! no step with what it judges.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extended {
    hi: f64,
    lo: f64,
}

/// a + b exactly (Knuth).
fn two_sum(a: f64, b: f64) -> Extended {
    let hi = a + b;
    let b_virtual = hi - a;
    Extended { hi, lo: (a - (hi - b_virtual)) + (b - b_virtual) }
}

/// a + b exactly, for |a| ≥ |b| (Dekker).
fn quick_two_sum(a: f64, b: f64) -> Extended {
    let hi = a + b;
    Extended { hi, lo: b - (hi - a) }
}

/// a·b exactly, by a fused multiply-add.
fn two_product(a: f64, b: f64) -> Extended {
    let hi = a * b;
    Extended { hi, lo: a.mul_add(b, -hi) }
}

impl Extended {
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// a + b, exactly.
    pub fn sum(a: f64, b: f64) -> Self {
        two_sum(a, b)
    }

    pub fn to_f64(self) -> f64 {
        self.hi
    }

    pub fn is_positive(self) -> bool {
        self.hi > 0.0 || (self.hi == 0.0 && self.lo > 0.0)
    }

    /// Of a number ≥ 0 (one Newton step from the f64 root: Karp and Markstein 1997).
    #[must_use]
    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return self;
        }
        let root = self.hi.sqrt();
        let rest = self - two_product(root, root);
        quick_two_sum(root, rest.hi / (2.0 * root))
    }
}

impl From<f64> for Extended {
    fn from(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

impl Neg for Extended {
    type Output = Self;

    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Extended {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let high = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(high.hi, high.lo + low.lo)
    }
}

impl Sub for Extended {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Extended {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = two_product(self.hi, other.hi);
        quick_two_sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for Extended {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        // Long division, three digits of 53 bits each.
        let first = self.hi / other.hi;
        let rest = self - other * first.into();
        let second = rest.hi / other.hi;
        let rest = rest - other * second.into();
        let third = rest.hi / other.hi;
        quick_two_sum(first, second) + third.into()
    }
}

/// What Fresnel's equations and Snell's law say at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Unpolarised.
    pub reflectance: f64,
    /// 0 where reflection is total.
    pub transmittance: f64,
    pub is_total: bool,
    /// cos θt; 0 where reflection is total.
    pub cos_t: f64,
    /// c²/b² with b = η cos θt: by how much a relative error of the cosine is amplified near the critical angle. Infinite where
    /// reflection is total.
    pub condition: f64,
}

/// Fresnel's equations between indices 1 + m1 and 1 + m2 at `c` = cos θi in (0, 1], rounded to f64 at the end.
pub fn fresnel(m1: f64, m2: f64, c: f64) -> Truth {
    let (n1, n2, c) = (Extended::sum(1.0, m1), Extended::sum(1.0, m2), Extended::from(c));
    let ratio = n1 / n2;
    let cos_t_squared = Extended::ONE - ratio * ratio * (Extended::ONE - c * c);
    if !cos_t_squared.is_positive() {
        return Truth { reflectance: 1.0, transmittance: 0.0, is_total: true, cos_t: 0.0, condition: f64::INFINITY };
    }
    let t = cos_t_squared.sqrt();
    let two = Extended::from(2.0);
    let half = Extended::from(0.5);
    let (s, p) = (n1 * c + n2 * t, n2 * c + n1 * t);
    let (rs, rp) = ((n1 * c - n2 * t) / s, (n2 * c - n1 * t) / p);
    let (ts, tp) = (two * n1 * c / s, two * n1 * c / p);
    let b = n2 / n1 * t;
    Truth {
        reflectance: (half * (rs * rs + rp * rp)).to_f64(),
        transmittance: (half * (ts * ts + tp * tp) * (n2 * t) / (n1 * c)).to_f64(),
        is_total: false,
        cos_t: t.to_f64(),
        condition: (c * c / (b * b)).to_f64(),
    }
}

/// Cosine of the critical angle from index 1 + m1 into 1 + m2, rounded to f64; `None` where there is none.
pub fn critical_cosine(m1: f64, m2: f64) -> Option<f64> {
    let ratio = Extended::sum(1.0, m2) / Extended::sum(1.0, m1);
    let squared = Extended::ONE - ratio * ratio;
    squared.is_positive().then(|| squared.sqrt().to_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against 60-digit arithmetic, over typical, nearly equal, extreme and inverted indices: right to the last digit or the one before.
    #[test]
    fn fresnel_agrees_with_sixty_digits() {
        let mut rows = 0;
        let table = include_bytes!("../../../tests/data/fresnel.csv").as_slice();
        for line in csv::ReaderBuilder::new().has_headers(false).from_reader(table).into_deserialize() {
            let (line, n): (String, [f64; 5]) = line.unwrap();
            let truth = fresnel(n[0], n[1], n[2]);
            assert!((truth.reflectance / n[3] - 1.0).abs() <= f64::EPSILON, "{line}: {truth:?}");
            let off = if n[4] == 0.0 { truth.transmittance } else { truth.transmittance / n[4] - 1.0 };
            assert!(off.abs() <= f64::EPSILON, "{line}: {truth:?}");
            rows += 1;
        }
        assert!(rows > 400);
    }

    #[test]
    fn digits_beyond_f64_are_kept() {
        let third = Extended::ONE / Extended::from(3.0);
        let rest = third * Extended::from(3.0) - Extended::ONE;
        assert!(rest.to_f64().abs() < 1e-31);
        let root = Extended::from(2.0).sqrt();
        assert!((root * root - Extended::from(2.0)).to_f64().abs() < 1e-31);
        let tiny = Extended::sum(1.0, 1e-25) - Extended::ONE;
        assert_eq!(tiny.to_f64(), 1e-25);
        assert_eq!((-tiny + tiny).to_f64(), 0.0);
    }

    /// sqrt(1 − (1.333/1.333001)²) = 1.2248973040345324e-3, to 50 digits; as f64 the indices differ by 1e-6 to ten digits.
    #[test]
    fn critical_cosines() {
        assert!((critical_cosine(0.333001, 0.333).unwrap() / 1.224_897_304_034_532_4e-3 - 1.0).abs() < 1e-9);
        assert_eq!(critical_cosine(0.0, 0.5), None);
    }
}
