//! What the panes show when a built-in scene is opened.

use super::settings::{MAX_PANES, PaneContent};
use crate::scene::Description;
use crate::session::first_modes::{self, FirstModes};

/// The mode that goes wrong and one that does not above, a third and the difference of the first two below; `None` for a scene that is not
/// built in.
pub fn of(description: &Description) -> Option<[PaneContent; MAX_PANES]> {
    use PaneContent::{Difference, Mode as Film};
    let FirstModes { wrong, right, third, .. } = *first_modes::of(description)?;
    Some([Film(wrong), Film(right), Film(third), Difference(wrong, right)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{builtin, open};

    #[test]
    fn built_in_scenes_have_first_panes_and_others_have_not() {
        for scene in builtin::all() {
            assert!(of(&open(scene.name).unwrap()).is_some(), "{}", scene.name);
        }
        assert_eq!(of(&crate::app::opening::no_scene()), None);
    }
}
