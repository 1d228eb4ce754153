//! `naive`: the interior IOR is taken as relative, the exterior always vacuum.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::scene::MediumId;

#[derive(Debug, Clone, Copy)]
pub struct Naive;

impl<'a> TrackingMode<'a> for Naive {
    const NAME: &'static str = "naive";
    const ABOUT: &'static str =
        "Takes every IOR as relative to vacuum: wrong wherever something is nested or the world's IOR is not 1.";

    fn of(_: &'a Prepared) -> Self {
        Self
    }
}

impl Tracker for Naive {
    type State = ();

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(MediumId::VACUUM, crossing.interior))
    }
}
