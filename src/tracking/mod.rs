//! The modes: ways to know, at a crossing of a refractor's surface, which medium is left and which is entered.

pub mod events;
pub mod naive;
pub mod prepare;
pub mod priority;
pub mod rectified;
pub mod reference;
pub mod stack;

pub use events::Events;
pub use prepare::{PrepareError, PrepareSeconds, Prepared, prepare, prepare_watched};

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

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
    /// The sides, given what lies outside.
    #[inline]
    fn sides(&self, outside: MediumId) -> Sides {
        if self.is_entering {
            Sides { from: outside, to: self.interior }
        } else {
            Sides { from: self.interior, to: outside }
        }
    }
}

/// A mode at work. The path loop is compiled once for each.
pub trait Tracker: Sync {
    /// What a path carries.
    type State: Clone + Default + Send;

    /// Makes `state` that of a fresh path.
    fn start(&self, state: &mut Self::State);

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
    fn transmit(&self, state: &mut Self::State, crossing: &Crossing);
}

/// A way of tracking media. Declared in the order in which they deserve trust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// The exterior is always vacuum.
    Naive,
    /// A stack of the media entered so far.
    Stack,
    /// A list of the refractors entered so far, ordered by their priorities.
    Priority,
    /// IOR rectification with one stored exterior per object; no state per path.
    RectifiedObject,
    /// The stored answer of IOR rectification; no state per path.
    Rectified,
    /// Containment asked anew on both sides of every hit: slow, the truth that the others are measured against.
    Reference,
}

impl Mode {
    pub const ALL: [Self; 6] =
        [Self::Naive, Self::Stack, Self::Priority, Self::RectifiedObject, Self::Rectified, Self::Reference];

    /// The name used on the command line, in JSON and on labels.
    pub fn name(self) -> &'static str {
        match self {
            Self::Naive => "naive",
            Self::Stack => "stack",
            Self::Priority => "priority",
            Self::RectifiedObject => "rectified-object",
            Self::Rectified => "rectified",
            Self::Reference => "reference",
        }
    }

    /// One sentence for tooltips and help.
    pub fn about(self) -> &'static str {
        match self {
            Self::Naive => {
                "Takes every IOR as relative to vacuum: wrong wherever something is nested or the world's IOR is not 1."
            }
            Self::Stack => {
                "Carries the media entered so far along each path: wrong when the path starts inside a dielectric."
            }
            Self::Priority => {
                "Carries the refractors entered so far and lets the highest priority win: right where volumes overlap, wrong when the path starts inside a dielectric."
            }
            Self::RectifiedObject => {
                "Looks up one exterior per object: no state per path, wrong where an object has different surroundings in different places."
            }
            Self::Rectified => {
                "Looks up what rectification found outside each refractor: no state per path, right wherever it starts."
            }
            Self::Reference => {
                "Asks what contains both sides of every hit, by winding numbers: slow, the truth the others are measured against."
            }
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|mode| mode.name() == text)
            .ok_or_else(|| format!("unknown mode `{text}`; valid modes: {}", Self::ALL.map(Self::name).join(", ")))
    }
}
