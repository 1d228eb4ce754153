//! Linear pictures, and their files.

use std::path::Path;

use super::ExportError;
use crate::formats::exr_of_pixels;
use crate::render::{Display, Film};
use crate::writing::write_atomically;

/// A picture in linear RGB (Rec. 709), row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels per row, > 0.
    pub width: u32,
    /// Rows, > 0.
    pub height: u32,
    /// Row-major, `width` × `height` of them.
    pub rgb: Vec<[f32; 3]>,
}

impl Picture {
    /// Whether the pixels go with the size, and there are any.
    pub(super) fn require_sound(&self) -> Result<(), ExportError> {
        let (width, height, pixels) = (self.width, self.height, self.rgb.len());
        let is_sound = pixels > 0 && u64::from(width) * u64::from(height) == pixels as u64;
        if is_sound { Ok(()) } else { Err(ExportError::BadPicture { width, height, pixels }) }
    }

    /// As a screen shows it, 8 bits a channel.
    pub fn encode(&self, display: &Display) -> image::RgbImage {
        let bytes = self.rgb.iter().flat_map(|&rgb| display.encode(rgb)).collect();
        image::RgbImage::from_raw(self.width, self.height, bytes).expect("the size was checked")
    }
}

impl From<&Film> for Picture {
    fn from(film: &Film) -> Self {
        Self { width: film.width, height: film.height, rgb: film.to_rgb() }
    }
}

/// A file format for pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// 8 bits, tone-mapped, with text.
    Png,
    /// 32-bit float, linear.
    Exr,
}

impl Format {
    /// By the file name's extension, in any case.
    ///
    /// # Errors
    /// When it is neither `.png` nor `.exr`.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(ExportError::UnknownExtension { path: path.to_path_buf(), expected: "`.png` or `.exr`" }),
        }
    }
}

/// Writes `picture` in the format that the path's extension names. `display` matters to PNG only.
///
/// # Errors
/// As [`png()`] and [`exr()`], and when the extension is neither.
pub fn save(path: &Path, picture: &Picture, display: &Display, text: &[(String, String)]) -> Result<(), ExportError> {
    match Format::of(path)? {
        Format::Png => png(path, picture, display, text),
        Format::Exr => exr(path, picture, text),
    }
}

/// Writes what `display` makes of `picture`, with `text` as (keyword, text) chunks.
///
/// # Errors
/// When the picture is empty, a keyword is not 1 to 79 Latin-1 characters, or the path cannot be written.
pub fn png(path: &Path, picture: &Picture, display: &Display, text: &[(String, String)]) -> Result<(), ExportError> {
    picture.require_sound()?;
    image_png(path, &picture.encode(display), text)
}

/// Writes an image that is already encoded for an sRGB screen, such as a [`super::comparison`].
///
/// # Errors
/// As [`png()`].
pub fn image_png(path: &Path, image: &image::RgbImage, text: &[(String, String)]) -> Result<(), ExportError> {
    let bytes = png_bytes(image, text, path)?;
    Ok(write_atomically(path, |writer| writer.write_all(&bytes))?)
}

/// The contents of a PNG file, for pages that hold their pictures themselves. `path` is what the picture is called in errors.
///
/// # Errors
/// When the picture is empty, or a keyword is not 1 to 79 Latin-1 characters.
pub fn png_bytes(image: &image::RgbImage, text: &[(String, String)], path: &Path) -> Result<Vec<u8>, ExportError> {
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 {
        return Err(ExportError::BadPicture { width, height, pixels: 0 });
    }
    encode_png(image, text).map_err(|e| ExportError::Encode { path: path.to_path_buf(), message: e.to_string() })
}

fn encode_png(image: &image::RgbImage, text: &[(String, String)]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (keyword, text) in text {
        // tEXt is Latin-1 by its specification; anything else needs iTXt, which is UTF-8.
        if text.is_ascii() {
            encoder.add_text_chunk(keyword.clone(), text.clone())?;
        } else {
            encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image.as_raw())?;
    writer.finish()?;
    Ok(bytes)
}

/// Writes `picture` as a linear 32-bit float OpenEXR image with channels R, G and B. The lines of `text`, as (keyword, text), are its attribute
/// `comments`.
///
/// # Errors
/// When the picture is empty or the path cannot be written.
pub fn exr(path: &Path, picture: &Picture, text: &[(String, String)]) -> Result<(), ExportError> {
    picture.require_sound()?;
    let bytes = encode_exr(picture, text)
        .map_err(|e| ExportError::Encode { path: path.to_path_buf(), message: e.to_string() })?;
    Ok(write_atomically(path, |writer| writer.write_all(&bytes))?)
}

fn encode_exr(picture: &Picture, text: &[(String, String)]) -> exr::error::Result<Vec<u8>> {
    let size = (picture.width as usize, picture.height as usize);
    exr_of_pixels(size, |x, y| picture.rgb[y * size.0 + x], text)
}
