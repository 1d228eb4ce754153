//! `reference`: containment asked anew at every hit, by voting rays. Slow; the truth that the other modes are measured against.

use super::{Crossing, Sides, Tracker};
use crate::rectify::containment::{containment, medium_of, top};
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
        let others = containment(world, crossing.point.position, Some(crossing.refractor));
        events.ambiguous += u64::from(others.is_ambiguous);
        let outside = medium_of(world, top(world, others.refractors.iter().copied()));
        let inside = medium_of(world, top(world, others.refractors.into_iter().chain([crossing.refractor])));
        let (from, to) = if crossing.is_entering { (outside, inside) } else { (inside, outside) };
        Some(Sides { from, to })
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}
