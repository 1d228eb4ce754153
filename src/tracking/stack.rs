//! `stack`: the media entered so far. Every path starts with the global medium alone, wherever it starts.

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::scene::MediumId;

#[derive(Debug, Clone, Copy)]
pub struct Stack;

impl<'a> TrackingMode<'a> for Stack {
    const NAME: &'static str = "stack";
    const ABOUT: &'static str =
        "Carries the media entered so far along each path: wrong when the path starts inside a dielectric.";

    fn of(_: &'a Prepared) -> Self {
        Self
    }
}

impl Tracker for Stack {
    /// Media above the global one, innermost last. Grows as needed: nothing overflows.
    type State = Vec<MediumId>;

    #[inline]
    fn sides(&self, state: &Self::State, crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        let below = |depth: usize| state.len().checked_sub(depth).map_or(MediumId::WORLD, |index| state[index]);
        if crossing.is_entering {
            return Some(Sides { from: below(1), to: crossing.interior });
        }
        if state.is_empty() {
            events.stack_underflow += 1;
            return Some(Sides { from: crossing.interior, to: MediumId::WORLD });
        }
        // What is popped should be what this refractor holds; where it is not, volumes overlap or an entry was missed.
        if below(1) != crossing.interior {
            events.inconsistent += 1;
        }
        Some(Sides { from: below(1), to: below(2) })
    }

    #[inline]
    fn transmit(&self, state: &mut Self::State, crossing: &Crossing) {
        if crossing.is_entering {
            state.push(crossing.interior);
        } else {
            state.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::SurfacePoint;
    use crate::scene::ObjectId;

    fn cross(state: &mut Vec<MediumId>, events: &mut Events, interior: u32, is_entering: bool) -> (u32, u32) {
        let point = SurfacePoint { position: DVec3::ZERO, normal: DVec3::Y, primitive: 0 };
        let (refractor, interior) = (ObjectId(interior), MediumId(interior));
        let crossing = Crossing { refractor, interior, is_entering, point, barycentric: [0.0; 2] };
        let sides = Stack.sides(state, &crossing, events).expect("a stack skips nothing");
        Stack.transmit(state, &crossing);
        (sides.from.0, sides.to.0)
    }

    #[test]
    fn a_nest_is_entered_and_left_in_order() {
        let (mut state, mut events) = (Vec::new(), Events::default());
        assert_eq!(cross(&mut state, &mut events, 2, true), (0, 2));
        assert_eq!(cross(&mut state, &mut events, 3, true), (2, 3));
        assert_eq!(cross(&mut state, &mut events, 3, false), (3, 2));
        assert_eq!(cross(&mut state, &mut events, 2, false), (2, 0));
        assert_eq!(events, Events::default());
    }

    #[test]
    fn an_exit_without_an_entry_is_counted_and_corrupts_nothing() {
        let (mut state, mut events) = (Vec::new(), Events::default());
        assert_eq!(cross(&mut state, &mut events, 2, false), (2, 0));
        assert_eq!(events.stack_underflow, 1);
        assert_eq!(cross(&mut state, &mut events, 3, true), (0, 3));
    }
}
