//! What can go wrong when a file is written.

use std::io;
use std::path::PathBuf;

/// A file that could not be written. What stood there before stands there still, and nothing was left behind. Paths are as asked for.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder that should hold the file does not exist.
    #[error("{}: there is no folder `{}`; create it or choose another place", path.display(), folder.display())]
    NoFolder {
        path: PathBuf,
        /// The missing one.
        folder: PathBuf,
    },
    /// The path is an existing folder.
    #[error("{}: is a folder; add a file name such as `picture.png`", path.display())]
    IsFolder { path: PathBuf },
    /// The path ends in no file name.
    #[error("`{}` does not name a file", path.display())]
    NoFileName { path: PathBuf },
    /// Nobody may write to the file.
    #[error("{}: is read-only and is not replaced; make it writable or choose another name", path.display())]
    ReadOnly { path: PathBuf },
    /// In a folder such as `/tmp`, whose sticky bit lets a file's owner alone replace it.
    #[error(
        "{}: belongs to another user, and only its owner may replace it in this folder; choose another name or folder",
        path.display()
    )]
    NotOwned { path: PathBuf },
    /// Something is mounted at the file itself, as containers do: it cannot be renamed over.
    #[error("{}: is a mount point and cannot be replaced; write into a folder that is mounted instead", path.display())]
    MountPoint { path: PathBuf },
    /// A kind of file that is not written to.
    #[error("{}: is {kind} and no file; choose another name", path.display())]
    NotAFile {
        path: PathBuf,
        /// With its article.
        kind: &'static str,
    },
    /// The system refused.
    #[error("{}: cannot be written: {reason}", path.display())]
    System { path: PathBuf, reason: io::Error },
}
