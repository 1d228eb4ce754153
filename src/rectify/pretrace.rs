//! The pre-trace: irregular rays outward from area-weighted points of a patch. Each ray says for every refractor, by its *first* hit, whether
//! the patch lies inside it; votes are counted member by member, and where they disagree more rays are shot.

use rayon::prelude::*;

use super::containment::{Poll, Vote, is_at_start, outward_ray, winding_beside, with_poll};
use super::nest::{self, Nest};
use super::progress::{Cancelled, Progress, Stage};
use super::random::Random;
use super::site::{Site, SiteVotes};
use crate::geometry::{Hit, Ray};
use crate::scene::Scene;

/// Rays for each site in each pre-trace.
const RAYS: u32 = 16;
/// Rays at the most, where those disagree.
const MOST_RAYS: u32 = 256;
/// Rays for each site at the least.
const FEWEST_RAYS: u32 = 3;
/// Once the rays of a site have this many hits together, the fewest rays are enough: each then asks about thousands of surfaces.
const MOST_HITS: usize = 1 << 15;
/// The same where rays disagree.
const MOST_HITS_TO_AGREE: usize = 1 << 18;

/// Another pre-trace of all sites, with fresh directions; its votes are added to `votes`.
///
/// # Errors
/// When `progress` is cancelled.
pub fn repeat(
    scene: &Scene,
    sites: &[Site],
    votes: &[SiteVotes],
    progress: &Progress,
) -> Result<Vec<SiteVotes>, Cancelled> {
    let nest = Nest::of_sites(scene, sites);
    progress.enter(Stage::Votes, sites.len())?;
    (sites.par_iter().zip(votes))
        .map(|(site, votes)| {
            progress.go_on()?;
            Ok(vote(scene, site, &nest, votes.clone()))
        })
        .collect()
}

/// Adds a pre-trace of one site to its votes.
pub fn vote(scene: &Scene, site: &Site, nest: &Nest, mut votes: SiteVotes) -> SiteVotes {
    // No refractor of this scene can contain anything.
    if !scene.needs.nesting || site.fixed.is_masked {
        return votes;
    }
    let asks_itself = scene.is_refractor(site.subject) && scene.object(site.subject).may_contain_itself();
    let seed = (u64::from(site.subject.0) << 32) ^ (u64::from(site.first_face()) << 12) ^ (u64::from(votes.rays) << 44);
    let mut random = Random::new(seed);
    if votes.rays == 0 || votes.within.is_some() {
        match nest.container(scene, site, &mut random) {
            Some(within) if votes.rays == 0 || within == votes.within => {
                let about = within.map(|refractor| Vote { refractor, inside: nest::RAYS, asked: nest::RAYS });
                votes.add(about.as_slice(), nest::RAYS);
                return SiteVotes { within, ..votes };
            }
            // Containers cannot be inherited, or the innermost one is another than before: ask about every refractor.
            _ => votes = SiteVotes::default(),
        }
    }
    let mut holed: Vec<Vote> = scene.holed.iter().map(|&refractor| Vote { refractor, inside: 0, asked: 0 }).collect();
    let mut rays = 0;
    let mut round = with_poll(scene, |poll| {
        let is_enough = |rays: u32, poll: &Poll| {
            rays >= FEWEST_RAYS
                && (rays >= RAYS || poll.hits() >= MOST_HITS)
                && (rays >= MOST_RAYS || poll.hits() >= MOST_HITS_TO_AGREE || poll.is_unanimous(scene))
        };
        while !is_enough(rays, poll) {
            let u = [random.next(), random.next(), random.next()];
            let Some(point) = site.sample(&scene.geometry, u) else { break };
            let ray = outward_ray(&point, &mut random);
            // Only settled refractors can coincide with the site.
            let is_ignored = |hit: &Hit| !site.settled.is_empty() && is_at_start(scene, &point, hit);
            poll.ask(scene, &ray, is_ignored);
            if scene.has_sheets {
                poll.ask_sheets(scene, &Ray { direction: -ray.direction, ..ray }, is_ignored);
            }
            for vote in &mut holed {
                vote.inside += u32::from(winding_beside(scene, vote.refractor, &point) > 0.5);
                vote.asked += 1;
            }
            rays += 1;
        }
        poll.votes(scene)
    });
    round.extend(holed.into_iter().filter(|vote| vote.inside > 0));
    round.retain(|vote| vote.refractor != site.subject || asks_itself);
    round.sort_unstable_by_key(|vote| vote.refractor);
    votes.add(&round, rays);
    votes
}
