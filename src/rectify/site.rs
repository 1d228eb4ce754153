//! Connected pieces of a surface with the same surroundings all over, and the votes about them.

use std::sync::Arc;

use super::containment::Vote;
use super::surroundings::{Membership, Surroundings};
use crate::geometry::{Geometry, PrimitiveId, SurfacePoint};
use crate::scene::ObjectId;

/// The faces of a site.
#[derive(Debug, Clone, PartialEq)]
pub enum Faces {
    /// All of the object's.
    Whole,
    /// Some triangles, in ascending order, with the running sums of their areas.
    Some { faces: Vec<PrimitiveId>, areas: Vec<f64> },
}

/// A connected piece of an object's surface with the same surroundings all over: a patch.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    pub subject: ObjectId,
    pub faces: Faces,
    /// The surroundings as far as they do not need votes: refractors that coincide with the site, and whether it is masked.
    pub fixed: Surroundings,
    /// The refractors whose membership `fixed` settles: votes about them do not count.
    pub settled: Vec<ObjectId>,
}

impl Site {
    /// The first of its faces, which no other site of the object has; 0 where it has all of them.
    pub fn first_face(&self) -> PrimitiveId {
        match &self.faces {
            Faces::Whole => 0,
            Faces::Some { faces, .. } => faces.first().copied().unwrap_or(0),
        }
    }

    pub fn face_count(&self, geometry: &Geometry) -> u32 {
        match &self.faces {
            Faces::Whole => geometry.face_count(self.subject.0),
            Faces::Some { faces, .. } => faces.len() as u32,
        }
    }

    /// In scene units squared.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        match &self.faces {
            Faces::Whole => geometry.area(self.subject.0),
            Faces::Some { areas, .. } => areas.last().copied().unwrap_or(0.0),
        }
    }

    /// A point of the site, uniform by area, for `u` uniform in [0, 1)³. `None` when it has no area.
    pub fn sample(&self, geometry: &Geometry, u: [f64; 3]) -> Option<SurfacePoint> {
        match &self.faces {
            Faces::Whole => geometry.sample_surface(self.subject.0, u),
            Faces::Some { faces, areas } => {
                let at = areas.partition_point(|&sum| sum <= u[0] * areas[areas.len() - 1]).min(areas.len() - 1);
                geometry.sample_primitive(faces[at], [u[1], u[2]])
            }
        }
    }
}

/// The votes about one site, over all pre-traces of its geometry.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SiteVotes {
    pub rays: u32,
    /// About every refractor that some ray found to contain the site, in ascending order. Shared, because it is long in deep nests.
    pub list: Arc<Vec<Vote>>,
    /// The innermost container, if the others are inherited from it: those are not listed.
    pub within: Option<ObjectId>,
}

impl SiteVotes {
    /// The fixed surroundings and the refractors that the majorities add; inherited containers are left out.
    pub fn surroundings(&self, site: &Site) -> Surroundings {
        self.surroundings_but_for(site, None)
    }

    /// The same with the answer about one refractor reversed.
    pub fn surroundings_but_for(&self, site: &Site, reversed: Option<ObjectId>) -> Surroundings {
        let mut surroundings = site.fixed.clone();
        for vote in &*self.list {
            if !site.settled.contains(&vote.refractor) && vote.is_inside() != (reversed == Some(vote.refractor)) {
                surroundings.add(vote.refractor, Membership::In);
            }
        }
        surroundings
    }

    /// Adds the votes of another round, in ascending order of refractors.
    pub(super) fn add(&mut self, round: &[Vote], rays: u32) {
        if self.list.is_empty() && self.rays == 0 {
            self.list = Arc::new(round.to_vec());
            self.rays = rays;
            return;
        }
        let list = Arc::make_mut(&mut self.list);
        for vote in round {
            match list.binary_search_by_key(&vote.refractor, |v| v.refractor) {
                Ok(at) => {
                    list[at].inside += vote.inside;
                    list[at].asked += vote.asked;
                }
                // All earlier rays voted about a closed refractor too: outside.
                Err(at) => list
                    .insert(at, Vote { asked: vote.asked + if vote.asked == rays { self.rays } else { 0 }, ..*vote }),
            }
        }
        // A refractor that no ray of this round found inside gets all votes of the round against it.
        for known in list {
            let is_found = round.binary_search_by_key(&known.refractor, |vote| vote.refractor).is_ok();
            if !is_found && known.asked == self.rays {
                known.asked += rays;
            }
        }
        self.rays += rays;
    }
}
