//! What the panes show when a built-in scene is opened: the mode that goes wrong there beside one that does not.

use super::settings::{MAX_PANES, PaneContent};
use crate::scene::Description;
use crate::tracking::Mode;

/// The panes of a scene's first picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FirstPanes {
    /// Name of the built-in scene.
    scene: &'static str,
    /// Panes that are shown.
    pub count: usize,
    /// With what the others show once there are more.
    pub panes: [PaneContent; MAX_PANES],
}

/// Four panes: `wrong` and `right` above, `third` and the difference of the first two below.
const fn four(scene: &'static str, wrong: Mode, right: Mode, third: Mode) -> FirstPanes {
    use PaneContent::{Difference, Mode as Film};
    FirstPanes { scene, count: 4, panes: [Film(wrong), Film(right), Film(third), Difference(wrong, right)] }
}

const ALL: &[FirstPanes] = &[
    four("iced-water", Mode::Stack, Mode::Rectified, Mode::Naive),
    four("camera-in-water", Mode::Stack, Mode::Rectified, Mode::Naive),
    four("nested-spheres", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("bubble-in-glass", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("three-shells", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("siblings", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("diamond-in-water", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("world-oil", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("lamp-in-ice", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("luneburg", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("plain-glass", Mode::Naive, Mode::Rectified, Mode::Stack),
    four("half-submerged", Mode::RectifiedObject, Mode::Rectified, Mode::Stack),
];

/// The panes for a scene as it was read; `None` for a scene that is not built in.
pub fn of(description: &Description) -> Option<&'static FirstPanes> {
    let source = description.source.as_ref().filter(|source| source.is_builtin)?;
    let name = source.path.file_stem()?;
    ALL.iter().find(|first| name == first.scene)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{builtin, open};

    #[test]
    fn every_built_in_scene_has_its_panes_and_no_other() {
        for scene in builtin::all() {
            let first = of(&open(scene.name).unwrap()).unwrap_or_else(|| panic!("{} has no panes", scene.name));
            assert!([1, 2, 4].contains(&first.count));
        }
        assert_eq!(ALL.len(), builtin::all().len());
        assert_eq!(of(&crate::app::opening::no_scene()), None);
    }
}
