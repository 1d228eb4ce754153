//! `rectified` and `rectified-object`: the media are looked up in what rectification stored. No state per path.

use super::{Crossing, Sides, Tracker};
use crate::geometry::Mask;
use crate::rectify::InterfaceTable;
use crate::scene::{MediumId, Scene};
use crate::tracking::Events;

/// An answer for every place on every refractor.
#[derive(Debug, Clone, Copy)]
pub struct Rectified<'a> {
    pub scene: &'a Scene,
    pub table: &'a InterfaceTable,
}

impl Tracker for Rectified<'_> {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        events.mixed += u64::from(self.table.is_mixed(crossing.refractor, crossing.point.primitive));
        let answer = self.table.look(self.scene, crossing.refractor, &crossing.point, crossing.barycentric);
        if answer.is_masked() {
            return None;
        }
        let (outside, inside) = (answer.outside, answer.inside);
        let (from, to) = if crossing.is_entering { (outside, inside) } else { (inside, outside) };
        Some(Sides { from, to })
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}

    #[inline]
    fn mask(&self) -> Option<&Mask> {
        self.table.mask()
    }

    fn can_skip(&self) -> bool {
        self.table.has_passable()
    }
}

/// One exterior for the whole of each object: right wherever an object lies wholly inside another, or inside none.
#[derive(Debug, Clone)]
pub struct RectifiedObject {
    /// By object id.
    outsides: Vec<MediumId>,
}

impl RectifiedObject {
    pub fn new(scene: &Scene, table: &InterfaceTable) -> Self {
        Self { outsides: table.object_table(scene).outsides(scene) }
    }
}

impl Tracker for RectifiedObject {
    type State = ();

    #[inline]
    fn start(&self, (): &mut ()) {}

    #[inline]
    fn sides(&self, (): &(), crossing: &Crossing, _: &mut Events) -> Option<Sides> {
        Some(crossing.sides(self.outsides[crossing.refractor.0 as usize]))
    }

    #[inline]
    fn transmit(&self, (): &mut (), _: &Crossing) {}
}
