//! `reference`: containment asked anew on both sides of every hit. Slow; the truth that the other modes are measured against.
//!
//! So that it can judge rectification, it shares none of its code: neither contacts, patches and votes nor the analysis and repair of meshes.
//! What it has in common with every mode is the shapes, the geometry that rays meet, and the estimator.
//!
//! - Each refractor's mesh is read anew, as it was loaded: vertices a few roundings apart are one, parts hang together by edges, inverted
//!   parts are turned ([`reading`]).
//! - A point lies inside where the parts wind around it more than half a time ([`winding`]): union, cavities, overlaps and small holes need no
//!   rule of their own. Sheets, which enclose nothing, have one ([`sheet`]).
//! - On a surface the winding number jumps. The faces at the hit, in its plane, whichever object's they are, are left out of the sum
//!   and add or take a half on either side, by the way they look: so no point has to be moved off the surface, and
//!   surfaces that coincide are one place with two sides. One of them, the first, stands for all.

pub mod bodies;
mod boxes;
mod reading;
mod sheet;
mod vertices;
mod winding;

use glam::DVec3;

use super::events::Events;
use super::prepare::Prepared;
use super::tracker::{Crossing, Sides, Tracker, TrackingMode};
use crate::geometry::SurfacePoint;
use crate::scene::{MediumId, ObjectId, Scene};

pub use bodies::Bodies;

#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    pub scene: &'a Scene,
    pub bodies: &'a Bodies,
}

impl<'a> TrackingMode<'a> for Reference<'a> {
    const NAME: &'static str = "reference";
    const ABOUT: &'static str = "Asks what contains both sides of every hit, by winding numbers: slow, the truth the others are measured against.";

    fn of(prepared: &'a Prepared) -> Self {
        Self { scene: &prepared.scene, bodies: prepared.bodies() }
    }
}

/// The refractors on both sides of a place on a refractor's surface. On each side the one that fills it comes first; where there is none, it is
/// the global medium.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Surroundings {
    pub outside: Vec<ObjectId>,
    pub inside: Vec<ObjectId>,
    /// Whether it is doubtful what contains the place.
    pub is_doubtful: bool,
}

impl Reference<'_> {
    /// What lies around a point (local coordinates) of a refractor's surface.
    pub fn surroundings(&self, point: &SurfacePoint) -> Surroundings {
        let place = self.bodies.place(&self.scene.geometry, point);
        let ([outside, inside], is_doubtful) = self.bodies.containers_beside(self.scene, &place, point.primitive);
        Surroundings { outside, inside, is_doubtful }
    }
}

impl Tracker for Reference<'_> {
    type State = ();

    fn sides(&self, (): &(), crossing: &Crossing, events: &mut Events) -> Option<Sides> {
        let primitive = crossing.point.primitive;
        let place = self.bodies.place(&self.scene.geometry, &crossing.point);
        if self.bodies.is_stood_for(self.scene, &place, primitive) {
            return None;
        }
        let beside = self.bodies.beside(self.scene, &place, primitive);
        events.ambiguous += u64::from(beside.is_doubtful);
        Some(crossing.sides(beside.front, beside.back))
    }

    fn can_skip(&self) -> bool {
        true
    }

    fn medium_at(&self, point: DVec3) -> Option<(MediumId, bool)> {
        Some(self.bodies.medium_at(self.scene, point))
    }
}
