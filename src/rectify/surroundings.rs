//! What lies on the two sides of a piece of surface: sets of refractors, and the media that they come to.

use super::containment::{medium_of, top};
use super::nest::Fillers;
use crate::scene::{MediumId, ObjectId, Scene};

/// How a refractor lies at a piece of another object's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum State {
    /// On neither side.
    Out = 0,
    /// On both sides.
    In = 1,
    /// Its surface coincides there and looks the same way: on the inner side only.
    InnerOnly = 2,
    /// Its surface coincides there and looks the other way: on the outer side only.
    OuterOnly = 3,
}

impl State {
    pub const ALL: [Self; 4] = [Self::Out, Self::In, Self::InnerOnly, Self::OuterOnly];

    pub fn of_coincident(same: bool) -> Self {
        if same { Self::InnerOnly } else { Self::OuterOnly }
    }

    pub fn of_sides(is_outer: bool, is_inner: bool) -> Self {
        match (is_outer, is_inner) {
            (false, false) => Self::Out,
            (true, true) => Self::In,
            (false, true) => Self::InnerOnly,
            (true, false) => Self::OuterOnly,
        }
    }

    pub fn is_outer(self) -> bool {
        matches!(self, Self::In | Self::OuterOnly)
    }

    pub fn is_inner(self) -> bool {
        matches!(self, Self::In | Self::InnerOnly)
    }
}

/// The refractors on both sides of a piece of the surface of `subject`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Surroundings {
    pub subject: ObjectId,
    /// Those that contain the outer side, in ascending order.
    pub outer: Vec<ObjectId>,
    /// Those that contain the inner side, besides the subject, in ascending order.
    pub inner: Vec<ObjectId>,
    /// Whether the piece is the twin of a coincident one that stands for both.
    pub is_masked: bool,
}

impl Surroundings {
    pub fn new(subject: ObjectId) -> Self {
        Self { subject, outer: Vec::new(), inner: Vec::new(), is_masked: false }
    }

    /// Adds a refractor in its place. The subject always lies on its own inner side.
    pub fn add(&mut self, refractor: ObjectId, state: State) {
        let insert = |set: &mut Vec<ObjectId>| {
            if let Err(at) = set.binary_search(&refractor) {
                set.insert(at, refractor);
            }
        };
        if state.is_outer() {
            insert(&mut self.outer);
        }
        if state.is_inner() && refractor != self.subject {
            insert(&mut self.inner);
        }
    }

    /// The refractor that fills the outer side.
    pub fn outer_refractor(&self, scene: &Scene) -> Option<ObjectId> {
        top(scene, self.outer.iter().copied())
    }

    /// The refractor that fills the inner side.
    pub fn inner_refractor(&self, scene: &Scene) -> Option<ObjectId> {
        top(scene, self.inner.iter().copied().chain([self.subject]))
    }

    pub fn resolve(&self, scene: &Scene) -> Answer {
        let fillers = Fillers { outer: self.outer_refractor(scene), inner: self.inner_refractor(scene) };
        Answer::of(scene, self.is_masked, fillers)
    }
}

/// The media on the two sides of a piece of surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    pub outside: MediumId,
    pub inside: MediumId,
}

impl Answer {
    /// Not to be met: a coincident surface stands for this one.
    pub const MASKED: Self = Self { outside: MediumId(u32::MAX), inside: MediumId(u32::MAX) };

    /// The media of what fills the two sides, unless the piece is masked.
    pub fn of(scene: &Scene, is_masked: bool, Fillers { outer, inner }: Fillers) -> Self {
        if is_masked {
            return Self::MASKED;
        }
        Self { outside: medium_of(scene, outer), inside: medium_of(scene, inner) }
    }

    #[inline]
    pub fn is_masked(self) -> bool {
        self == Self::MASKED
    }
}
