//! How fast both backends render a scene, and how far their images are apart.

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::Timed;
use crate::render::choice::{KnownAdapter, Work};
use crate::render::{Backend, GPU_MODES, ImageSettings};
use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};

/// Difference of a pixel, relative to its brightness, that rounding does not make.
const ROUNDING: f64 = 1e-3;
/// Added to the brightness, so that black pixels are not divided by.
const DARK: f64 = 1e-3;

/// What is measured, and how long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BackendsPlan {
    /// Of the images whose rendering is timed.
    pub size: [u32; 2],
    /// Of the images that are compared.
    pub compared_size: [u32; 2],
    /// Samples per pixel of the images that are compared.
    pub compared_samples: u32,
    pub seed: u64,
    /// Slices that are timed, and the seconds of each, at least.
    pub slices: usize,
    pub slice_secs: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Backends {
    /// Name and interface of the graphics processor.
    pub adapter: String,
    /// Whether it computes on the CPU.
    pub is_software: bool,
    pub size: [u32; 2],
    /// In the order of [`GPU_MODES`]; modes are left out that it cannot render in this scene.
    pub modes: Vec<ModeBackends>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeBackends {
    pub mode: Mode,
    /// Pixel samples a second, without splits.
    pub cpu: f64,
    pub gpu: f64,
    /// Share of the pixels that differ by more than rounding: with equal random numbers, those whose paths part ways.
    pub parted: f64,
    /// Mean of the graphics processor's image over that of the CPU's.
    pub mean_ratio: f64,
}

/// Measures one scene on the current pool. `None` when cancelled, or when the graphics processor fails.
pub fn measure(
    prepared: &Prepared,
    camera: &Camera,
    adapter: &KnownAdapter,
    plan: &BackendsPlan,
    progress: &Progress<'_>,
) -> Option<Backends> {
    let mut modes = Vec::new();
    for mode in GPU_MODES.into_iter().filter(|mode| *mode != Mode::Declared) {
        let usual = ImageSettings { splits: 0, ..ImageSettings::new(mode, plan.seed) };
        let work = Work { prepared, camera, settings: &[usual], size: plan.size, samples: None };
        if let Err(why) = work.make_ready() {
            log::warn!("{mode} is not measured: {why}");
            continue;
        }
        let by = |backend| ImageSettings { backend, ..usual };
        let image = |backend| {
            let mut timed = Timed::new(prepared, camera, by(backend), plan.compared_size.into());
            timed.slice(plan.compared_samples, progress)?;
            (timed.film.backend == Some(backend)).then(|| timed.film.to_rgb())
        };
        let (parted, mean_ratio) = apart(&image(Backend::Cpu)?, &image(Backend::Gpu)?);
        let rate = |backend| {
            let mut timed = Timed::new(prepared, camera, by(backend), plan.size.into());
            let secs = timed.sample_secs(plan.slices, plan.slice_secs, progress)?;
            (timed.film.backend == Some(backend)).then_some(1.0 / secs)
        };
        modes.push(ModeBackends { mode, cpu: rate(Backend::Cpu)?, gpu: rate(Backend::Gpu)?, parted, mean_ratio });
    }
    let KnownAdapter { label, is_software } = adapter.clone();
    Some(Backends { adapter: label, is_software, size: plan.size, modes })
}

/// The share of pixels that differ by more than rounding, and the ratio of the second image's mean to the first's.
pub fn apart(cpu: &[[f32; 3]], gpu: &[[f32; 3]]) -> (f64, f64) {
    let brightness = |rgb: &[f32; 3]| rgb.iter().map(|x| f64::from(*x)).sum::<f64>() / 3.0;
    let pairs = || cpu.iter().zip(gpu).map(|(cpu, gpu)| (brightness(cpu), brightness(gpu)));
    let parted = pairs().filter(|(cpu, gpu)| (cpu - gpu).abs() > ROUNDING * (cpu.abs() + DARK)).count();
    let (of_cpu, of_gpu) = pairs().fold((0.0, 0.0), |(a, b), (cpu, gpu)| (a + cpu, b + gpu));
    // Two black images agree.
    let mean_ratio = if of_cpu == of_gpu { 1.0 } else { of_gpu / of_cpu };
    (parted as f64 / cpu.len().max(1) as f64, mean_ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_part_are_counted_and_rounding_is_not() {
        let cpu = [[0.5; 3], [0.0; 3], [2.0; 3], [1.0; 3]];
        let mut gpu = cpu;
        gpu[0][1] *= 1.000_1;
        assert_eq!(apart(&cpu, &cpu), (0.0, 1.0));
        assert_eq!(apart(&cpu, &gpu).0, 0.0);
        gpu[1] = [0.1; 3];
        gpu[3][2] = 0.9;
        let (parted, ratio) = apart(&cpu, &gpu);
        assert_eq!(parted, 0.5);
        assert!(ratio > 1.01 && ratio < 1.03, "{ratio}");
    }
}
