//! What the panes show when a scene is opened that is built in, or that declares media for another renderer.

use super::settings::{MAX_PANES, PaneContent};
use crate::scene::Description;
use crate::session::first_modes::{self, FirstModes};

/// The mode that goes wrong and one that does not above, a third and the difference of the first two below; `None` for other scenes.
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
        let text = b"<scene><shape type=\"sphere\"><bsdf type=\"dielectric\"/></shape></scene>";
        let read =
            |name: &str| crate::formats::read(text, std::path::Path::new(name), &crate::formats::Memory::default());
        let panes = of(&read("s.xml").unwrap()).expect("it declares what lies outside");
        assert_eq!(panes[0], PaneContent::Mode(crate::tracking::Mode::Declared));
    }
}
