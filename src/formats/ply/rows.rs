//! The rows of the body, one property after the other.

use std::str::SplitAsciiWhitespace;

use super::super::lines::{Lines, number, shown};
use super::super::passed_over::{Kind, PassedOver};
use super::super::polygons::Fault;
use super::header::{Property, Scalar};

pub(super) trait Rows {
    fn begin_row(&mut self) -> Result<(), Fault>;
    /// A number. All of types up to 32 bits fit f64 exactly, and so do indices and counts of any type.
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault>;
    /// Passes over a value.
    fn skip(&mut self, kind: Scalar) -> Result<(), Fault>;
    fn fault(&self, message: String) -> Fault;
    /// Where the row stands, in text files.
    fn line(&self) -> Option<usize>;
    fn bytes_left(&self) -> usize;
    /// The fewest bytes that a property can take.
    fn least_bytes(&self, property: &Property) -> u64;
    /// At most so many values can follow: a bound on what a list's length may promise.
    fn most_values(&self) -> usize;
    /// Notes what is left when every element has been read.
    fn finish(self, passed_over: &mut PassedOver);
}

pub(super) struct AsciiRows<'a> {
    lines: Lines<'a>,
    words: SplitAsciiWhitespace<'a>,
    /// Of the whole body.
    bytes: usize,
    /// Rows with more values than there are properties, and the line of the first.
    too_long: (u64, Option<usize>),
}

impl<'a> AsciiRows<'a> {
    /// `header_lines` come before the body.
    pub fn new(body: &'a [u8], header_lines: usize) -> Self {
        let lines = Lines { number: header_lines, ..Lines::new(body) };
        Self { lines, words: "".split_ascii_whitespace(), bytes: body.len(), too_long: (0, None) }
    }

    fn next_word(&mut self) -> Result<&'a str, Fault> {
        self.words.next().ok_or_else(|| self.fault("the line has too few values".into()))
    }

    fn end_row(&mut self) {
        if self.words.next().is_some() {
            self.too_long = (self.too_long.0 + 1, self.too_long.1.or(self.line()));
        }
    }
}

impl Rows for AsciiRows<'_> {
    fn begin_row(&mut self) -> Result<(), Fault> {
        self.end_row();
        loop {
            let Some(line) = self.lines.next() else {
                return Err(Fault::at(self.lines.number + 1, "the file ends before its last element"));
            };
            if !line.is_empty() {
                let text = std::str::from_utf8(line).map_err(|_| self.fault("is not text".into()))?;
                self.words = text.split_ascii_whitespace();
                return Ok(());
            }
        }
    }

    fn next(&mut self, kind: Scalar) -> Result<f64, Fault> {
        let word = self.next_word()?;
        let number = number(word).map_err(|message| self.fault(message))?;
        if kind.is_whole() && number.fract() != 0.0 {
            return Err(self.fault(format!("{} is not a whole number", shown(word.as_bytes()))));
        }
        Ok(number)
    }

    fn skip(&mut self, _: Scalar) -> Result<(), Fault> {
        self.next_word().map(drop)
    }

    fn fault(&self, message: String) -> Fault {
        Fault::at(self.lines.number, message)
    }

    fn line(&self) -> Option<usize> {
        Some(self.lines.number)
    }

    fn bytes_left(&self) -> usize {
        self.lines.rest.len()
    }

    fn least_bytes(&self, _: &Property) -> u64 {
        1
    }

    fn most_values(&self) -> usize {
        self.bytes
    }

    fn finish(mut self, passed_over: &mut PassedOver) {
        self.end_row();
        passed_over.add_many(Kind::ExtraValues, self.too_long.0, self.too_long.1);
        let (mut bytes, mut first_line) = (0, None);
        while let Some(line) = self.lines.next() {
            if !line.is_empty() {
                bytes += line.len() as u64;
                first_line = first_line.or(self.line());
            }
        }
        passed_over.add_many(Kind::TrailingBytes, bytes, first_line);
        let padding = self.lines.padding;
        passed_over.add_many(Kind::NulBytes, padding.bytes, Some(padding.first_line));
    }
}

pub(super) struct BinaryRows<'a, const IS_BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const IS_BIG: bool> BinaryRows<'a, IS_BIG> {
    pub fn new(body: &'a [u8]) -> Self {
        Self { rest: body }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (taken, rest) = self.rest.split_first_chunk::<N>().ok_or_else(Self::cut_off)?;
        self.rest = rest;
        let mut taken = *taken;
        if IS_BIG {
            taken.reverse();
        }
        Ok(taken)
    }

    #[cold]
    fn cut_off() -> Fault {
        Fault::new("the file is cut off: it ends before its last element")
    }
}

impl<const IS_BIG: bool> Rows for BinaryRows<'_, IS_BIG> {
    fn begin_row(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    #[inline]
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault> {
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::I64 => i64::from_le_bytes(self.take()?) as f64,
            Scalar::U64 => u64::from_le_bytes(self.take()?) as f64,
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
            Scalar::Other => return Err(self.fault("a value has a type of no known size".into())),
        })
    }

    #[inline]
    fn skip(&mut self, kind: Scalar) -> Result<(), Fault> {
        self.rest = self.rest.get(kind.bytes()..).ok_or_else(Self::cut_off)?;
        Ok(())
    }

    fn fault(&self, message: String) -> Fault {
        Fault::new(message)
    }

    fn line(&self) -> Option<usize> {
        None
    }

    fn bytes_left(&self) -> usize {
        self.rest.len()
    }

    fn least_bytes(&self, property: &Property) -> u64 {
        property.length.unwrap_or(property.kind).bytes() as u64
    }

    fn most_values(&self) -> usize {
        self.rest.len()
    }

    fn finish(self, passed_over: &mut PassedOver) {
        passed_over.add_many(Kind::TrailingBytes, self.rest.len() as u64, None);
    }
}
