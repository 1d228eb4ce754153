//! What a scene declares of the media around surfaces and around the camera, whatever is found to be there.

use super::description::Description;
use super::error::SceneError;
use super::scene::{MediumId, ObjectId};
use crate::optics::medium::WORLD;

/// The declarations of a scene, with their media resolved.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Declared {
    /// What lies outside, by object id; `None` where nothing is said.
    outsides: Vec<Option<MediumId>>,
    /// What the camera is in.
    pub camera: Option<MediumId>,
}

impl Declared {
    /// `medium` finds the scene's media by their names.
    ///
    /// # Errors
    /// When a medium is unknown.
    pub(super) fn new(
        description: &Description,
        medium: impl Fn(&str) -> Option<MediumId>,
    ) -> Result<Self, SceneError> {
        let resolve = |who: &dyn Fn() -> String, name: Option<&str>| match name {
            None => Ok(None),
            Some(WORLD) => Ok(Some(MediumId::WORLD)),
            Some(name) => medium(name).map(Some).ok_or_else(|| {
                SceneError::new(format!("{}: unknown medium `{name}`, which is declared around it", who()))
            }),
        };
        let outsides = (description.objects.iter())
            .map(|object| resolve(&|| format!("`{}`", object.name), object.outside()))
            .collect::<Result<_, _>>()?;
        Ok(Self { outsides, camera: resolve(&|| "the camera".to_owned(), description.camera_medium.as_deref())? })
    }

    /// What is said to lie outside of an object.
    pub fn outside(&self, object: ObjectId) -> Option<MediumId> {
        self.outsides.get(object.0 as usize).copied().flatten()
    }

    /// Whether nothing is declared.
    pub fn is_empty(&self) -> bool {
        self.camera.is_none() && self.outsides.iter().all(Option::is_none)
    }

    /// What lies outside of each object, by object id: the global medium where nothing is said.
    pub fn outsides(&self) -> Vec<MediumId> {
        self.outsides.iter().map(|outside| outside.unwrap_or(MediumId::WORLD)).collect()
    }
}
