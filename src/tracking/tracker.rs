//! What every mode answers: the media on both sides of a crossing, given what the path carries.

use glam::DVec3;

use super::events::Events;
use super::prepare::Prepared;
use crate::geometry::{Mask, SurfacePoint};
use crate::scene::{MediumId, ObjectId};

/// A ray meeting a refractor's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    pub refractor: ObjectId,
    /// The medium inside `refractor`.
    pub interior: MediumId,
    /// Whether the ray comes from outside.
    pub is_entering: bool,
    pub point: SurfacePoint,
    /// As in [`crate::geometry::Hit`].
    pub barycentric: [f64; 2],
}

/// The media on both sides of a crossing, seen along the ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sides {
    pub from: MediumId,
    pub to: MediumId,
}

impl Crossing {
    /// The sides, given what lies outside and inside.
    #[inline]
    pub(super) fn sides(&self, outside: MediumId, inside: MediumId) -> Sides {
        let (from, to) = if self.is_entering { (outside, inside) } else { (inside, outside) };
        Sides { from, to }
    }
}

/// A mode at work. The path loop is compiled once for each.
pub trait Tracker: Sync {
    /// What a path carries.
    type State: Clone + Default + Send;

    /// Makes `state` that of a fresh path.
    #[inline]
    fn start(&self, state: &mut Self::State) {
        // What it has allocated is kept.
        state.clone_from(&Self::State::default());
    }

    /// Whether [`Tracker::sides`] may answer `None`: shadow rays must then look at every refractor in their way.
    #[inline]
    fn can_skip(&self) -> bool {
        false
    }

    /// The medium at a point off all surfaces (local coordinates), and whether there is doubt; `None` where the mode has no way of its own to
    /// ask, and takes what rectification finds.
    fn medium_at(&self, _point: DVec3) -> Option<(MediumId, bool)> {
        None
    }

    /// The medium that paths from the camera start in, where the mode is told; `None`: it is asked about the place.
    fn camera_medium(&self) -> Option<MediumId> {
        None
    }

    /// The same of paths from a light, or from the environment.
    fn light_medium(&self, _light: Option<ObjectId>) -> Option<MediumId> {
        None
    }

    /// Primitives of refractors that are no interface anywhere: rays need not meet them.
    #[inline]
    fn mask(&self) -> Option<&Mask> {
        None
    }

    /// Which media the crossing lies between. Reflection there leaves the state as it is.
    ///
    /// `None`: there is no interface here. The path goes straight on in the medium it is in, and [`Tracker::transmit`] is told all the
    /// same, because the path did go through this surface.
    fn sides(&self, state: &Self::State, crossing: &Crossing, events: &mut Events) -> Option<Sides>;

    /// Records that the path went through, bent or not.
    #[inline]
    fn transmit(&self, _state: &mut Self::State, _crossing: &Crossing) {}
}

/// A tracker that is a mode of its own: see [`super::Mode`].
pub trait TrackingMode<'a>: Tracker + Sized {
    /// The name used on the command line, in JSON and on labels.
    const NAME: &'static str;
    /// One sentence for tooltips and help.
    const ABOUT: &'static str;
    /// Whether it looks up what rectification found, whose time then counts as the mode's own.
    const IS_RECTIFIED: bool = false;

    /// The tracker for a scene.
    fn of(prepared: &'a Prepared) -> Self;
}

/// Work to be done with a tracker, compiled once for each mode.
pub trait WithTracker {
    type Output;

    fn run<T: Tracker>(self, tracker: &T) -> Self::Output;
}
