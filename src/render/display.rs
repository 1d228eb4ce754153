//! From linear radiance to what a screen shows. Display only: measurements are made on linear film.

use std::fmt;
use std::str::FromStr;

use crate::color::{NOT_A_NUMBER, srgb_from_linear};

/// How radiance above 1 is brought into a screen's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneCurve {
    /// Cut off at 1: comparable by eye with other programs' plain output.
    Clip,
    /// A shoulder from 0.8 on that keeps hue steps smooth and never quite reaches white; linear below.
    #[default]
    Soft,
}

impl ToneCurve {
    pub const ALL: [Self; 2] = [Self::Clip, Self::Soft];

    pub fn name(self) -> &'static str {
        match self {
            Self::Clip => "clip",
            Self::Soft => "soft",
        }
    }

    /// Maps a linear component ≥ 0 into [0, 1].
    #[inline]
    fn apply(self, x: f32) -> f32 {
        const SHOULDER: f32 = 0.8;
        match self {
            Self::Soft if x > SHOULDER => {
                let over = (x - SHOULDER) / (1.0 - SHOULDER);
                // Slope 1 at the shoulder, so the curve has no kink; tends to 1 slowly enough to keep a sun's surroundings apart.
                SHOULDER + (1.0 - SHOULDER) * (over / (1.0 + over))
            }
            _ => x.clamp(0.0, 1.0),
        }
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ToneCurve {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|curve| curve.name() == text).ok_or_else(|| {
            format!("unknown tone curve `{text}`; valid curves: {}", Self::ALL.map(Self::name).join(", "))
        })
    }
}

/// Exposure and tone curve.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Display {
    /// In stops: radiance is multiplied by 2^exposure.
    pub exposure: f32,
    pub curve: ToneCurve,
}

impl Display {
    /// Encodes linear RGB for an sRGB screen. Infinite is white, NaN magenta: neither is ever hidden as black.
    #[inline]
    pub fn encode(&self, rgb: [f32; 3]) -> [u8; 3] {
        if rgb.iter().any(|x| x.is_nan()) {
            return NOT_A_NUMBER;
        }
        let gain = self.exposure.exp2();
        rgb.map(|x| (srgb_from_linear(self.curve.apply((x * gain).min(1e6))) * 255.0 + 0.5) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_of_srgb() {
        let display = Display { exposure: 0.0, curve: ToneCurve::Clip };
        assert_eq!(display.encode([0.0, 1.0, 0.214_041_14]), [0, 255, 128]);
        assert_eq!(display.encode([-1.0, 7.0, f32::INFINITY]), [0, 255, 255]);
    }

    #[test]
    fn not_a_number_is_seen() {
        assert_eq!(Display::default().encode([f32::NAN, 0.0, 0.0]), [255, 0, 255]);
    }

    #[test]
    fn the_soft_curve_rises_and_stays_below_white() {
        let values: Vec<f32> = (0..2000).map(|i| ToneCurve::Soft.apply(i as f32 * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[1] > w[0]) && values[1999] < 1.0);
    }
}
