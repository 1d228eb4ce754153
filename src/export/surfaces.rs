//! Painted surfaces with their legends, side by side on one sheet.

use image::RgbImage;

use super::canvas::{Align, Canvas, Color};
use super::comparison::{INK, MUTED, SHEET, zoom_for};
use crate::render::surfaces::{Painting, SurfaceQuantity, Tint, confidence_color};
use crate::tracking::Prepared;

/// Entries of a legend at the most; the rest is counted.
const MOST_ENTRIES: usize = 24;

/// A sheet with every painting, its quantity as a title, and under it what the colours mean. Empty without paintings.
pub fn painted_surfaces(prepared: &Prepared, paintings: &[(SurfaceQuantity, &Painting)]) -> RgbImage {
    let Some((_, first)) = paintings.first() else { return RgbImage::new(0, 0) };
    let zoom = zoom_for(first.width.max(1));
    let pane = first.width * zoom;
    let text = (pane as f32 / 27.0).clamp(13.0, 40.0);
    let margin = (text * 1.5).round() as u32;
    let line = (text * 1.45).round() as u32;
    let legends: Vec<Vec<(Option<Color>, String)>> =
        paintings.iter().map(|(quantity, painting)| legend(prepared, *quantity, painting)).collect();
    let rows = legends.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let top = margin + 2 * line;
    let tallest = paintings.iter().map(|(_, painting)| painting.height * zoom).max().unwrap_or(0);
    let width = paintings.len() as u32 * (pane + margin) + margin;
    let mut canvas = Canvas::new(width, top + tallest + margin / 2 + rows * line + margin, SHEET);
    for (index, ((quantity, painting), legend)) in paintings.iter().zip(&legends).enumerate() {
        let left = margin + index as u32 * (pane + margin);
        let baseline = (margin + line) as f32;
        canvas.text(quantity.name(), left as f32, baseline, Align::Left, text * 1.25, INK);
        let pixels: Vec<Color> = painting.pixels().collect();
        let at = |x: u32, y: u32| pixels[(y * painting.width + x) as usize];
        canvas.paint(left, top, painting.width, painting.height, zoom, at);
        let mut y = top + tallest + margin / 2;
        for (color, words) in legend {
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
