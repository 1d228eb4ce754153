//! Finished pieces of a report on disk, so that an interrupted one goes on where it was.
//!
//! A piece is a file, named after the piece and the hash of everything that decides it: scene, settings, build, machine. It holds the SHA-256 of the
//! rest, then what decided the piece as JSON and the piece itself, both in CBOR. A file that is damaged, or stands in the place of another, is
//! made again.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::export::ExportError;
use crate::formats::disk::{self, FileError, MAX_DATA_BYTES};
use crate::scene::Fingerprint;
use crate::writing::{WriteError, require_writable, write_atomically};

/// Bytes of a SHA-256.
const CHECKSUM: usize = 32;

/// A folder of finished pieces.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
    /// Part of every key: the build that measures.
    build: String,
}

/// Where a piece is kept, and what decided it.
struct Key {
    path: PathBuf,
    /// JSON.
    made_from: String,
}

impl Store {
    /// The pieces in `folder`, which is made where it is missing.
    ///
    /// # Errors
    /// When the folder cannot be made or written into.
    pub fn open(folder: &Path) -> Result<Self, ExportError> {
        let failed = |reason| WriteError::System { path: folder.to_path_buf(), reason };
        fs::create_dir_all(folder).map_err(failed)?;
        require_writable(&folder.join("piece"))?;
        Ok(Self { folder: folder.to_path_buf(), build: build() })
    }

    fn key(&self, name: &str, inputs: &impl Serialize) -> Key {
        let made_from = serde_json::json!({ "name": name, "build": self.build, "inputs": inputs }).to_string();
        let path = self.folder.join(format!("{name}-{}", Fingerprint::of_bytes(made_from.as_bytes()).short()));
        Key { path, made_from }
    }

    /// The piece called `name` that follows from `inputs`: as it was kept, else made now and kept. `None` where `make` gives up, as it
    /// does when it is cancelled; nothing is kept then.
    ///
    /// # Errors
    /// When `make` fails, or what it made cannot be kept.
    pub fn piece<T: Serialize + DeserializeOwned, E: From<ExportError>>(
        &self,
        name: &str,
        inputs: &impl Serialize,
        make: impl FnOnce() -> Result<Option<T>, E>,
    ) -> Result<Option<T>, E> {
        if let Some(piece) = self.find(name, inputs) {
            return Ok(Some(piece));
        }
        let made = make()?;
        if let Some(piece) = &made {
            self.keep(name, inputs, piece)?;
        }
        Ok(made)
    }

    /// The piece as it was kept; `None` where there is none, or one that cannot be used, which is logged.
    pub fn find<T: DeserializeOwned>(&self, name: &str, inputs: &impl Serialize) -> Option<T> {
        let key = self.key(name, inputs);
        let problem = match disk::read(&key.path, MAX_DATA_BYTES) {
            Ok(bytes) => match parse(&bytes, &key.made_from) {
                Ok(piece) => return Some(piece),
                Err(problem) => problem,
            },
            Err(FileError::NotFound) => return None,
            Err(error) => error.to_string(),
        };
        log::warn!("{}: {problem}; it is made again", key.path.display());
        None
    }

    /// Keeps a piece in place of the one kept under the same name and inputs.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn keep(&self, name: &str, inputs: &impl Serialize, piece: &impl Serialize) -> Result<(), ExportError> {
        let Key { path, made_from } = self.key(name, inputs);
        let mut bytes = Vec::new();
        ciborium::into_writer(&(made_from, piece), &mut bytes)
            .map_err(|error| WriteError::System { path: path.clone(), reason: std::io::Error::other(error) })?;
        let checksum = Fingerprint::of_bytes(&bytes).to_bytes();
        Ok(write_atomically(&path, |file| {
            file.write_all(&checksum)?;
            file.write_all(&bytes)
        })?)
    }

    /// Removes a piece, if it is kept.
    pub fn forget(&self, name: &str, inputs: &impl Serialize) {
        let path = self.key(name, inputs).path;
        if let Err(error) = fs::remove_file(&path)
            && error.kind() != ErrorKind::NotFound
        {
            log::warn!("{}: cannot be removed ({error}); it is of no more use", path.display());
        }
    }
}

fn parse<T: DeserializeOwned>(bytes: &[u8], made_from: &str) -> Result<T, String> {
    let (checksum, rest) = bytes.split_at_checked(CHECKSUM).ok_or("is damaged (it is too short)")?;
    if Fingerprint::of_bytes(rest).to_bytes() != checksum {
        return Err("is damaged (its contents are not those that were written)".to_owned());
    }
    let (of, piece): (String, T) =
        ciborium::from_reader(rest).map_err(|error| format!("cannot be understood ({error})"))?;
    if of == made_from { Ok(piece) } else { Err("is another piece".to_owned()) }
}

/// What tells one build of the program from another: times of one say nothing about the next.
fn build() -> String {
    let stamp = || {
        let meta = fs::metadata(std::env::current_exe().ok()?).ok()?;
        let age = meta.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
        Some(format!("{} bytes of {}.{:09}", meta.len(), age.as_secs(), age.subsec_nanos()))
    };
    format!("{} {}", env!("CARGO_PKG_VERSION"), stamp().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::Events;

    fn make(store: &Store, inputs: &str, value: f64) -> f64 {
        let made: Result<_, ExportError> = store.piece("piece", &inputs, || Ok(Some(value)));
        made.unwrap().unwrap()
    }

    #[test]
    fn a_piece_is_kept_until_anything_that_decides_it_changes() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&folder.path().join("a/b")).unwrap();
        // Numbers come back to the bit.
        let value = 0.1 + 0.2;
        assert_eq!(make(&store, "x", value), value);
        assert_eq!(make(&store, "x", 7.0), value);
        assert_eq!(make(&store, "y", 7.0), 7.0);
        let other_build = Store { build: "another".into(), ..store };
        assert_eq!(make(&other_build, "x", 8.0), 8.0);
    }

    /// Every count, those that are no events among them.
    #[test]
    fn a_kept_piece_comes_back_whole() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let events = Events {
            stack_underflow: 1,
            stack_overflow: 2,
            ambiguous: 3,
            inconsistent: 4,
            non_finite: 5,
            radiance_overflow: 8,
            crossings: u64::MAX,
            mixed: 7,
        };
        for made_now in [events, Events::default()] {
            let piece: Result<_, ExportError> = store.piece("piece", &"x", || Ok(Some(made_now)));
            assert_eq!(piece.unwrap(), Some(events));
        }
    }

    #[test]
    fn what_is_damaged_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        assert_eq!(make(&store, "x", 1.25), 1.25);
        let path = store.key("piece", &"x").path;
        let whole = fs::read(&path).unwrap();
        assert_eq!(make(&store, "y", 2.5), 2.5);
        let another = fs::read(store.key("piece", &"y").path).unwrap();
        let flipped = |bit: usize| {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        };
        let bits = [0, 8 * CHECKSUM, 8 * whole.len() - 1].map(flipped);
        let ends = [0, CHECKSUM - 1, CHECKSUM, whole.len() - 1].map(|length| whole[..length].to_vec());
        for damaged in bits.into_iter().chain(ends).chain([another]) {
            fs::write(&path, damaged).unwrap();
            assert_eq!(make(&store, "x", 3.5), 3.5);
        }
        fs::write(&path, &whole).unwrap();
        assert_eq!(make(&store, "x", 9.0), 1.25);
    }

    #[test]
    fn what_was_given_up_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let made: Result<Option<f64>, ExportError> = store.piece("piece", &"x", || Ok(None));
        assert!(made.unwrap().is_none());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn what_is_forgotten_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        store.forget("piece", &"x");
        assert_eq!(make(&store, "x", 1.0), 1.0);
        store.forget("piece", &"x");
        assert_eq!(make(&store, "x", 2.0), 2.0);
    }
}
