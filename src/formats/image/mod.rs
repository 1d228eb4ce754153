//! Environment images.
//!
//! Whatever a file holds ends as a latitude–longitude image in linear Rec. 709, or as an error that says what to do. Sizes are tested on
//! the header, before anything is decoded (see [`limits`]).

pub(super) mod bitmap;
mod color;
mod cube;
mod exr;
pub(crate) mod limits;
mod radiance;
mod repair;

use std::path::Path;

use super::ending::{Format, by_ending, list};
use crate::scene::environment::EnvironmentImage;

pub(super) type ImageFormat = Format<fn(&[u8]) -> Result<EnvironmentImage, String>>;

/// Every image format that is read.
const FORMATS: &[ImageFormat] = &[
    ImageFormat { endings: &["exr"], read: exr::read },
    ImageFormat { endings: &["hdr", "pic"], read: radiance::read },
    ImageFormat { endings: &["png"], read: bitmap::png },
    ImageFormat { endings: &["jpg", "jpeg"], read: bitmap::jpeg },
];

/// The first of them hold linear light.
const LINEAR: usize = 2;

/// The format that a file's ending names; an error lists those that are read.
pub(super) fn format_of(path: &Path) -> Result<&'static ImageFormat, String> {
    by_ending(FORMATS, path)
        .ok_or_else(|| format!("`{}` is no environment image that is read: use {}", path.display(), list(FORMATS)))
}

/// Decodes an image: EXR and HDR as linear light, PNG and JPEG as sRGB. What had to be replaced or converted is said in its notes. Files
/// that are too large, damaged, cut off, or of a kind that is not read are errors.
pub(super) fn read(bytes: &[u8], format: &ImageFormat) -> Result<EnvironmentImage, String> {
    let mut image = (format.read)(bytes)?;
    repair::repair(&mut image);
    cube::unfold(&mut image)?;
    Ok(image)
}

/// Decodes a picture of linear light as it is: negative components stay, and what is no finite number is replaced, which is said in its
/// notes.
pub(super) fn read_picture(bytes: &[u8], name: &Path) -> Result<EnvironmentImage, String> {
    let format = by_ending(&FORMATS[..LINEAR], name)
        .ok_or_else(|| format!("`{}` holds no linear light: use {}", name.display(), list(&FORMATS[..LINEAR])))?;
    let mut image = (format.read)(bytes)?;
    repair::replace_broken(&mut image);
    Ok(image)
}
