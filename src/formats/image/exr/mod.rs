//! OpenEXR: scan lines and tiles, one part or several, half, float and integer channels, RGB, XYZ, luminance with or without chroma.
//!
//! "Technical Introduction to OpenEXR" and "OpenEXR File Layout" (Academy Software Foundation). The `exr` crate parses headers and
//! decompresses blocks; its readers of whole images know neither subsampled channels nor limits, so blocks are put together here.

mod blocks;
mod chroma;
mod layer;

use std::io::Cursor;
use std::ops::Range;

use exr::meta::MetaData;
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;

use self::blocks::Samples;
use self::layer::{Colors, Layer};
use super::color::{self, Chromaticities};
use super::limits::{self, black, pixel_count};
use crate::scene::LoadNote;
use crate::scene::environment::EnvironmentImage;

pub(super) fn read(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    let mut rest = Cursor::new(bytes);
    let meta = MetaData::read_from_buffered(&mut rest, false).map_err(decoding)?;
    if meta.requirements.has_deep_data || meta.headers.iter().any(|header| header.deep) {
        return Err("holds deep data (several samples a pixel), which is not read: flatten it first".into());
    }
    limits::check_exr(&meta.headers)?;
    let (layer, note) = Layer::choose(&meta.headers)?;
    let header = &meta.headers[layer.part];
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        return Err(
            "is a cube map, which is not read: convert it to latitude–longitude, for example with `exrenvmap -latlong`"
                .into(),
        );
    }
    let mut notes: Vec<LoadNote> = note.into_iter().collect();
    let windows = Windows::of(header)?;
    notes.extend(windows.note());

    let count = pixel_count(windows.width as u64, windows.height as u64)?;
    let mut samples = Samples { windows, pixels: black(count)?, chroma: chroma::planes(header, &layer)? };
    blocks::read(&meta, &layer, &mut rest, &mut samples)?;
    let Samples { windows, mut pixels, chroma } = samples;

    let chromaticities = header.shared_attributes.chromaticities.map(|c| {
        Chromaticities([c.red, c.green, c.blue, c.white].map(|point| [f64::from(point.0), f64::from(point.1)]))
    });
    match (&layer.colors, chroma) {
        (Colors::Luminance(_), _) => pixels.iter_mut().for_each(|pixel| *pixel = [pixel[1]; 3]),
        (Colors::LuminanceChroma { .. }, Some(chroma)) => {
            let weights = chromaticities.unwrap_or(color::REC_709).luminance_weights();
            chroma.add_to(&mut pixels, &windows, weights);
        }
        _ => {}
    }
    let matrix = match (&layer.colors, chromaticities.map(Chromaticities::to_rec_709)) {
        (Colors::Xyz(_), _) => Some((color::rec_709_from_xyz(), "CIE XYZ")),
        // Grey has the colour of white, whichever that is.
        (Colors::Luminance(_), _) | (_, None | Some(Ok(None))) => None,
        (_, Some(Ok(Some(matrix)))) => Some((matrix, "its chromaticities")),
        (_, Some(Err(fault))) => {
            let message = format!("its chromaticities {fault} and were ignored: it was read as Rec. 709");
            notes.push(LoadNote::new("ignored_header", 1, message));
            None
        }
    };
    if let Some((matrix, from)) = matrix {
        color::convert(&mut pixels, matrix);
        notes.push(color::note(from));
    }
    Ok(EnvironmentImage { width: windows.width, height: windows.height, pixels, notes })
}

fn decoding(error: exr::error::Error) -> String {
    format!("cannot be decoded: {error}")
}

/// The window that the image fills, and where the file's data lie in it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Windows {
    /// Of the display window: the size of the image.
    width: usize,
    height: usize,
    /// Top left corner of the data window, from that of the display window.
    left: i64,
    top: i64,
    data_width: usize,
    data_height: usize,
}

impl Windows {
    fn of(header: &Header) -> Result<Self, String> {
        let (display, data) = (header.shared_attributes.display_window, header.data_window());
        let windows = Self {
            width: display.size.0,
            height: display.size.1,
            left: i64::from(data.position.0) - i64::from(display.position.0),
            top: i64::from(data.position.1) - i64::from(display.position.1),
            data_width: data.size.0,
            data_height: data.size.1,
        };
        if windows.columns().is_empty() || windows.rows().is_empty() {
            return Err("has no data within its display window: its windows must overlap".into());
        }
        Ok(windows)
    }

    /// Columns of the data that are within the display window.
    fn columns(&self) -> Range<usize> {
        overlap(self.left, self.data_width, self.width)
    }

    /// Rows of the data that are within the display window.
    fn rows(&self) -> Range<usize> {
        overlap(self.top, self.data_height, self.height)
    }

    /// The row of the image that a row of the data is, if it is within the display window.
    fn row(&self, data_row: usize) -> Option<usize> {
        self.rows().contains(&data_row).then(|| (self.top + data_row as i64) as usize)
    }

    /// The column of the image that a column of the data is, which must be within the display window.
    fn column(&self, data_column: usize) -> usize {
        (self.left + data_column as i64) as usize
    }

    fn note(&self) -> Option<LoadNote> {
        let seen = self.columns().len() * self.rows().len();
        let (empty, cropped) = (self.width * self.height - seen, self.data_width * self.data_height - seen);
        let what = match (empty, cropped) {
            (0, 0) => return None,
            (_, 0) => format!("{empty} pixels have no data and are black"),
            (0, _) => format!("{cropped} pixels outside it were cropped"),
            _ => format!("{empty} pixels have no data and are black, and {cropped} outside it were cropped"),
        };
        let message = format!("the data of the environment image do not fill its display window: {what}");
        Some(LoadNote::new("data_window", (empty + cropped) as u64, message))
    }
}

/// Which of `data` places, the first of which lies at `offset`, are among the first `size`.
fn overlap(offset: i64, data: usize, size: usize) -> Range<usize> {
    let first = (-offset).clamp(0, data as i64);
    let end = (size as i64 - offset).clamp(first, data as i64);
    first as usize..end as usize
}

/// Names from files, such as may be shown.
fn shown<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    /// Names that are listed; the rest is counted.
    const MOST: usize = 12;
    let names: Vec<&str> = names.into_iter().collect();
    let short = |name: &&str| format!("`{}`", name.chars().take(40).collect::<String>().escape_debug());
    let mut list = names.iter().take(MOST).map(short).collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        list += &format!(" and {} more", names.len() - MOST);
    }
    list
}
