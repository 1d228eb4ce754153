//! Films and images on disk between runs of the program: written beside and renamed, and never trusted without their checksum.
//!
//! A file is the SHA-256 of all that follows, then numbers in little-endian order. What they mean is the business of who wrote them; the key in
//! the file's name is of everything that decided them.

use std::path::Path;

use crate::export::ExportError;
use crate::formats::disk::{self, FileError, MAX_DATA_BYTES};
use crate::scene::Fingerprint;
use crate::tracking::Events;
use crate::writing::write_atomically;

const CHECKSUM: usize = 32;

/// Writes numbers.
#[derive(Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    pub fn integer(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn small(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn number(&mut self, value: f64) {
        self.integer(value.to_bits());
    }

    pub fn single(&mut self, value: f32) {
        self.small(value.to_bits());
    }

    pub fn events(&mut self, events: &Events) {
        let Events {
            stack_underflow,
            stack_overflow,
            ambiguous,
            inconsistent,
            non_finite,
            radiance_overflow,
            crossings,
            mixed,
        } = *events;
        [stack_underflow, stack_overflow, ambiguous, inconsistent, non_finite, radiance_overflow, crossings, mixed]
            .into_iter()
            .for_each(|count| self.integer(count));
    }

    /// Keeps what was written at `path`.
    ///
    /// # Errors
    /// As [`write_atomically`].
    pub fn keep(self, path: &Path) -> Result<(), ExportError> {
        let checksum = checksum(&self.0);
        Ok(write_atomically(path, |file| {
            file.write_all(&checksum)?;
            file.write_all(&self.0)
        })?)
    }
}

fn checksum(bytes: &[u8]) -> [u8; CHECKSUM] {
    Fingerprint::of_bytes(bytes).to_bytes()
}

/// Reads what a [`Writer`] wrote. Every read past the end is `None`.
pub struct Reader {
    bytes: Vec<u8>,
    at: usize,
}

impl Reader {
    /// `None` where there is no such file, or one that is damaged or cannot be read, which is logged: it is to be made again.
    pub fn open(path: &Path) -> Option<Self> {
        let problem = match disk::read(path, MAX_DATA_BYTES) {
            Ok(bytes) if bytes.len() < CHECKSUM || checksum(&bytes[CHECKSUM..]) != bytes[..CHECKSUM] => {
                "is damaged: its contents are not those that were written".to_owned()
            }
            Ok(bytes) => return Some(Self { bytes, at: CHECKSUM }),
            Err(FileError::NotFound) => return None,
            Err(error) => error.to_string(),
        };
        log::warn!("{}: {problem}; it is made again", path.display());
        None
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = self.bytes.get(self.at..self.at + N)?.try_into().ok()?;
        self.at += N;
        Some(bytes)
    }

    pub fn integer(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub fn small(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn number(&mut self) -> Option<f64> {
        self.integer().map(f64::from_bits)
    }

    pub fn single(&mut self) -> Option<f32> {
        self.small().map(f32::from_bits)
    }

    pub fn events(&mut self) -> Option<Events> {
        Some(Events {
            stack_underflow: self.integer()?,
            stack_overflow: self.integer()?,
            ambiguous: self.integer()?,
            inconsistent: self.integer()?,
            non_finite: self.integer()?,
            radiance_overflow: self.integer()?,
            crossings: self.integer()?,
            mixed: self.integer()?,
        })
    }

    /// Whether all has been read.
    pub fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_is_written_is_read_and_what_is_damaged_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("piece");
        assert!(Reader::open(&path).is_none());
        let mut writer = Writer::default();
        writer.integer(u64::MAX - 3);
        writer.small(7);
        writer.number(0.1);
        writer.single(-0.0);
        writer.keep(&path).unwrap();
        let mut reader = Reader::open(&path).unwrap();
        assert_eq!(reader.integer(), Some(u64::MAX - 3));
        assert_eq!(reader.small(), Some(7));
        assert_eq!(reader.number(), Some(0.1));
        assert!(!reader.is_at_end());
        assert_eq!(reader.single().map(f32::to_bits), Some((-0.0_f32).to_bits()));
        assert!(reader.is_at_end() && reader.small().is_none());

        let whole = fs::read(&path).unwrap();
        for bit in [0, 8 * CHECKSUM, 8 * whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, damaged).unwrap();
            assert!(Reader::open(&path).is_none(), "bit {bit}");
        }
        for length in [0, CHECKSUM - 1, CHECKSUM, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(Reader::open(&path).is_none(), "{length} bytes");
        }
    }
}
