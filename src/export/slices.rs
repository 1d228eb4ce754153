//! Slices with their legends, side by side on one sheet.

use image::RgbImage;

use super::canvas::Color;
use super::surfaces::{Sheet, sheet};
use crate::render::slice::Slice;
use crate::tracking::Prepared;

/// A sheet with every slice, its mode as a title, and under it what the colours mean. Empty without slices.
pub fn slices(prepared: &Prepared, slices: &[&Slice]) -> RgbImage {
    let sheets: Vec<Sheet> = slices
        .iter()
        .map(|slice| {
            let mut inks: Vec<_> = slice.seen.iter().map(|(ink, _)| *ink).collect();
            inks.sort_unstable();
            let mut legend: Vec<(Option<Color>, String)> =
                inks.into_iter().map(|ink| (Some(ink.color()), ink.label(prepared))).collect();
            legend.push((None, slice.doubt_in_words()));
            Sheet {
                title: format!("slice: {}", slice.mode.name()),
                size: slice.size,
                pixels: slice.pixels.clone(),
                legend,
            }
        })
        .collect();
    sheet(&sheets)
}
