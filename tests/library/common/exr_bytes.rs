//! OpenEXR files written byte by byte, of kinds that no encoder at hand makes.

use exr::compression::Compression;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, ChannelList, IntegerBounds, LevelMode, SampleType, Text, TileDescription,
};
use exr::meta::header::Header;
use exr::prelude::f16;

/// A channel, with its value at absolute pixel coordinates.
pub struct Channel {
    pub name: &'static str,
    pub sample_type: SampleType,
    pub sampling: i32,
    pub value: Box<dyn Fn(i32, i32) -> f32>,
}

pub fn channel(name: &'static str, sample_type: SampleType, value: impl Fn(i32, i32) -> f32 + 'static) -> Channel {
    Channel { name, sample_type, sampling: 1, value: Box::new(value) }
}

/// One part. Windows are (left, top, right, bottom), all inclusive.
pub struct Part {
    pub name: &'static str,
    /// In the order of their names.
    pub channels: Vec<Channel>,
    pub data: [i32; 4],
    pub display: [i32; 4],
    pub compression: Compression,
    /// The side of tiles and the byte of their level mode: 0 none, 1 mip map, 2 rip map.
    pub tiles: Option<(i32, u8)>,
    /// Name, type and value.
    pub attributes: Vec<(&'static str, &'static str, Vec<u8>)>,
    pub is_deep: bool,
}

impl Part {
    /// Scan lines without compression, data and display window alike.
    pub fn new(size: (i32, i32), channels: Vec<Channel>) -> Self {
        let window = [0, 0, size.0 - 1, size.1 - 1];
        Self {
            name: "",
            channels,
            data: window,
            display: window,
            compression: Compression::Uncompressed,
            tiles: None,
            attributes: vec![],
            is_deep: false,
        }
    }

    fn size(&self) -> (i32, i32) {
        (self.data[2] - self.data[0] + 1, self.data[3] - self.data[1] + 1)
    }

    fn header(&self, is_one_of_several: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
            bytes.extend((value.len() as i32).to_le_bytes());
            bytes.extend(value);
        };
        let ints = |values: &[i32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
        let mut channels = Vec::new();
        for channel in &self.channels {
            channels.extend(channel.name.bytes().chain([0]));
            let kind = match channel.sample_type {
                SampleType::U32 => 0,
                SampleType::F16 => 1,
                SampleType::F32 => 2,
            };
            channels.extend(ints(&[kind, 0, channel.sampling, channel.sampling]));
        }
        channels.push(0);
        attribute("channels", "chlist", &channels);
        let compression = match self.compression {
            Compression::Uncompressed => 0,
            Compression::RLE => 1,
            Compression::ZIP1 => 2,
            Compression::ZIP16 => 3,
            Compression::PIZ => 4,
            Compression::PXR24 => 5,
            Compression::B44 => 6,
            other => panic!("{other:?}"),
        };
        attribute("compression", "compression", &[compression]);
        attribute("dataWindow", "box2i", &ints(&self.data));
        attribute("displayWindow", "box2i", &ints(&self.display));
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
        if let Some((side, mode)) = self.tiles {
            attribute("tiles", "tiledesc", &[ints(&[side, side]), vec![mode]].concat());
        }
        if is_one_of_several || self.is_deep {
            attribute("name", "string", self.name.as_bytes());
            let kind = match (self.is_deep, self.tiles) {
                (true, _) => "deepscanline",
                (false, Some(_)) => "tiledimage",
                (false, None) => "scanlineimage",
            };
            attribute("type", "string", kind.as_bytes());
            attribute("chunkCount", "int", &ints(&[self.blocks().len() as i32]));
        }
        if self.is_deep {
            attribute("version", "int", &ints(&[1]));
        }
        for (name, kind, value) in &self.attributes {
            attribute(name, kind, value);
        }
        bytes.push(0);
        bytes
    }

    /// Coordinates as they stand before a block, and the block's pixels by level, from the data window: (left, top, width, height).
    fn blocks(&self) -> Vec<(Vec<i32>, u32, [i32; 4])> {
        let (width, height) = self.size();
        let mut blocks = Vec::new();
        let Some((side, mode)) = self.tiles else {
            let rows = self.compression.scan_lines_per_block() as i32;
            for top in (0..height).step_by(rows as usize) {
                blocks.push((vec![self.data[1] + top], 0, [0, top, width, rows.min(height - top)]));
            }
            return blocks;
        };
        for level in 0..if mode == 0 { 1 } else { width.max(height).ilog2() + 1 } {
            let (width, height) = ((width >> level).max(1), (height >> level).max(1));
            for row in 0..(height + side - 1) / side {
                for column in 0..(width + side - 1) / side {
                    let (left, top) = (column * side, row * side);
                    let size = [left, top, side.min(width - left), side.min(height - top)];
                    blocks.push((vec![column, row, level as i32, level as i32], level, size));
                }
            }
        }
        blocks
    }

    /// The samples of a block, compressed.
    fn samples(&self, level: u32, [left, top, width, height]: [i32; 4]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for y in top..top + height {
            for channel in self.channels.iter().filter(|channel| y % channel.sampling == 0) {
                for x in (left..left + width).step_by(channel.sampling as usize) {
                    // Levels below the first hold what must not be seen.
                    let value = if level > 0 { -77.0 } else { (channel.value)(self.data[0] + x, self.data[1] + y) };
                    match channel.sample_type {
                        SampleType::F16 => bytes.extend(f16::from_f32(value).to_bits().to_le_bytes()),
                        SampleType::F32 => bytes.extend(value.to_le_bytes()),
                        SampleType::U32 => bytes.extend((value as u32).to_le_bytes()),
                    }
                }
            }
        }
        let channels = self.channels.iter().map(|channel| ChannelDescription {
            name: Text::from(channel.name),
            sample_type: channel.sample_type,
            quantize_linearly: false,
            sampling: Vec2(channel.sampling as usize, channel.sampling as usize),
        });
        let (w, h) = self.size();
        let mut header = Header::new(Text::from(self.name), (w as usize, h as usize), Default::default());
        header.channels = ChannelList::new(channels.collect());
        header.compression = self.compression;
        header.blocks = match self.tiles {
            None => BlockDescription::ScanLines,
            Some((side, _)) => BlockDescription::Tiles(TileDescription {
                tile_size: Vec2(side as usize, side as usize),
                level_mode: LevelMode::Singular,
                rounding_mode: RoundingMode::Down,
            }),
        };
        let section = IntegerBounds::new((left, top), (width as usize, height as usize));
        self.compression.compress_image_section_to_le(&header, bytes, section).unwrap()
    }
}

/// A file of one or several parts.
pub fn file(parts: &[Part]) -> Vec<u8> {
    let is_several = parts.len() > 1;
    let mut flags = 2_u32;
    flags |= u32::from(!is_several && parts[0].tiles.is_some()) << 9;
    flags |= u32::from(parts.iter().any(|part| part.is_deep)) << 11;
    flags |= u32::from(is_several) << 12;
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01];
    bytes.extend(flags.to_le_bytes());
    parts.iter().for_each(|part| bytes.extend(part.header(is_several)));
    if is_several {
        bytes.push(0);
    }
    let count: usize = parts.iter().map(|part| part.blocks().len()).sum();
    let mut table = bytes.len();
    bytes.resize(table + 8 * count, 0);
    for (index, part) in parts.iter().enumerate() {
        for (coordinates, level, pixels) in part.blocks() {
            let offset = bytes.len() as u64;
            bytes[table..table + 8].copy_from_slice(&offset.to_le_bytes());
            table += 8;
            let samples = part.samples(level, pixels);
            if is_several {
                bytes.extend((index as i32).to_le_bytes());
            }
            coordinates.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            bytes.extend((samples.len() as i32).to_le_bytes());
            bytes.extend(samples);
        }
    }
    bytes
}

/// Where the value of an attribute of the first part begins.
pub fn value_of(bytes: &[u8], name: &str) -> usize {
    let find = |from: usize, what: &[u8]| from + bytes[from..].windows(what.len()).position(|w| w == what).unwrap();
    let name_at = find(8, &[name.as_bytes(), &[0]].concat());
    find(name_at + name.len() + 1, &[0]) + 5
}
