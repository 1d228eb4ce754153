//! The files that make up an exported scene.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::scene::ResolvedScene;
use crate::formats::exr_of_pixels;
use crate::scene::lights::EnvironmentLight;
use crate::writing::{WriteError, write_atomically};

/// Files, by their paths below the folder that they go to, and what is to be said about them.
#[derive(Debug, Default)]
pub struct Bundle {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// The one to open.
    pub main: PathBuf,
    /// What is approximated, and what is left out.
    pub notes: Vec<String>,
}

impl Bundle {
    pub fn new(notes: Vec<String>) -> Self {
        Self { notes, ..Self::default() }
    }

    pub fn add(&mut self, path: impl Into<PathBuf>, bytes: Vec<u8>) {
        self.files.push((path.into(), bytes));
    }

    /// Adds the file to open, which is written last: while it is not there, nothing is.
    pub fn add_main(&mut self, path: impl Into<PathBuf>, bytes: Vec<u8>) {
        self.main = path.into();
        self.add(self.main.clone(), bytes);
    }

    /// The paths below the folder, in the order in which they are written.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }

    pub fn get(&self, path: impl AsRef<Path>) -> Option<&[u8]> {
        self.files.iter().find(|(known, _)| known == path.as_ref()).map(|(_, bytes)| bytes.as_slice())
    }

    /// Writes all files to `folder`, which is made if it is not there. Each is whole or not there at all.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), WriteError> {
        for (path, bytes) in &self.files {
            let target = folder.join(path);
            if let Some(parent) = target.parent() {
                let failed = |reason| WriteError::System { path: parent.to_path_buf(), reason };
                std::fs::create_dir_all(parent).map_err(failed)?;
            }
            write_atomically(&target, |to| to.write_all(bytes))?;
        }
        Ok(())
    }
}

/// Rows of the image that stands for a gradient.
const GRADIENT_ROWS: usize = 1024;
/// Its columns: all are equal.
const GRADIENT_COLUMNS: usize = 16;

/// The environment as a latitude–longitude image, top row +y, and by how many degrees it is turned about +y, counter-clockwise seen from above.
pub fn environment_exr(resolved: &ResolvedScene, light: &EnvironmentLight) -> (f64, Vec<u8>) {
    use crate::scene::description::Environment;
    match &resolved.description().environment {
        Environment::Image { image, rotation, scale, .. } => {
            let pixel = |x: usize, y: usize| image.pixels[y * image.width + x].map(|c| (f64::from(c) * scale) as f32);
            (*rotation, exr_bytes(image.width, image.height, pixel))
        }
        _ => {
            let pixel = |_: usize, y: usize| {
                let polar = (y as f64 + 0.5) / GRADIENT_ROWS as f64 * std::f64::consts::PI;
                light.radiance(DVec3::new(polar.sin(), polar.cos(), 0.0)).to_rgb().map(|c| c as f32)
            };
            (0.0, exr_bytes(GRADIENT_COLUMNS, GRADIENT_ROWS, pixel))
        }
    }
}

/// An EXR file in f32, of pixels by column and row.
pub fn exr_bytes(width: usize, height: usize, pixel: impl Sync + Fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    // Writing to memory does not fail.
    exr_of_pixels((width, height), pixel, &[]).unwrap_or_default()
}
