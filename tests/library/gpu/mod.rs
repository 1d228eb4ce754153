//! The graphics processor against the CPU: functions one by one, images at equal seeds, images in the mean; and faults planted in each shader module, which
//! these comparisons must find.
//!
//! On a machine without a graphics processor Mesa's llvmpipe does. Where there is neither, a test fails if the environment variable CI is set, and else
//! says that it is skipped. `--nocapture` shows by how much images differ.

#![allow(clippy::print_stderr, reason = "they say what is skipped, and by how much images differ")]

mod faults;
mod lookups;
mod parity;
mod probes;

use std::path::Path;
use std::sync::Arc;

use iorect::formats;
use iorect::render::gpu::{GpuDevice, GpuFault};
use iorect::render::{Backend, Film, GPU_MODES as MODES, ImageSettings, RenderTask};
use iorect::scene::camera::Camera;
use iorect::scene::description::Description;
use iorect::tracking::{Mode, Prepared};

use crate::common::ready;

fn device() -> Option<Arc<GpuDevice>> {
    match GpuDevice::shared() {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("CI").is_some() => panic!("no device to test on: {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

fn settings(mode: Mode, seed: u64) -> ImageSettings {
    ImageSettings { splits: 0, backend: Backend::Gpu, ..ImageSettings::new(mode, seed) }
}

/// A scene in which every module of the shaders has something to do: spheres and meshes that nest, overlap and share faces, smooth and flat; absorption; a
/// mirror, a checkerboard, an image; lights of every kind and an image all around; a lens.
fn workshop() -> Description {
    const TEXT: &str = r#"
        camera = { position = [0.4, 1.3, 4.6], target = [0.0, -0.1, 0.0], vertical_fov = 38.0, aperture_radius = 0.02 }
        world = { ior = 1.0 }
        medium = [
            { name = "water", ior = 1.333, absorption = [0.4, 0.1, 0.05] },
            { name = "glass", ior = 1.5 },
            { name = "air", ior = 1.0 },
        ]
        [[refractor]]
        name = "pool"
        medium = "water"
        shape = { box = { min = [-1.3, -0.8, -0.9], max = [1.1, 0.0, 0.9] } }
        [[refractor]]
        name = "ball"
        medium = "glass"
        priority = 1
        shape = { sphere = { center = [-0.55, 0.06, 0.2], radius = 0.45 } }
        [[refractor]]
        name = "bubble"
        medium = "air"
        priority = 2
        shape = { sphere = { center = [-0.5, 0.1, 0.25], radius = 0.2 } }
        [[refractor]]
        name = "rod"
        medium = "glass"
        priority = 1
        smooth = true
        shape = { cylinder = { center = [0.0, 0.0, 0.0], radius = 0.14, height = 1.7, segments = 24 } }
        transform = { rotate = [12.0, 0.0, -30.0], translate = [0.55, 0.1, 0.3] }
        [[refractor]]
        name = "block"
        medium = "glass"
        shape = { box = { min = [-0.2, 0.0, -0.7], max = [0.5, 0.4, -0.1] } }
        [[solid]]
        name = "floor"
        shape = { quad = { center = [0.0, -0.85, 0.0], edge_u = [0.0, 0.0, 6.0], edge_v = [6.0, 0.0, 0.0] } }
        checker = { a = [0.8, 0.7, 0.6], b = [0.2, 0.3, 0.4], size = 0.4 }
        [[solid]]
        name = "mirror"
        mirror = true
        color = [0.9, 0.9, 0.8]
        shape = { box = { min = [-2.4, -0.8, -1.9], max = [2.4, 1.4, -1.8] } }
        [[solid]]
        name = "berry"
        smooth = true
        texture = "assets/thumbnails/iced-water.png"
        tint = [1.0, 0.4, 0.3]
        shape = { icosphere = { center = [1.5, -0.45, 0.5], radius = 0.38, subdivisions = 2 } }
        [[light]]
        name = "panel"
        radiance = [5.0, 4.5, 4.0]
        two_sided = true
        shape = { quad = { center = [0.6, 2.4, 0.6], edge_u = [1.0, 0.0, 0.0], edge_v = [0.0, 0.0, 1.0] } }
        [[light]]
        name = "bulb"
        radiance = [9.0, 8.0, 6.0]
        shape = { sphere = { center = [-1.7, 0.5, 0.7], radius = 0.18 } }
        [[light]]
        name = "spark"
        point = { position = [1.3, 0.7, 1.1] }
        intensity = [0.8, 0.9, 1.0]
        [[light]]
        name = "spot"
        spot = { position = [1.8, 0.9, 1.6], target = [1.6, -0.85, 1.4], inner_angle = 15.0, outer_angle = 50.0 }
        power = [6.0, 8.0, 9.0]
        [[light]]
        name = "sun"
        directional = { direction = [-0.3, -1.0, -0.6], angle = 20.0 }
        irradiance = [0.4, 0.3, 0.2]
        [[light]]
        name = "star"
        directional = { direction = [0.8, -1.0, -0.2] }
        irradiance = [0.1, 0.2, 0.3]
    "#;
    let mut description = formats::parse(TEXT, Path::new("workshop.toml"), &formats::Disk).unwrap();
    description.environment = formats::open("half-submerged").unwrap().environment;
    description
}

/// A scene that is ready, with the camera it is seen by.
struct Subject {
    prepared: Prepared,
    camera: Camera,
}

impl Subject {
    fn new(description: Description) -> Self {
        let camera = Camera::new(&description.camera).unwrap();
        Self { prepared: ready(description), camera }
    }

    fn builtin(name: &str) -> Self {
        Self::new(formats::open(name).unwrap())
    }

    fn task<'a>(&'a self, settings: &'a ImageSettings) -> RenderTask<'a> {
        RenderTask { prepared: &self.prepared, camera: &self.camera, settings }
    }
}

/// Fails unless nothing went wrong.
fn fine<T>(result: Result<T, GpuFault>) -> T {
    result.unwrap_or_else(|fault| panic!("{fault}"))
}

fn floats(words: &[u32]) -> Vec<f64> {
    words.iter().map(|bits| f64::from(f32::from_bits(*bits))).collect()
}

/// How an image of the graphics processor differs from the CPU's at the same seed.
#[derive(Debug, Clone, Copy)]
struct Difference {
    /// Share of the pixels that differ by more than a thousandth, relative to the brighter channel: some of their paths went other ways.
    parted: f64,
    /// The largest relative difference of the others.
    rounding: f64,
    /// Relative difference of the means over all pixels.
    mean: f64,
}

impl Difference {
    fn between(cpu: &Film, gpu: &Film) -> Self {
        let (mut parted, mut rounding) = (0, 0.0_f64);
        let (mut sum, mut other_sum) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
        for pixel in 0..cpu.sums.len() {
            let (a, b) = (cpu.mean(pixel), gpu.mean(pixel));
            sum += a;
            other_sum += b;
            let relative = (a - b).abs().max_element() / (a.max(b).max_element() + 1e-3);
            // Also where it is no number.
            if relative <= 1e-3 {
                rounding = rounding.max(relative);
            } else {
                parted += 1;
            }
        }
        let mean = ((sum - other_sum).abs() / sum).max_element();
        Self { parted: f64::from(parted) / cpu.sums.len() as f64, rounding, mean }
    }
}
