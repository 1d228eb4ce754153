//! How often which radiance, or which difference, occurs in a picture.

use super::settings::DifferenceKind;
use crate::export::color_map::luminance;

/// Stops of radiance that are told apart: powers of two, in scene units.
pub const STOPS: std::ops::Range<i32> = -20..20;
pub const BINS_PER_STOP: usize = 4;
const BINS: usize = (STOPS.end - STOPS.start) as usize * BINS_PER_STOP;
/// Bins of a difference, over the whole scale of colours.
pub const DIFFERENCE_BINS: usize = 64;

#[derive(Debug, Clone, PartialEq)]
pub enum Histogram {
    Radiance(Box<Radiance>),
    Difference(Box<Difference>),
}

/// Of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiance {
    /// Of luminance, r, g and b: pixels by quarter stops, from the first of [`STOPS`] on. What lies outside is in the outermost bins,
    /// zero in the first.
    pub counts: [[u32; BINS]; 4],
    /// Of the largest of r, g and b.
    largest: [u32; BINS],
    pub pixels: u32,
    /// Pixels with a channel that is not finite; they are in no bin.
    pub odd: u32,
}

/// Of a difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    pub kind: DifferenceKind,
    /// Pixels by their place in the scale of colours: from 0 to 1, or from −1 to 1 where `kind` is signed.
    pub counts: [u32; DIFFERENCE_BINS],
    /// Pixels at the end of the scale or beyond it.
    pub beyond: u32,
    pub pixels: u32,
    /// Pixels that are not a number; they are in no bin.
    pub odd: u32,
}

/// The bin of a radiance.
fn bin_of(x: f32) -> usize {
    let stops = f64::from(x).log2() - f64::from(STOPS.start);
    // Zero and what is negative have no logarithm: the first bin.
    if stops > 0.0 { ((stops * BINS_PER_STOP as f64) as usize).min(BINS - 1) } else { 0 }
}

impl Radiance {
    pub fn of(rgb: &[[f32; 3]]) -> Self {
        let mut histogram = Self { counts: [[0; BINS]; 4], largest: [0; BINS], pixels: rgb.len() as u32, odd: 0 };
        for rgb in rgb {
            if !rgb.iter().all(|x| x.is_finite()) {
                histogram.odd += 1;
                continue;
            }
            let values = [luminance(*rgb), rgb[0], rgb[1], rgb[2]];
            for (counts, value) in histogram.counts.iter_mut().zip(values) {
                counts[bin_of(value)] += 1;
            }
            histogram.largest[bin_of(rgb[0].max(rgb[1]).max(rgb[2]))] += 1;
        }
        histogram
    }

    /// The share of the pixels with a channel that `exposure`, in stops, brings above white. Exact where the exposure is a multiple of
    /// a quarter; between, pixels of a bin count as spread evenly over it.
    pub fn clipped_share(&self, exposure: f32) -> f64 {
        let white = ((f64::from(-exposure) - f64::from(STOPS.start)) * BINS_PER_STOP as f64).clamp(0.0, BINS as f64);
        let part = |bin: usize| (bin as f64 + 1.0 - white).clamp(0.0, 1.0);
        let clipped: f64 = self.largest.iter().enumerate().map(|(bin, count)| part(bin) * f64::from(*count)).sum();
        clipped / f64::from(self.pixels.max(1))
    }
}

impl Difference {
    /// `places` are those of the pixels in the scale of colours.
    pub fn of(kind: DifferenceKind, places: impl Iterator<Item = f32>) -> Self {
        let mut histogram = Self { kind, counts: [0; DIFFERENCE_BINS], beyond: 0, pixels: 0, odd: 0 };
        for place in places {
            histogram.pixels += 1;
            if place.is_nan() {
                histogram.odd += 1;
                continue;
            }
            histogram.beyond += u32::from(place.abs() >= 1.0);
            let part = if kind == DifferenceKind::Signed { 0.5 * (place + 1.0) } else { place.abs() };
            let bin = (part.clamp(0.0, 1.0) * DIFFERENCE_BINS as f32) as usize;
            histogram.counts[bin.min(DIFFERENCE_BINS - 1)] += 1;
        }
        histogram
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_counted_in_its_quarter_of_a_stop() {
        let image = [[1.0, 0.5, 4.1], [0.0, 0.0, 0.0], [f32::NAN, 1.0, 1.0], [1e30, -1.0, 1e-30]];
        let histogram = Radiance::of(&image);
        assert_eq!((histogram.pixels, histogram.odd), (4, 1));
        for counts in &histogram.counts {
            assert_eq!(counts.iter().sum::<u32>(), 3);
        }
        let bin = |stop: i32| (stop - STOPS.start) as usize * BINS_PER_STOP;
        let [_, red, green, blue] = &histogram.counts;
        assert_eq!((red[bin(0)], red[BINS - 1], red[0]), (1, 1, 1));
        assert_eq!((green[bin(-1)], green[0]), (1, 2));
        assert_eq!((blue[bin(2)], blue[0]), (1, 2));
    }

    #[test]
    fn what_the_exposure_clips_is_counted() {
        // One pixel in the middle of each quarter of a stop around 1.
        let image: Vec<[f32; 3]> = (-8..8).map(|i| [((i as f32 + 0.5) / 4.0).exp2(), 0.0, 0.0]).collect();
        let histogram = Radiance::of(&image);
        for (exposure, clipped) in [(0.0, 8), (1.0, 12), (-1.0, 4), (5.0, 16), (-5.0, 0), (0.25, 9)] {
            let by_hand = image.iter().filter(|rgb| rgb[0] * f32::exp2(exposure) > 1.0).count();
            assert_eq!(by_hand, clipped);
            let share = histogram.clipped_share(exposure);
            assert!((share * 16.0 - clipped as f64).abs() < 1e-9, "{exposure}: {share}");
        }
        assert!((histogram.clipped_share(0.125) * 16.0 - 8.5).abs() < 1e-6, "half of a bin");
        assert_eq!(Radiance::of(&[]).clipped_share(0.0), 0.0);
    }

    #[test]
    fn differences_are_counted_by_their_colours() {
        let places = [0.0, 0.26, 0.999, 1.0, 1.0, f32::NAN];
        let absolute = Difference::of(DifferenceKind::Absolute, places.into_iter());
        assert_eq!((absolute.pixels, absolute.odd, absolute.beyond), (6, 1, 2));
        assert_eq!((absolute.counts[0], absolute.counts[16], absolute.counts[63]), (1, 1, 3));
        let signed = Difference::of(DifferenceKind::Signed, [-1.0, -0.01, 0.01, 1.0].into_iter());
        assert_eq!([0, 31, 32, 63].map(|bin| signed.counts[bin]), [1; 4]);
        assert_eq!(signed.beyond, 2);
    }
}
