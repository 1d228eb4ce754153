//! The blocks of the chosen part: decompressed some at a time on all cores, and put where they belong.

use std::io::Cursor;
use std::iter;
use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, ChannelList, IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData, compute_block_count};
use exr::prelude::f16;
use rayon::prelude::*;

use super::chroma::Chroma;
use super::layer::{Colors, Layer};
use super::{Windows, decoding};

/// Bytes of decompressed blocks that are held at a time, unless one alone is larger.
const BATCH_BYTES: usize = 64 << 20;

/// Where samples go.
pub(super) struct Samples {
    pub windows: Windows,
    /// Of the display window. Luminance goes into the second component.
    pub pixels: Vec<[f32; 3]>,
    pub chroma: Option<Chroma>,
}

/// What a channel is to the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    None,
    Component(usize),
    Chroma(usize),
}

/// Reads the largest level of `layer`. `rest` stands after the headers.
pub(super) fn read(
    meta: &MetaData,
    layer: &Layer,
    rest: &mut Cursor<&[u8]>,
    samples: &mut Samples,
) -> Result<(), String> {
    let part = Part::new(&meta.headers[layer.part], layer)?;
    // Offsets tell where chunks begin, which reading one after the other tells as well. Whoever cuts a file off leaves them wrong.
    let chunks: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let tables = rest.position() + 8 * chunks as u64;
    if tables > rest.get_ref().len() as u64 {
        return Err("is cut off in its table of blocks".into());
    }
    rest.set_position(tables);
    let mut has_come = vec![false; part.columns * part.rows];
    let mut missing = has_come.len();
    let mut batch = Vec::new();
    for index in 0..chunks {
        let chunk = Chunk::read(rest, meta)
            .map_err(|error| format!("is cut off or damaged in block {} of {chunks}: {error}", index + 1))?;
        if chunk.layer_index == layer.part
            && let Some((place, section)) = part.place(&chunk)?
        {
            if std::mem::replace(&mut has_come[place], true) {
                return Err("is damaged: one of its blocks comes twice".into());
            }
            missing -= 1;
            batch.push((section, chunk));
        }
        let is_last = index + 1 == chunks;
        if is_last || batch.len() * part.header.max_block_byte_size() >= BATCH_BYTES {
            let blocks: Vec<_> =
                batch.par_drain(..).map(|(section, chunk)| (section, part.decompress(chunk, section))).collect();
            for (section, bytes) in blocks {
                part.put(section, &bytes?, samples);
            }
        }
    }
    if missing > 0 {
        return Err(format!("is damaged: {missing} of its {} blocks are missing", has_come.len()));
    }
    Ok(())
}

/// The part that is read.
struct Part<'a> {
    header: &'a Header,
    /// Of each channel of the header.
    roles: Vec<Role>,
    /// Blocks of the largest level.
    columns: usize,
    rows: usize,
    /// For blocks of which some channels lack pixels.
    is_subsampled: bool,
}

impl<'a> Part<'a> {
    fn new(header: &'a Header, layer: &Layer) -> Result<Self, String> {
        let channels = &header.channels.list;
        let mut roles = vec![Role::None; channels.len()];
        match layer.colors {
            Colors::Rgb(indices) | Colors::Xyz(indices) => {
                indices.iter().enumerate().for_each(|(component, index)| roles[*index] = Role::Component(component));
            }
            Colors::Luminance(y) => roles[y] = Role::Component(1),
            Colors::LuminanceChroma { y, ry, by } => {
                (roles[y], roles[ry], roles[by]) = (Role::Component(1), Role::Chroma(0), Role::Chroma(1));
            }
        }
        let mut is_subsampled = false;
        let window = header.data_window();
        for (channel, role) in channels.iter().zip(&roles) {
            let Vec2(x, y) = channel.sampling;
            is_subsampled |= (x, y) != (1, 1);
            let divides = |position: i32, size: usize, by: usize| {
                i32::try_from(by).is_ok_and(|by| by > 0 && position % by == 0) && size.is_multiple_of(by)
            };
            if !divides(window.position.0, window.size.0, x) || !divides(window.position.1, window.size.1, y) {
                return Err("cannot be decoded: the sampling of a channel does not divide its data window".into());
            }
            if matches!(role, Role::Component(_)) && (x, y) != (1, 1) {
                return Err("has subsampled colours, which are not read: save it with all samples".into());
            }
        }
        if is_subsampled && header.blocks != BlockDescription::ScanLines {
            return Err("cannot be decoded: tiles cannot be subsampled".into());
        }
        // The crate tests the rest, but refuses subsampling.
        let mut plain = header.clone();
        plain.channels.list.iter_mut().for_each(|channel| channel.sampling = Vec2(1, 1));
        plain.validate(false, &mut false, false).map_err(decoding)?;
        let (block_width, block_height) = match header.blocks {
            BlockDescription::Tiles(tiles) => (tiles.tile_size.0, tiles.tile_size.1),
            BlockDescription::ScanLines => (header.layer_size.0, header.compression.scan_lines_per_block()),
        };
        Ok(Self {
            header,
            roles,
            columns: compute_block_count(header.layer_size.0, block_width),
            rows: compute_block_count(header.layer_size.1, block_height),
            is_subsampled,
        })
    }

    /// The number of a block and where it lies in the data window; `None` for those of smaller levels.
    fn place(&self, chunk: &Chunk) -> Result<Option<(usize, IntegerBounds)>, String> {
        let block = self.header.get_block_data_indices(&chunk.compressed_block).map_err(decoding)?;
        if block.level_index != Vec2(0, 0) {
            return Ok(None);
        }
        let Vec2(column, row) = block.tile_index;
        if column >= self.columns || row >= self.rows {
            return Err("is damaged: a block lies outside the image".into());
        }
        let section = self.header.get_absolute_block_pixel_coordinates(block).map_err(decoding)?;
        Ok(Some((row * self.columns + column, section)))
    }

    /// Native-endian samples: row by row, in each row channel by channel.
    fn decompress(&self, chunk: Chunk, section: IntegerBounds) -> Result<Vec<u8>, String> {
        let bytes = match chunk.compressed_block {
            CompressedBlock::ScanLine(block) => block.compressed_pixels_le,
            CompressedBlock::Tile(block) => block.compressed_pixels_le,
            _ => return Err("holds deep data, which is not read".into()),
        };
        let mut header;
        let (mut described, mut bounds) = (self.header, section);
        if self.is_subsampled {
            // The crate takes a block to have all samples of all channels. It is given a description with as many bytes as there are.
            header = self.header.clone();
            let count = self.byte_count(section);
            let Vec2(width, height) = section.size;
            match header.compression {
                // These compress bytes, whatever they mean.
                Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => {
                    let channel = ChannelDescription::named("Y", SampleType::F16);
                    header.channels = ChannelList::new(iter::once(channel).collect());
                    header.layer_size = Vec2(count / 2, height);
                    bounds = IntegerBounds::new((0, 0), (count / 2, 1));
                }
                // These know of sampling, but for the size of the result.
                _ if count.is_multiple_of(width * height) => header.channels.bytes_per_pixel = count / (width * height),
                other => {
                    return Err(format!("has subsampled channels with {other}, which are not read: save it with ZIP"));
                }
            }
            described = &header;
        }
        let decompress = || described.compression.decompress_image_section_from_le(described, bytes, bounds, false);
        // The crate's decoder of B44 counts on numbers that damage may have changed.
        match catch_unwind(AssertUnwindSafe(decompress)) {
            Ok(result) => result.map_err(decoding),
            Err(_) => Err("is damaged: one of its blocks cannot be decompressed".into()),
        }
    }

    /// Samples of a channel in a row of a block of this width, if it has any there.
    fn samples_in_row(channel: &ChannelDescription, width: usize, row: usize) -> Option<usize> {
        let Vec2(x, y) = channel.sampling;
        row.is_multiple_of(y).then_some(width / x)
    }

    fn byte_count(&self, section: IntegerBounds) -> usize {
        let first = section.position.1 as usize;
        let rows = first..first + section.size.1;
        let of_row = |row| {
            let samples = |channel| Self::samples_in_row(channel, section.size.0, row).unwrap_or(0);
            self.header.channels.list.iter().map(|c| samples(c) * c.sample_type.bytes_per_sample()).sum::<usize>()
        };
        rows.map(of_row).sum()
    }

    /// Puts decompressed samples where they belong. `bytes` are as many as the block has.
    fn put(&self, section: IntegerBounds, bytes: &[u8], samples: &mut Samples) {
        let (left, top) = (section.position.0 as usize, section.position.1 as usize);
        let windows = samples.windows;
        let columns = windows.columns();
        // Of this block, within the display window.
        let seen = columns.start.max(left)..columns.end.min(left + section.size.0);
        let mut rest = bytes;
        for row in top..top + section.size.1 {
            for (channel, role) in self.header.channels.list.iter().zip(&self.roles) {
                let Some(count) = Self::samples_in_row(channel, section.size.0, row) else { continue };
                let size = channel.sample_type.bytes_per_sample();
                let (line, later) = rest.split_at(count * size);
                rest = later;
                match (*role, windows.row(row), &mut samples.chroma) {
                    (Role::Component(component), Some(target), _) if !seen.is_empty() => {
                        let line = &line[(seen.start - left) * size..(seen.end - left) * size];
                        let at = target * windows.width + windows.column(seen.start);
                        let pixels = &mut samples.pixels[at..at + seen.len()];
                        convert(channel.sample_type, line, pixels.iter_mut().map(|pixel| &mut pixel[component]));
                    }
                    (Role::Chroma(plane), _, Some(chroma)) => {
                        convert(channel.sample_type, line, chroma.row_mut(plane, row).iter_mut());
                    }
                    _ => {}
                }
            }
        }
    }
}

fn convert<'a>(from: SampleType, line: &[u8], to: impl Iterator<Item = &'a mut f32>) {
    let word = |bytes: &[u8]| u32::from_ne_bytes(bytes.try_into().expect("chunks of four"));
    match from {
        SampleType::F16 => {
            let halves = line.chunks_exact(2).map(|b| f16::from_bits(u16::from_ne_bytes([b[0], b[1]])).to_f32());
            to.zip(halves).for_each(|(to, value)| *to = value);
        }
        SampleType::F32 => {
            to.zip(line.chunks_exact(4)).for_each(|(to, bytes)| *to = f32::from_bits(word(bytes)));
        }
        SampleType::U32 => to.zip(line.chunks_exact(4)).for_each(|(to, bytes)| *to = word(bytes) as f32),
    }
}
