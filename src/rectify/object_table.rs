//! One exterior for each object: the source's method, kept to be compared with. Rays go outward from area-weighted points; the first
//! dielectric whose *first hit is from behind* contains the object and is its exterior; several rays vote, against rare misses.

use std::collections::HashSet;

use rayon::prelude::*;

use super::containment::{medium_of, outward_ray};
use super::random::Random;
use crate::geometry::{Hit, Ray};
use crate::scene::{MediumId, ObjectId, Scene};

/// Rays for each refractor.
const RAYS: u32 = 16;
/// Rays at the most, where those disagree.
const MOST_RAYS: u32 = 256;

/// The answer for one refractor.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectAnswer {
    pub refractor: ObjectId,
    /// Votes for each container, `None` being the global medium, most first.
    pub votes: Vec<(Option<ObjectId>, u32)>,
}

impl ObjectAnswer {
    /// The container that was found; `None` is the global medium.
    pub fn outside_refractor(&self) -> Option<ObjectId> {
        self.votes.first().and_then(|(container, _)| *container)
    }

    pub fn rays(&self) -> u32 {
        self.votes.iter().map(|(_, count)| count).sum()
    }

    /// Share of the votes that the answer got, in [0, 1]; 1 where none were needed.
    pub fn confidence(&self) -> f64 {
        self.votes.first().map_or(1.0, |(_, agreeing)| f64::from(*agreeing) / f64::from(self.rays()))
    }
}

/// One answer for each refractor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObjectTable {
    /// In the order of object ids, with which refractors begin.
    pub answers: Vec<ObjectAnswer>,
}

impl ObjectTable {
    /// Asks about every refractor.
    pub fn new(scene: &Scene) -> Self {
        let refractors: Vec<ObjectId> = scene.refractors().map(|(id, _)| id).collect();
        let vote = |refractor: ObjectId| ObjectAnswer { refractor, votes: vote(scene, refractor) };
        Self { answers: refractors.into_par_iter().map(vote).collect() }
    }

    /// The medium outside each refractor, by object id.
    pub fn outsides(&self, scene: &Scene) -> Vec<MediumId> {
        self.answers.iter().map(|answer| medium_of(scene, answer.outside_refractor())).collect()
    }
}

fn vote(scene: &Scene, refractor: ObjectId) -> Vec<(Option<ObjectId>, u32)> {
    let mut votes: Vec<(Option<ObjectId>, u32)> = Vec::new();
    // No refractor of this scene can contain anything.
    if !scene.needs.nesting {
        return votes;
    }
    let mut random = Random::new(u64::from(refractor.0) << 32);
    let mut rays = 0;
    while rays < RAYS || (votes.len() > 1 && rays < MOST_RAYS) {
        let u = [random.next(), random.next(), random.next()];
        let Some(point) = scene.geometry.sample_surface(refractor.0, u) else { break };
        let container = container_along(scene, outward_ray(&point, &mut random), refractor);
        match votes.iter_mut().find(|(candidate, _)| *candidate == container) {
            Some((_, count)) => *count += 1,
            None => votes.push((container, 1)),
        }
        rays += 1;
    }
    // Ties go to the earlier object, so that the answer does not depend on the order of rays.
    votes.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    votes
}

/// The first refractor along `ray` whose first hit is from behind. Opaque objects are looked through, and `own` never counts.
pub(super) fn container_along(scene: &Scene, mut ray: Ray, own: ObjectId) -> Option<ObjectId> {
    /// Hits that are searched for one by one: most containers are among them. All hits beyond are gathered in one walk.
    const NEAR: u32 = 8;
    let mut met_from_outside: HashSet<ObjectId> = HashSet::new();
    let mut is_container = |hit: &Hit| {
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        let counts = object != own && scene.is_refractor(object) && !met_from_outside.contains(&object);
        if counts && hit.is_front {
            met_from_outside.insert(object);
        }
        (counts && !hit.is_front).then_some(object)
    };
    for _ in 0..NEAR {
        let hit = scene.geometry.closest(&ray)?;
        if let Some(container) = is_container(&hit) {
            return Some(container);
        }
        ray = ray.beyond(&hit);
    }
    scene.geometry.all_hits(&ray).iter().find_map(is_container)
}
