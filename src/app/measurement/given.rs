//! A reference image from a file, of another renderer perhaps.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::formats::{RenderedPicture, picture_from_file};
use crate::scene::LoadNote;
use crate::session::{GroundTruth, Halves};

/// Largest width and height, in pixels: every graphics card shows pictures of this size.
const MOST_SIDE: u32 = 8192;
/// Most pixels: films have as many, one for each mode.
const MOST_PIXELS: u32 = 1 << 24;

/// What panes are measured against instead of a ground truth that is rendered.
#[derive(Debug)]
pub struct GivenImage {
    pub path: PathBuf,
    /// What of the file was replaced or converted.
    pub notes: Vec<LoadNote>,
    /// The image twice: as if there were no noise in it, for nobody knows how much there is.
    pub halves: Arc<Halves>,
}

impl GivenImage {
    /// Reads it.
    ///
    /// # Errors
    /// When the file holds no picture of linear light, or one that is too large: says where and why.
    pub fn read(path: &Path) -> Result<Self, String> {
        let RenderedPicture { size, rgb, notes } = picture_from_file(path).map_err(|error| error.to_string())?;
        let [width, height] = size;
        if width.max(height) > MOST_SIDE || width * height > MOST_PIXELS {
            return Err(format!(
                "{}: {width} × {height} pixels are too many to measure against: at most {MOST_SIDE} either way and 16 million in all",
                path.display()
            ));
        }
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let halves = Halves { size, samples: 1, file: Some(file), rgb: [rgb.clone(), rgb.clone()], mean: rgb };
        Ok(Self { path: path.to_owned(), notes, halves: Arc::new(halves) })
    }

    /// Its file's name.
    pub fn name(&self) -> &str {
        self.halves.file.as_deref().unwrap_or_default()
    }

    pub fn size(&self) -> [u32; 2] {
        self.halves.size
    }
}

/// An image that is wanted, or none: equal where it is the very same.
#[derive(Debug, Clone, Default)]
pub struct Given(pub Option<Arc<GivenImage>>);

impl PartialEq for Given {
    fn eq(&self, other: &Self) -> bool {
        self.0.as_ref().map(Arc::as_ptr) == other.0.as_ref().map(Arc::as_ptr)
    }
}

impl Given {
    /// The ground truth of films of `epoch`: the image, or else what has been rendered for them.
    pub fn or_rendered(&self, epoch: u64, rendered: Option<GroundTruth>) -> Option<GroundTruth> {
        match &self.0 {
            Some(image) => {
                let halves = Some(Arc::clone(&image.halves));
                Some(GroundTruth { epoch, samples: 1, seconds: 0.0, is_done: true, halves })
            }
            None => rendered.filter(|truth| truth.epoch == epoch),
        }
    }
}
