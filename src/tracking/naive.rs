//! `naive`: the interior IOR is taken as relative, the exterior always vacuum.

use super::{Crossing, Sides, Tracker};
use crate::scene::MediumId;
use crate::tracking::Events;

#[derive(Debug, Clone, Copy)]
pub struct Naive;

impl Tracker for Naive {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(MediumId::VACUUM))
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}
