//! Files that are either whole or not there: written beside, flushed, and renamed into place.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::ExportError;

/// Writes a file through a temporary one in the same folder. What stood at `path` before stays until the new file is complete, so an
/// interruption or a full disk leaves nothing half written.
///
/// # Errors
/// When the folder is missing or not writable, `path` is a folder, or `write` fails.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), ExportError> {
    let target = resolve(path)?;
    let failed = |reason| ExportError::Write { path: path.to_path_buf(), reason };
    let mut writer = BufWriter::new(temporary_beside(&target).map_err(failed)?);
    write(&mut writer).map_err(failed)?;
    let file = writer.into_inner().map_err(|e| failed(e.into_error()))?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(&target).map_err(|e| failed(e.error))?;
    Ok(())
}

/// Finds out whether [`write_atomically`] would be able to write `path`, without leaving anything behind: to be asked before minutes
/// are spent on a picture that could not be kept.
///
/// # Errors
/// As [`write_atomically`].
pub fn require_writable(path: &Path) -> Result<(), ExportError> {
    let target = resolve(path)?;
    match temporary_beside(&target) {
        Ok(_removed_when_dropped) => Ok(()),
        Err(reason) => Err(ExportError::Write { path: path.to_path_buf(), reason }),
    }
}

/// The file to replace: what a link points to, so that the link itself survives.
fn resolve(path: &Path) -> Result<PathBuf, ExportError> {
    if path.is_dir() {
        return Err(ExportError::IsFolder { path: path.to_path_buf() });
    }
    if path.file_name().is_none() {
        return Err(ExportError::NoFileName { path: path.to_path_buf() });
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(ExportError::NoFolder { path: path.to_path_buf(), folder: folder.to_path_buf() });
    }
    Ok(fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn without_path(error: &io::Error) -> String {
    let cause = error.get_ref().and_then(std::error::Error::source);
    cause.map_or_else(|| error.to_string(), ToString::to_string)
}

fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".iorect-").suffix(".tmp");
    // Temporary files are private by default; a picture should be as readable as the user's umask makes any other file.
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    // The crate adds the temporary file's own name to the error, which would only puzzle.
    builder.tempfile_in(folder_of(target)).map_err(|error| io::Error::new(error.kind(), without_path(&error)))
}
