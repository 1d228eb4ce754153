//! `rectified`: the media are looked up in what rectification stored for each place. No state per path.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::geometry::Mask;
use crate::rectify::InterfaceTable;
use crate::scene::Scene;

/// An answer for every place on every refractor.
#[derive(Debug, Clone, Copy)]
pub struct Rectified<'a> {
    pub scene: &'a Scene,
    pub table: &'a InterfaceTable,
}

impl<'a> TrackingMode<'a> for Rectified<'a> {
    const NAME: &'static str = "rectified";
    const ABOUT: &'static str =
        "Looks up what rectification found outside each refractor: no state per path, right wherever it starts.";
    const IS_RECTIFIED: bool = true;

    fn of(prepared: &'a Prepared) -> Self {
        Self { scene: &prepared.scene, table: &prepared.table }
    }
}

impl Tracker for Rectified<'_> {
    type State = ();

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        events.mixed += u64::from(self.table.is_mixed(crossing.refractor, crossing.point.primitive));
        let answer = self.table.look(self.scene, crossing.refractor, &crossing.point, crossing.barycentric);
        (!answer.is_masked()).then(|| crossing.sides(answer.outside, answer.inside))
    }

    #[inline]
    fn mask(&self) -> Option<&Mask> {
        self.table.mask()
    }

    fn can_skip(&self) -> bool {
        self.table.has_passable()
    }
}
