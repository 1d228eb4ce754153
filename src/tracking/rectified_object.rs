//! `rectified-object`: one exterior for each object, as the method was first described. No state per path.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::scene::MediumId;

/// One exterior for the whole of each object: right wherever an object lies wholly inside another, or inside none.
#[derive(Debug, Clone)]
pub struct RectifiedObject {
    /// By object id.
    outsides: Vec<MediumId>,
}

impl<'a> TrackingMode<'a> for RectifiedObject {
    const NAME: &'static str = "rectified-object";
    const ABOUT: &'static str = "Looks up one exterior per object: no state per path, wrong where an object has different surroundings in different places.";
    const IS_RECTIFIED: bool = true;

    fn of(prepared: &'a Prepared) -> Self {
        Self { outsides: prepared.table.object_table(&prepared.scene).outsides(&prepared.scene) }
    }
}

impl Tracker for RectifiedObject {
    type State = ();

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(self.outsides[crossing.refractor.0 as usize], crossing.interior))
    }
}
