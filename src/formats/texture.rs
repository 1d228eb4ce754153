//! Images of textures from files: of the disk, or within a glTF file.

use std::path::{Path, PathBuf};

use super::encoding::without_mark;
use super::files::{Files, Input};
pub use super::image::to_png;
use super::{ending, gltf, image};
use crate::scene::texture::TextureImage;

/// What stands between the name of a glTF file and the place of an image in it.
const WITHIN: &str = "#/images/";

/// How scenes name an image within a glTF file.
pub(super) fn within(file: &Path, index: usize) -> PathBuf {
    format!("{}{WITHIN}{index}", file.to_string_lossy()).into()
}

/// The glTF file and the place in it that a path names, if it is such a path.
pub(super) fn parts_of(path: &Path) -> Option<(&Path, usize)> {
    let (file, index) = path.to_str()?.rsplit_once(WITHIN)?;
    Some((Path::new(file), index.parse().ok()?))
}

/// What a path is called in short: its file's name, and which image of it.
pub fn short_name(path: &Path) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match parts_of(path) {
        Some((file, index)) => format!("image {index} of {}", name(file)),
        None => name(path),
    }
}

/// The file that a path names.
pub fn file_of(path: &Path) -> &Path {
    parts_of(path).map_or(path, |(file, _)| file)
}

/// The image that a scene names, whose file is found in `folder`. What it is, its bytes tell.
///
/// # Errors
/// Says why it cannot be read, in words that follow its name.
pub(super) fn read(path: &Path, folder: &Path, files: &dyn Files) -> Result<TextureImage, String> {
    let Some((file, index)) = parts_of(path) else {
        return decode(&files.read(&files.locate(&folder.join(path)))?);
    };
    let file = files.locate(&folder.join(file));
    let bytes = files.read(&file)?;
    let input = Input { bytes: &without_mark(&bytes), path: &file, files };
    decode(&gltf::image(&input, index)?)
}

/// An image from the bytes of its file.
///
/// # Errors
/// Says why it cannot be read, in words that follow its name.
pub fn decode(bytes: &[u8]) -> Result<TextureImage, String> {
    match image::texture(bytes) {
        Some(read) => read,
        None => Err(format!("is no image that is read: use {}", ending::list(image::FORMATS))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Memory;

    #[test]
    fn a_written_image_is_read_again() {
        let texels = (0..6_u8).map(|i| [i * 40, 255 - i, i, 255]).collect();
        let image = TextureImage::new(3, 2, texels);
        assert_eq!(decode(&to_png(&image)), Ok(image.clone()));
        let files = Memory([("a/t.weird".into(), to_png(&image))].into());
        assert_eq!(read(Path::new("t.weird"), Path::new("a"), &files), Ok(image));
        assert!(read(Path::new("gone.png"), Path::new("a"), &files).unwrap_err().contains("no such file"));
    }

    #[test]
    fn what_is_no_image_is_told() {
        let error = decode(b"GIF89a").unwrap_err();
        assert!(error.contains(".png") && error.contains(".jpg"), "{error}");
    }

    #[test]
    fn images_within_files() {
        let path = within(Path::new("a b/cube.glb"), 3);
        assert_eq!(path, Path::new("a b/cube.glb#/images/3"));
        assert_eq!(parts_of(&path), Some((Path::new("a b/cube.glb"), 3)));
        assert_eq!(file_of(&path), Path::new("a b/cube.glb"));
        assert_eq!([&path, Path::new("a/b.png")].map(short_name), ["image 3 of cube.glb", "b.png"]);
        for plain in ["oak.jpg", "c#4.png", "cube.glb#/images/x"] {
            assert_eq!(file_of(Path::new(plain)), Path::new(plain));
        }
    }
}
