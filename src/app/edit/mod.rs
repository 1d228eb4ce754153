//! Everything that can be changed about a scene, as data. [`Edit::apply`] is the only place that changes a description, and holds it to
//! what readers of scene files demand: whatever comes out can be saved and read again.

mod media;
mod media_list;
mod objects;
pub mod priorities;
#[cfg(test)]
mod tests;

pub use self::media::{MediumEdit, ior_of};
pub use self::media_list::MediaEdit;
pub use self::objects::ObjectEdit;
use super::command::MediumRef;
use super::objects::replaced;
use crate::optics::Medium;
use crate::scene::description::{CameraDescription, Environment, Object};
use crate::scene::{Description, Fault, validate};

/// A change to a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// The scene's own name.
    Name(String),
    /// Of one object, by name.
    Object(String, ObjectEdit),
    /// A new object, and the medium that it brings where it is made of none that is there.
    Add(Box<Object>, Option<Medium>),
    /// New objects that came together, each with the medium that it brings.
    AddAll(Vec<(Object, Option<Medium>)>),
    /// Takes an object out of the scene, by name.
    Remove(String),
    /// Of several refractors, by name.
    Priorities(Vec<(String, i32)>),
    Medium(MediumRef, MediumEdit),
    /// Of the list of media.
    Media(MediaEdit),
    /// The scene's own camera.
    Camera(CameraDescription),
    /// What the scene declares its camera to be in.
    CameraMedium(Option<String>),
    Environment(Environment),
}

/// What an edit changes, in words that follow "Undo": successive edits of the same thing are undone together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditKey {
    label: String,
    merges: bool,
}

impl EditKey {
    /// Of a change that may come in many small steps, such as the drag of a slider.
    pub fn continuous(label: impl Into<String>) -> Self {
        Self { label: label.into(), merges: true }
    }

    /// Of a change that is undone on its own.
    pub fn single(label: impl Into<String>) -> Self {
        Self { label: label.into(), merges: false }
    }

    pub fn label(&self) -> &str {
        &self.label
    }

    /// Whether an edit of `self` goes on with what an edit of `last` began.
    pub fn continues(&self, last: &Self) -> bool {
        self.merges && self == last
    }
}

impl Edit {
    pub fn key(&self) -> EditKey {
        match self {
            Self::Name(_) => EditKey::single("name of the scene"),
            Self::Object(name, edit) => edit.key(name),
            Self::Add(object, _) => EditKey::single(format!("adding {}", object.name)),
            Self::AddAll(objects) => EditKey::single(match &objects[..] {
                [(object, _)] => format!("adding {}", object.name),
                objects => format!("adding {} objects", objects.len()),
            }),
            Self::Remove(name) => EditKey::single(format!("deleting {name}")),
            Self::Priorities(_) => EditKey::continuous("order of priorities"),
            Self::Medium(medium, edit) => edit.key(medium),
            Self::Media(edit) => edit.key(),
            Self::Camera(_) => EditKey::continuous("scene camera"),
            Self::CameraMedium(_) => EditKey::continuous("declared medium of the camera"),
            Self::Environment(environment) => EditKey::continuous(match environment {
                Environment::Color(_) => "colour of the environment",
                Environment::Gradient { .. } => "gradient of the environment",
                Environment::Image { .. } => "image of the environment",
            }),
        }
    }

    /// The object that is selected after the edit, if one of that name was before; `None` if another is to be.
    pub fn selection(&self, before: Option<&str>) -> Option<String> {
        match self {
            Self::Add(object, _) => Some(object.name.clone()),
            Self::AddAll(objects) => objects.first().map(|(object, _)| object.name.clone()),
            Self::Remove(name) if before == Some(name) => None,
            Self::Object(name, ObjectEdit::Rename(new)) if before == Some(name) => Some(new.trim().to_owned()),
            _ => before.map(str::to_owned),
        }
    }

    /// The edited scene; `None` where nothing changes, such as for an object that is not there.
    ///
    /// # Errors
    /// Why a file that says this would be refused.
    pub fn apply(&self, description: &Description) -> Result<Option<Description>, String> {
        let mut edited = description.clone();
        let is_changed = match self {
            Self::Name(name) if name.trim().is_empty() => Fault::at("name", "`name` is empty").map(|()| false),
            Self::Name(name) => Ok(replaced(&mut edited.name, name.trim().to_owned())),
            Self::Object(name, edit) => edit.apply(name, &mut edited),
            Self::Add(object, medium) => objects::add(object, medium.as_ref(), &mut edited),
            Self::AddAll(all) => all.iter().try_fold(false, |is_changed, (object, medium)| {
                objects::add(object, medium.as_ref(), &mut edited).map(|is_added| is_changed | is_added)
            }),
            Self::Remove(name) => Ok(objects::remove(name, &mut edited)),
            Self::Priorities(priorities) => Ok(objects::set_priorities(priorities, &mut edited)),
            Self::Medium(medium, edit) => edit.apply(medium, &mut edited),
            Self::Media(edit) => edit.apply(&mut edited),
            Self::Camera(camera) => {
                let is_changed = replaced(&mut edited.camera, *camera);
                validate::table(&edited, "camera", |v| { *camera }.fields(v)).map(|()| is_changed)
            }
            Self::CameraMedium(medium) => {
                let is_changed = replaced(&mut edited.camera_medium, medium.clone());
                let mut camera = edited.camera;
                validate::table(&edited, "camera", |v| camera.fields_in(&mut medium.clone(), v)).map(|()| is_changed)
            }
            Self::Environment(environment) => {
                let is_changed = replaced(&mut edited.environment, environment.clone());
                validate::table(&edited, "environment", |v| environment.clone().fields(v)).map(|()| is_changed)
            }
        };
        match is_changed {
            Ok(is_changed) => Ok(is_changed.then_some(edited)),
            Err(Fault { message, .. }) => Err(message),
        }
    }
}
