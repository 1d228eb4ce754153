//! Scenes that are compiled into the program, so that they work from any folder.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::files::{Files, normal};

/// The scene that opens where none is asked for.
pub const DEFAULT: &str = "iced-water";

/// A scene that is compiled into the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Builtin {
    /// The name that works wherever a file's does.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub about: &'static str,
    /// The scene file.
    pub text: &'static str,
    /// A small picture of it, a PNG of 192×144 pixels.
    pub thumbnail: &'static [u8],
}

/// Folder that the paths of built-in scenes begin with; no such folder exists.
const ROOT: &str = "built-in";

macro_rules! builtins {
    ($($name:literal: $about:literal,)*) => {
        &[$(Builtin {
            name: $name,
            about: $about,
            text: include_str!(concat!("../../assets/scenes/", $name, ".toml")),
            thumbnail: include_bytes!(concat!("../../assets/thumbnails/", $name, ".png")),
        }),*]
    };
}

const SCENES: &[Builtin] = builtins! {
    "iced-water": "Glass hides the water that overlaps it, ice floats in the water and juts out, a straw breaks at the surface.",
    "camera-in-water": "The camera is under water: a glass ball with a bubble in it hangs below Snell's window.",
    "nested-spheres": "Air in water in glass: three spheres, one in the other.",
    "bubble-in-glass": "Bubbles of air in a paperweight, which naive does not see at all.",
    "three-shells": "Thin shells of glass with air between them, six surfaces deep.",
    "siblings": "Four balls side by side in one block: neighbours, but nobody's container.",
    "diamond-in-water": "A diamond in water has less fire than a dry one, except for naive.",
    "world-oil": "The world is oil: a glass rod of the oil's IOR vanishes, a denser one does not.",
    "lamp-in-ice": "A lamp in ice in water: light that starts inside the nest.",
    "wine-glass": "A small lamp behind a glass of red wine, which gathers its light on the table.",
    "pool-light": "A pool at night, lit from under the water: its light starts inside, and is seen from outside.",
    "glass-ball-in-sun": "Balls of glass and of water in the sun, each with its bright spot in its shadow.",
    "luneburg": "A Luneburg lens of 30 concentric shells: the deepest nest here.",
    "plain-glass": "Nothing is nested and the world is vacuum: all modes agree.",
    "half-submerged": "A glass ball and a glass rod, half in water and half in air: each of their patches knows which.",
};

macro_rules! assets {
    ($($path:literal,)*) => {
        &[$(($path, include_bytes!(concat!("../../assets/", $path)))),*]
    };
}

/// Files that the scenes name, by their path under `assets/`.
const ASSETS: &[(&str, &[u8])] = assets! {
    "environments/evening.exr",
    "environments/forest.exr",
    "environments/studio.exr",
    "environments/sunset.exr",
    "environments/warehouse.exr",
    "models/brilliant.obj",
    "models/ice-cube.obj",
};

/// Every built-in scene, in the order of a gallery.
pub fn all() -> &'static [Builtin] {
    SCENES
}

pub fn find(name: &str) -> Option<&'static Builtin> {
    SCENES.iter().find(|scene| scene.name == name)
}

impl Builtin {
    /// The path by which the scene goes.
    pub(super) fn path(&self) -> PathBuf {
        [ROOT, "scenes", &format!("{}.toml", self.name)].iter().collect()
    }
}

/// The files that are compiled into the program, by their paths under `assets/` with [`ROOT`] in front.
#[derive(Debug, Clone, Copy)]
pub struct BuiltIn;

impl Files for BuiltIn {
    fn read(&self, path: &Path) -> Result<Cow<'_, [u8]>, String> {
        let located = normal(path);
        let asset = located.strip_prefix(ROOT).ok();
        let found = asset.and_then(|asset| ASSETS.iter().find(|(name, _)| Path::new(name) == asset));
        found.map(|(_, bytes)| Cow::Borrowed(*bytes)).ok_or_else(|| "no such file is built into the program".to_owned())
    }

    fn locate(&self, path: &Path) -> PathBuf {
        normal(path)
    }

    fn is_builtin(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::open;
    use std::collections::BTreeSet;

    #[test]
    fn every_scene_can_be_read() {
        for scene in all() {
            let description = open(scene.name).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
            assert!(!description.objects.refractors().is_empty(), "{} shows no dielectric", scene.name);
            assert!(description.source.is_some_and(|source| source.is_builtin));
            assert!(scene.about.ends_with('.') && scene.about.len() < 120, "{}", scene.about);
        }
    }

    #[test]
    fn every_scene_has_a_small_picture() {
        let mut seen = BTreeSet::new();
        for scene in all() {
            let picture = image::load_from_memory(scene.thumbnail).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
            assert_eq!((picture.width(), picture.height()), (192, 144), "{}", scene.name);
            assert!(scene.thumbnail.len() <= 64 * 1024, "{}: {} bytes", scene.name, scene.thumbnail.len());
            assert!(seen.insert(scene.thumbnail), "{} shows another scene", scene.name);
        }
    }

    #[test]
    fn every_scene_has_its_own_fingerprint() {
        let fingerprints: BTreeSet<_> = all().iter().map(|scene| open(scene.name).unwrap().fingerprint()).collect();
        assert_eq!(fingerprints.len(), all().len());
    }

    #[test]
    fn every_scene_file_is_built_in() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|ending| ending == "toml") {
                count += 1;
                let name = path.file_stem().unwrap().to_str().unwrap();
                assert!(find(name).is_some(), "{name} lies in assets/scenes but is not built in");
            }
        }
        assert_eq!(count, all().len());
        assert!(find(DEFAULT).is_some() && find("no-such-scene").is_none());
    }
}
