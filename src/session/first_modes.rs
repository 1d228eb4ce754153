//! What a scene is opened with that is made for it: the mode that goes wrong there beside one that does not.

use crate::scene::Description;
use crate::tracking::Mode;

/// The modes of a scene's first picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FirstModes {
    /// Name of the built-in scene; empty for others.
    scene: &'static str,
    /// The one that goes wrong, where one does; its difference from `right` is shown too.
    pub wrong: Mode,
    pub right: Mode,
    pub third: Mode,
}

const fn modes(scene: &'static str, wrong: Mode, right: Mode, third: Mode) -> FirstModes {
    FirstModes { scene, wrong, right, third }
}

const ALL: &[FirstModes] = &[
    modes("iced-water", Mode::Stack, Mode::Rectified, Mode::Naive),
    modes("camera-in-water", Mode::Stack, Mode::Rectified, Mode::Naive),
    modes("nested-spheres", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("bubble-in-glass", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("three-shells", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("siblings", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("diamond-in-water", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("world-oil", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("lamp-in-ice", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("wine-glass", Mode::Stack, Mode::Rectified, Mode::Naive),
    modes("pool-light", Mode::Stack, Mode::Rectified, Mode::Naive),
    modes("glass-ball-in-sun", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("luneburg", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("plain-glass", Mode::Naive, Mode::Rectified, Mode::Stack),
    modes("half-submerged", Mode::RectifiedObject, Mode::Rectified, Mode::Stack),
];

/// Of a scene of another program that declares what lies around its objects: what that program makes of it.
const IMPORTED: FirstModes = modes("", Mode::Declared, Mode::Rectified, Mode::Stack);

/// The modes for a scene as it was read; `None` for one that is neither built in nor of another program with declarations.
pub fn of(description: &Description) -> Option<&'static FirstModes> {
    let source = description.source.as_ref()?;
    if source.import.is_some() && description.declared().next().is_some() {
        return Some(&IMPORTED);
    }
    let source = Some(source).filter(|source| source.is_builtin)?;
    let name = source.path.file_stem()?;
    ALL.iter().find(|first| name == first.scene)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{builtin, open};

    #[test]
    fn every_built_in_scene_has_its_modes() {
        for scene in builtin::all() {
            let first = of(&open(scene.name).unwrap()).unwrap_or_else(|| panic!("{} has no modes", scene.name));
            assert!(first.wrong != first.right && first.right != first.third && first.third != first.wrong);
        }
        assert_eq!(ALL.len(), builtin::all().len());
    }
}
