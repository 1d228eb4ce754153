//! Changes to the list of media, and to what refractors are made of.

use std::collections::HashSet;

use super::EditKey;
use crate::app::objects::replaced;
use crate::optics::Medium;
use crate::optics::medium::{VACUUM, WORLD};
use crate::scene::tables::medium_fields;
use crate::scene::{Description, Fault, validate};

/// A change to the scene's media.
#[derive(Debug, Clone, PartialEq)]
pub enum MediaEdit {
    /// Makes a refractor, by name, of another medium of the scene.
    Assign(String, String),
    /// Adds a medium, under a numbered name where its own is taken, and makes a refractor of it if one is named.
    Add(Medium, Option<String>),
    /// Gives a medium another name; what is made of it stays so.
    Rename(String, String),
    /// Removes the media that no refractor is made of and that nothing is declared to lie in.
    RemoveUnused,
}

impl MediaEdit {
    pub(super) fn key(&self) -> EditKey {
        EditKey::single(match self {
            Self::Assign(object, _) | Self::Add(_, Some(object)) => format!("medium of {object}"),
            Self::Add(medium, None) => format!("adding {}", medium.name),
            Self::Rename(medium, _) => format!("renaming {medium}"),
            Self::RemoveUnused => "deleting unused media".to_owned(),
        })
    }

    /// Whether something changed.
    pub(super) fn apply(&self, edited: &mut Description) -> Result<bool, Fault> {
        match self {
            Self::Assign(object, medium) => {
                if edited.medium(medium).is_none() {
                    return Ok(false);
                }
                let refractor = edited.objects.find_mut(object).and_then(|object| object.refractor_mut());
                Ok(refractor.is_some_and(|refractor| replaced(&mut refractor.medium, medium.clone())))
            }
            Self::Add(medium, object) => {
                let name = free_name(edited, &medium.name);
                edited.media.push(Medium { name: name.clone(), ..medium.clone() });
                check(edited, &name)?;
                if let Some(object) = object {
                    // Nothing is added for an object that is not there.
                    return Self::Assign(object.clone(), name).apply(edited);
                }
                Ok(true)
            }
            Self::Rename(medium, name) => {
                let Some(known) = edited.media.iter_mut().find(|known| known.name == *medium) else { return Ok(false) };
                if !replaced(&mut known.name, name.clone()) {
                    return Ok(false);
                }
                let of_it = edited.objects.refractor_roles_mut().filter(|refractor| refractor.medium == *medium);
                of_it.for_each(|refractor| refractor.medium.clone_from(name));
                edited
                    .declared_mut()
                    .filter(|declared| *declared == medium)
                    .for_each(|declared| declared.clone_from(name));
                check(edited, name).map(|()| true)
            }
            Self::RemoveUnused => {
                let made_of = edited.objects.refractor_roles().map(|role| role.medium.clone());
                let used: HashSet<String> = made_of.chain(edited.declared().map(str::to_owned)).collect();
                let count = edited.media.len();
                edited.media.retain(|medium| used.contains(&medium.name));
                Ok(edited.media.len() != count)
            }
        }
    }
}

/// Holds a medium to what files demand.
fn check(edited: &Description, name: &str) -> Result<(), Fault> {
    let Some(mut medium) = edited.medium(name).cloned() else { return Ok(()) };
    validate::table(edited, "medium", |v| medium_fields(&mut medium, v))
}

/// `name`, or `name 2` and so on where it is taken.
fn free_name(description: &Description, name: &str) -> String {
    let is_free = |name: &str| description.medium(name).is_none() && !matches!(name, WORLD | VACUUM);
    if is_free(name) {
        return name.to_owned();
    }
    // Of a name with a number, the next.
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let stem = if stem.ends_with(' ') && stem.trim() != "" { stem.trim_end() } else { name };
    (2_u32..).map(|number| format!("{stem} {number}")).find(|name| is_free(name)).unwrap_or_else(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::edit::Edit;
    use crate::optics::Ior;

    fn scene() -> Description {
        crate::formats::open("nested-spheres").unwrap()
    }

    fn applied(edit: MediaEdit, to: &Description) -> Option<Description> {
        Edit::Media(edit).apply(to).unwrap()
    }

    fn medium_of(description: &Description, object: &str) -> String {
        description.objects.find(object).and_then(|object| object.refractor()).unwrap().medium.clone()
    }

    /// Whatever comes out is read again as it is.
    fn assert_survives_saving(description: &Description) {
        let text = crate::formats::to_text(description);
        let read =
            crate::formats::parse(&text, &description.source.as_ref().unwrap().path, &crate::formats::BuiltIn).unwrap();
        assert_eq!((&read.media, &read.objects), (&description.media, &description.objects), "{text}");
    }

    #[test]
    fn a_copy_has_a_name_of_its_own_and_is_used() {
        let scene = scene();
        let object = scene.objects.refractors()[0].name.clone();
        let medium = scene.medium(&medium_of(&scene, &object)).unwrap().clone();
        let once = applied(MediaEdit::Add(medium.clone(), Some(object.clone())), &scene).unwrap();
        assert_eq!(medium_of(&once, &object), format!("{} 2", medium.name));
        assert_eq!(once.media.len(), scene.media.len() + 1);
        let copy = once.medium(&medium_of(&once, &object)).unwrap().clone();
        assert_eq!((&copy.ior, copy.absorption), (&medium.ior, medium.absorption));
        let twice = applied(MediaEdit::Add(copy, Some(object.clone())), &once).unwrap();
        assert_eq!(medium_of(&twice, &object), format!("{} 3", medium.name));
        assert_survives_saving(&twice);
        let tidied = applied(MediaEdit::RemoveUnused, &twice).unwrap();
        assert!(tidied.media.len() < twice.media.len());
        assert_survives_saving(&tidied);
        assert!(applied(MediaEdit::RemoveUnused, &tidied).is_none());
    }

    #[test]
    fn a_renamed_medium_keeps_its_objects() {
        let scene = scene();
        let object = scene.objects.refractors()[0].name.clone();
        let old = medium_of(&scene, &object);
        let renamed = applied(MediaEdit::Rename(old.clone(), "soup".into()), &scene).unwrap();
        assert_eq!(medium_of(&renamed, &object), "soup");
        assert!(renamed.medium(&old).is_none());
        assert_survives_saving(&renamed);
        for bad in ["", "world", "vacuum", scene.media.last().unwrap().name.as_str()] {
            let result = Edit::Media(MediaEdit::Rename(old.clone(), bad.into())).apply(&scene);
            assert!(bad == old || result.is_err(), "{bad}");
        }
    }

    #[test]
    fn what_is_not_there_changes_nothing() {
        let scene = scene();
        let soup = || Medium { name: "soup".into(), ior: Ior::Constant(1.3), absorption: [0.0; 3] };
        let object = scene.objects.refractors()[0].name.clone();
        for edit in [
            MediaEdit::Assign(object, "no such medium".into()),
            MediaEdit::Assign("no such object".into(), scene.media[0].name.clone()),
            MediaEdit::Add(soup(), Some("no such object".into())),
            MediaEdit::Rename("no such medium".into(), "soup".into()),
        ] {
            assert!(applied(edit.clone(), &scene).is_none(), "{edit:?}");
        }
        let bad = Medium { ior: Ior::Constant(-1.0), ..soup() };
        assert!(Edit::Media(MediaEdit::Add(bad, None)).apply(&scene).is_err());
    }
}
