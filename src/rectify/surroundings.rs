//! What lies on the two sides of a piece of surface: sets of refractors, and the media that they come to.

use super::containment::{fills_beside, medium_of, top};
use crate::geometry::SurfacePoint;
use crate::scene::{MediumId, ObjectId, Scene};

/// On which sides of a piece of another object's surface a refractor lies. The numbers are those of [`super::flat`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Membership {
    /// On neither side.
    Out = 0,
    /// On both sides.
    In = 1,
    /// Its surface coincides there and looks the same way: on the inner side only.
    InnerOnly = 2,
    /// Its surface coincides there and looks the other way: on the outer side only.
    OuterOnly = 3,
}

impl Membership {
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
    pub fn add(&mut self, refractor: ObjectId, membership: Membership) {
        let insert = |set: &mut Vec<ObjectId>| {
            if let Err(at) = set.binary_search(&refractor) {
                set.insert(at, refractor);
            }
        };
        if matches!(membership, Membership::In | Membership::OuterOnly) {
            insert(&mut self.outer);
        }
        if matches!(membership, Membership::In | Membership::InnerOnly) && refractor != self.subject {
            insert(&mut self.inner);
        }
    }

    /// The refractors that fill the two sides.
    pub fn fillers(&self, scene: &Scene) -> Fillers {
        let outer = top(scene, self.outer.iter().copied());
        Fillers { outer, inner: top(scene, self.inner.iter().copied().chain([self.subject])) }
    }

    pub fn resolve(&self, scene: &Scene) -> Answer {
        Answer::of(scene, self.is_masked, self.fillers(scene))
    }
}

/// On which sides of a surface a refractor of several parts lies, at a point where faces of its own coincide with that surface. Both are asked about:
/// several faces may coincide, of parts on either side, and other parts may contain all of it. `None` where the refractor is the subject itself
/// and its coincident faces enclose nothing between them.
pub(super) fn membership_of_parts(
    scene: &Scene,
    refractor: ObjectId,
    subject: ObjectId,
    point: &SurfacePoint,
) -> Option<Membership> {
    let [is_outer, is_inner] = [true, false].map(|is_outer| fills_beside(scene, refractor, point, is_outer));
    (is_inner || refractor != subject).then(|| Membership::of_sides(is_outer, is_inner))
}

/// The refractors that fill the two sides of a piece of surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fillers {
    pub outer: Option<ObjectId>,
    pub inner: Option<ObjectId>,
}

/// The media on the two sides of a piece of surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Answer {
    pub outside: MediumId,
    pub inside: MediumId,
}

impl Answer {
    /// The crossing is skipped: a coincident surface stands for this one.
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
