//! Where the files that a scene names are found.

use std::path::{Component, Path, PathBuf};

use crate::scene::builtin;

/// Where the files that a scene names are found.
#[derive(Debug, Clone, Copy)]
pub(super) enum Files<'a> {
    /// Relative to this folder.
    Disk(&'a Path),
    /// Compiled into the program; relative to this folder of the assets.
    BuiltIn(&'a Path),
    /// Not wanted: only the scene's own text is read.
    Nowhere,
}

impl Files<'_> {
    /// The path by which errors call a file.
    pub fn locate(&self, path: &Path) -> PathBuf {
        match self {
            Self::Disk(folder) => folder.join(path),
            Self::BuiltIn(folder) => normal(&folder.join(path)),
            Self::Nowhere => path.to_path_buf(),
        }
    }

    /// # Errors
    /// Says why a file cannot be read.
    pub fn read(&self, path: &Path) -> Result<Vec<u8>, String> {
        let located = self.locate(path);
        match self {
            Self::Disk(_) => read_file(&located),
            Self::BuiltIn(_) => builtin::asset(&located)
                .map(<[u8]>::to_vec)
                .ok_or_else(|| "no such file is built into the program".to_string()),
            Self::Nowhere => Ok(Vec::new()),
        }
    }
}

/// Most bytes that a scene, mesh or image may have.
const MAX_BYTES: u64 = 4 << 30;

/// # Errors
/// Says why the file cannot be read, in words for people.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    let metadata = std::fs::metadata(path).map_err(|error| format!("cannot be read: {}", plain(&error)))?;
    if metadata.is_dir() {
        return Err("is a folder, not a file".into());
    }
    if metadata.len() > MAX_BYTES {
        return Err(format!("has {} bytes; at most {MAX_BYTES} are read", metadata.len()));
    }
    std::fs::read(path).map_err(|error| format!("cannot be read: {}", plain(&error)))
}

fn plain(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}

/// Takes `.` and `..` out of a path by name; those that lead out of it stay.
pub(in crate::scene) fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(normal.components().next_back(), Some(Component::Normal(_))) => {
                normal.pop();
            }
            other => normal.push(other),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_taken_out() {
        assert_eq!(normal(Path::new("a/./b/../c")), Path::new("a/c"));
        assert_eq!(normal(Path::new("../a/../../c")), Path::new("../../c"));
    }

    #[test]
    fn a_missing_file_and_a_folder() {
        assert!(read_file(Path::new("no/such/file")).unwrap_err().contains("no such file"));
        assert!(read_file(Path::new(".")).unwrap_err().contains("folder"));
    }
}
