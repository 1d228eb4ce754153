//! Smoothing of noise for display: the edge-avoiding à-trous wavelet transform (Dammertz et al. 2010), where differences count against the
//! noise that is estimated at each pixel, as in SVGF (Schied et al. 2017). With more samples there is less noise, so less is smoothed, and
//! in the end nothing.
//!
//! The filter takes detail finer than its noise for noise. So its result counts, at each place, only by what it is estimated to gain there: noise
//! against what it has moved the image by beyond that noise.
//!
//! What comes of it is biased: it is to be looked at and not to be measured.

use rayon::prelude::*;

use super::film::Film;
use super::noise::Noise;
use crate::color::luminance;

/// Passes; the taps of each are twice as far apart as those of the one before.
const PASSES: u32 = 4;
/// Differences in luminance of so many standard deviations are taken for edges.
const DEVIATIONS: f32 = 3.0;
/// Variance as a part of what two halves of the samples say: where the second half fills the gaps of the first, they differ by more than the
/// mean of both is wrong by.
const OF_HALVES: f32 = 0.5;
/// B3 spline from the middle outward.
const KERNEL: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];
/// Pixels to each side over which estimates of variance are averaged: each comes of two numbers only.
const VARIANCE_REACH: i64 = 3;

/// An image of linear RGB without much of its noise. `variances` are those of each pixel's luminance; rows have `width` pixels. An image of
/// another size than its variances stays as it is.
pub fn denoised(rgb: &[[f32; 3]], width: usize, variances: &[f32]) -> Vec<[f32; 3]> {
    if width == 0 || variances.len() != rgb.len() || !rgb.len().is_multiple_of(width) {
        return rgb.to_vec();
    }
    let noise = averaged(variances, width);
    let (mut pixels, mut variances) = (rgb.to_vec(), noise.clone());
    for pass in 0..PASSES {
        let step = 1_i64 << pass;
        let luminances: Vec<f32> = pixels.par_iter().map(|pixel| luminance(*pixel)).collect();
        let (next, next_variances) = (0..pixels.len())
            .into_par_iter()
            .map(|pixel| smoothed(&pixels, &luminances, &variances, width, pixel, step))
            .unzip();
        (pixels, variances) = (next, next_variances);
    }
    let moved: Vec<f32> =
        pixels.par_iter().zip(rgb).map(|(now, before)| (luminance(*now) - luminance(*before)).powi(2)).collect();
    let moved = averaged(&moved, width);
    (pixels.par_iter().zip(rgb).zip(noise.par_iter().zip(&moved)))
        .map(|((smooth, noisy), (noise, moved))| mixed(*smooth, *noisy, share_of_smooth(*noise, *moved)))
        .collect()
}

/// The share that the filtered image gets where its square difference from the noisy one is `moved` and that one's variance is `noise`, both means
/// around the place: it leaves the least expected error. What moves more than the noise explains is bias.
fn share_of_smooth(noise: f32, moved: f32) -> f32 {
    let noise = OF_HALVES * noise;
    let squared_bias = (moved - noise).max(0.0);
    if noise > 0.0 { noise / (noise + squared_bias) } else { 0.0 }
}

fn mixed(a: [f32; 3], b: [f32; 3], share_of_a: f32) -> [f32; 3] {
    std::array::from_fn(|c| b[c] + share_of_a * (a[c] - b[c]))
}

/// The pixel and its variance after one pass.
fn smoothed(
    pixels: &[[f32; 3]],
    luminances: &[f32],
    variances: &[f32],
    width: usize,
    pixel: usize,
    step: i64,
) -> ([f32; 3], f32) {
    let own = luminances[pixel];
    let tolerance = DEVIATIONS * variances[pixel].max(0.0).sqrt() + f32::MIN_POSITIVE;
    if !own.is_finite() || !tolerance.is_finite() {
        return (pixels[pixel], variances[pixel]);
    }
    let height = (pixels.len() / width) as i64;
    let (x, y) = ((pixel % width) as i64, (pixel / width) as i64);
    let (mut sum, mut weights, mut variance) = ([0.0_f32; 3], 0.0_f32, 0.0_f32);
    for dy in -2..=2_i64 {
        for dx in -2..=2_i64 {
            let (nx, ny) = (x + dx * step, y + dy * step);
            if nx < 0 || ny < 0 || nx >= width as i64 || ny >= height {
                continue;
            }
            let at = ny as usize * width + nx as usize;
            let difference = (luminances[at] - own).abs();
            if !difference.is_finite() {
                continue;
            }
            let weight = KERNEL[dx.unsigned_abs() as usize]
                * KERNEL[dy.unsigned_abs() as usize]
                * (-difference / tolerance).exp();
            sum.iter_mut().zip(pixels[at]).for_each(|(sum, value)| *sum += weight * value);
            weights += weight;
            variance += weight * weight * variances[at];
        }
    }
    (sum.map(|value| value / weights), variance / (weights * weights))
}

/// Means over a square around each pixel.
fn averaged(values: &[f32], width: usize) -> Vec<f32> {
    let mean = |values: &mut dyn Iterator<Item = f32>| {
        let (sum, count) = values.filter(|x| x.is_finite()).fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
        sum / count.max(1) as f32
    };
    let window = |at: usize, size: usize| {
        let low = (at as i64 - VARIANCE_REACH).max(0) as usize;
        low..(at + VARIANCE_REACH as usize + 1).min(size)
    };
    let across: Vec<f32> = (values.par_chunks(width))
        .flat_map_iter(|row| (0..width).map(|x| mean(&mut row[window(x, width)].iter().copied())))
        .collect();
    let height = values.len() / width;
    (0..values.len())
        .into_par_iter()
        .map(|pixel| {
            let (x, y) = (pixel % width, pixel / width);
            mean(&mut window(y, height).map(|y| across[y * width + x]))
        })
        .collect()
}

/// Variances of the luminance of each pixel's mean, where they are known.
pub fn variances(film: &Film, noise: &Noise) -> Option<Vec<f32>> {
    let (at, squares) = noise.squares()?;
    let scale = at as f32 / film.samples.max(at) as f32;
    Some(squares.iter().map(|square| scale * square).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::render::{ImageSettings, RenderTask};
    use crate::scene::camera::Camera;
    use crate::tracking::{Mode, prepare};

    const SIZE: [u32; 2] = [64, 40];

    fn error(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
        let of_pixel = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((luminance(*a) - luminance(*b)).powi(2));
        a.iter().zip(b).map(of_pixel).sum::<f64>() / a.len() as f64
    }

    /// Against a far better image: of a scene with large even areas, and of one whose pixels hold more detail than that.
    #[test]
    fn noise_goes_and_the_picture_stays() {
        noise_goes("nested-spheres", 0.5, 0.8);
        noise_goes("iced-water", 0.75, 1.0);
    }

    /// The ratio of square errors with and without the filter is below `at_4` and `at_32` with so many samples.
    fn noise_goes(scene: &str, at_4: f64, at_32: f64) {
        let description = Arc::new(crate::formats::open(scene).unwrap());
        let camera = Camera::new(&description.camera).unwrap();
        let prepared = prepare(description, None).unwrap();
        let rendered = |seed: u64, samples: u32| {
            let settings = ImageSettings { max_depth: Some(12), ..ImageSettings::new(Mode::Rectified, seed) };
            let task = RenderTask { prepared: &prepared, camera: &camera, settings: &settings };
            let (mut film, mut noise) = (Film::new(SIZE[0], SIZE[1]), Noise::default());
            while film.samples < samples {
                let some = Noise::samples_to_look(&film);
                assert!(task.pass(&mut film, some, &AtomicBool::new(false)));
                noise.look(&film);
            }
            (film, noise)
        };
        let truth = rendered(9, 128).0.to_rgb();
        for (samples, most) in [(4, at_4), (32, at_32)] {
            let (film, noise) = rendered(1, samples);
            let noisy = film.to_rgb();
            let smooth = denoised(&noisy, SIZE[0] as usize, &variances(&film, &noise).unwrap());
            let ratio = error(&smooth, &truth) / error(&noisy, &truth);
            assert!(ratio < most, "{scene}, {samples} samples: {ratio}");
        }
    }

    #[test]
    fn without_noise_nothing_changes_and_what_is_not_finite_does_not_spread() {
        let image: Vec<[f32; 3]> = (0..60).map(|i| [(i * 37 % 11) as f32; 3]).collect();
        assert_eq!(denoised(&image, 10, &[0.0; 60]), image);
        assert_eq!(denoised(&image, 7, &[1.0; 60]), image, "no such width");
        let mut broken = image.clone();
        broken[33] = [f32::NAN; 3];
        let smooth = denoised(&broken, 10, &[4.0; 60]);
        assert!(smooth.iter().enumerate().all(|(at, pixel)| pixel[0].is_nan() == (at == 33)));
    }
}
