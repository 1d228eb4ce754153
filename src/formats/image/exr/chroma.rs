//! Colours from luminance and chroma.
//!
//! As the OpenEXR library's `ImfRgbaYca`: a pixel has Y = w·(R, G, B), with the weights of its chromaticities, RY = (R − Y) / Y and
//! BY = (B − Y) / Y. Where chroma has only every second sample, those between are filtered from 14 around them, across and down.

use exr::math::Vec2;
use exr::meta::header::Header;
use glam::DVec3;
use rayon::prelude::*;

use super::Windows;
use super::layer::{Colors, Layer};

/// Weights of the samples at distances 1, 3, 5, … from one that is missing (`RgbaYca::reconstructChromaHoriz`).
const TAPS: [f32; 7] = [0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_540, 0.002_128];

/// The planes RY and BY, in the resolution of the file.
pub(super) struct Chroma {
    planes: [Vec<f32>; 2],
    width: usize,
    height: usize,
    /// 1: of every pixel. 2: of every second, each way.
    sampling: usize,
}

/// Planes for the chroma of a layer; `None` if it has none, an error if it is sampled in a way that is not read.
pub(super) fn planes(header: &Header, layer: &Layer) -> Result<Option<Chroma>, String> {
    let Colors::LuminanceChroma { ry, by, .. } = layer.colors else { return Ok(None) };
    let sampling = match [ry, by].map(|index| header.channels.list[index].sampling) {
        [Vec2(1, 1), Vec2(1, 1)] => 1,
        [Vec2(2, 2), Vec2(2, 2)] => 2,
        [Vec2(x, y), _] => {
            return Err(format!(
                "has chroma (RY, BY) of every {x}×{y} pixels; only 1×1 and 2×2 are read: save it in RGB"
            ));
        }
    };
    let (width, height) = (header.layer_size.0 / sampling, header.layer_size.1 / sampling);
    Ok(Some(Chroma { planes: [vec![0.0; width * height], vec![0.0; width * height]], width, height, sampling }))
}

impl Chroma {
    /// Samples of a row of the data window that has some.
    pub fn row_mut(&mut self, plane: usize, data_row: usize) -> &mut [f32] {
        &mut self.planes[plane][data_row / self.sampling * self.width..][..self.width]
    }

    /// Colours pixels that have their luminance in the second component.
    pub fn add_to(&self, pixels: &mut [[f32; 3]], windows: &Windows, weights: DVec3) {
        let columns = windows.columns();
        pixels.par_chunks_mut(windows.width).enumerate().for_each(|(row, pixels)| {
            let data_row = row as i64 - windows.top;
            if !(0..windows.data_height as i64).contains(&data_row) {
                return;
            }
            let lines = [0, 1].map(|plane| self.line(plane, data_row as usize));
            for column in columns.clone() {
                let chroma = lines.each_ref().map(|line| self.sample(line, column));
                let pixel = &mut pixels[windows.column(column)];
                *pixel = color(pixel[1], chroma, weights);
            }
        });
    }

    /// The samples of a plane at a row of the data window.
    fn line(&self, plane: usize, data_row: usize) -> Vec<f32> {
        let row = |index: usize| &self.planes[plane][index * self.width..][..self.width];
        let above = data_row / self.sampling;
        if data_row.is_multiple_of(self.sampling) {
            return row(above).to_vec();
        }
        (0..self.width).map(|column| between(above, self.height, |index| row(index)[column])).collect()
    }

    fn sample(&self, line: &[f32], column: usize) -> f32 {
        let left = column / self.sampling;
        if column.is_multiple_of(self.sampling) { line[left] } else { between(left, self.width, |index| line[index]) }
    }
}

/// Halfway between samples `at` and `at` + 1 of `count`. Those beyond the ends are as the last.
fn between(at: usize, count: usize, sample: impl Fn(usize) -> f32) -> f32 {
    let pair = |(distance, weight): (usize, &f32)| {
        let (before, after) = (at.saturating_sub(distance), (at + 1 + distance).min(count - 1));
        weight * (sample(before) + sample(after))
    };
    TAPS.iter().enumerate().map(pair).sum()
}

fn color(y: f32, [ry, by]: [f32; 2], weights: DVec3) -> [f32; 3] {
    // Grey, exactly.
    if ry == 0.0 && by == 0.0 {
        return [y; 3];
    }
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    let g = (f64::from(y) - weights.x * f64::from(r) - weights.z * f64::from(b)) / weights.y;
    [r, g as f32, b]
}
