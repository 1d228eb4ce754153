//! Finished pieces of a report on disk, so that an interrupted one goes on where it was.
//!
//! A piece is kept under the hash of everything that decides it, and with a hash of its own contents: what was made from another scene,
//! by other settings, another build or another machine is never found, and a file that was damaged is made again.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::export::ExportError;
use crate::formats::disk::{self, FileError, MAX_DATA_BYTES};
use crate::scene::Fingerprint;
use crate::writing::{WriteError, require_writable, write_atomically};

/// A folder of finished pieces.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
    /// Part of every key: the build that measures.
    build: String,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    /// What decided the piece, for people who look.
    made_from: serde_json::Value,
    /// SHA-256 of `piece`.
    sha256: Fingerprint,
    /// The piece as JSON.
    piece: String,
}

impl Store {
    /// The pieces in `folder`, which is made where it is missing.
    ///
    /// # Errors
    /// When the folder cannot be made or written into.
    pub fn open(folder: &Path) -> Result<Self, ExportError> {
        let failed = |reason| WriteError::System { path: folder.to_path_buf(), reason };
        fs::create_dir_all(folder).map_err(failed)?;
        require_writable(&folder.join("piece.json"))?;
        Ok(Self { folder: folder.to_path_buf(), build: build() })
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where something of this build is kept that is no JSON and has a format of its own.
    pub fn file(&self, name: &str, inputs: Fingerprint) -> PathBuf {
        let key = Fingerprint::of_bytes(format!("{} {inputs}", self.build).as_bytes());
        self.folder.join(format!("{name}-{}", key.short()))
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
        let made_from = serde_json::json!({ "name": name, "build": self.build, "inputs": inputs });
        let key = Fingerprint::of_bytes(made_from.to_string().as_bytes());
        let path = self.folder.join(format!("{name}-{}.json", key.short()));
        match self.read(&path) {
            Ok(Some(piece)) => return Ok(Some(piece)),
            Ok(None) => {}
            Err(reason) => log::warn!("{}: {reason}; it is made again", path.display()),
        }
        let Some(made) = make()? else { return Ok(None) };
        self.write(&path, made_from, &made)?;
        Ok(Some(made))
    }

    /// `Ok(None)` where nothing is kept.
    fn read<T: DeserializeOwned>(&self, path: &Path) -> Result<Option<T>, String> {
        let text = match disk::read(path, MAX_DATA_BYTES) {
            Ok(text) => text,
            Err(FileError::NotFound) => return Ok(None),
            Err(error) => return Err(error.to_string()),
        };
        let kept: Kept = serde_json::from_slice(&text).map_err(|error| format!("is damaged ({error})"))?;
        if Fingerprint::of_bytes(kept.piece.as_bytes()) != kept.sha256 {
            return Err("is damaged (its contents are not those that were written)".to_owned());
        }
        serde_json::from_str(&kept.piece).map(Some).map_err(|error| format!("cannot be understood ({error})"))
    }

    fn write(&self, path: &Path, made_from: serde_json::Value, piece: &impl Serialize) -> Result<(), ExportError> {
        let failed = |error: serde_json::Error| WriteError::System { path: path.to_path_buf(), reason: error.into() };
        let piece = serde_json::to_string(piece).map_err(failed)?;
        let kept = Kept { made_from, sha256: Fingerprint::of_bytes(piece.as_bytes()), piece };
        let text = serde_json::to_string(&kept).map_err(failed)?;
        Ok(write_atomically(path, |writer| writer.write_all(text.as_bytes()))?)
    }
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
        let path = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        for damaged in [text.replace("1.25", "1.75"), text[..text.len() / 2].to_owned(), String::new()] {
            assert_ne!(damaged, text);
            fs::write(&path, damaged).unwrap();
            assert_eq!(make(&store, "x", 3.5), 3.5);
            fs::write(&path, &text).unwrap();
        }
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
}
