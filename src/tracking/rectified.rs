//! `rectified` and `rectified-object`: the exterior is looked up in what rectification stored. No state per path.

use super::{Crossing, Sides, Tracker};
use crate::rectify::InterfaceTable;
use crate::render::Events;

#[derive(Debug, Clone, Copy)]
pub struct Rectified<'a> {
    pub table: &'a InterfaceTable,
}

impl Tracker for Rectified<'_> {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(self.table.patch(crossing.refractor).outside))
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}

/// One exterior for the whole of each object: right wherever an object lies wholly inside another, or inside none.
#[derive(Debug, Clone, Copy)]
pub struct RectifiedObject<'a> {
    pub table: &'a InterfaceTable,
}

impl Tracker for RectifiedObject<'_> {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(self.table.patch(crossing.refractor).outside))
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}
