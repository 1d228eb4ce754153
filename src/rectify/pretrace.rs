//! The pre-trace: irregular rays outward from area-weighted points of a patch. Each ray says for every refractor, by its *first* hit, whether
//! the patch lies inside it; votes are counted member by member, and where they disagree more rays are shot.

use std::sync::Arc;

use rayon::prelude::*;

use super::contact::is_refractor;
use super::containment::{Poll, Vote, is_at_start, outward_ray, winding_beside, with_poll};
use super::layout::{Layout, Site};
use super::nest::{self, Nest};
use super::progress::{Cancelled, Progress, Stage};
use super::random::Random;
use super::surroundings::{State, Surroundings};
use crate::geometry::Ray;
use crate::scene::{ObjectId, Scene};

/// Rays for each site in each pre-trace.
const RAYS: u32 = 16;
/// Rays at the most, where those disagree.
const MOST_RAYS: u32 = 256;
/// Rays for each site at the least.
const FEWEST_RAYS: u32 = 3;
/// Hits of all rays of a site beyond which no more rays are shot than the fewest: where each meets thousands of surfaces, a few are as many questions.
const MOST_HITS: usize = 1 << 15;
/// The same where rays disagree.
const MOST_HITS_TO_AGREE: usize = 1 << 18;

/// The votes about one site, over all pre-traces of its geometry.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SiteVotes {
    pub rays: u32,
    /// About every refractor that some ray found to contain the site, in ascending order. Shared: of deep nests it is long.
    pub list: Arc<Vec<Vote>>,
    /// The innermost container, where that is enough to know: what contains it contains the site too, and is not listed.
    pub within: Option<ObjectId>,
}

impl SiteVotes {
    /// What the majorities say, next to what is fixed; of a site with an innermost container nothing beyond that one.
    pub fn surroundings(&self, site: &Site) -> Surroundings {
        self.surroundings_but_for(site, None)
    }

    /// The same with the answer about one refractor reversed.
    pub fn surroundings_but_for(&self, site: &Site, reversed: Option<ObjectId>) -> Surroundings {
        let mut surroundings = site.fixed.clone();
        for vote in &*self.list {
            if !site.settled.contains(&vote.refractor) && vote.is_inside() != (reversed == Some(vote.refractor)) {
                surroundings.add(vote.refractor, State::In);
            }
        }
        surroundings
    }

    /// Adds the votes of another round, in ascending order of refractors.
    fn add(&mut self, round: &[Vote], rays: u32) {
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
                // Closed refractors were asked before too, and none of those rays was inside.
                Err(at) => list
                    .insert(at, Vote { asked: vote.asked + if vote.asked == rays { self.rays } else { 0 }, ..*vote }),
            }
        }
        // A member that no ray of this round found has as many votes against it.
        for known in list {
            let is_found = round.binary_search_by_key(&known.refractor, |vote| vote.refractor).is_ok();
            if !is_found && known.asked == self.rays {
                known.asked += rays;
            }
        }
        self.rays += rays;
    }
}

/// Another pre-trace of all sites, with fresh directions; its votes are added to `votes`.
///
/// # Errors
/// When `progress` is cancelled.
pub fn repeat(
    scene: &Scene,
    layout: &Layout,
    votes: &[SiteVotes],
    progress: &Progress,
) -> Result<Vec<SiteVotes>, Cancelled> {
    let nest = Nest::of_layout(scene, layout);
    progress.enter(Stage::Votes, layout.sites.len())?;
    (layout.sites.par_iter().zip(votes))
        .map(|(site, votes)| {
            progress.go_on()?;
            Ok(vote(scene, site, &nest, votes.clone()))
        })
        .collect()
}

/// Adds a pre-trace of one site to its votes.
pub fn vote(scene: &Scene, site: &Site, nest: &Nest, mut votes: SiteVotes) -> SiteVotes {
    // With nothing that could contain anything, the answer is known.
    if !scene.needs.nesting || site.fixed.is_masked {
        return votes;
    }
    let asks_itself = is_refractor(scene, site.subject) && scene.object(site.subject).may_contain_itself();
    // Sites of one object have first faces of their own.
    let first = match &site.faces {
        super::layout::Faces::Whole => 0,
        super::layout::Faces::Some { faces, .. } => faces.first().copied().unwrap_or(0),
    };
    let seed = (u64::from(site.subject.0) << 32) ^ (u64::from(first) << 12) ^ (u64::from(votes.rays) << 44);
    let mut random = Random::new(seed);
    if votes.rays == 0 || votes.within.is_some() {
        match nest.container(scene, site, &mut random) {
            Some(within) if votes.rays == 0 || within == votes.within => {
                let about = within.map(|refractor| Vote { refractor, inside: nest::RAYS, asked: nest::RAYS });
                votes.add(about.as_slice(), nest::RAYS);
                return SiteVotes { within, ..votes };
            }
            // Asked about everything.
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
            let is_ignored = |hit: &crate::geometry::Hit| !site.settled.is_empty() && is_at_start(scene, &point, hit);
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
