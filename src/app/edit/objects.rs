//! Changes to objects.

use super::EditKey;
use crate::app::objects::{Manipulation, replaced};
use crate::optics::Medium;
use crate::scene::description::{Emission, Object, Paint, Role, Shape, Transform};
use crate::scene::tables::medium_fields;
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
    /// Another name.
    Rename(String),
    Shape(Shape),
    /// Whether normals are interpolated over faces. Of a refractor or a solid.
    Smooth(bool),
    /// Of a solid.
    Paint(Paint),
    /// Of a solid.
    Mirror(bool),
    /// Of a light.
    Emission(Emission),
    /// Whether a light emits from its inward side too.
    TwoSided(bool),
    /// What the scene declares outside of a refractor or a light.
    Outside(Option<String>),
}

impl ObjectEdit {
    pub(super) fn key(&self, name: &str) -> EditKey {
        EditKey::continuous(match self {
            Self::Priority(_) => format!("priority of {name}"),
            Self::Visible(_) => format!("hiding or showing {name}"),
            Self::Transform(manipulation, _) => format!("{} {name}", manipulation.doing()),
            Self::Rename(_) => return EditKey::single(format!("renaming {name}")),
            Self::Shape(_) => format!("shape of {name}"),
            Self::Smooth(_) => format!("smoothing of {name}"),
            Self::Paint(_) => format!("colour of {name}"),
            Self::Mirror(_) => format!("mirror of {name}"),
            Self::Emission(_) => format!("light of {name}"),
            Self::TwoSided(_) => format!("sides of {name}"),
            Self::Outside(_) => format!("declared outside of {name}"),
        })
    }

    /// Whether something changed.
    pub(super) fn apply(&self, name: &str, edited: &mut Description) -> Result<bool, Fault> {
        let Some(object) = edited.objects.find_mut(name) else { return Ok(false) };
        let is_changed = self.change(object);
        if !is_changed {
            return Ok(false);
        }
        let mut object = object.clone();
        require_object(edited, &mut object)?;
        Ok(true)
    }

    fn change(&self, object: &mut Object) -> bool {
        match self {
            Self::Priority(priority) => object.refractor_mut().is_some_and(|r| replaced(&mut r.priority, *priority)),
            Self::Visible(visible) => replaced(&mut object.visible, *visible),
            Self::Transform(_, transform) => replaced(&mut object.transform, *transform),
            Self::Rename(name) => replaced(&mut object.name, name.trim().to_owned()),
            Self::Shape(shape) => replaced(&mut object.shape, shape.clone()),
            Self::Smooth(smooth) => match &mut object.role {
                Role::Refractor(refractor) => replaced(&mut refractor.smooth, *smooth),
                Role::Solid(solid) => replaced(&mut solid.smooth, *smooth),
                Role::Light(_) => false,
            },
            Self::Paint(paint) => object.solid_mut().is_some_and(|solid| replaced(&mut solid.paint, paint.clone())),
            Self::Mirror(mirror) => object.solid_mut().is_some_and(|solid| replaced(&mut solid.mirror, *mirror)),
            Self::Emission(emission) => {
                object.light_mut().is_some_and(|light| replaced(&mut light.emission, *emission))
            }
            Self::TwoSided(two_sided) => {
                object.light_mut().is_some_and(|light| replaced(&mut light.two_sided, *two_sided))
            }
            Self::Outside(outside) => object.outside_mut().is_some_and(|known| replaced(known, outside.clone())),
        }
    }
}

/// Holds an object of the scene to what scene files may say.
fn require_object(description: &Description, object: &mut Object) -> Result<(), Fault> {
    validate::table(description, object.kind().name(), |v| object.fields(v))
}

/// Adds an object, and the medium that it brings.
pub(super) fn add(object: &Object, medium: Option<&Medium>, edited: &mut Description) -> Result<bool, Fault> {
    if let Some(medium) = medium {
        edited.media.push(medium.clone());
        validate::table(edited, "medium", |v| medium_fields(&mut medium.clone(), v))?;
    }
    edited.objects.push(object.clone());
    require_object(edited, &mut object.clone())?;
    Ok(true)
}

pub(super) fn remove(name: &str, edited: &mut Description) -> bool {
    let index = edited.objects.iter().position(|object| object.name == name);
    index.map(|index| edited.objects.remove(index)).is_some()
}

/// Sets the priorities of several refractors.
pub(super) fn set_priorities(priorities: &[(String, i32)], edited: &mut Description) -> bool {
    let mut is_changed = false;
    for (name, priority) in priorities {
        if let Some(refractor) = edited.objects.find_mut(name).and_then(Object::refractor_mut) {
            is_changed |= replaced(&mut refractor.priority, *priority);
        }
    }
    is_changed
}
