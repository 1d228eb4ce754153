//! FLIP: how much two images differ to someone who looks at one and then at the other, per pixel in [0, 1].
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström and M. D. Fairchild: "ꟻLIP: A Difference Evaluator for
//! Alternating Images", HPG 2020 ([`Reference::ldr`]); P. Andersson, J. Nilsson, P. Shirley and T. Akenine-Möller: "Visualizing Errors in Rendered
//! High Dynamic Range Images", Eurographics short papers 2021 ([`Reference::hdr`]). Filters are separated as in the authors' note
//! "Separated convolutions" (Cz, a sum of two Gaussians, in two parts). Constants carry the papers' names.
//!
//! The figures are those of the authors' program, `flip-evaluator` 1.7, to 1e-4 in every pixel; the tests hold them against it. Bindings of
//! an older version of that program (the crate `nv-flip`) take 8 bits a channel only, from which HDR cannot be built to that
//! accuracy, and need a C++ compiler, so they serve the tests alone.
//!
//! NaN would pass through the formulas as a large or a small error, so images that are not finite are refused.

mod appearance;

use rayon::prelude::*;

use self::appearance::{Appearance, Filters};
use super::metrics::{MetricError, require_finite};
use crate::color::linear_from_srgb;
use crate::render::Display;

/// Pixels per degree of visual angle for a screen 0.7 m wide of 3840 pixels, seen from 0.7 m: the papers' viewing conditions.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_645;
/// Pixels per degree that are taken: beyond, filters are wider than most images.
const PIXELS_PER_DEGREE: std::ops::RangeInclusive<f32> = 1.0..=1000.0;

/// The colour difference below which most of [0, 1] lies, as a share of the greatest, and where it is mapped to.
const PC: f32 = 0.4;
const PT: f32 = 0.95;
/// Exponents of the colour and of the feature difference.
const QC: f32 = 0.7;
const QF: f32 = 0.5;
/// Tone-mapped luminance at which the darkest and the brightest exposure put the reference's greatest and median luminance.
const EXPOSED: f64 = 0.85;

/// The error of every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// In [0, 1], row-major like the images.
    pub error: Vec<f32>,
}

impl Flip {
    /// The figure for the whole image that the papers use.
    pub fn mean(&self) -> f64 {
        self.error.iter().map(|&e| f64::from(e)).sum::<f64>() / self.error.len() as f64
    }
}

/// A reference made ready: half of the work, for those who hold several images against it. Takes 20 bytes a pixel for each exposure,
/// of which HDR has as many as there are stops between the median and the maximum of its luminance, and two at least, and 40 more
/// while an image is held against it.
///
/// All images are row-major.
#[derive(Debug, Clone)]
pub struct Reference {
    width: usize,
    height: usize,
    filters: Filters,
    /// What is seen of it, for each way to show it.
    seen: Vec<(Screen, Appearance)>,
}

/// How a component becomes light in [0, 1].
#[derive(Debug, Clone, Copy)]
enum Screen {
    /// It is encoded for an sRGB screen.
    Encoded,
    /// It is linear, and encoded first.
    Displayed(Display),
    /// It is linear, exposed by so many stops, and tone-mapped.
    Exposed(f32),
}

impl Screen {
    fn appearance(self, image: &[[f32; 3]], width: usize, filters: &Filters) -> Appearance {
        match self {
            Self::Encoded => Appearance::new(image, width, filters, decoded),
            Self::Displayed(display) => {
                let shown = |rgb| display.encode(rgb).map(|byte| f32::from(byte) / 255.0);
                Appearance::new(image, width, filters, |rgb| decoded(shown(rgb)))
            }
            Self::Exposed(stops) => Appearance::new(image, width, filters, exposed(stops)),
        }
    }
}

impl Reference {
    /// FLIP of images as a screen shows them: RGB with the sRGB transfer function applied, each component in [0, 1] (bytes / 255; what
    /// lies outside is cut off).
    ///
    /// # Errors
    /// When the size does not fit, there are no pixels, a component is not finite, or `pixels_per_degree` is not between 1 and 1000.
    pub fn ldr(
        reference: &[[f32; 3]],
        width: usize,
        height: usize,
        pixels_per_degree: f32,
    ) -> Result<Self, MetricError> {
        Self::new(reference, width, height, pixels_per_degree, || vec![Screen::Encoded])
    }

    /// The same of linear images, as `display` shows them in 8 bits a channel.
    ///
    /// # Errors
    /// As [`Self::ldr`].
    pub fn displayed(
        reference: &[[f32; 3]],
        width: usize,
        height: usize,
        pixels_per_degree: f32,
        display: Display,
    ) -> Result<Self, MetricError> {
        Self::new(reference, width, height, pixels_per_degree, || vec![Screen::Displayed(display)])
    }

    /// HDR-FLIP of linear images (Rec. 709 primaries, any scale, negative components count as 0): of each pixel the greatest FLIP over a
    /// range of exposures, which the reference decides, tone-mapped by ACES.
    ///
    /// # Errors
    /// As [`Self::ldr`].
    pub fn hdr(
        reference: &[[f32; 3]],
        width: usize,
        height: usize,
        pixels_per_degree: f32,
    ) -> Result<Self, MetricError> {
        let screens = || exposures(reference).into_iter().map(Screen::Exposed).collect();
        Self::new(reference, width, height, pixels_per_degree, screens)
    }

    fn new(
        reference: &[[f32; 3]],
        width: usize,
        height: usize,
        pixels_per_degree: f32,
        screens: impl FnOnce() -> Vec<Screen>,
    ) -> Result<Self, MetricError> {
        if reference.is_empty() {
            return Err(MetricError::Empty);
        }
        if width.checked_mul(height) != Some(reference.len()) {
            return Err(MetricError::WrongShape { pixels: reference.len(), width, height });
        }
        require_finite(reference, "reference")?;
        if !PIXELS_PER_DEGREE.contains(&pixels_per_degree) {
            return Err(MetricError::PixelsPerDegree);
        }
        let filters = Filters::new(pixels_per_degree);
        let seen =
            screens().into_iter().map(|screen| (screen, screen.appearance(reference, width, &filters))).collect();
        Ok(Self { width, height, filters, seen })
    }

    /// The error of `image` against this reference.
    ///
    /// # Errors
    /// When the image's size is another, or a component is not finite.
    pub fn flip(&self, image: &[[f32; 3]]) -> Result<Flip, MetricError> {
        let pixels = self.width * self.height;
        if image.len() != pixels {
            return Err(MetricError::SizesDiffer { image: image.len(), reference: pixels });
        }
        require_finite(image, "image")?;
        let mut error = vec![0.0_f32; pixels];
        for (screen, reference) in &self.seen {
            raise(&mut error, &screen.appearance(image, self.width, &self.filters), reference);
        }
        Ok(Flip { error })
    }
}

/// Puts the error of each pixel where it is greater than what is there.
fn raise(error: &mut [f32], test: &Appearance, reference: &Appearance) {
    let greatest = greatest_color_difference();
    error.par_iter_mut().enumerate().for_each(|(pixel, error)| {
        let color = color_error(test.lab[pixel], reference.lab[pixel], greatest);
        let edge = (test.edge[pixel] - reference.edge[pixel]).abs();
        let point = (test.point[pixel] - reference.point[pixel]).abs();
        let feature = (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).powf(QF);
        *error = error.max(color.powf(1.0 - feature));
    });
}

/// The colour difference, mapped to [0, 1] so that most of it is for small ones (HPG 2020, §4.1.4).
fn color_error(a: [f32; 3], b: [f32; 3], greatest: f32) -> f32 {
    let difference = hyab(a, b).powf(QC);
    let knee = PC * greatest;
    if difference < knee { difference * (PT / knee) } else { PT + (difference - knee) / (greatest - knee) * (1.0 - PT) }
}

/// City block distance in lightness, Euclidean in chroma.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// The difference of pure green and pure blue.
fn greatest_color_difference() -> f32 {
    hyab(appearance::lab([0.0, 1.0, 0.0]), appearance::lab([0.0, 0.0, 1.0])).powf(QC)
}

fn decoded(srgb: [f32; 3]) -> [f32; 3] {
    srgb.map(|encoded| linear_from_srgb(encoded.clamp(0.0, 1.0)))
}

/// ACES as Narkowicz fitted it, with its pre-exposure of 0.6 multiplied in: (ax² + bx)/(cx² + dx + e).
const ACES: [f32; 5] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

/// Exposes and tone-maps.
fn exposed(stops: f32) -> impl Fn([f32; 3]) -> [f32; 3] + Sync {
    // In f64, where neither the factor nor a square can overflow.
    let factor = f64::from(stops).exp2();
    let [a, b, c, d, e] = ACES.map(f64::from);
    move |rgb| {
        rgb.map(|linear| {
            let x = f64::from(linear.max(0.0)) * factor;
            ((x * (a * x + b)) / (x * (c * x + d) + e)).clamp(0.0, 1.0) as f32
        })
    }
}

/// The exposures in stops, from the one that shows the brightest pixel of the reference to the one that shows the median (Eurographics
/// 2021, §3). The paper does not say what to do where more than half of the pixels are black: the median is then that of the others.
fn exposures(reference: &[[f32; 3]]) -> Vec<f32> {
    let luminance = |[r, g, b]: &[f32; 3]| 0.2126 * r.max(0.0) + 0.7152 * g.max(0.0) + 0.0722 * b.max(0.0);
    let mut luminances: Vec<f32> = reference.par_iter().map(luminance).collect();
    let median = |luminances: &mut [f32]| {
        let middle = luminances.len() / 2;
        *luminances.select_nth_unstable_by(middle, f32::total_cmp).1
    };
    let mut typical = median(&mut luminances);
    if typical == 0.0 {
        luminances.retain(|&luminance| luminance > 0.0);
        if luminances.is_empty() {
            // Any image of which something can be seen at all differs from black.
            return vec![0.0];
        }
        typical = median(&mut luminances);
    }
    let brightest = luminances.iter().copied().fold(0.0, f32::max);
    // Where the tone curve reaches `EXPOSED`: the greater root of (a − tc)x² + (b − td)x − te.
    let [a, b, c, d, e] = ACES.map(f64::from);
    let (a, b, c) = (a - EXPOSED * c, b - EXPOSED * d, -EXPOSED * e);
    let root = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let (start, stop) = ((root / f64::from(brightest)).log2(), (root / f64::from(typical)).log2());
    let count = (stop - start).ceil().max(2.0) as usize;
    (0..count).map(|index| (start + (stop - start) * index as f64 / (count - 1) as f64) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tone_curve_shows_the_brightest_and_the_median_as_it_should() {
        let reference: Vec<[f32; 3]> = (0..100).map(|i| [0.01 * 1.1_f32.powi(i); 3]).collect();
        let stops = exposures(&reference);
        for (pixel, stops) in [(99, stops[0]), (50, stops[stops.len() - 1])] {
            let [shown, ..] = exposed(stops)(reference[pixel]);
            assert!((shown - 0.85).abs() < 1e-5, "{shown}");
        }
        // log2 of 1.1⁴⁹ is 6.7.
        assert_eq!(stops.len(), 7);
    }

    #[test]
    fn exposures_of_dark_images() {
        assert_eq!(exposures(&[[0.0; 3]; 5]), [0.0]);
        let mut mostly_black = vec![[0.0; 3]; 100];
        mostly_black[7] = [4.0; 3];
        mostly_black[8] = [1.0; 3];
        mostly_black[9] = [2.0; 3];
        let stops = exposures(&mostly_black);
        assert!(stops.len() == 2 && (stops[1] - stops[0] - 1.0).abs() < 1e-6, "{stops:?}");
        assert!(exposures(&[[f32::MAX; 3], [f32::MIN_POSITIVE; 3], [1.0; 3]]).iter().all(|stops| stops.is_finite()));
    }
}
