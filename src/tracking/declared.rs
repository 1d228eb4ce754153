//! `declared`: both sides of each surface as the scene declares them, which is what renderers make of a file that names both. No state per path.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::scene::{MediumId, ObjectId};

/// One exterior for each object, from its description; the global medium where nothing is said.
#[derive(Debug, Clone)]
pub struct Declared {
    /// By object id.
    outsides: Vec<MediumId>,
    camera: MediumId,
}

impl<'a> TrackingMode<'a> for Declared {
    const NAME: &'static str = "declared";
    const ABOUT: &'static str = "Believes what the scene declares outside of each object (the world where it says nothing), as renderers do that are told both sides: as right as the declarations.";

    fn of(prepared: &'a Prepared) -> Self {
        let declared = &prepared.scene.declared;
        Self { outsides: declared.outsides(), camera: declared.camera.unwrap_or(MediumId::WORLD) }
    }
}

impl Tracker for Declared {
    type State = ();

    fn camera_medium(&self) -> Option<MediumId> {
        Some(self.camera)
    }

    fn light_medium(&self, light: Option<ObjectId>) -> Option<MediumId> {
        Some(light.map_or(MediumId::WORLD, |light| self.outsides[light.0 as usize]))
    }

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(self.outsides[crossing.refractor.0 as usize], crossing.interior))
    }
}
