//! OpenEXR files.

use std::io;

/// The bytes of an EXR file in f32, of pixels by column and row. The lines of `text`, as (keyword, text), are its attribute `comments`.
pub fn exr_of_pixels(
    size: (usize, usize),
    pixel: impl Sync + Fn(usize, usize) -> [f32; 3],
    text: &[(String, String)],
) -> exr::error::Result<Vec<u8>> {
    use exr::prelude::{Encoding, Image, LayerAttributes, LineOrder, SpecificChannels, Text, Vec2, WritableImage};
    let pixel = |at: Vec2<usize>| <(f32, f32, f32)>::from(pixel(at.x(), at.y()));
    // Blocks are compressed on all cores: in no particular order, equal pictures would not give equal files.
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };
    let lines: Vec<String> = text.iter().map(|(keyword, text)| format!("{keyword}: {text}")).collect();
    // Texts are bytes, in UTF-8 by the file format's convention.
    let comments = Some(Text::from_slice_unchecked(lines.join("\n").as_bytes())).filter(|_| !lines.is_empty());
    let attributes = LayerAttributes { comments, ..Default::default() };
    let layer = exr::prelude::Layer::new(size, attributes, encoding, SpecificChannels::rgb(pixel));
    let mut bytes = io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}
