//! The pre-trace: rays outward from each refractor. The first dielectric whose *first hit is from behind* contains the surface and is
//! its exterior; several rays vote, against rare misses.

use std::time::Instant;

use rayon::prelude::*;

use super::containment::medium_of;
use super::random::Random;
use super::table::{InterfaceTable, Patch, RectifySeconds};
use crate::geometry::{Ray, uniform_direction};
use crate::scene::World;
use crate::scene::world::{MediumId, ObjectId, Surface};

/// Rays for each refractor in each pre-trace.
const RAYS: u32 = 16;
/// Rays at the most, where those disagree.
const MOST_RAYS: u32 = 256;

/// Votes for each container, `None` being the global medium.
type Votes = Vec<(Option<ObjectId>, u32)>;

/// Rectifies `world`. Votes of `previous`, a table of the same geometry, count on: the new rays have fresh directions.
pub fn rectify(world: &World, previous: Option<&InterfaceTable>) -> InterfaceTable {
    let start = Instant::now();
    let refractors: Vec<(ObjectId, MediumId)> = world.refractors().collect();
    let votes: Vec<Votes> = refractors
        .par_iter()
        .enumerate()
        .map(|(index, &(refractor, _))| {
            let earlier = previous.and_then(|table| table.patches.get(index)).map(|patch| patch.votes.clone());
            vote(world, refractor, earlier.unwrap_or_default())
        })
        .collect();
    let pretrace = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let mut table = InterfaceTable { patch_of_object: vec![u32::MAX; world.objects.len()], ..Default::default() };
    for (&(refractor, medium), votes) in refractors.iter().zip(votes) {
        table.patch_of_object[refractor.0 as usize] = table.patches.len() as u32;
        table.patches.push(resolve(world, refractor, medium, votes));
    }
    table.seconds = RectifySeconds { pretrace, resolve: start.elapsed().as_secs_f64(), ..Default::default() };
    table
}

/// Adds this pre-trace's votes to `votes`, most first.
fn vote(world: &World, refractor: ObjectId, mut votes: Votes) -> Votes {
    // With nothing that could contain anything, the answer is known.
    if !world.needs.nesting {
        return votes;
    }
    let earlier: u32 = votes.iter().map(|(_, count)| count).sum();
    let mut random = Random::new((u64::from(refractor.0) << 32) | u64::from(earlier));
    let mut rays = 0;
    while rays < RAYS || (votes.len() > 1 && rays < MOST_RAYS) {
        let u = [random.next(), random.next(), random.next()];
        let Some(point) = world.geometry.sample_surface(refractor.0, u) else { break };
        let mut direction = uniform_direction([random.next(), random.next()]);
        if direction.dot(point.normal) < 0.0 {
            direction = -direction;
        }
        let container = container_along(world, Ray::leaving(point.position, direction, point.primitive), refractor);
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
fn container_along(world: &World, mut ray: Ray, own: ObjectId) -> Option<ObjectId> {
    let mut met_from_outside: Vec<ObjectId> = Vec::new();
    while let Some(hit) = world.geometry.closest(&ray) {
        let object = ObjectId(world.geometry.object_of(hit.primitive));
        let is_candidate = object != own && matches!(world.object(object).surface, Surface::Refractor { .. });
        if is_candidate && !met_from_outside.contains(&object) {
            if !hit.is_front {
                return Some(object);
            }
            met_from_outside.push(object);
        }
        ray = ray.beyond(&hit);
    }
    None
}

/// From votes to media.
fn resolve(world: &World, refractor: ObjectId, inside: MediumId, votes: Votes) -> Patch {
    let rays: u32 = votes.iter().map(|(_, count)| count).sum();
    let (container, agreeing) = votes.first().copied().unwrap_or((None, 0));
    Patch {
        refractor,
        index: 0,
        faces: world.geometry.face_count(refractor.0),
        area: world.geometry.area(refractor.0),
        outside: medium_of(world, container),
        inside,
        outside_refractor: container,
        rays,
        confidence: if rays == 0 { 1.0 } else { f64::from(agreeing) / f64::from(rays) },
        votes,
    }
}
