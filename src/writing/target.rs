//! The target of a write: a file to replace or to make, a stream, or something that is refused.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::WriteError;

/// Links that are followed one after another, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// How a path is written to.
pub(super) enum Target {
    /// By replacing a file, or making it.
    File(Replaced),
    /// In sequence: a FIFO or a character device.
    Stream(PathBuf),
}

/// A file to be replaced.
pub(super) struct Replaced {
    /// Where it is, links followed.
    pub path: PathBuf,
    /// What stands there, if anything.
    pub existing: Option<Metadata>,
}

impl Target {
    /// # Errors
    /// When nothing can be written there, whoever tries.
    pub fn find(path: &Path) -> Result<Self, WriteError> {
        let failed = |reason| WriteError::System { path: path.to_path_buf(), reason };
        if path.is_dir() {
            return Err(WriteError::IsFolder { path: path.to_path_buf() });
        }
        if path.file_name().is_none() {
            return Err(WriteError::NoFileName { path: path.to_path_buf() });
        }
        require_folder(path, path)?;
        let existing = match fs::metadata(path) {
            Ok(existing) => existing,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let end = end_of_links(path).map_err(failed)?;
                require_folder(path, &end)?;
                return Ok(Self::File(Replaced { path: end, existing: None }));
            }
            Err(error) => return Err(failed(error)),
        };
        if existing.is_file() {
            let path = fs::canonicalize(path).map_err(failed)?;
            return Ok(Self::File(Replaced { path, existing: Some(existing) }));
        }
        match special(&existing) {
            None => Ok(Self::Stream(path.to_path_buf())),
            Some(kind) => Err(WriteError::NotAFile { path: path.to_path_buf(), kind }),
        }
    }
}

/// What a special file is called, with its article, if it is none that takes bytes in sequence.
fn special(existing: &Metadata) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = existing.file_type();
        if kind.is_fifo() || kind.is_char_device() {
            return None;
        }
        if kind.is_socket() {
            return Some("a socket");
        }
        if kind.is_block_device() {
            return Some("a disk");
        }
    }
    let _ = existing;
    Some("something special")
}

fn require_folder(asked: &Path, path: &Path) -> Result<(), WriteError> {
    let folder = folder_of(path);
    if folder.is_dir() {
        Ok(())
    } else {
        Err(WriteError::NoFolder { path: asked.to_path_buf(), folder: folder.to_path_buf() })
    }
}

/// Where a chain of links that points nowhere ends; `path` itself where it is no link.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut end = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&end) {
            Ok(to) => end = folder_of(&end).join(to),
            Err(_) => return Ok(end),
        }
    }
    Err(io::Error::other("too many symbolic links follow each other"))
}

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

impl Replaced {
    /// Refuses what a rename would replace although nobody may write to it, and what it cannot replace.
    pub fn require_replaceable(&self, asked: &Path) -> Result<(), WriteError> {
        let Some(existing) = &self.existing else { return Ok(()) };
        if existing.permissions().readonly() {
            return Err(WriteError::ReadOnly { path: asked.to_path_buf() });
        }
        // Finds what permissions do not tell, such as immutable files and file systems that are read-only. Nothing is written.
        if let Err(reason) = OpenOptions::new().write(true).open(&self.path) {
            return Err(WriteError::System { path: asked.to_path_buf(), reason });
        }
        if is_mount_point(&self.path) {
            return Err(WriteError::MountPoint { path: asked.to_path_buf() });
        }
        Ok(())
    }

    /// In a folder with the sticky bit, refuses the file of somebody else. `ours` is a file of this user.
    #[cfg(unix)]
    pub fn require_owned(&self, asked: &Path, ours: &File) -> Result<(), WriteError> {
        use std::os::unix::fs::MetadataExt;
        const STICKY: u32 = 0o1000;
        let failed = |reason| WriteError::System { path: asked.to_path_buf(), reason };
        let Some(existing) = &self.existing else { return Ok(()) };
        let folder = fs::metadata(folder_of(&self.path)).map_err(failed)?;
        let user = ours.metadata().map_err(failed)?.uid();
        let may_rename = folder.mode() & STICKY == 0 || [0, folder.uid(), existing.uid()].contains(&user);
        // Root may replace every file, a user their own.
        if may_rename || user == 0 { Ok(()) } else { Err(WriteError::NotOwned { path: asked.to_path_buf() }) }
    }

    #[cfg(not(unix))]
    pub fn require_owned(&self, _: &Path, _: &File) -> Result<(), WriteError> {
        Ok(())
    }

    /// Gives the new file the permissions of the one that it replaces, and its owner and group where the system allows it.
    pub fn hand_down_permissions(&self, file: &File) -> io::Result<()> {
        #[cfg(unix)]
        if let Some(existing) = &self.existing {
            use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
            let new = file.metadata()?;
            let mut mode = existing.mode() & 0o777;
            if (new.uid(), new.gid()) != (existing.uid(), existing.gid()) {
                // Only root may give files away; to a group of theirs, anyone may.
                let is_kept = fchown(file, Some(existing.uid()), Some(existing.gid())).is_ok()
                    || fchown(file, None, Some(existing.gid())).is_ok();
                if !is_kept && new.gid() != existing.gid() {
                    // The new group does not get the old group's permissions.
                    mode &= !0o070;
                }
            }
            file.set_permissions(fs::Permissions::from_mode(mode))?;
        }
        #[cfg(not(unix))]
        let _ = file;
        Ok(())
    }
}

/// Whether a file system is mounted at the file itself.
fn is_mount_point(path: &Path) -> bool {
    // Elsewhere than on Linux there is no such list, and the rename itself will tell.
    let Ok(mounts) = fs::read("/proc/self/mountinfo") else { return false };
    let Some(path) = path.to_str() else { return false };
    // In that file, spaces and the like are written as octal numbers.
    let escaped: String = path
        .chars()
        .map(|c| if " \t\n\\".contains(c) { format!("\\{:03o}", c as u32) } else { c.to_string() })
        .collect();
    mounts.split(|byte| *byte == b'\n').any(|line| line.split(|byte| *byte == b' ').nth(4) == Some(escaped.as_bytes()))
}
