//! Changes to objects.

use super::EditKey;
use crate::app::objects::{Manipulation, replaced};
use crate::scene::description::{Object, Transform};
use crate::scene::{Description, Fault, validate};

/// A change to one object.
#[derive(Debug, Clone, PartialEq)]
pub enum ObjectEdit {
    /// Of a refractor.
    Priority(i32),
    /// Hides it or shows it.
    Visible(bool),
    /// Its transform, and what about it is new.
    Transform(Manipulation, Transform),
}

impl ObjectEdit {
    pub(super) fn key(&self, name: &str) -> EditKey {
        EditKey::continuous(match self {
            Self::Priority(_) => format!("priority of {name}"),
            Self::Visible(_) => format!("hiding or showing {name}"),
            Self::Transform(manipulation, _) => format!("{} {name}", manipulation.doing()),
        })
    }

    /// Whether something changed.
    pub(super) fn apply(&self, name: &str, edited: &mut Description) -> Result<bool, Fault> {
        let Some(object) = edited.objects.find_mut(name) else { return Ok(false) };
        let is_changed = self.change(object);
        let mut object = object.clone();
        validate::table(edited, object.kind().name(), |v| object.fields(v))?;
        Ok(is_changed)
    }

    fn change(&self, object: &mut Object) -> bool {
        match self {
            Self::Priority(priority) => object.refractor_mut().is_some_and(|r| replaced(&mut r.priority, *priority)),
            Self::Visible(visible) => replaced(&mut object.visible, *visible),
            Self::Transform(_, transform) => replaced(&mut object.transform, *transform),
        }
    }
}
