//! Which refractors meet: volumes that overlap in part, and surfaces that coincide.

use std::collections::BTreeMap;

use super::layout::{Layout, Site};
use super::pretrace::SiteVotes;
use super::surroundings::Surroundings;
use crate::rectify::cells::Node;
use crate::rectify::contact::is_refractor;
use crate::scene::World;
use crate::scene::world::ObjectId;

/// How two refractors meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Meeting {
    /// A part of one's surface lies inside the other, and another part does not.
    Overlap,
    /// A part of their surfaces coincides.
    Touch,
    /// The whole surface of one coincides with the other's, looking the same way.
    Copy,
}

/// Two refractors that meet, `a` before `b`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Encounter {
    pub a: ObjectId,
    pub b: ObjectId,
    pub meeting: Meeting,
}

/// What is known of one refractor along another's surface.
#[derive(Clone, Copy, Default)]
struct Seen {
    inside: bool,
    outside: bool,
    same: bool,
    opposed: bool,
}

/// All encounters, sorted; each pair once for each way in which it meets.
pub(super) fn encounters(world: &World, layout: &Layout, votes: &[SiteVotes]) -> Vec<Encounter> {
    let mut pieces: Vec<(ObjectId, Surroundings)> = (layout.sites.iter().zip(votes))
        .map(|(site, votes): (&Site, _)| (site.subject, votes.surroundings(site)))
        .filter(|(subject, _)| is_refractor(world, *subject))
        .collect();
    let used = layout.nodes.iter().filter_map(|node| match node {
        Node::Known(answer) => layout.surroundings.get(*answer as usize - layout.sites.len()),
        _ => None,
    });
    let mut of_cells: Vec<&Surroundings> = used.filter(|s| is_refractor(world, s.subject)).collect();
    of_cells.sort_unstable_by_key(|s| (s.subject, &s.outer, &s.inner, s.is_masked));
    of_cells.dedup();
    pieces.extend(of_cells.into_iter().map(|s| (s.subject, s.clone())));
    pieces.sort_by_key(|(subject, _)| *subject);

    let mut found = Vec::new();
    for group in pieces.chunk_by(|x, y| x.0 == y.0) {
        let subject = group[0].0;
        // A masked piece does not say what else is there. Of the others, those that name a refractor on neither side lie outside it.
        let telling = group.iter().filter(|(_, s)| !s.is_masked).count();
        let mut all: BTreeMap<ObjectId, (Seen, usize)> = BTreeMap::new();
        for (_, s) in group {
            for (&other, both) in s.outer.iter().map(|other| (other, s.inner.binary_search(other).is_ok())) {
                let (seen, named) = all.entry(other).or_default();
                *(if both { &mut seen.inside } else { &mut seen.opposed }) = true;
                *named += usize::from(!s.is_masked);
            }
            for other in s.inner.iter().filter(|other| s.outer.binary_search(other).is_err()) {
                let (seen, named) = all.entry(*other).or_default();
                seen.same = true;
                *named += usize::from(!s.is_masked);
            }
        }
        for (other, (mut seen, named)) in all.into_iter().filter(|(other, _)| *other != subject) {
            seen.outside = named < telling;
            let (a, b) = (subject.min(other), subject.max(other));
            if seen.inside && seen.outside {
                found.push(Encounter { a, b, meeting: Meeting::Overlap });
            }
            if seen.same && !seen.inside && !seen.outside && !seen.opposed {
                found.push(Encounter { a, b, meeting: Meeting::Copy });
            } else if seen.same || seen.opposed {
                found.push(Encounter { a, b, meeting: Meeting::Touch });
            }
        }
    }
    // A crossing may be smaller than any cell.
    found.extend(layout.crossing.iter().map(|&(a, b)| Encounter { a, b, meeting: Meeting::Overlap }));
    found.sort_unstable();
    found.dedup();
    found
}
