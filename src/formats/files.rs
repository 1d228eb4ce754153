//! Where the files that a scene names come from.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

/// A place that files are read from. Paths are the scene file's folder with what the scene names.
pub trait Files {
    /// All bytes of a file.
    ///
    /// # Errors
    /// Says why it cannot be read, in words that follow its name.
    fn read(&self, path: &Path) -> Result<Cow<'_, [u8]>, String>;

    /// The path by which errors call a file.
    fn locate(&self, path: &Path) -> PathBuf {
        path.to_path_buf()
    }

    /// Whether its scenes belong to the program and have no files of their own.
    fn is_builtin(&self) -> bool {
        false
    }
}

/// A file that was read, and where others that it names are found.
pub(super) struct Input<'a> {
    pub bytes: &'a [u8],
    pub path: &'a Path,
    pub files: &'a dyn Files,
}

/// Files in memory, by paths without `.` and `..`: for programs that have no disk, such as in a browser.
#[derive(Debug, Clone, Default)]
pub struct Memory(pub HashMap<PathBuf, Vec<u8>>);

impl Files for Memory {
    fn read(&self, path: &Path) -> Result<Cow<'_, [u8]>, String> {
        let bytes = self.0.get(&normal(path)).ok_or("cannot be read: there is no such file")?;
        Ok(bytes.into())
    }
}

/// Takes `.` and `..` out of a path by name; those that lead out of it stay.
pub(super) fn normal(path: &Path) -> PathBuf {
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
    use crate::formats::read;
    use crate::scene::description::Shape;

    #[test]
    fn dots_are_taken_out() {
        assert_eq!(normal(Path::new("a/./b/../c")), Path::new("a/c"));
        assert_eq!(normal(Path::new("../a/../../c")), Path::new("../../c"));
    }

    #[test]
    fn a_scene_with_its_mesh_from_memory() {
        let text = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[solid]]\nname = \"s\"\nshape = { mesh = \"../m.obj\" }\n";
        let read = |name: &str| {
            let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec();
            read(text.as_bytes(), Path::new("a/b/s.toml"), &Memory([(name.into(), obj)].into()))
        };
        let scene = read("a/m.obj").unwrap();
        let Shape::Mesh { mesh, .. } = &scene.objects[0].shape else { panic!("no mesh") };
        assert_eq!(mesh.triangles.len(), 1);
        let error = read("m.obj").unwrap_err().to_string();
        assert!(error.starts_with("a/b/s.toml:6:18: the mesh a/b/../m.obj cannot be read"), "{error}");
    }
}
