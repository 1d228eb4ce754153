//! The files that a scene names, when the scene moves to another folder.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::formats::builtin::BuiltIn;
use crate::formats::disk::{self, FileError};
use crate::formats::files::{Files, normal};
use crate::formats::image::write::exr_of_pixels;
use crate::formats::toml::read::parse_text_only;
use crate::formats::{ply, texture};
use crate::geometry::Mesh;
use crate::scene::SceneError;
use crate::scene::description::{Description, Environment, MeshPart, Object, Paint, Role, Shape, Solid, Source};
use crate::scene::environment::EnvironmentImage;
use crate::scene::texture::TextureImage;
use crate::writing::write_atomically;

/// Makes the scene's paths right for a scene file at `target`: relative ones for its folder, and what was added by an absolute path relative
/// to the folder where it lies in there. Absolute paths that the scene's file had stay.
pub(super) fn relocate(description: &mut Description, target: &Path) -> Result<(), SceneError> {
    let source = description.source.clone();
    let old_folder = source.as_ref().and_then(|source| source.path.parent()).unwrap_or(Path::new("")).to_path_buf();
    let new_folder = target.parent().unwrap_or(Path::new("")).to_path_buf();
    let kept = source.as_ref().map_or_else(Vec::new, |source| absolute_paths(source));
    let moved = |path: &mut PathBuf| -> Result<(), SceneError> {
        *path = match &source {
            _ if path.is_absolute() && kept.contains(path) => return Ok(()),
            _ if path.is_absolute() => below(&new_folder, path).unwrap_or_else(|| path.clone()),
            None => return Ok(()),
            Some(source) if source.is_builtin => copy_asset(&old_folder.join(&*path), &new_folder)?,
            Some(_) => {
                let (old, new) = (absolute(&old_folder), absolute(&new_folder));
                if old == new {
                    return Ok(());
                }
                relative(&new, &normal(&old.join(&*path)))
            }
        };
        // Scene files are text.
        if path.to_str().is_none() {
            let message = format!(
                "names {}, which a scene file cannot: it is not UTF-8. Rename that folder, or save the scene beside its files",
                path.display()
            );
            return Err(SceneError::in_file(target, message));
        }
        Ok(())
    };
    // Of solids with their texture coordinates, of others without: positions are split where coordinates differ.
    let [mut meshes, mut bare_meshes] = [(); 2].map(|()| Beside::<Mesh>::new(target, "meshes"));
    let mut images = Beside::<TextureImage>::new(target, "textures");
    for Object { name, shape, role, .. } in description.objects.iter_mut() {
        if let Role::Solid(Solid { paint: Paint::Texture { path, image, .. }, .. }) = role {
            let (file, is_within) = (texture::file_of(path), texture::file_of(path) != path);
            if is_within && source.as_ref().is_some_and(|source| is_in_import(source, file)) {
                *path = images.write(image, name, "png", || texture::to_png(image))?;
            } else if let Some((file, index)) = texture::parts_of(path) {
                let mut file = file.to_path_buf();
                moved(&mut file)?;
                *path = texture::within(&file, index);
            } else {
                moved(path)?;
            }
        }
        if let Shape::Mesh { path, part, mesh, .. } = shape {
            if source.as_ref().is_some_and(|source| is_in_import(source, path)) {
                let bytes = |mesh: &Mesh| ply::to_bytes(mesh, ply::PlyExtra::default());
                *path = match role {
                    Role::Solid(_) => meshes.write(mesh, name, "ply", || bytes(mesh))?,
                    Role::Refractor(_) | Role::Light(_) => {
                        bare_meshes.write(mesh, name, "ply", || bytes(&mesh.without_uvs()))?
                    }
                };
                *part = MeshPart::default();
            } else {
                moved(path)?;
            }
        }
    }
    if let Environment::Image { path, image, .. } = &mut description.environment {
        match &source {
            Some(source) if is_in_import(source, path) => *path = write_environment(image, target)?,
            _ => moved(path)?,
        }
    }
    Ok(())
}

/// The absolute paths in a scene's file.
fn absolute_paths(source: &Source) -> Vec<PathBuf> {
    if source.import.is_some() {
        return Vec::new();
    }
    let Ok(description) = parse_text_only(&source.text, &source.path) else { return Vec::new() };
    let meshes = description.objects.iter().filter_map(|object| match &object.shape {
        Shape::Mesh { path, .. } => Some(path),
        _ => None,
    });
    let image = match &description.environment {
        Environment::Image { path, .. } => Some(path),
        _ => None,
    };
    let textures = description.objects.iter().filter_map(|object| match &object.solid()?.paint {
        Paint::Texture { path, .. } => Some(path),
        _ => None,
    });
    meshes.chain(textures).chain(image).filter(|path| path.is_absolute()).cloned().collect()
}

/// Where a file with an absolute path is within a folder; `None` where it is elsewhere.
fn below(folder: &Path, file: &Path) -> Option<PathBuf> {
    let within = |folder: &Path, file: &Path| file.strip_prefix(folder).ok().map(Path::to_path_buf);
    let as_named = std::path::absolute(folder).ok().and_then(|folder| within(&folder, file));
    as_named.or_else(|| within(&absolute(folder), &absolute(file.parent()?).join(file.file_name()?)))
}

/// Whether a mesh or an image comes from the file of another format that the scene itself does: a scene file names meshes of its own.
fn is_in_import(source: &Source, path: &Path) -> bool {
    source.import.is_some() && source.path.file_name().is_some_and(|name| path == Path::new(name))
}

/// What a scene of another format holds of one kind, as files in a folder beside the scene file.
struct Beside<T> {
    /// Of the scene file.
    parent: PathBuf,
    /// The name of the folder in there.
    folder: PathBuf,
    /// By identity: objects may share one.
    written: HashMap<*const T, PathBuf>,
}

impl<T> Beside<T> {
    fn new(target: &Path, kind: &str) -> Self {
        let stem = target.file_stem().unwrap_or_default().to_string_lossy();
        Self {
            parent: target.parent().unwrap_or(Path::new("")).to_path_buf(),
            folder: format!("{stem}-{kind}").into(),
            written: HashMap::new(),
        }
    }

    /// Writes what an object of that name has, once, and answers how the scene file names it.
    fn write(
        &mut self,
        part: &Arc<T>,
        name: &str,
        ending: &str,
        bytes: impl FnOnce() -> Vec<u8>,
    ) -> Result<PathBuf, SceneError> {
        if let Some(path) = self.written.get(&Arc::as_ptr(part)) {
            return Ok(path.clone());
        }
        let folder = self.parent.join(&self.folder);
        if !folder.is_dir() {
            let failed = |error| SceneError::in_file(&folder, format!("this folder cannot be made: {error}"));
            std::fs::create_dir(&folder).map_err(failed)?;
        }
        let file = write_beside(&bytes(), &folder, &file_stem(name), ending)?;
        let path = self.folder.join(file);
        self.written.insert(Arc::as_ptr(part), path.clone());
        Ok(path)
    }
}

/// Writes an image that is in no file as it is beside the scene file, and answers its name.
fn write_environment(image: &EnvironmentImage, target: &Path) -> Result<PathBuf, SceneError> {
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    let pixel = |x: usize, y: usize| image.pixels[y * image.width + x];
    let bytes = exr_of_pixels((image.width, image.height), pixel, &[])
        .map_err(|error| SceneError::in_file(target, format!("the environment cannot be written: {error}")))?;
    write_beside(&bytes, target.parent().unwrap_or(Path::new("")), &file_stem(&format!("{stem}-environment")), "exr")
}

/// A name as that of a file on every system.
fn file_stem(name: &str) -> String {
    const MOST: usize = 60;
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    let stem: String = name.chars().take(MOST).map(|c| if is_plain(c) { c } else { '-' }).collect();
    let stem = stem.trim_matches([' ', '.']);
    if stem.is_empty() { "mesh".to_owned() } else { stem.to_owned() }
}

/// Writes a file that is compiled into the program into `folder`.
fn copy_asset(asset: &Path, folder: &Path) -> Result<PathBuf, SceneError> {
    let asset = BuiltIn.locate(asset);
    let missing = || SceneError::in_file(&asset, "no such file is built into the program");
    let bytes = BuiltIn.read(&asset).map_err(|_| missing())?;
    let stem = asset.file_stem().ok_or_else(missing)?.to_string_lossy();
    write_beside(&bytes, folder, &stem, &asset.extension().unwrap_or_default().to_string_lossy())
}

/// Writes a file of that name into `folder` or, where another file has it, of a numbered one; answers its name. One that says the same is left alone.
fn write_beside(bytes: &[u8], folder: &Path, stem: &str, ending: &str) -> Result<PathBuf, SceneError> {
    for number in 1_u32.. {
        let name = if number == 1 { format!("{stem}.{ending}") } else { format!("{stem}-{number}.{ending}") };
        let path = folder.join(&name);
        match disk::read(&path, bytes.len() as u64) {
            Ok(there) if *there == *bytes => return Ok(name.into()),
            Err(FileError::NotFound) => {
                write(&path, bytes)?;
                return Ok(name.into());
            }
            _ => {}
        }
    }
    Err(SceneError::in_file(folder, format!("there are too many files called {stem}")))
}

/// Writes a file, whole or not at all.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    write_atomically(path, |writer| writer.write_all(bytes)).map_err(|error| SceneError::new(error.to_string()))
}

/// With links resolved where the folder exists.
fn absolute(folder: &Path) -> PathBuf {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    std::fs::canonicalize(folder).or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.to_path_buf())
}

/// The way from a folder to a file, both absolute; the file itself where there is none, as between drives.
fn relative(folder: &Path, file: &Path) -> PathBuf {
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if !folder.components().take(common).any(|c| matches!(c, Component::RootDir)) {
        return file.to_path_buf();
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files() {
        assert_eq!(file_stem("Glas é 2.5"), "Glas é 2.5");
        assert_eq!(file_stem("../a\\b:c*\n"), "-a-b-c--");
        assert_eq!([file_stem("..."), file_stem("")], ["mesh", "mesh"]);
        assert_eq!(file_stem(&"x".repeat(1000)).len(), 60);
    }

    #[cfg(unix)]
    #[test]
    fn the_way_between_folders() {
        assert_eq!(relative(Path::new("/a/b"), Path::new("/a/c/m.obj")), Path::new("../c/m.obj"));
        assert_eq!(relative(Path::new("/a"), Path::new("/a/m.obj")), Path::new("m.obj"));
        assert_eq!(relative(Path::new("/a/b/c"), Path::new("/m.obj")), Path::new("../../../m.obj"));
    }
}
