//! Scenes from files, whatever their format.

use std::path::Path;

use super::disk::{MAX_DATA_BYTES, MAX_SCENE_BYTES};
use super::ending::{Format, by_ending};
use super::files::Input;
use super::{gltf, mitsuba, pbrt, toml};
use crate::scene::{Description, SceneError};

pub(super) type SceneFormat = Format<fn(&Input<'_>) -> Result<Description, SceneError>>;

/// The endings of files that scenes are read from, in lower case.
pub const SCENE_ENDINGS: &[&str] = &["toml", "glb", "gltf", "xml", "pbrt"];

/// The program's own format, which files of any other ending are taken for too.
const OWN: SceneFormat =
    SceneFormat { endings: &["toml"], read: |input| toml::read(input.bytes, input.path, input.files) };

/// Every scene format that is read.
const FORMATS: &[SceneFormat] = &[
    OWN,
    SceneFormat { endings: &["glb", "gltf"], read: gltf::scene },
    SceneFormat { endings: &["xml"], read: mitsuba::read },
    SceneFormat { endings: &["pbrt"], read: pbrt::read },
];

/// The format that a file's ending names; `None` where it names none.
pub(super) fn format_of(path: &Path) -> Option<&'static SceneFormat> {
    by_ending(FORMATS, path)
}

/// Whether a file's ending names the format of another program.
pub(super) fn is_foreign(path: &Path) -> bool {
    format_of(path).is_some_and(|format| format.endings != OWN.endings)
}

/// Most bytes of a scene's file: those of other programs may hold their meshes.
pub(super) fn most_bytes(path: &Path) -> u64 {
    if is_foreign(path) { MAX_DATA_BYTES } else { MAX_SCENE_BYTES }
}

pub(super) fn read(input: &Input<'_>) -> Result<Description, SceneError> {
    (format_of(input.path).unwrap_or(&OWN).read)(input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_by_ending() {
        let endings: Vec<&str> = FORMATS.iter().flat_map(|format| format.endings).copied().collect();
        assert_eq!(endings, SCENE_ENDINGS);
        assert!(format_of(Path::new("a/b.TOML")).is_some());
        assert_eq!(format_of(Path::new("b.glb")).map(|format| format.endings[1]), Some("gltf"));
        assert_eq!(most_bytes(Path::new("a.GLTF")), MAX_DATA_BYTES);
        assert!(format_of(Path::new("toml")).is_none());
        assert_eq!(most_bytes(Path::new("a.toml")), MAX_SCENE_BYTES);
        assert_eq!(most_bytes(Path::new("/dev/stdin")), MAX_SCENE_BYTES);
    }
}
