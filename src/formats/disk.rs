//! Files on disk, read with bounds: regular files only, and no more of them than a documented limit.
//!
//! What is no regular file (a device, a named pipe, a socket) may have no end, or keep a reader waiting for ever, so it is refused
//! before it is opened.

use std::borrow::Cow;
use std::fs::{File, FileType, Metadata};
use std::io::{self, Read};
use std::path::Path;

use super::files::Files;

/// Most bytes of a scene file. A scene's size is in its meshes and images; its text is for people.
pub const MAX_SCENE_BYTES: u64 = 64 << 20;
/// Most bytes of a mesh or an image that a scene names, and of what the program keeps for itself between runs.
pub const MAX_DATA_BYTES: u64 = 4 << 30;

/// Why a file cannot be read, in words that follow its name.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("cannot be read: there is no such file")]
    NotFound,
    /// A folder, a device, a pipe or a socket.
    #[error("is {0}, not a file")]
    NotAFile(&'static str),
    #[error("has {bytes} bytes; at most {limit} are read")]
    TooLarge { bytes: u64, limit: u64 },
    /// It grew while it was read, or told no size.
    #[error("has more bytes than the {0} that are read at most")]
    Endless(u64),
    #[error("cannot be read: there is not enough memory for its {0} bytes")]
    OutOfMemory(u64),
    #[error("cannot be read: permission denied")]
    PermissionDenied,
    #[error("cannot be read: {0}")]
    Other(io::Error),
}

impl From<io::Error> for FileError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => Self::NotFound,
            io::ErrorKind::PermissionDenied => Self::PermissionDenied,
            _ => Self::Other(error),
        }
    }
}

/// The file system: regular files of at most [`MAX_DATA_BYTES`].
#[derive(Debug, Clone, Copy)]
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &Path) -> Result<Cow<'_, [u8]>, String> {
        read(path, MAX_DATA_BYTES).map(Cow::Owned).map_err(|error| error.to_string())
    }
}

/// All bytes of a regular file.
///
/// # Errors
/// When it is missing, no regular file, larger than `limit`, or the system refuses.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    let (file, bytes) = open_with_size(path)?;
    if bytes > limit {
        return Err(FileError::TooLarge { bytes, limit });
    }
    if bytes == 0 {
        // Files of `/proc` tell no size; some have no end, and reading others waits.
        return Ok(Vec::new());
    }
    read_at_most(file, bytes, limit)
}

/// A regular file, open for reading.
///
/// # Errors
/// When it is missing, no regular file, or the system refuses.
pub fn open(path: &Path) -> Result<File, FileError> {
    open_with_size(path).map(|(file, _)| file)
}

/// All bytes of a regular file, or of what this process was handed open, such as a pipe at `/dev/stdin`: that ends when its writer does.
///
/// # Errors
/// As [`read`].
pub fn read_or_receive(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    if is_handed_over(path) && !require_known(&std::fs::metadata(path)?)?.is_file() {
        return read_at_most(File::open(path)?, 0, limit);
    }
    read(path, limit)
}

/// Whether the path is the name of an open descriptor of this process.
fn is_handed_over(path: &Path) -> bool {
    cfg!(unix) && (path == Path::new("/dev/stdin") || ["/dev/fd", "/proc/self/fd"].iter().any(|f| path.starts_with(f)))
}

fn open_with_size(path: &Path) -> Result<(File, u64), FileError> {
    // Before it is opened: that alone can wait for ever, as at a pipe without a writer, or do something, as at a device.
    require_regular(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    // Another file may have taken its place in between.
    let metadata = file.metadata()?;
    require_regular(&metadata)?;
    Ok((file, metadata.len()))
}

fn require_regular(metadata: &Metadata) -> Result<(), FileError> {
    let kind = require_known(metadata)?;
    if kind.is_file() { Ok(()) } else { Err(FileError::NotAFile(kind_of(kind))) }
}

/// The type of anything but a folder, which never can be read.
fn require_known(metadata: &Metadata) -> Result<FileType, FileError> {
    let kind = metadata.file_type();
    if kind.is_dir() { Err(FileError::NotAFile("a folder")) } else { Ok(kind) }
}

fn kind_of(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a named pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    let _ = kind;
    "something special"
}

/// What is read until the end, of which `expected` bytes are known to be there.
fn read_at_most(source: impl Read, expected: u64, limit: u64) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let reserved = usize::try_from(expected).ok().and_then(|expected| bytes.try_reserve_exact(expected).ok());
    reserved.ok_or(FileError::OutOfMemory(expected))?;
    source.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(FileError::Endless(limit)) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_up_to_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        std::fs::write(&path, [7; 1000]).unwrap();
        assert_eq!(read(&path, 1000).unwrap(), [7; 1000]);
        assert_eq!(read(&path, 999).unwrap_err().to_string(), "has 1000 bytes; at most 999 are read");
        std::fs::write(&path, "").unwrap();
        assert!(read(&path, 0).unwrap().is_empty());
    }

    /// A file that tells too small a size, as one does that grows.
    #[test]
    fn what_grows_is_bounded() {
        assert_eq!(read_at_most(io::repeat(1).take(50), 10, 50).unwrap(), [1; 50]);
        assert!(matches!(read_at_most(io::repeat(1), 10, 50), Err(FileError::Endless(50))));
        assert!(matches!(read_at_most(io::empty(), u64::MAX, u64::MAX - 1), Err(FileError::OutOfMemory(u64::MAX))));
    }

    #[test]
    fn a_missing_file_and_a_folder() {
        let refusal = |path: &str| read(Path::new(path), 1000).unwrap_err().to_string();
        assert_eq!(refusal("no/such/file"), "cannot be read: there is no such file");
        assert_eq!(refusal("."), "is a folder, not a file");
        assert!(open(Path::new(".")).is_err());
    }

    /// (What every reader says of these: `tests/files.rs`.)
    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let of = |name: &str| read(&at(name), 1000).unwrap_err().to_string();
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        assert_eq!(of("pipe"), "is a named pipe, not a file");
        assert_eq!(of("/dev/zero"), "is a device, not a file");
        assert!(matches!(open(&at("pipe")), Err(FileError::NotAFile("a named pipe"))));
        assert!(matches!(read_or_receive(&at("pipe"), 9), Err(FileError::NotAFile("a named pipe"))));
        // A loop of links.
        std::os::unix::fs::symlink("loop", at("loop")).unwrap();
        assert!(of("loop").starts_with("cannot be read: "));
    }

    /// `/proc` tells no sizes, and some of its files have no end.
    #[cfg(target_os = "linux")]
    #[test]
    fn files_that_tell_no_size_are_not_read() {
        assert!(read(Path::new("/proc/self/pagemap"), 1000).unwrap().is_empty());
    }
}
