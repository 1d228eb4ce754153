//! Enlarging of coarse previews, so that no blocks are seen: by cubic B-splines, which ring nowhere and smooth noise (Unser 1999). Works on
//! pixels as they are displayed, where steps are even to the eye.

use egui::{Color32, ColorImage};
use rayon::prelude::*;

/// A graphics card enlarges the rest, linearly.
const LEFT_TO_THE_CARD: usize = 2;

/// `image`, enlarged to half the size `full` if it is smaller than that.
pub fn enlarged(image: ColorImage, full: [u32; 2]) -> ColorImage {
    let size = full.map(|side| (side as usize / LEFT_TO_THE_CARD).max(1));
    let [width, height] = image.size;
    if width == 0 || height == 0 || width >= size[0] || height >= size[1] {
        return image;
    }
    let [across, down] = [0, 1].map(|side| taps(image.size[side], size[side]));
    // Rows first, then columns.
    let pixel = |color: Color32| [color.r(), color.g(), color.b()].map(f32::from);
    let wide: Vec<[f32; 3]> = image
        .pixels
        .par_chunks(width)
        .flat_map_iter(|row| across.iter().map(|tap| tap.mix(|column| pixel(row[column]))))
        .collect();
    let rows = down.par_iter();
    let pixels = rows.flat_map_iter(|tap| {
        (0..size[0]).map(|column| {
            let [r, g, b] = tap.mix(|row| wide[row * size[0] + column]).map(|x| x.round() as u8);
            Color32::from_rgb(r, g, b)
        })
    });
    ColorImage::new(size, pixels.collect())
}

/// The four pixels that one of the enlarged picture is made of, along one side.
struct Tap {
    at: [usize; 4],
    weights: [f32; 4],
}

impl Tap {
    fn mix(&self, pixel: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (at, weight) in self.at.iter().zip(self.weights) {
            sum.iter_mut().zip(pixel(*at)).for_each(|(sum, x)| *sum += weight * x);
        }
        sum
    }
}

fn taps(from: usize, to: usize) -> Vec<Tap> {
    let tap = |index: usize| {
        let place = (index as f32 + 0.5) * from as f32 / to as f32 - 0.5;
        let t = place - place.floor();
        let first = place.floor() as i64 - 1;
        let at = [0, 1, 2, 3].map(|k| (first + k).clamp(0, from as i64 - 1) as usize);
        let u = 1.0 - t;
        let weights = [u.powi(3), 3.0 * t.powi(3) - 6.0 * t * t + 4.0, 3.0 * u.powi(3) - 6.0 * u * u + 4.0, t.powi(3)];
        Tap { at, weights: weights.map(|weight| weight / 6.0) }
    };
    (0..to).map(tap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_colours_and_ramps_stay_and_steps_become_smooth() {
        let plain = ColorImage::filled([5, 4], Color32::from_rgb(10, 200, 77));
        let large = enlarged(plain, [100, 80]);
        assert_eq!(large.size, [50, 40]);
        assert!(large.pixels.iter().all(|pixel| *pixel == Color32::from_rgb(10, 200, 77)));
        // A step over 16 pixels: no two neighbours are far apart, none is darker than the one before.
        let step = ColorImage::new([4, 1], [0, 0, 240, 240].map(Color32::from_gray).to_vec());
        let large = enlarged(step, [128, 64]);
        for row in large.pixels.chunks(64) {
            for pair in row.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|pixel| i32::from(pixel.r()));
                assert!((0..24).contains(&(b - a)), "{a} {b}");
            }
        }
    }

    #[test]
    fn what_is_large_enough_stays_as_it_is() {
        let image = ColorImage::filled([50, 40], Color32::WHITE);
        assert_eq!(enlarged(image.clone(), [100, 80]), image);
        assert_eq!(enlarged(ColorImage::filled([1, 1], Color32::RED), [1, 1]).size, [1, 1]);
    }
}
