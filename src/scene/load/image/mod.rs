//! Environment images.
//!
//! Whatever a file holds ends as a latitude–longitude image in linear Rec. 709, or as an error that says what to do. Sizes are tested on
//! the header, before anything is decoded (see [`limits`]).

mod bitmap;
mod color;
mod cube;
mod exr;
pub(crate) mod limits;
mod radiance;
mod repair;

use std::path::Path;

use crate::scene::environment::EnvironmentImage;

/// The formats of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    OpenExr,
    Radiance,
    Png,
    Jpeg,
}

/// The format that a file's ending names.
///
/// # Errors
/// Lists the formats that are read.
pub(super) fn format_of(path: &Path) -> Result<Format, String> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "exr" => Ok(Format::OpenExr),
        "hdr" | "pic" => Ok(Format::Radiance),
        "png" => Ok(Format::Png),
        "jpg" | "jpeg" => Ok(Format::Jpeg),
        _ => Err(format!("`{}` is no environment image that is read: use .exr, .hdr, .png or .jpg", path.display())),
    }
}

/// Decodes an image: EXR and HDR as linear light, PNG and JPEG as sRGB. What had to be replaced or converted is said in its notes.
///
/// # Errors
/// When the file is too large, damaged, cut off, or of a kind that is not read.
pub(super) fn read(bytes: &[u8], format: Format) -> Result<EnvironmentImage, String> {
    let mut image = match format {
        Format::OpenExr => exr::read(bytes),
        Format::Radiance => radiance::read(bytes),
        Format::Png => bitmap::png(bytes),
        Format::Jpeg => bitmap::jpeg(bytes),
    }?;
    repair::repair(&mut image);
    cube::unfold(&mut image)?;
    Ok(image)
}
