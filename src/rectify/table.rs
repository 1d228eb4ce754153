//! What rectification stores: for each patch of each refractor, the media on its two sides.

use crate::scene::world::{MediumId, ObjectId};

/// A part of a refractor's surface with the same surroundings everywhere: for now the whole refractor.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    pub refractor: ObjectId,
    /// Index among the refractor's patches.
    pub index: u32,
    /// Number of primitives.
    pub faces: u32,
    /// Scene units squared.
    pub area: f64,
    pub outside: MediumId,
    pub inside: MediumId,
    /// The container that was found; `None` is the global medium.
    pub outside_refractor: Option<ObjectId>,
    /// Rays shot so far, over all pre-traces of this geometry.
    pub rays: u32,
    /// Share of the votes that the answer got, in [0, 1].
    pub confidence: f64,
    /// Votes for each container, most first.
    pub votes: Vec<(Option<ObjectId>, u32)>,
}

/// The answer of rectification, looked up at every crossing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InterfaceTable {
    /// Sorted by refractor.
    pub patches: Vec<Patch>,
    /// Patch of each object; `u32::MAX` for solids and lights.
    pub patch_of_object: Vec<u32>,
    pub seconds: RectifySeconds,
}

/// Time spent on each part, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct RectifySeconds {
    pub topology: f64,
    pub patches: f64,
    pub pretrace: f64,
    pub resolve: f64,
}

impl RectifySeconds {
    pub fn total(&self) -> f64 {
        self.topology + self.patches + self.pretrace + self.resolve
    }
}

impl InterfaceTable {
    /// The patch that a point of `object`, a refractor, belongs to.
    #[inline]
    pub fn patch(&self, object: ObjectId) -> &Patch {
        &self.patches[self.patch_of_object[object.0 as usize] as usize]
    }
}
