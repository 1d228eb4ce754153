//! PNG and JPEG: sRGB, of 8 or 16 bits. What they were, they stay: transparency and colour profiles are not looked at.

use std::io::Cursor;

use bytemuck::{cast_slice, cast_slice_mut};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};

use super::limits::{pixel_count, zeroed};
use crate::color::linear_from_srgb;
use crate::scene::environment::EnvironmentImage;

/// What the samples of a file become.
pub(super) trait Pixel: bytemuck::Pod {
    type Table;

    /// For samples from 0 to `max`.
    fn table(max: u16) -> Self::Table;

    /// From grey or RGB, with or without transparency.
    fn of<S: Copy + Into<usize>>(table: &Self::Table, samples: &[S]) -> Self;
}

/// Linear light.
impl Pixel for [f32; 3] {
    type Table = Vec<f32>;

    fn table(max: u16) -> Vec<f32> {
        (0..=max).map(|value| linear_from_srgb(f32::from(value) / f32::from(max))).collect()
    }

    fn of<S: Copy + Into<usize>>(table: &Vec<f32>, samples: &[S]) -> Self {
        let at = |index: usize| table[samples[index].into()];
        if samples.len() >= 3 { [at(0), at(1), at(2)] } else { [at(0); 3] }
    }
}

/// sRGB of 8 bits, with 255 behind it.
impl Pixel for [u8; 4] {
    type Table = usize;

    fn table(max: u16) -> usize {
        usize::from(max)
    }

    fn of<S: Copy + Into<usize>>(max: &usize, samples: &[S]) -> Self {
        let at = |index: usize| ((samples[index].into() * 255 + max / 2) / max) as u8;
        if samples.len() >= 3 { [at(0), at(1), at(2), 255] } else { [at(0), at(0), at(0), 255] }
    }
}

/// An image of any pixels, the upper row first.
pub(super) struct Decoded<P> {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<P>,
}

impl From<Decoded<[f32; 3]>> for EnvironmentImage {
    fn from(Decoded { width, height, pixels }: Decoded<[f32; 3]>) -> Self {
        Self { width, height, pixels, notes: Vec::new() }
    }
}

pub(super) fn png(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    decode_png(bytes).map(Into::into)
}

pub(super) fn jpeg(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    decode_jpeg(bytes).map(Into::into)
}

/// Row by row: a file that is cut off does not take the room of a whole one.
pub(super) fn decode_png<P: Pixel>(bytes: &[u8]) -> Result<Decoded<P>, String> {
    let decoding = |error: png::DecodingError| format!("cannot be decoded: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(decoding)?;
    let (width, height) = (info.width as usize, info.height as usize);
    let count = pixel_count(width as u64, height as u64)?;
    let mut reader = decoder.read_info().map_err(decoding)?;
    let (color_type, depth) = reader.output_color_type();
    let has_words = depth == png::BitDepth::Sixteen;
    let table = P::table(if has_words { u16::MAX } else { u16::from(u8::MAX) });
    let mut pixels: Vec<P> = zeroed(count)?;
    let mut rows = 0;
    // What is asked for after the last row also reads, and tests, what is left of the data.
    while let Some(row) = reader.next_interlaced_row().map_err(decoding)? {
        let samples = color_type.samples();
        let colors: Vec<P> = if has_words {
            let word = |pair: &[u8]| u16::from_be_bytes([pair[0], pair[1]]);
            let words: Vec<u16> = row.data().chunks_exact(2).map(word).collect();
            words.chunks_exact(samples).map(|pixel| P::of(&table, pixel)).collect()
        } else {
            row.data().chunks_exact(samples).map(|pixel| P::of(&table, pixel)).collect()
        };
        match row.interlace() {
            png::InterlaceInfo::Null(_) => pixels[rows * width..][..width].copy_from_slice(&colors),
            png::InterlaceInfo::Adam7(pass) => {
                let (pixel_bytes, pixel_bits) = (size_of::<P>(), 8 * size_of::<P>() as u8);
                let (to, from) = (cast_slice_mut(&mut pixels), cast_slice(&colors));
                png::expand_interlaced_row(to, width * pixel_bytes, from, pass, pixel_bits);
            }
        }
        rows += 1;
    }
    Ok(Decoded { width, height, pixels })
}

pub(super) fn decode_jpeg<P: Pixel>(bytes: &[u8]) -> Result<Decoded<P>, String> {
    let decoding = |error: image::ImageError| format!("cannot be decoded: {error}");
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(decoding)?;
    let (width, height) = decoder.dimensions();
    let count = pixel_count(u64::from(width), u64::from(height))?;
    // The decoder fills in grey for what is missing, and takes the room of the whole image first. Each block of 8×8 pixels takes a bit
    // at least in some component, whose size can be a quarter of the image's each way when others are smaller the other way.
    let is_too_short = count as u64 > 1024 * bytes.len() as u64;
    if is_too_short || !has_jpeg_end(bytes) {
        return Err(format!("is cut off: its {} bytes do not hold all of its {width}×{height} pixels", bytes.len()));
    }
    let samples = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        other => return Err(format!("has pixels of type {other:?}, which is not read: save it in RGB")),
    };
    let mut values = vec![0; count * samples];
    decoder.read_image(&mut values).map_err(decoding)?;
    let table = P::table(u16::from(u8::MAX));
    let mut pixels: Vec<P> = zeroed(count)?;
    pixels.iter_mut().zip(values.chunks_exact(samples)).for_each(|(to, values)| *to = P::of(&table, values));
    Ok(Decoded { width: width as usize, height: height as usize, pixels })
}

/// Whether the marker that ends a JPEG stands anywhere after the first scan began. (Before it, there may be a thumbnail with an end of
/// its own.)
fn has_jpeg_end(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let mut at = 2;
    while let [0xff, marker, high, low, ..] = bytes[at.min(bytes.len())..] {
        if marker == START_OF_SCAN {
            return bytes[at..].windows(2).any(|pair| pair == END_OF_IMAGE);
        }
        // Segments may have more than one 0xff before their marker.
        at += if marker == 0xff { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
    }
    // Not laid out as expected, but decoded nevertheless.
    bytes.windows(2).any(|pair| pair == END_OF_IMAGE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageFormat, Rgb, RgbImage};

    fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// Asserts that pixels are what `image` makes of the file. Its own arithmetic differs in the last bit where it changes the layout.
    fn is_as_decoded(read: &EnvironmentImage, bytes: &[u8]) {
        let decoded = image::load_from_memory(bytes).unwrap();
        let is_exact = matches!(decoded, DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgb16(_));
        let decoded = decoded.into_rgb32f();
        assert_eq!((read.width as u32, read.height as u32), decoded.dimensions());
        for (pixel, expected) in read.pixels.iter().zip(decoded.pixels()) {
            let expected = expected.0.map(linear_from_srgb);
            let is_near = pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 4e-7 * b);
            assert!(if is_exact { *pixel == expected } else { is_near }, "{pixel:?}, not {expected:?}");
        }
    }

    fn color(x: u32, y: u32) -> [u8; 3] {
        [(x * 37 + y * 11) as u8, (x * 5 + y * 91) as u8, (x ^ (y * 3)) as u8]
    }

    /// A PNG of 13×11 pixels, of any kind; interlaced, it stores the seven passes by their definition.
    fn encode_png(color_type: png::ColorType, bit_depth: png::BitDepth, interlaced: bool) -> Vec<u8> {
        /// First column and row of each pass, and the steps between (PNG, third edition, 8.1).
        const ADAM_7: [[usize; 4]; 7] =
            [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];
        let (width, height) = (13_u32, 11_u32);
        let bits = color_type.samples() * bit_depth as usize;
        let bit = |x: u32, y: u32, bit: usize| (x * 7 + y * 13 + bit as u32 * (x + 3 * y)) % 5 % 2;
        let mut raw = Vec::new();
        for &[left, top, across, down] in if interlaced { &ADAM_7[..] } else { &[[0, 0, 1, 1]] } {
            for y in (top as u32..height).step_by(down) {
                let columns = (left as u32..width).step_by(across);
                let row: Vec<u32> = columns.flat_map(|x| (0..bits).map(move |b| bit(x, y, b))).collect();
                let byte = |bits: &[u32]| bits.iter().enumerate().fold(0, |byte, (i, b)| byte | (*b as u8) << (7 - i));
                raw.push(0); // no filter
                raw.extend(row.chunks(8).map(byte));
            }
        }
        // zlib with one stored block. (The encoder itself writes no passes.)
        let length = raw.len() as u16;
        let (a, b) = raw.iter().fold((1_u32, 0_u32), |(a, b), byte| {
            let a = (a + u32::from(*byte)) % 65521;
            (a, (b + a) % 65521)
        });
        let sizes = [length.to_le_bytes(), (!length).to_le_bytes()].concat();
        let data = [&[0x78, 0x01, 1], &sizes[..], &raw, &(b << 16 | a).to_be_bytes()].concat();
        let colors = (0..1_usize << bit_depth as usize).flat_map(|i| [(i * 31) as u8, 255 - i as u8, 9]);
        let mut info = png::Info::with_size(width, height);
        (info.color_type, info.bit_depth, info.interlaced) = (color_type, bit_depth, interlaced);
        info.palette = (color_type == png::ColorType::Indexed).then(|| colors.collect());
        let mut bytes = Vec::new();
        let mut writer = png::Encoder::with_info(&mut bytes, info).unwrap().write_header().unwrap();
        writer.write_chunk(png::chunk::IDAT, &data).unwrap();
        drop(writer);
        bytes
    }

    #[test]
    fn every_kind_of_png_reads_as_before() {
        use png::BitDepth::{Eight, Four, One, Sixteen, Two};
        use png::ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
        let kinds = [
            (Grayscale, &[One, Two, Four, Eight, Sixteen][..]),
            (Indexed, &[One, Two, Four, Eight]),
            (GrayscaleAlpha, &[Eight, Sixteen]),
            (Rgb, &[Eight, Sixteen]),
            (Rgba, &[Eight, Sixteen]),
        ];
        for (color_type, depths) in kinds {
            for depth in depths {
                for interlaced in [false, true] {
                    let bytes = encode_png(color_type, *depth, interlaced);
                    let read =
                        png(&bytes).unwrap_or_else(|error| panic!("{color_type:?} {depth:?} {interlaced}: {error}"));
                    assert_eq!((read.width, read.height), (13, 11));
                    is_as_decoded(&read, &bytes);
                }
            }
        }
    }

    #[test]
    fn jpeg_reads_as_before() {
        let colored = RgbImage::from_fn(37, 21, |x, y| Rgb(color(x, y)));
        let grey = GrayImage::from_fn(37, 21, |x, y| image::Luma([color(x, y)[0]]));
        for bytes in [encode(colored, ImageFormat::Jpeg), encode(grey, ImageFormat::Jpeg)] {
            is_as_decoded(&jpeg(&bytes).unwrap(), &bytes);
        }
    }

    /// The smallest honest JPEG of its size: one colour, two bits a block or so.
    #[test]
    fn a_jpeg_of_one_color_is_read() {
        let bytes = encode(RgbImage::from_pixel(2048, 1024, Rgb([90, 120, 200])), ImageFormat::Jpeg);
        assert_eq!(jpeg(&bytes).unwrap().pixels.len(), 2048 * 1024);
    }
}
