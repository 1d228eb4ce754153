//! Environment images.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader};

use crate::scene::environment::EnvironmentImage;

/// The format that a file's ending names.
///
/// # Errors
/// Lists the formats that are read.
pub(super) fn format_of(path: &Path) -> Result<ImageFormat, String> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "exr" => Ok(ImageFormat::OpenExr),
        "hdr" => Ok(ImageFormat::Hdr),
        "png" => Ok(ImageFormat::Png),
        "jpg" | "jpeg" => Ok(ImageFormat::Jpeg),
        _ => Err(format!("`{}` is no environment image that is read: use .exr, .hdr, .png or .jpg", path.display())),
    }
}

/// Decodes an image: EXR and HDR as linear Rec. 709, PNG and JPEG as sRGB. Negative components become 0 and are counted.
///
/// # Errors
/// When the file is damaged or has a pixel that is not a finite number, which is named.
pub(super) fn read(bytes: &[u8], format: ImageFormat) -> Result<EnvironmentImage, String> {
    let decoded = ImageReader::with_format(Cursor::new(bytes), format)
        .decode()
        .map_err(|error| format!("cannot be decoded: {error}"))?;
    let is_linear = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let rgb = decoded.into_rgb32f();
    let (width, height) = (rgb.width() as usize, rgb.height() as usize);
    if width == 0 || height == 0 {
        return Err(format!("has no pixels: it is {width}×{height}"));
    }
    let mut clipped = 0;
    let mut pixels = Vec::with_capacity(width * height);
    for (x, y, pixel) in rgb.enumerate_pixels() {
        let mut color = pixel.0;
        for component in &mut color {
            if !component.is_finite() {
                return Err(format!("the pixel at column {x}, row {y} is {component}, must be finite"));
            }
            if *component < 0.0 {
                *component = 0.0;
                clipped += 1;
            }
            if !is_linear {
                *component = linear_from_srgb(*component);
            }
        }
        pixels.push(color);
    }
    Ok(EnvironmentImage { width, height, pixels, clipped })
}

/// The transfer function of IEC 61966-2-1.
fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, Rgb32FImage, RgbImage};

    fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn floats(values: [[f32; 3]; 2], format: ImageFormat) -> Vec<u8> {
        let image = Rgb32FImage::from_fn(2, 1, |x, _| Rgb(values[x as usize]));
        encode(&DynamicImage::from(image), format)
    }

    #[test]
    fn exr_is_linear_and_negatives_are_clipped() {
        let image = read(&floats([[0.25, 7.5, 1e4], [-0.5, 0.0, -1e-3]], ImageFormat::OpenExr), ImageFormat::OpenExr);
        let image = image.unwrap();
        assert_eq!((image.width, image.height, image.clipped), (2, 1, 2));
        assert_eq!(image.pixels, vec![[0.25, 7.5, 1e4], [0.0; 3]]);
    }

    #[test]
    fn hdr_is_linear() {
        let image = read(&floats([[0.25, 0.5, 0.125], [16.0, 8.0, 4.0]], ImageFormat::Hdr), ImageFormat::Hdr).unwrap();
        assert_eq!(image.pixels, vec![[0.25, 0.5, 0.125], [16.0, 8.0, 4.0]]);
    }

    #[test]
    fn png_is_srgb() {
        let image = RgbImage::from_pixel(1, 1, Rgb([0, 128, 255]));
        let image = read(&encode(&DynamicImage::from(image), ImageFormat::Png), ImageFormat::Png).unwrap();
        assert_eq!((image.pixels[0][0], image.pixels[0][2]), (0.0, 1.0));
        assert!((image.pixels[0][1] - 0.215_860_5).abs() < 1e-6);
    }

    #[test]
    fn a_pixel_that_is_no_number_is_named() {
        let bytes = floats([[0.0; 3], [0.0, f32::NAN, 0.0]], ImageFormat::OpenExr);
        let message = read(&bytes, ImageFormat::OpenExr).unwrap_err();
        assert!(message.contains("column 1, row 0"), "{message}");
        let bytes = floats([[f32::INFINITY; 3], [0.0; 3]], ImageFormat::OpenExr);
        assert!(read(&bytes, ImageFormat::OpenExr).unwrap_err().contains("inf"));
    }

    #[test]
    fn damaged_images_are_errors() {
        for (format, values) in [(ImageFormat::OpenExr, [[0.5; 3]; 2]), (ImageFormat::Hdr, [[0.5; 3]; 2])] {
            let bytes = floats(values, format);
            for length in 0..bytes.len() {
                assert!(read(&bytes[..length], format).is_err(), "{format:?} cut at {length}");
            }
        }
        assert!(read(b"not an image", ImageFormat::Png).is_err());
    }

    #[test]
    fn no_damage_makes_it_panic() {
        let png = RgbImage::from_fn(3, 2, |x, y| Rgb([x as u8 * 50, y as u8 * 90, 7]));
        for (format, bytes) in [
            (ImageFormat::OpenExr, floats([[0.5; 3], [2.0; 3]], ImageFormat::OpenExr)),
            (ImageFormat::Hdr, floats([[0.5; 3], [2.0; 3]], ImageFormat::Hdr)),
            (ImageFormat::Png, encode(&png.clone().into(), ImageFormat::Png)),
            (ImageFormat::Jpeg, encode(&png.into(), ImageFormat::Jpeg)),
        ] {
            for place in 0..bytes.len() {
                for flip in [0x01, 0x80] {
                    let mut damaged = bytes.clone();
                    damaged[place] ^= flip;
                    // Any answer will do that is not a panic, and that is an image if it is one.
                    if let Ok(image) = read(&damaged, format) {
                        assert_eq!(image.pixels.len(), image.width * image.height);
                        assert!(image.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
                    }
                }
            }
        }
    }
}
