//! Where the files that a scene names are found.

use std::path::{Component, Path, PathBuf};

use crate::scene::builtin;
use crate::scene::files::{self, MAX_DATA_BYTES};

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
            Self::Disk(_) => files::read(&located, MAX_DATA_BYTES).map_err(|error| error.to_string()),
            Self::BuiltIn(_) => builtin::asset(&located)
                .map(<[u8]>::to_vec)
                .ok_or_else(|| "no such file is built into the program".to_string()),
            Self::Nowhere => Ok(Vec::new()),
        }
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
}
