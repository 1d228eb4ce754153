//! `reference`: containment asked anew on both sides of every hit, by voting rays. Slow; the truth that the other modes are measured
//! against.

use super::{Crossing, Sides, Tracker};
use crate::rectify::contact::is_stood_for;
use crate::rectify::containment::{containment_beside, medium_of, top};
use crate::render::Events;
use crate::scene::World;

#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    pub world: &'a World,
}

impl Tracker for Reference<'_> {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    fn sides(&self, (): &(), crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        let world = self.world;
        if is_stood_for(world, &crossing.point) {
            return None;
        }
        let (outer, inner) =
            (containment_beside(world, &crossing.point, true), containment_beside(world, &crossing.point, false));
        events.ambiguous += u64::from(outer.is_ambiguous || inner.is_ambiguous);
        let outside = medium_of(world, top(world, outer.refractors));
        let inside = medium_of(world, top(world, inner.refractors.into_iter().chain([crossing.refractor])));
        let (from, to) = if crossing.is_entering { (outside, inside) } else { (inside, outside) };
        Some(Sides { from, to })
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}

    fn can_skip(&self) -> bool {
        true
    }
}
