//! Painted surfaces with their legends, side by side on one sheet.

use image::RgbImage;

use super::canvas::{Align, Canvas, Color};
use super::comparison::{INK, MUTED, SHEET, zoom_for};
use crate::render::surfaces::{Painting, SurfaceQuantity, Tint, confidence_color};
use crate::tracking::Prepared;

/// Entries of a legend at the most; the rest is counted.
const MOST_ENTRIES: usize = 24;

/// A picture with a title above and a legend below.
pub(super) struct Sheet {
    pub title: String,
    pub size: [u32; 2],
    /// sRGB, row 0 at the top.
    pub pixels: Vec<Color>,
    pub legend: Vec<(Option<Color>, String)>,
}

/// A sheet with every painting, its quantity as a title, and under it what the colours mean. Empty without paintings.
pub fn painted_surfaces(prepared: &Prepared, paintings: &[(SurfaceQuantity, &Painting)]) -> RgbImage {
    let sheets: Vec<Sheet> = paintings
        .iter()
        .map(|(quantity, painting)| Sheet {
            title: quantity.name().to_owned(),
            size: [painting.width, painting.height],
            pixels: painting.pixels().collect(),
            legend: legend(prepared, *quantity, painting),
        })
        .collect();
    sheet(&sheets)
}

/// Pictures side by side. Empty without any.
pub(super) fn sheet(sheets: &[Sheet]) -> RgbImage {
    let Some(first) = sheets.first() else { return RgbImage::new(0, 0) };
    let zoom = zoom_for(first.size[0].max(1));
    let pane = first.size[0] * zoom;
    let text = (pane as f32 / 27.0).clamp(13.0, 40.0);
    let margin = (text * 1.5).round() as u32;
    let line = (text * 1.45).round() as u32;
    let rows = sheets.iter().map(|sheet| sheet.legend.len()).max().unwrap_or(0) as u32;
    let top = margin + 2 * line;
    let tallest = sheets.iter().map(|sheet| sheet.size[1] * zoom).max().unwrap_or(0);
    let width = sheets.len() as u32 * (pane + margin) + margin;
    let mut canvas = Canvas::new(width, top + tallest + margin / 2 + rows * line + margin, SHEET);
    for (index, sheet) in sheets.iter().enumerate() {
        let left = margin + index as u32 * (pane + margin);
        let baseline = (margin + line) as f32;
        canvas.text(&sheet.title, left as f32, baseline, Align::Left, text * 1.25, INK);
        let [width, height] = sheet.size;
        let at = |x: u32, y: u32| sheet.pixels[(y * width + x) as usize];
        canvas.paint(left, top, width, height, zoom, at);
        let mut y = top + tallest + margin / 2;
        for (color, words) in &sheet.legend {
            let side = (text * 0.8).round() as u32;
            let indent = if let Some(color) = color {
                canvas.fill(left, y + (line - side) / 2, side, side, *color);
                side + margin / 2
            } else {
                0
            };
            let words = canvas.fitted(words, text, (pane - indent) as f32);
            let baseline = y as f32 + 0.5 * line as f32 + 0.35 * text;
            canvas.text(&words, (left + indent) as f32, baseline, Align::Left, text, MUTED);
            y += line;
        }
    }
    canvas.image
}

fn legend(prepared: &Prepared, quantity: SurfaceQuantity, painting: &Painting) -> Vec<(Option<Color>, String)> {
    if quantity == SurfaceQuantity::Confidence {
        let seen = painting.seen.iter().filter_map(|(tint, _)| match tint {
            Tint::Confidence(percent) => Some(*percent),
            _ => None,
        });
        let mut scale: Vec<(Option<Color>, String)> = [50_u8, 75, 100]
            .map(|percent| {
                (Some(confidence_color((f32::from(percent) - 50.0) / 50.0)), format!("{percent} % of the rays agree"))
            })
            .into();
        scale.extend(seen.min().map(|least| (None, format!("least in sight: {least} %"))));
        return scale;
    }
    let mut tints: Vec<Tint> = painting.seen.iter().take(MOST_ENTRIES).map(|(tint, _)| *tint).collect();
    tints.sort_unstable();
    let mut entries: Vec<_> = tints.iter().map(|tint| (Some(tint.color()), tint.label(prepared))).collect();
    if painting.seen.len() > MOST_ENTRIES {
        entries.push((None, format!("and {} more", painting.seen.len() - MOST_ENTRIES)));
    }
    entries
}
