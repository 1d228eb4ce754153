//! Parts of an image as OpenEXR files: sums and counts without rounding, next to a picture that any viewer opens.
//!
//! One layer, losslessly compressed, with these channels of each pixel:
//!
//! | channel | type | |
//! |---|---|---|
//! | `R`, `G`, `B` | f32 | mean radiance, for looking at; readers of sums only check that it goes with them |
//! | `sum0.R` … `sum3.B` | u32 | the sum of its samples: an integer of 128 bits in two's complement, lowest 32 bits first, in units of 2^`unit_exponent` |
//! | `count.N` | u32 | how many samples are in the sum |
//!
//! The attribute `iorectSums`, a text in JSON, says what the samples are of ([`Recipe`]), which they are, and what happened on the way; a
//! checksum over it and over sums and counts tells a file that was damaged or edited.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers,
    WritableImage,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::ExportError;
use crate::formats::disk::{self, FileError};
use crate::formats::image::limits;
use crate::render::exact::{ExactSums, MOST_BITS};
use crate::render::{Partial, Recipe, SampleRange};
use crate::scene::Fingerprint;
use crate::scene::fingerprint::Hasher;
use crate::tracking::Events;
use crate::writing::write_atomically;

/// Where the text stands in the file.
const ATTRIBUTE: &str = "iorectSums";
/// Version of the format; files of another are refused.
const FORMAT: u32 = 3;
/// Most pixels that are read: as many as can be rendered.
const MOST_PIXELS: u64 = 1 << 26;
/// Largest count of an event that is accepted from a file: the sums over all files cannot overflow.
const MOST_EVENTS: u64 = 1 << 56;
const COLORS: [&str; 3] = ["R", "G", "B"];
const COUNT: &str = "count.N";
/// The counts, and of each colour the mean and four parts of the sum.
const CHANNELS: usize = 1 + COLORS.len() * 5;

/// A file that is no part of an image.
#[derive(Debug, thiserror::Error)]
pub enum SumsError {
    #[error("{}: {reason}", path.display())]
    Read { path: PathBuf, reason: FileError },
    #[error("{}: is no OpenEXR file, or not a whole one: {message}", path.display())]
    NotExr { path: PathBuf, message: String },
    /// A picture and nothing more.
    #[error("{}: holds no sums; `iorect render SCENE --samples A..B -o FILE.exr` writes them", path.display())]
    NoSums { path: PathBuf },
    #[error("{}: is of format {format}, and this iorect reads format {FORMAT}; use one version for all files", path.display())]
    OtherFormat { path: PathBuf, format: u64 },
    /// The file's parts contradict each other.
    #[error("{}: was damaged or edited: {what}; render its samples anew", path.display())]
    Damaged { path: PathBuf, what: String },
}

/// What a file says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    format: u32,
    #[serde(flatten)]
    pub recipe: Recipe,
    /// Ranges of samples, ascending and disjoint.
    pub samples: Vec<SampleRange>,
    pub events: Events,
    checksum: Fingerprint,
}

/// Writes a part of an image. The same part gives the same bytes.
///
/// # Errors
/// When the path cannot be written, or the encoder refuses.
pub fn write_sums(path: &Path, partial: &Partial) -> Result<(), ExportError> {
    let encode = |message: String| ExportError::Encode { path: path.to_path_buf(), message };
    let bytes = encoded(partial).map_err(encode)?;
    Ok(write_atomically(path, |writer| writer.write_all(&bytes))?)
}

fn encoded(partial: &Partial) -> Result<Vec<u8>, String> {
    let (width, height) = (partial.recipe.width as usize, partial.recipe.height as usize);
    let pixels = partial.counts.len();
    if pixels == 0 || width * height != pixels || partial.sums.sums.len() != pixels {
        return Err(format!("{width}×{height} is not the size of {pixels} pixels"));
    }
    let rgb = partial.to_rgb();
    let mut channels = vec![AnyChannel::new(COUNT, FlatSamples::U32(partial.counts.clone()))];
    for (index, color) in COLORS.into_iter().enumerate() {
        channels.push(AnyChannel::new(color, FlatSamples::F32(rgb.iter().map(|rgb| rgb[index]).collect())));
        for part in 0..4 {
            let bits = partial.sums.sums.par_iter().map(|sum| (sum[index] >> (32 * part)) as u32).collect();
            channels.push(AnyChannel::new(part_name(part, color).as_str(), FlatSamples::U32(bits)));
        }
    }
    let mut head = Head {
        format: FORMAT,
        recipe: partial.recipe.clone(),
        samples: partial.ranges.clone(),
        events: partial.events,
        checksum: Hasher::new("").finish(),
    };
    head.checksum = checksum(&head, partial)?;
    let text = ascii(&serde_json::to_string(&head).map_err(|error| error.to_string())?);
    // ZIP without loss: 16 rows are compressed together.
    let layer = Layer::new(
        (width, height),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut image = Image::from_layer(layer);
    image.attributes.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(Text::from(text.as_str())));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

fn part_name(part: usize, color: &str) -> String {
    format!("sum{part}.{color}")
}

/// JSON in ASCII, all other characters escaped: texts of OpenEXR are bytes.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            text.push(c);
        } else {
            // Such characters stand within strings only.
            c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| text += &format!("\\u{unit:04x}"));
        }
    }
    text
}

/// Over the head, without its checksum, and all sums and counts.
fn checksum(head: &Head, partial: &Partial) -> Result<Fingerprint, String> {
    let mut hasher = Hasher::new("iorect sums 1");
    let head = Head { checksum: Hasher::new("").finish(), ..head.clone() };
    hasher.text(&serde_json::to_string(&head).map_err(|error| error.to_string())?);
    let mut bytes = Vec::new();
    for (sums, counts) in partial.sums.sums.chunks(1024).zip(partial.counts.chunks(1024)) {
        bytes.clear();
        sums.iter().flatten().for_each(|sum| bytes.extend(sum.to_le_bytes()));
        counts.iter().for_each(|count| bytes.extend(count.to_le_bytes()));
        hasher.bytes(&bytes);
    }
    Ok(hasher.finish())
}

/// What a file says of itself, without its pixels.
///
/// # Errors
/// When the file cannot be read, or is no part of an image.
pub fn read_sums_head(path: &Path) -> Result<Head, SumsError> {
    let file = open(path)?;
    let meta = MetaData::read_from_buffered(BufReader::new(file), false).map_err(|error| not_exr(path, &error))?;
    let [header] = &meta.headers[..] else { return Err(SumsError::NoSums { path: path.to_path_buf() }) };
    let name = Text::from(ATTRIBUTE);
    let attribute = header.shared_attributes.other.get(&name).or_else(|| header.own_attributes.other.get(&name));
    let Some(AttributeValue::Text(text)) = attribute else {
        return Err(SumsError::NoSums { path: path.to_path_buf() });
    };
    let damaged = |what: String| SumsError::Damaged { path: path.to_path_buf(), what };
    let text = text.to_string();
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| damaged(format!("its attribute `{ATTRIBUTE}`: {error}")))?;
    match value.get("format").and_then(serde_json::Value::as_u64) {
        Some(format) if format != u64::from(FORMAT) => {
            return Err(SumsError::OtherFormat { path: path.to_path_buf(), format });
        }
        _ => {}
    }
    let head: Head =
        serde_json::from_value(value).map_err(|error| damaged(format!("its attribute `{ATTRIBUTE}`: {error}")))?;
    // Before anything is decoded: pixels, and channels of them, are allocated as the header says.
    limits::check_exr(&meta.headers).map_err(|what| damaged(format!("its image {what}")))?;
    let channels = header.channels.list.len();
    if channels != CHANNELS {
        return Err(damaged(format!("it has {channels} channels instead of {CHANNELS}")));
    }
    let size = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    if size != (u64::from(head.recipe.width), u64::from(head.recipe.height)) || size.0 * size.1 > MOST_PIXELS {
        return Err(damaged(format!("its size is {}×{}", size.0, size.1)));
    }
    let is_in_order = head.samples.windows(2).all(|pair| pair[0].1 < pair[1].0);
    if head.samples.is_empty() || !is_in_order || head.samples.iter().any(|range| range.count() == 0) {
        return Err(damaged("its ranges of samples are empty or out of order".into()));
    }
    Ok(head)
}

/// Reads a part of an image, and makes sure that it is as it was written.
///
/// # Errors
/// When the file cannot be read, is no part of an image, or was changed.
pub fn read_sums(path: &Path) -> Result<Partial, SumsError> {
    let head = read_sums_head(path)?;
    let damaged = |what: String| SumsError::Damaged { path: path.to_path_buf(), what };
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(BufReader::new(open(path)?))
        .map_err(|error| not_exr(path, &error))?;
    let mut channels: HashMap<String, FlatSamples> =
        image.layer_data.channel_data.list.into_iter().map(|c| (c.name.to_string(), c.sample_data)).collect();
    let pixels = head.recipe.width as usize * head.recipe.height as usize;
    let mut integers = |name: &str| match channels.remove(name) {
        Some(FlatSamples::U32(values)) if values.len() == pixels => Ok(values),
        _ => Err(damaged(format!("its channel `{name}` is missing or of another type"))),
    };
    let counts = integers(COUNT)?;
    let mut sums = vec![[0_i128; 3]; pixels];
    for (index, color) in COLORS.into_iter().enumerate() {
        for part in 0..4 {
            let bits = integers(&part_name(part, color))?;
            let bits_of = |bits: u32| (u128::from(bits) << (32 * part)) as i128;
            sums.par_iter_mut().zip(&bits).for_each(|(sum, bits)| sum[index] |= bits_of(*bits));
        }
    }
    let partial = Partial {
        ranges: head.samples.clone(),
        events: head.events,
        sums: ExactSums { unit_exponent: head.recipe.unit_exponent, sums },
        counts,
        recipe: head.recipe.clone(),
    };
    if checksum(&head, &partial).map_err(damaged)? != head.checksum {
        return Err(damaged("its checksum is not that of its contents".into()));
    }
    require_plausible(&partial).map_err(damaged)?;
    let rgb = partial.to_rgb();
    for (index, color) in COLORS.into_iter().enumerate() {
        let is_mean = match channels.remove(color) {
            Some(FlatSamples::F32(values)) => {
                // To the bit: what another program has touched may no longer mean the same.
                values.len() == pixels && values.iter().zip(&rgb).all(|(a, b)| a.to_bits() == b[index].to_bits())
            }
            _ => false,
        };
        if !is_mean {
            return Err(damaged(format!("its channel `{color}` is not the mean of its sums")));
        }
    }
    Ok(partial)
}

/// Whether sums of so many parts can be added without overflow, as all that are written can.
fn require_plausible(partial: &Partial) -> Result<(), String> {
    let samples = partial.samples();
    let events = partial.events;
    if events.named().iter().any(|(_, count)| *count > MOST_EVENTS) || events.crossings.max(events.mixed) > MOST_EVENTS
    {
        return Err("it counts more events than can have happened".into());
    }
    if !(-1024..=1023).contains(&partial.recipe.unit_exponent) {
        return Err("the unit of its sums is out of range".into());
    }
    if let Some(pixel) = partial.counts.iter().position(|count| *count > samples) {
        return Err(format!("pixel {pixel} has more samples than it can have"));
    }
    let is_too_large =
        |(sum, count): (&[i128; 3], &u32)| sum.iter().any(|sum| sum.unsigned_abs() > u128::from(*count) << MOST_BITS);
    match partial.sums.sums.iter().zip(&partial.counts).position(is_too_large) {
        Some(pixel) => Err(format!("the sum of pixel {pixel} is larger than it can be")),
        None => Ok(()),
    }
}

fn open(path: &Path) -> Result<File, SumsError> {
    disk::open(path).map_err(|reason| SumsError::Read { path: path.to_path_buf(), reason })
}

fn not_exr(path: &Path, error: &exr::error::Error) -> SumsError {
    SumsError::NotExr { path: path.to_path_buf(), message: error.to_string() }
}
