//! A sheet to lay pictures and text out on.

use ab_glyph::{Font, FontRef, Glyph, ScaleFont, point};
use image::{Rgb, RgbImage};

use super::escape::escaped;

/// An sRGB colour.
pub type Color = [u8; 3];

/// A sheet of pixels with a typeface.
pub struct Canvas {
    pub image: RgbImage,
    font: FontRef<'static>,
}

/// Which end of a text stands at the given x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Center,
    Right,
}

impl Canvas {
    pub fn new(width: u32, height: u32, background: Color) -> Self {
        // Ubuntu Light, the typeface of the window, from the crate that the window takes it from.
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("the bundled font is sound");
        Self { image: RgbImage::from_pixel(width, height, Rgb(background)), font }
    }

    /// Fills a rectangle; what lies outside the sheet is cut off.
    pub fn fill(&mut self, x: u32, y: u32, width: u32, height: u32, color: Color) {
        for y in y..(y + height).min(self.image.height()) {
            for x in x..(x + width).min(self.image.width()) {
                self.image.put_pixel(x, y, Rgb(color));
            }
        }
    }

    /// Draws `width` × `height` pixels at (x, y), each enlarged to `zoom` × `zoom`.
    pub fn paint(&mut self, x: u32, y: u32, width: u32, height: u32, zoom: u32, pixel: impl Fn(u32, u32) -> Color) {
        for row in 0..height {
            for column in 0..width {
                self.fill(x + column * zoom, y + row * zoom, zoom, zoom, pixel(column, row));
            }
        }
    }

    /// Width of `text` in pixels at `size` pixels per em line.
    pub fn text_width(&self, text: &str, size: f32) -> f32 {
        self.set(text, size).1
    }

    /// Writes `text` with its baseline at `y`.
    pub fn text(&mut self, text: &str, x: f32, y: f32, align: Align, size: f32, color: Color) {
        let (glyphs, width) = self.set(text, size);
        let left = match align {
            Align::Left => x,
            Align::Center => x - width / 2.0,
            Align::Right => x - width,
        };
        for mut glyph in glyphs {
            glyph.position.x += left;
            glyph.position.y = y;
            let Some(outline) = self.font.outline_glyph(glyph) else { continue };
            let bounds = outline.px_bounds();
            let (image, color) = (&mut self.image, color);
            outline.draw(|dx, dy, coverage| {
                let (x, y) = (bounds.min.x + dx as f32, bounds.min.y + dy as f32);
                if x < 0.0 || y < 0.0 {
                    return;
                }
                if let Some(pixel) = image.get_pixel_mut_checked(x as u32, y as u32) {
                    // Thin strokes on a dark sheet look starved at plain coverage.
                    let alpha = coverage.clamp(0.0, 1.0).powf(0.8);
                    for (channel, ink) in pixel.0.iter_mut().zip(color) {
                        let mixed = f32::from(*channel) * (1.0 - alpha) + f32::from(ink) * alpha;
                        *channel = mixed.round() as u8;
                    }
                }
            });
        }
    }

    /// `text` as one line, cut to `width` with an ellipsis where it is longer.
    pub fn fitted(&self, text: &str, size: f32, width: f32) -> String {
        let font = self.font.as_scaled(size);
        let ellipsis = font.glyph_id('…');
        let text = escaped(text);
        let (mut x, mut previous, mut cut) = (0.0, None, 0);
        for (at, character) in text.char_indices() {
            let id = font.glyph_id(character);
            x += previous.map_or(0.0, |previous| font.kern(previous, id)) + font.h_advance(id);
            previous = Some(id);
            if x > width {
                // A name can be long: what is behind the cut is not looked at.
                let is_room = cut > 0 || font.h_advance(ellipsis) <= width;
                return if is_room { text[..cut].trim_end().to_owned() + "…" } else { String::new() };
            }
            if x + font.kern(id, ellipsis) + font.h_advance(ellipsis) <= width {
                cut = at + character.len_utf8();
            }
        }
        text.into_owned()
    }

    /// Glyphs side by side from x = 0, kerned, and their width together.
    fn set(&self, text: &str, size: f32) -> (Vec<Glyph>, f32) {
        let font = self.font.as_scaled(size);
        let mut glyphs: Vec<Glyph> = Vec::with_capacity(text.len());
        let mut x = 0.0;
        for character in escaped(text).chars() {
            let id = font.glyph_id(character);
            if let Some(previous) = glyphs.last() {
                x += font.kern(previous.id, id);
            }
            glyphs.push(id.with_scale_and_position(size, point(x, 0.0)));
            x += font.h_advance(id);
        }
        (glyphs, x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_sign_that_labels_use() {
        let canvas = Canvas::new(1, 1, [0; 3]);
        for sign in "azAZ09·×−…²%&,.:;|()/+éµΔ".chars() {
            assert_ne!(canvas.font.glyph_id(sign).0, 0, "no glyph for {sign}");
        }
    }

    #[test]
    fn text_leaves_ink_where_it_is_told_and_is_cut_where_it_is_told() {
        let mut canvas = Canvas::new(200, 40, [0; 3]);
        canvas.text("iorect", 190.0, 30.0, Align::Right, 24.0, [255; 3]);
        let inked = |canvas: &Canvas, columns: std::ops::Range<u32>| {
            columns.flat_map(|x| (0..40).map(move |y| (x, y))).any(|(x, y)| canvas.image.get_pixel(x, y).0[0] > 128)
        };
        assert!(inked(&canvas, 140..191) && !inked(&canvas, 0..100) && !inked(&canvas, 192..200));

        let cut = canvas.fitted("a very long name of a scene", 24.0, 100.0);
        assert!(cut.ends_with('…') && canvas.text_width(&cut, 24.0) <= 100.0);
        assert_eq!(canvas.fitted("short", 24.0, 100.0), "short");
        // One more character would not fit; nor does the ellipsis where there is no room at all.
        let kept = cut.chars().count() - 1;
        let longer: String = "a very long name of a scene".chars().take(kept + 1).chain(['…']).collect();
        assert!(canvas.text_width(&longer, 24.0) > 100.0, "{cut}");
        assert_eq!(canvas.fitted("short", 24.0, 1.0), "");
        assert_eq!(canvas.fitted("a\u{1b}", 24.0, 100.0), "a\\u{1b}");
        // Off the sheet on every side: nothing to see, and no panic.
        canvas.text("W", -20.0, -3.0, Align::Center, 60.0, [255; 3]);
        canvas.text("W", 1e4, 1e4, Align::Left, 60.0, [255; 3]);
    }
}
