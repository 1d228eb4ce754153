//! Environment images of other renderers as they are here: by latitude and longitude, upright, whatever layout and turn the file has.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Importer;
use crate::scene::Place;
use crate::scene::description::Environment;
use crate::scene::environment::EnvironmentImage;
use crate::scene::equal_area;

/// How an image is laid out over directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// The square of pbrt-v4.
    EqualArea,
    /// Mitsuba's latitude and longitude: y up, −z at both ends of a row.
    Upright,
    /// That of older versions of pbrt: z up, a row from +x by +y.
    Lying,
}

/// Rows of what comes out, and the most of them.
const ROWS: std::ops::RangeInclusive<usize> = 256..=2048;
/// Places along each side of a pixel at which the file's image is looked up.
const PLACES: usize = 3;
/// The same where it holds much of the light: a sun may be one pixel.
const MORE_PLACES: usize = 16;

impl Layout {
    /// The place of a unit direction in [0, 1]².
    fn place(self, d: DVec3) -> [f64; 2] {
        let around = |angle: f64| (angle / TAU).rem_euclid(1.0);
        match self {
            Self::EqualArea => equal_area::place(d),
            Self::Upright => [around(d.x.atan2(-d.z)), d.y.clamp(-1.0, 1.0).acos() / PI],
            Self::Lying => [around(d.y.atan2(d.x)), d.z.clamp(-1.0, 1.0).acos() / PI],
        }
    }

    /// Share of the sphere, not normalised, that pixels of a row of `height` have.
    fn weight(self, row: usize, height: usize) -> f64 {
        match self {
            Self::EqualArea => 1.0,
            Self::Upright | Self::Lying => ((row as f64 + 0.5) / height as f64 * PI).sin(),
        }
    }

    /// The pixel beside the edges that a column and a row are, which may lie one beyond them.
    fn neighbour(self, [x, y]: [i64; 2], [width, height]: [i64; 2]) -> usize {
        let [x, y] = match self {
            // Each edge is folded onto itself about its middle.
            Self::EqualArea if x < 0 || x >= width => [x.clamp(0, width - 1), height - 1 - y],
            Self::EqualArea if y < 0 || y >= height => [width - 1 - x, y.clamp(0, height - 1)],
            _ => [x.rem_euclid(width), y],
        };
        (y.clamp(0, height - 1) * width + x) as usize
    }
}

impl EnvironmentImage {
    /// The image by latitude and longitude, where `layout` is that of this one, and `local_from_scene` leads from directions of the scene to
    /// those of the image. Each pixel is a mean over its solid angle.
    pub fn upright(&self, layout: Layout, local_from_scene: DMat3) -> Self {
        let source = self.without_slivers(layout);
        let size = [self.width, self.height];
        let height = self.height.clamp(*ROWS.start(), *ROWS.end());
        let width = 2 * height;
        let lookup = |direction: DVec3| {
            let place = layout.place((local_from_scene * direction).normalize_or(DVec3::Y));
            let [x, y] = [0, 1].map(|k| ((place[k] * size[k] as f64) as usize).min(size[k] - 1));
            y * self.width + x
        };
        let (contrast, mean) = source.contrasts(layout);
        // A pixel of what comes out may cover several.
        let more = MORE_PLACES * self.height.div_ceil(height);
        let pixel = |x: usize, y: usize| {
            // Heights of the pixel's edges: equal steps between them are equal solid angles.
            let [top, bottom] = [y, y + 1].map(|y| (y as f64 / height as f64 * PI).cos());
            let at = |i: usize, j: usize, places: usize| {
                let along = (i as f64 + 0.5) / places as f64;
                let angle = ((x as f64 + along) / width as f64 - 0.5) * TAU;
                let up = top + (bottom - top) * (j as f64 + 0.5) / places as f64;
                let ring = (1.0 - up * up).max(0.0).sqrt();
                lookup(DVec3::new(ring * angle.sin(), up, -ring * angle.cos()))
            };
            let over = |places: usize| {
                let all = (0..places * places).map(|k| at(k % places, k / places, places));
                let sum =
                    all.fold([0.0; 3], |sum: [f64; 3], k| [0, 1, 2].map(|c| sum[c] + f64::from(source.pixels[k][c])));
                sum.map(|sum| (sum / (places * places) as f64) as f32)
            };
            let is_uneven = (0..PLACES * PLACES).any(|k| contrast[at(k % PLACES, k / PLACES, PLACES)] > mean);
            over(if is_uneven { more } else { PLACES })
        };
        let pixels = (0..width * height).into_par_iter().map(|k| pixel(k % width, k / width)).collect();
        let notes = self.notes.iter().filter(|note| note.kind != "unusual_aspect").cloned().collect();
        Self { width, height, pixels, notes }
    }

    /// The image with pixels near the poles, which are narrow there, made as wide as they are high: each that many of a row have their mean.
    fn without_slivers(&self, layout: Layout) -> Cow<'_, Self> {
        if layout == Layout::EqualArea {
            return Cow::Borrowed(self);
        }
        let mut image = self.clone();
        for (row, pixels) in image.pixels.chunks_mut(self.width.max(1)).enumerate() {
            let together = (1.0 / layout.weight(row, self.height)).floor().clamp(1.0, self.width as f64) as usize;
            for some in pixels.chunks_mut(together) {
                let sum = |c: usize| some.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
                let mean = [0, 1, 2].map(|c| (sum(c) / some.len() as f64) as f32);
                some.fill(mean);
            }
        }
        Cow::Owned(image)
    }

    /// By how much the brightness of each pixel's surroundings differs, and the mean of all.
    fn contrasts(&self, layout: Layout) -> (Vec<f32>, f32) {
        let brightness = |pixel: &[f32; 3]| pixel.iter().sum::<f32>();
        let size = [self.width, self.height].map(|side| side as i64);
        let contrast = |index: usize| {
            let [x, y] = [index % self.width, index / self.width].map(|k| k as i64);
            let around = (0..9).map(|k| layout.neighbour([x + k % 3 - 1, y + k / 3 - 1], size));
            let range = around.map(|k| brightness(&self.pixels[k]));
            let (low, high) = range.fold((f32::INFINITY, 0.0_f32), |(low, high), b| (low.min(b), high.max(b)));
            high - low
        };
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, pixels) in self.pixels.chunks(self.width.max(1)).enumerate() {
            let weight = layout.weight(row, self.height);
            weights += weight * pixels.len() as f64;
            sum += weight * pixels.iter().map(|pixel| f64::from(brightness(pixel))).sum::<f64>();
        }
        ((0..self.pixels.len()).into_par_iter().map(contrast).collect(), (sum / f64::max(weights, 1e-300)) as f32)
    }
}

impl Importer<'_> {
    /// Sets what surrounds the scene. Of several the last counts, which is said.
    pub fn set_environment(&mut self, environment: Environment, place: &Place) {
        if self.environment != Environment::DEFAULT {
            self.note("environment", place, "of several environments the last is taken");
        }
        self.environment = environment;
    }

    /// Sets an image that is in no file as it is: it gets one when the scene is saved.
    pub fn set_environment_image(&mut self, image: EnvironmentImage, scale: f64, place: &Place) {
        let path: PathBuf = self.input.path.file_name().unwrap_or_default().into();
        self.set_environment(Environment::Image { path, image: Arc::new(image), rotation: 0.0, scale }, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn black(width: usize, height: usize) -> EnvironmentImage {
        EnvironmentImage { width, height, pixels: vec![[0.0; 3]; width * height], notes: Vec::new() }
    }

    /// The mean over the sphere.
    fn mean(image: &EnvironmentImage) -> [f64; 3] {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (index, pixel) in image.pixels.iter().enumerate() {
            let row = index / image.width;
            let [top, bottom] = [row, row + 1].map(|row| (row as f64 / image.height as f64 * PI).cos());
            weights += top - bottom;
            (0..3).for_each(|c| sum[c] += (top - bottom) * f64::from(pixel[c]));
        }
        sum.map(|sum| sum / weights)
    }

    /// Whatever the layout, the turn and the place of the sun, each of which is one pixel.
    #[test]
    fn light_is_kept() {
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(2.0) * DMat3::from_rotation_z(-1.1);
        for (layout, width, height) in [
            (Layout::EqualArea, 64, 64),
            (Layout::EqualArea, 300, 300),
            (Layout::Upright, 256, 128),
            (Layout::Lying, 96, 48),
        ] {
            for sun in
                [[0, 0], [width - 1, height / 2], [width / 3, height - 1], [width / 2, height / 2], [7, height / 3]]
            {
                let mut image = black(width, height);
                image
                    .pixels
                    .iter_mut()
                    .zip(0..)
                    .for_each(|(pixel, k)| *pixel = [1.0, (k % 5) as f32, (k / width) as f32]);
                image.pixels[sun[1] * width + sun[0]] = [1e6, 0.0, 1.0];
                let (mut sums, mut weights) = ([0.0; 3], 0.0);
                for (index, pixel) in image.pixels.iter().enumerate() {
                    let row = index / width;
                    let weight = match layout {
                        Layout::EqualArea => 1.0,
                        _ => (row as f64 / height as f64 * PI).cos() - ((row + 1) as f64 / height as f64 * PI).cos(),
                    };
                    weights += weight;
                    (0..3).for_each(|c| sums[c] += weight * f64::from(pixel[c]));
                }
                let found = mean(&image.upright(layout, turn));
                for c in 0..3 {
                    let expected = sums[c] / weights;
                    assert!((found[c] / expected - 1.0).abs() < 0.01, "{layout:?} {sun:?} {c}: {found:?}, {expected}");
                }
            }
        }
    }

    #[test]
    fn even_light_stays_even() {
        let mut image = black(32, 32);
        image.pixels.fill([0.25, 0.5, 1.0]);
        let upright = image.upright(Layout::EqualArea, DMat3::from_rotation_x(1.0));
        assert!(upright.pixels.iter().all(|pixel| *pixel == [0.25, 0.5, 1.0]));
        assert_eq!((upright.width, upright.height), (512, 256));
    }
}
