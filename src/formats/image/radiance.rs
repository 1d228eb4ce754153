//! Radiance pictures (.hdr, .pic).
//!
//! As Radiance's own `color.c`, `header.c` and `resolu.c` read them (Ward, "Real Pixels", Graphics Gems II, 1991; "Radiance File
//! Formats"): all eight orientations, flat and both run-length encodings, RGBE and XYZE. Radiance in W/(sr·m²) is what the pixels say,
//! divided by the product of all `EXPOSURE` lines and, channel by channel, of all `COLORCORR` lines.

use super::color::{self, Chromaticities};
use super::limits::{black, pixel_count};
use crate::scene::LoadNote;
use crate::scene::environment::EnvironmentImage;

pub(super) fn read(bytes: &[u8]) -> Result<EnvironmentImage, String> {
    let mut lines = Lines::new(bytes);
    let mut header = Header::read(&mut lines)?;
    let layout = Layout::parse(lines.next().ok_or("is cut off before its resolution")?)?;
    let (width, height) = layout.size();
    let count = pixel_count(width as u64, height as u64)?;
    let mut data = Data { bytes: lines.rest };
    let scales = header.scales();
    let is_as_stored = scales == [1.0; 3] && header.gamma == 1.0;
    let exponents: Vec<f32> = (0..=255).map(|e| if e == 0 { 0.0 } else { (e as f32 - 136.0).exp2() }).collect();
    let mut pixels = black(count)?;
    let mut scanline = vec![[0_u8; 4]; layout.length];
    for index in 0..layout.scanlines {
        data.scanline(&mut scanline)
            .map_err(|fault| format!("{fault} in scanline {} of {}", index + 1, layout.scanlines))?;
        for (along, [r, g, b, e]) in scanline.iter().enumerate() {
            let exponent = exponents[usize::from(*e)];
            let mut color = [r, g, b].map(|mantissa| f32::from(*mantissa) * exponent);
            if !is_as_stored {
                for (component, scale) in color.iter_mut().zip(scales) {
                    *component = (f64::from(*component).powf(header.gamma) * scale) as f32;
                }
            }
            pixels[layout.place(index, along)] = color;
        }
    }
    header.convert_colors(&mut pixels);
    Ok(EnvironmentImage { width, height, pixels, notes: header.notes })
}

/// The lines of the header. What follows the last is binary.
struct Lines<'a> {
    rest: &'a [u8],
    /// 1-based, of the line that was read last.
    number: usize,
    end: u8,
}

impl<'a> Lines<'a> {
    /// The first line tells how lines end: by LF, which may have a CR before it, or by CR alone.
    fn new(bytes: &'a [u8]) -> Self {
        let first = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let is_cr = first.is_some_and(|at| bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n'));
        Self { rest: bytes, number: 0, end: if is_cr { b'\r' } else { b'\n' } }
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        let at = self.rest.iter().position(|byte| *byte == self.end)?;
        let line = &self.rest[..at];
        self.rest = &self.rest[at + 1..];
        self.number += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// What the header says of the pixels.
struct Header {
    exposure: f64,
    correction: [f64; 3],
    /// Pixels are radiance to the power of 1 / this.
    gamma: f64,
    primaries: Option<Chromaticities>,
    is_xyz: bool,
    notes: Vec<LoadNote>,
}

impl Header {
    fn read(lines: &mut Lines<'_>) -> Result<Self, String> {
        // Programs put their own name after `#?`.
        if !lines.rest.starts_with(b"#?") {
            return Err("is no Radiance picture: it does not begin with `#?`".into());
        }
        let mut header =
            Self { exposure: 1.0, correction: [1.0; 3], gamma: 1.0, primaries: None, is_xyz: false, notes: Vec::new() };
        loop {
            let line = lines.next().ok_or("is cut off in its header")?;
            if line.is_empty() {
                return Ok(header);
            }
            // Indented lines tell of the pictures that this one was made from, and do not count.
            let line = String::from_utf8_lossy(line);
            let Some((key, value)) = line.split_once('=') else { continue };
            header.line(key, value.trim(), lines.number)?;
        }
    }

    fn line(&mut self, key: &str, value: &str, number: usize) -> Result<(), String> {
        match key {
            "FORMAT" => match value {
                "32-bit_rle_rgbe" => self.is_xyz = false,
                "32-bit_rle_xyze" => self.is_xyz = true,
                _ => {
                    return Err(format!(
                        "is of format `{}`, which is not read: save it as 32-bit_rle_rgbe",
                        value.escape_debug()
                    ));
                }
            },
            "EXPOSURE" => match positive(value) {
                Some([exposure]) => self.exposure *= exposure,
                None => self.ignore(key, value, number),
            },
            "COLORCORR" => match positive::<3>(value) {
                Some(factors) => (0..3).for_each(|channel| self.correction[channel] *= factors[channel]),
                None => self.ignore(key, value, number),
            },
            "GAMMA" => match positive(value) {
                Some([gamma]) => self.gamma = gamma,
                None => self.ignore(key, value, number),
            },
            "PRIMARIES" => match numbers(value)
                .map(|[rx, ry, gx, gy, bx, by, wx, wy]| Chromaticities([[rx, ry], [gx, gy], [bx, by], [wx, wy]]))
            {
                Some(primaries) if primaries.to_rec_709().is_ok() => self.primaries = Some(primaries),
                _ => self.ignore(key, value, number),
            },
            _ => {}
        }
        Ok(())
    }

    fn ignore(&mut self, key: &str, value: &str, number: usize) {
        let value: String = value.chars().take(60).collect();
        match self.notes.iter_mut().find(|note| note.kind == "ignored_header") {
            Some(note) => note.count += 1,
            None => {
                let message = format!("`{key}={}` in its header makes no sense and was ignored", value.escape_debug());
                self.notes.push(LoadNote { first_line: Some(number), ..LoadNote::new("ignored_header", 1, message) });
            }
        }
    }

    /// What pixels are to be multiplied by, to be radiance.
    fn scales(&mut self) -> [f64; 3] {
        let scales = self.correction.map(|factor| 1.0 / (factor * self.exposure));
        let shown = if scales[0] == scales[1] && scales[1] == scales[2] {
            format!("{}", scales[0])
        } else {
            format!("{} (red), {} (green) and {} (blue)", scales[0], scales[1], scales[2])
        };
        if scales != [1.0; 3] {
            let message = format!(
                "its header says that it was exposed (EXPOSURE, COLORCORR): multiplied by {shown}, so that it is radiance again"
            );
            self.notes.push(LoadNote::new("exposure_undone", 1, message));
        }
        scales
    }

    fn convert_colors(&mut self, pixels: &mut [[f32; 3]]) {
        let (matrix, from) = match self.primaries.map(Chromaticities::to_rec_709) {
            _ if self.is_xyz => (color::rec_709_from_xyz(), "CIE XYZ"),
            Some(Ok(Some(matrix))) => (matrix, "the primaries in its header"),
            _ => return,
        };
        color::convert(pixels, matrix);
        self.notes.push(color::note(from));
    }
}

fn numbers<const N: usize>(value: &str) -> Option<[f64; N]> {
    let values: Result<Vec<f64>, _> = value.split_whitespace().map(str::parse).collect();
    values.ok()?.try_into().ok()
}

fn positive<const N: usize>(value: &str) -> Option<[f64; N]> {
    numbers(value).filter(|values| values.iter().all(|value| value.is_finite() && *value > 0.0))
}

/// Size and orientation.
struct Layout {
    scanlines: usize,
    /// Pixels of a scanline.
    length: usize,
    /// Whether scanlines are columns.
    is_sideways: bool,
    /// Whether rows go up, and columns to the left.
    is_upwards: bool,
    is_leftwards: bool,
}

impl Layout {
    fn parse(line: &[u8]) -> Result<Self, String> {
        let text = String::from_utf8_lossy(line);
        let fault = || {
            let shown: String = text.chars().take(60).collect();
            format!("has no resolution such as `-Y 512 +X 1024` after its header, but `{}`", shown.escape_debug())
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        let [outer, scanlines, inner, length] = words[..] else { return Err(fault()) };
        let number = |word: &str| word.parse::<u32>().map(|n| n as usize).map_err(|_| fault());
        let (is_sideways, y, x) = match (outer, inner) {
            ("-Y" | "+Y", "-X" | "+X") => (false, outer, inner),
            ("-X" | "+X", "-Y" | "+Y") => (true, inner, outer),
            _ => return Err(fault()),
        };
        Ok(Self {
            scanlines: number(scanlines)?,
            length: number(length)?,
            is_sideways,
            is_upwards: y == "+Y",
            is_leftwards: x == "-X",
        })
    }

    /// Width and height.
    fn size(&self) -> (usize, usize) {
        if self.is_sideways { (self.scanlines, self.length) } else { (self.length, self.scanlines) }
    }

    /// Where the pixel `along` of a scanline lies, row by row from the top left.
    fn place(&self, scanline: usize, along: usize) -> usize {
        let (width, height) = self.size();
        let (column, row) = if self.is_sideways { (scanline, along) } else { (along, scanline) };
        let column = if self.is_leftwards { width - 1 - column } else { column };
        let row = if self.is_upwards { height - 1 - row } else { row };
        row * width + column
    }
}

/// The scanlines.
struct Data<'a> {
    bytes: &'a [u8],
}

impl<'a> Data<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        Ok(self.bytes.split_off(..count).ok_or("is cut off")?)
    }

    fn scanline(&mut self, scanline: &mut [[u8; 4]]) -> Result<(), String> {
        /// Lengths that the newer encoding can have.
        const NEWER: std::ops::RangeInclusive<usize> = 8..=0x7fff;
        if let [2, 2, high @ 0..=127, low, ..] = *self.bytes {
            let length = usize::from(high) << 8 | usize::from(low);
            if length == scanline.len() {
                self.take(4)?;
                return (0..4).try_for_each(|channel| self.channel(scanline, channel));
            }
            if NEWER.contains(&scanline.len()) {
                return Err(format!("has {length} pixels instead of {}", scanline.len()));
            }
        }
        self.pixels(scanline)
    }

    /// One channel of a scanline: runs (above 128) and literal bytes.
    fn channel(&mut self, scanline: &mut [[u8; 4]], channel: usize) -> Result<(), String> {
        let mut rest = scanline;
        while !rest.is_empty() {
            let code = self.take(1)?[0];
            let count = usize::from(if code > 128 { code - 128 } else { code });
            let (now, later) = rest.split_at_mut_checked(count).ok_or("has a run longer than the scanline")?;
            if code > 128 {
                let value = self.take(1)?[0];
                now.iter_mut().for_each(|pixel| pixel[channel] = value);
            } else {
                now.iter_mut().zip(self.take(count)?).for_each(|(pixel, value)| pixel[channel] = *value);
            }
            rest = later;
        }
        Ok(())
    }

    /// Pixel by pixel. (1, 1, 1, n) is no pixel but repeats the one before n times; another right after it counts 256-fold.
    fn pixels(&mut self, scanline: &mut [[u8; 4]]) -> Result<(), String> {
        let (mut at, mut shift) = (0, 0);
        while at < scanline.len() {
            let pixel: [u8; 4] = self.take(4)?.try_into().expect("four were taken");
            let [1, 1, 1, repeats] = pixel else {
                scanline[at] = pixel;
                (at, shift) = (at + 1, 0);
                continue;
            };
            let previous = *at.checked_sub(1).and_then(|at| scanline.get(at)).ok_or("begins with a run of no pixel")?;
            // More than 2²⁸ pixels are not read, which four such bytes can count.
            let count = if shift < 32 { usize::from(repeats) << shift } else { usize::MAX };
            let run = scanline[at..].get_mut(..count).ok_or("has a run longer than the scanline")?;
            run.fill(previous);
            (at, shift) = (at + count, shift + 8);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of the given pixels, flat.
    fn picture(header: &str, resolution: &str, pixels: &[[u8; 4]]) -> Vec<u8> {
        let mut bytes = format!("#?RADIANCE\n{header}\n{resolution}\n").into_bytes();
        bytes.extend(pixels.iter().flatten());
        bytes
    }

    /// Values (0.5, 1, 2) times what the header says.
    fn one(header: &str) -> EnvironmentImage {
        read(&picture(header, "-Y 1 +X 1", &[[64, 128, 255, 129]])).unwrap()
    }

    #[test]
    fn exposures_multiply_and_are_undone() {
        assert_eq!(one("").pixels, [[0.5, 1.0, 1.992_187_5]]);
        assert!(one("").notes.is_empty());
        let image = one("EXPOSURE=4\nEXPOSURE= 0.5 \nCOLORCORR=1 2 0.5\nCOLORCORR=0.5 1 1\n");
        assert_eq!(image.pixels, [[0.5, 0.25, 1.992_187_5]]);
        assert_eq!(image.notes[0].kind, "exposure_undone");
        // Of a picture that this one was made from.
        assert_eq!(one("pcompos a.hdr\n\tEXPOSURE=4\n").pixels, [[0.5, 1.0, 1.992_187_5]]);
    }

    #[test]
    fn lines_that_make_no_sense_are_ignored_and_said() {
        let image = one("EXPOSURE=0\nEXPOSURE=bright\nCOLORCORR=1 1\nPRIMARIES=0 0 0 0 0 0 0 0\nGAMMA=-1\n");
        assert_eq!(image.pixels, one("").pixels);
        let note = &image.notes[0];
        assert_eq!((note.kind, note.count, note.first_line), ("ignored_header", 5, Some(2)));
    }

    #[test]
    fn orientations() {
        // 3×2 pixels, told apart by their red byte: in place, 1 2 3 over 4 5 6.
        let stored = [
            ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
            ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
            ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
            ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
            ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
            ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
            ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
            ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
        ];
        for (resolution, reds) in stored {
            let image = read(&picture("", resolution, &reds.map(|red| [red, 0, 0, 136]))).unwrap();
            assert_eq!((image.width, image.height), (3, 2), "{resolution}");
            let reds: Vec<f32> = image.pixels.iter().map(|pixel| pixel[0]).collect();
            assert_eq!(reds, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{resolution}");
        }
    }

    #[test]
    fn older_runs() {
        // 300 = 44 + 1 × 256 repeats; a run that follows another counts 256-fold.
        let pixels = [[9, 8, 7, 136], [1, 1, 1, 44], [1, 1, 1, 1], [5, 5, 5, 136], [1, 1, 1, 2]];
        let image = read(&picture("", "-Y 1 +X 304", &pixels)).unwrap();
        assert!(image.pixels[..301].iter().all(|pixel| *pixel == [9.0, 8.0, 7.0]));
        assert!(image.pixels[301..].iter().all(|pixel| *pixel == [5.0; 3]));
        for (pixels, fault) in [
            (vec![[1, 1, 1, 3]], "a run of no pixel"),
            (vec![[9, 9, 9, 136], [1, 1, 1, 200], [1, 1, 1, 200]], "longer than the scanline"),
            (vec![[9, 9, 9, 136]], "cut off in scanline 1 of 1"),
        ] {
            let message = read(&picture("", "-Y 1 +X 304", &pixels)).unwrap_err();
            assert!(message.contains(fault), "{message}");
        }
    }

    #[test]
    fn flat_pixels_that_look_like_the_newer_encoding() {
        // Too short for it, so these are pixels.
        let image = read(&picture("", "-Y 1 +X 2", &[[2, 2, 3, 136], [2, 2, 4, 136]])).unwrap();
        assert_eq!(image.pixels, [[2.0, 2.0, 3.0], [2.0, 2.0, 4.0]]);
        let message = read(&picture("", "-Y 1 +X 9", &[[2, 2, 0, 8]; 9])).unwrap_err();
        assert!(message.contains("has 8 pixels instead of 9"), "{message}");
    }

    #[test]
    fn line_ends() {
        for end in ["\n", "\r\n", "\r"] {
            let mut bytes = format!("#?AUTOPANO{end}# made here{end}EXPOSURE=2{end}{end}-Y 1 +X 1{end}").into_bytes();
            // A first byte that could pass for the end of a line.
            bytes.extend([b'\n', 20, 30, 137]);
            assert_eq!(read(&bytes).unwrap().pixels, [[10.0, 20.0, 30.0]], "{end:?}");
        }
    }

    #[test]
    fn headers_that_are_refused() {
        for (bytes, fault) in [
            (&b"P6 1 1 255\n"[..], "no Radiance picture"),
            (b"#?RADIANCE\nFORMAT=ascii\n\n-Y 1 +X 1\n", "format `ascii`"),
            (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "cut off in its header"),
            (b"#?RADIANCE\n\n-Y 1 -Y 1\n", "no resolution"),
            (b"#?RADIANCE\n\n-Y 1 +X -1\n", "no resolution"),
            (b"#?RADIANCE\n\n-Y 0 +X 1\n", "no pixels"),
        ] {
            let message = read(bytes).unwrap_err();
            assert!(message.contains(fault), "{message}");
        }
    }
}
