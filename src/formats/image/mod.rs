//! Environment images, and textures.
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
pub(super) mod write;

use std::path::Path;

use super::ending::{Format, by_ending, list};
use crate::scene::environment::EnvironmentImage;
use crate::scene::texture::TextureImage;

pub(super) type ImageFormat = Format<fn(&[u8]) -> Result<EnvironmentImage, String>>;

/// Every image format that is read.
pub(super) const FORMATS: &[ImageFormat] = &[
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

/// An image for a surface, whatever its file is called; `None`: it is of none of the formats that are read. PNG and JPEG stay as they are, of linear
/// light the texture is encoded.
pub(super) fn texture(bytes: &[u8]) -> Option<Result<TextureImage, String>> {
    let of_bytes = |decoded: bitmap::Decoded<[u8; 4]>| {
        let bitmap::Decoded { width, height, pixels } = decoded;
        TextureImage::new(width, height, pixels)
    };
    let of_light = |read: Result<EnvironmentImage, String>| {
        read.map(|mut image| {
            repair::repair(&mut image);
            let mut texture = TextureImage::from_linear(image.width, image.height, &image.pixels);
            texture.notes.splice(0..0, image.notes);
            texture
        })
    };
    Some(match bytes {
        [0x89, b'P', b'N', b'G', ..] => bitmap::decode_png(bytes).map(of_bytes),
        [0xff, 0xd8, ..] => bitmap::decode_jpeg(bytes).map(of_bytes),
        [0x76, 0x2f, 0x31, 0x01, ..] => of_light(exr::read(bytes)),
        [b'#', b'?', ..] => of_light(radiance::read(bytes)),
        _ => return None,
    })
}

/// A texture as the bytes of a PNG file.
pub fn to_png(image: &TextureImage) -> Vec<u8> {
    let rgb: Vec<u8> = image.texels().iter().flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width() as u32, image.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    // Into memory nothing fails, and there are as many bytes as texels want.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&rgb));
    debug_assert!(written.is_ok(), "{written:?}");
    bytes
}
