//! `rectified`: the exterior is looked up in what rectification stored. No state per path.

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
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Sides {
        crossing.sides(self.table.patch(crossing.refractor).outside)
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}
