//! What an eye at some distance makes of an image: colours that are blurred as its contrast sensitivity has it, edges and points.

use rayon::prelude::*;

/// Amplitudes and widths of the contrast sensitivities' Gaussians: lightness, red–green, and the two of blue–yellow, a and b of
/// a √(π/b) exp(−π² x²/b), x in degrees (HPG 2020, table 1, after Johnson and Fairchild 2003).
const SENSITIVITY: [[f64; 2]; 4] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04], [13.5, 0.025]];
/// Width of what is seen as an edge or a point, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// XYZ of D65, the white point.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];
/// XYZ from linear Rec. 709.
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// Its inverse, as the reference implementation rounds it.
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// Of each pixel.
#[derive(Debug, Clone)]
pub(super) struct Appearance {
    /// CIELAB of the blurred image, chroma weakened in the dark (Hunt).
    pub lab: Vec<[f32; 3]>,
    /// Strength of edges and of points in the lightness.
    pub edge: Vec<f32>,
    pub point: Vec<f32>,
}

/// Weights along a row or a column, for one viewing distance.
#[derive(Debug, Clone)]
pub(super) struct Filters {
    /// In the order of [`SENSITIVITY`]; the last two are to be added.
    sensitivity: [Vec<f32>; 4],
    gaussian: Vec<f32>,
    /// First and second derivatives of the Gaussian, each with positive weights that sum to 1 and negative ones to −1.
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Filters {
    pub fn new(pixels_per_degree: f32) -> Self {
        let per_degree = f64::from(pixels_per_degree);
        let pi_squared = std::f64::consts::PI.powi(2);
        let widest = SENSITIVITY.iter().map(|[_, b]| *b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * pi_squared)).sqrt() * per_degree).ceil() as i32;
        let taps = |radius: i32, weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (-radius..=radius).map(|x| weight(f64::from(x))).collect()
        };
        let gaussian_of_sensitivity = |index: usize, amplitude: f64| {
            let b = SENSITIVITY[index][1];
            taps(radius, &|x| amplitude * (-pi_squared * (x / per_degree).powi(2) / b).exp())
        };
        // A Gaussian in two dimensions is the product of two; their amplitude is its root. Together, the two of blue–yellow have sum 1.
        let blue_yellow = [2, 3].map(|index| {
            let [a, b] = SENSITIVITY[index];
            gaussian_of_sensitivity(index, (a * (std::f64::consts::PI / b).sqrt()).sqrt())
        });
        let total = blue_yellow.iter().map(|part| part.iter().sum::<f64>().powi(2)).sum::<f64>().sqrt();
        let [third, fourth] = blue_yellow.map(|part| scaled(&part, 1.0 / total));
        let [first, second] = [0, 1].map(|index| normalized(&gaussian_of_sensitivity(index, 1.0)));

        let deviation = 0.5 * FEATURE_WIDTH * per_degree;
        let feature_radius = (3.0 * deviation).ceil() as i32;
        let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        let feature = |weight: &dyn Fn(f64) -> f64| taps(feature_radius, weight);
        Self {
            sensitivity: [first, second, third, fourth],
            gaussian: normalized(&feature(&gaussian)),
            first: normalized(&feature(&|x| -x * gaussian(x))),
            second: normalized(&feature(&|x| (x * x / (deviation * deviation) - 1.0) * gaussian(x))),
        }
    }
}

/// Positive weights divided by their sum, negative ones by theirs.
fn normalized(weights: &[f64]) -> Vec<f32> {
    let sum = |sign: f64| weights.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    weights.iter().map(|&w| if w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) } as f32).collect()
}

fn scaled(weights: &[f64], by: f64) -> Vec<f32> {
    weights.iter().map(|w| (w * by) as f32).collect()
}

impl Appearance {
    /// Of `rgb`, of that width, made linear and brought to [0, 1] by `linear`.
    pub fn new(
        rgb: &[[f32; 3]],
        width: usize,
        filters: &Filters,
        linear: impl Fn([f32; 3]) -> [f32; 3] + Sync,
    ) -> Self {
        let [mut y, mut cx, mut cz] = [(); 3].map(|()| vec![0.0_f32; rgb.len()]);
        (y.par_iter_mut(), cx.par_iter_mut(), cz.par_iter_mut(), rgb.par_iter())
            .into_par_iter()
            .for_each(|(y, cx, cz, rgb)| [*y, *cx, *cz] = opponents(linear(*rgb)));
        let [edge, point] = features(&y, width, filters);
        let blurred = |plane: &[f32], index: usize| {
            let weights = &filters.sensitivity[index];
            along_columns(&along_rows(plane, width, weights), width, weights)
        };
        // Each plane is dropped once the next one has been computed from it.
        y = blurred(&y, 0);
        cx = blurred(&cx, 1);
        let cz_narrow = blurred(&cz, 2);
        cz = blurred(&cz, 3);
        let color = |pixel: usize| {
            let rgb = rgb_from_opponents([y[pixel], cx[pixel], cz_narrow[pixel] + cz[pixel]]);
            lab(rgb.map(|component| component.clamp(0.0, 1.0)))
        };
        Self { lab: (0..rgb.len()).into_par_iter().map(color).collect(), edge, point }
    }
}

/// Edge and point strength of a lightness plane.
fn features(y: &[f32], width: usize, filters: &Filters) -> [Vec<f32>; 2] {
    let lightness: Vec<f32> = y.par_iter().map(|y| (y + 16.0) / 116.0).collect();
    let of = |derivative: &[f32]| -> Vec<f32> {
        let smooth = &filters.gaussian;
        let across = along_columns(&along_rows(&lightness, width, derivative), width, smooth);
        let down = along_columns(&along_rows(&lightness, width, smooth), width, derivative);
        across.par_iter().zip(&down).map(|(a, b)| (a * a + b * b).sqrt()).collect()
    };
    [of(&filters.first), of(&filters.second)]
}

/// Convolution along rows; pixels beyond an edge are as those at it.
fn along_rows(plane: &[f32], width: usize, weights: &[f32]) -> Vec<f32> {
    let radius = weights.len() / 2;
    let mut result = vec![0.0; plane.len()];
    let rows = result.par_chunks_mut(width).zip(plane.par_chunks(width));
    rows.for_each_init(Vec::new, |padded: &mut Vec<f32>, (result, row)| {
        padded.clear();
        padded.extend(std::iter::repeat_n(row[0], radius));
        padded.extend_from_slice(row);
        padded.extend(std::iter::repeat_n(row[width - 1], radius));
        for (shift, &weight) in weights.iter().enumerate() {
            add_scaled(result, &padded[shift..shift + width], weight);
        }
    });
    result
}

/// The same along columns.
fn along_columns(plane: &[f32], width: usize, weights: &[f32]) -> Vec<f32> {
    let (radius, last) = (weights.len() / 2, plane.len() / width - 1);
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(row, result)| {
        for (shift, &weight) in weights.iter().enumerate() {
            let from = (row + shift).saturating_sub(radius).min(last);
            add_scaled(result, &plane[from * width..][..width], weight);
        }
    });
    result
}

/// A row at a time, which compilers make vector instructions of.
#[inline]
fn add_scaled(to: &mut [f32], values: &[f32], weight: f32) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to += weight * value);
}

fn product(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// YCxCz, which is CIELAB without its roots: lightness, red–green, blue–yellow.
fn opponents(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = product(&XYZ_FROM_RGB, rgb.map(f64::from));
    let [x, y, z] = [0, 1, 2].map(|i| xyz[i] / WHITE[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|component| component as f32)
}

fn rgb_from_opponents(opponents: [f32; 3]) -> [f32; 3] {
    let [l, cx, cz] = opponents.map(f64::from);
    let y = (l + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    product(&RGB_FROM_XYZ, [0, 1, 2].map(|i| relative[i] * WHITE[i])).map(|component| component as f32)
}

/// CIELAB of a linear colour, its chroma weakened in proportion to lightness, after Hunt.
pub(super) fn lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let xyz = product(&XYZ_FROM_RGB, rgb.map(f64::from));
    let root = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = [0, 1, 2].map(|i| root(xyz[i] / WHITE[i]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
        .map(|component| component as f32)
}
