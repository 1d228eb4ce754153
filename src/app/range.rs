//! How differences in luminance become places in a scale of colours: where the scale ends, and how it is divided.

use serde::{Deserialize, Serialize};

use crate::export::color_map::round_up_to_125;

/// Share of the pixels that an automatic range holds.
const PERCENTILE: f64 = 0.995;
/// Decades below its end that a logarithmic scale shows.
pub const DECADES: f32 = 4.0;
/// Ends of fixed ranges, in linear luminance.
pub const ENDS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Where the scale ends.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum RangeEnd {
    /// At the luminance that the exposure brings to white.
    #[default]
    Exposure,
    /// Where nearly all pixels lie within it, rounded up to 1, 2 or 5 times a power of ten.
    Automatic,
    /// At this luminance, within [`ENDS`].
    Fixed(f32),
}

/// How the scale is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum RangeCurve {
    /// By the square root: small differences are seen beside large ones.
    #[default]
    Root,
    Linear,
    /// By the logarithm, over [`DECADES`].
    Logarithmic,
}

impl RangeCurve {
    pub fn name(self) -> &'static str {
        match self {
            Self::Root => "root",
            Self::Linear => "linear",
            Self::Logarithmic => "log",
        }
    }
}

/// What a user asks of the colours of differences.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DifferenceRange {
    pub end: RangeEnd,
    pub curve: RangeCurve,
    /// Whether an automatic range is the same in all panes.
    pub is_shared: bool,
}

impl Default for DifferenceRange {
    fn default() -> Self {
        Self { end: RangeEnd::default(), curve: RangeCurve::default(), is_shared: true }
    }
}

impl DifferenceRange {
    /// With an end that is a number of three digits, within [`ENDS`].
    #[must_use]
    pub fn repaired(self) -> Self {
        let end = match self.end {
            RangeEnd::Fixed(end) if end.is_finite() && end > 0.0 => {
                RangeEnd::Fixed(three_digits(end.clamp(*ENDS.start() as f32, *ENDS.end() as f32)))
            }
            RangeEnd::Fixed(_) => RangeEnd::default(),
            other => other,
        };
        Self { end, ..self }
    }
}

fn three_digits(x: f32) -> f32 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// A scale whose end is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The luminance at its end, > 0.
    pub end: f32,
    pub curve: RangeCurve,
}

impl Scale {
    /// Where a difference lies, from −1 to 1: 0 is none, ±1 and beyond are the ends. NaN stays NaN.
    pub fn place(self, difference: f32) -> f32 {
        let size = difference.abs() / self.end;
        let place = match self.curve {
            RangeCurve::Root => size.sqrt(),
            RangeCurve::Linear => size,
            // Zero has no logarithm: it is minus infinity, below the scale.
            RangeCurve::Logarithmic => 1.0 + size.log10() / DECADES,
        };
        // NaN passes through.
        place.clamp(0.0, 1.0).copysign(difference)
    }

    /// The difference at a part of a legend's bar, in [−1, 1]. The bar is even in luminance, or in its logarithm.
    pub fn difference_at(self, part: f32) -> f32 {
        match self.curve {
            RangeCurve::Root | RangeCurve::Linear => part * self.end,
            RangeCurve::Logarithmic => (self.end * 10_f32.powf((part.abs() - 1.0) * DECADES)).copysign(part),
        }
    }

    /// The size of the difference at a place, from 0 to 1.
    pub fn size_at(self, place: f32) -> f32 {
        match self.curve {
            RangeCurve::Root => place * place * self.end,
            RangeCurve::Linear => place * self.end,
            RangeCurve::Logarithmic => self.end * 10_f32.powf((place - 1.0) * DECADES),
        }
    }

    /// The least luminance that has a colour of its own; 0 but for logarithmic scales.
    pub fn least(self) -> f32 {
        match self.curve {
            RangeCurve::Root | RangeCurve::Linear => 0.0,
            RangeCurve::Logarithmic => self.end * 10_f32.powf(-DECADES),
        }
    }
}

/// The end of an automatic range for these differences; 1 where there are none.
pub fn automatic_end(differences: impl Iterator<Item = f32>) -> f32 {
    let mut sizes: Vec<f32> = differences.map(f32::abs).filter(|size| *size > 0.0 && size.is_finite()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let index = ((sizes.len() - 1) as f64 * PERCENTILE).round() as usize;
    let (_, size, _) = sizes.select_nth_unstable_by(index, f32::total_cmp);
    round_up_to_125(*size).min(*ENDS.end() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [RangeCurve; 3] = [RangeCurve::Root, RangeCurve::Linear, RangeCurve::Logarithmic];

    #[test]
    fn scales_rise_from_nothing_to_their_end() {
        for curve in CURVES {
            let scale = Scale { end: 0.2, curve };
            let places: Vec<f32> = (0..=400).map(|i| scale.place(i as f32 * 1e-3)).collect();
            assert!(places.windows(2).all(|w| w[0] <= w[1]), "{curve:?}");
            assert_eq!((places[0], places[400]), (0.0, 1.0));
            assert!((places[200] - 1.0).abs() < 1e-6 && places[150] < 1.0, "{curve:?}");
            assert_eq!(scale.place(-0.03), -scale.place(0.03));
            assert!([0.1, 0.5, 1.0].iter().all(|place| (scale.place(scale.size_at(*place)) - place).abs() < 1e-5));
            assert!(scale.place(f32::NAN).is_nan() && scale.place(f32::INFINITY) == 1.0);
        }
    }

    #[test]
    fn the_legend_says_which_difference_has_which_colour() {
        let log = Scale { end: 2.0, curve: RangeCurve::Logarithmic };
        for part in [0.1, 0.25, 0.5, 1.0, -0.5] {
            assert!((log.place(log.difference_at(part)) - part).abs() < 1e-5, "the bar is even in colour");
        }
        assert!((log.difference_at(0.5) - 0.02).abs() < 1e-6 && (log.least() - 2e-4).abs() < 1e-9);
        let root = Scale { end: 2.0, curve: RangeCurve::Root };
        assert_eq!((root.difference_at(0.5), root.place(0.5)), (1.0, 0.5));
    }

    #[test]
    fn an_automatic_range_holds_nearly_all_pixels() {
        let differences = || (0..1000).map(|i| if i < 3 { 80.0 } else { -0.13 });
        assert!((automatic_end(differences()) - 0.2).abs() < 1e-6);
        assert_eq!(automatic_end([0.0, f32::NAN, f32::INFINITY].into_iter()), 1.0);
        // A single pixel that differs is seen.
        assert!((automatic_end((0..1000).map(|i| if i == 7 { 0.4 } else { 0.0 })) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn damaged_ranges_are_repaired() {
        let end = |end| DifferenceRange { end: RangeEnd::Fixed(end), ..DifferenceRange::default() }.repaired().end;
        for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            assert_eq!(end(bad), RangeEnd::Exposure);
        }
        assert_eq!(end(1e30), RangeEnd::Fixed(1e6));
        assert_eq!(end(0.123_456), RangeEnd::Fixed(0.123));
    }
}
