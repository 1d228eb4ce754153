//! Fresnel's equations in the ways that renderers evaluate them.

use serde::{Deserialize, Serialize};

use crate::optics::Interface;
use crate::optics::fresnel::Refraction;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Formula {
    /// The code that renders: from E = η² − 1, in f64.
    Shipped,
    /// The same equations in f32, with E and η rounded to f32 beforehand, as a GPU would evaluate them. Every operation is rounded once.
    ShortShipped,
    /// As textbooks and many renderers have it: from n1, n2 and Snell's law for the sine, in f32; T = 1 − R.
    ShortTextbook,
}

/// What a formula says at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluated {
    pub reflectance: f64,
    /// 0 where reflection is total.
    pub transmittance: f64,
    pub is_total: bool,
    /// cos θt; 0 where reflection is total.
    pub cos_t: f64,
}

impl Evaluated {
    pub(super) const TOTAL: Self = Self { reflectance: 1.0, transmittance: 0.0, is_total: true, cos_t: 0.0 };

    /// c²/b² with b = η cos θt: by how much a relative error of the cosine is amplified near the critical angle. Infinite where
    /// reflection is total.
    pub fn condition(&self, m1: f64, m2: f64, c: f64) -> f64 {
        (c * (1.0 + m1) / ((1.0 + m2) * self.cos_t)).powi(2)
    }
}

impl Formula {
    pub const ALL: [Self; 3] = [Self::Shipped, Self::ShortShipped, Self::ShortTextbook];

    /// For captions.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shipped => "E-form in f64 (as rendered)",
            Self::ShortShipped => "E-form in f32 (as on a GPU)",
            Self::ShortTextbook => "textbook form in f32",
        }
    }

    /// From a medium of index 1 + m1 into one of 1 + m2, at `c` = cos θi in (0, 1].
    pub fn evaluate(self, m1: f64, m2: f64, c: f64) -> Evaluated {
        match self {
            Self::Shipped => shipped(m1, m2, c),
            Self::ShortShipped => short_shipped(m1, m2, c as f32),
            Self::ShortTextbook => short_textbook((1.0 + m1) as f32, (1.0 + m2) as f32, c as f32),
        }
    }
}

fn shipped(m1: f64, m2: f64, c: f64) -> Evaluated {
    let interface = Interface::new(m1, m2);
    match interface.refraction(c) {
        Refraction::TotalReflection => Evaluated::TOTAL,
        Refraction::Partial { reflectance, b } => Evaluated {
            reflectance,
            transmittance: interface.transmittance(c, b),
            is_total: false,
            cos_t: b * (1.0 + m1) / (1.0 + m2),
        },
    }
}

fn short_shipped(m1: f64, m2: f64, c: f32) -> Evaluated {
    // Once for each pair of media, on the host.
    let n1 = 1.0 + m1;
    let eta = ((1.0 + m2) / n1) as f32;
    let e = ((m2 - m1) * (2.0 + m1 + m2) / (n1 * n1)) as f32;
    // For each hit.
    let q = (1.0 - c) * (1.0 + c);
    let b_squared = if eta * eta < 0.5 { eta * eta - q } else { e + c * c };
    if b_squared <= 0.0 {
        return Evaluated::TOTAL;
    }
    let b = b_squared.sqrt();
    let rs = e / ((c + b) * (c + b));
    let rp_over_rs = (c * b - q) / (c * b + q);
    let tp_over_ts = eta / (c * b + q);
    Evaluated {
        reflectance: f64::from(0.5 * rs * rs * (1.0 + rp_over_rs * rp_over_rs)),
        transmittance: f64::from(2.0 * c * b / ((c + b) * (c + b)) * (1.0 + tp_over_ts * tp_over_ts)),
        is_total: false,
        cos_t: f64::from(b / eta),
    }
}

fn short_textbook(n1: f32, n2: f32, c: f32) -> Evaluated {
    let ratio = n1 / n2;
    let sin_squared = ratio * ratio * (1.0 - c * c);
    if sin_squared >= 1.0 {
        return Evaluated::TOTAL;
    }
    let t = (1.0 - sin_squared).sqrt();
    let rs = (n1 * c - n2 * t) / (n1 * c + n2 * t);
    let rp = (n2 * c - n1 * t) / (n2 * c + n1 * t);
    let reflectance = 0.5 * (rs * rs + rp * rp);
    Evaluated {
        reflectance: f64::from(reflectance),
        transmittance: f64::from(1.0 - reflectance),
        is_total: false,
        cos_t: f64::from(t),
    }
}
