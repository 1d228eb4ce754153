//! Temporary files beside their targets, which go with whoever made them.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

use super::target::{Replaced, folder_of};

/// How their names begin and end.
pub(super) const PREFIX: &str = ".iorect-";
pub(super) const SUFFIX: &str = ".tmp";

/// Paths of this process's temporary files, for [`remove_all`].
static ALIVE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A temporary file, removed when dropped unless it was renamed.
pub(super) struct Temporary {
    file: File,
    path: TempPath,
    _listed: Listed,
}

impl Temporary {
    /// Locked for as long as it is open, by which [`super::stale`] knows that somebody still writes to it.
    pub fn beside(target: &Replaced) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A new file gets what the umask leaves; a replacement is private until it is given the old file's permissions.
            let mode = if target.existing.is_some() { 0o600 } else { 0o666 };
            builder.permissions(std::fs::Permissions::from_mode(mode));
        }
        // The list stays locked until the file is on it, so that an interruption finds every file.
        let mut alive = alive();
        let (file, path) = builder.tempfile_in(folder_of(&target.path)).map_err(without_path)?.into_parts();
        alive.push(path.to_path_buf());
        drop(alive);
        // Where there are no locks, `stale` goes by the file's age.
        let _ = file.try_lock();
        Ok(Self { file, _listed: Listed(path.to_path_buf()), path })
    }

    pub fn file(&self) -> &File {
        &self.file
    }

    /// Puts it in the place of `target`.
    pub fn rename(self, target: &Path) -> io::Result<()> {
        self.path.persist(target).map_err(|error| error.error)
    }
}

/// An entry of [`ALIVE`], gone when dropped.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        let mut alive = alive();
        if let Some(index) = alive.iter().position(|path| *path == self.0) {
            alive.swap_remove(index);
        }
    }
}

fn alive() -> MutexGuard<'static, Vec<PathBuf>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files. While the returned guard is held, no more can be made.
pub(super) fn remove_all() -> MutexGuard<'static, Vec<PathBuf>> {
    let alive = alive();
    for path in &*alive {
        // It may have been renamed just now, or its folder be gone; the process ends anyhow.
        let _ = std::fs::remove_file(path);
    }
    alive
}

/// The crate adds the temporary file's own name to an error, which would only puzzle.
fn without_path(error: io::Error) -> io::Error {
    let cause = error.get_ref().and_then(std::error::Error::source);
    let message = cause.map_or_else(|| error.to_string(), ToString::to_string);
    io::Error::new(error.kind(), message)
}
