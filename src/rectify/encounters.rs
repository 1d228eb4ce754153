//! Which refractors meet: volumes that overlap in part, and surfaces that coincide.

use super::copies::have_same_surface;
use super::layout::Layout;
use super::site::SiteVotes;
use super::surroundings::Surroundings;
use crate::scene::{ObjectId, Scene};

/// How two refractors meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Meeting {
    /// A part of one's surface lies inside the other, and another part does not.
    Overlap,
    /// A part of their surfaces coincides.
    Touch,
    /// They have the same surface, looking the same way.
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
pub(super) fn encounters(scene: &Scene, layout: &Layout, votes: &[SiteVotes]) -> Vec<Encounter> {
    let mut of_cells: Vec<&Surroundings> =
        layout.surroundings.iter().filter(|s| scene.is_refractor(s.subject)).collect();
    of_cells.sort_unstable_by_key(|s| (s.subject, &s.outer, &s.inner, s.is_masked));

    let mut found = Vec::new();
    let mut tally = Tally::new(scene.objects.len());
    let mut cells = of_cells.chunk_by(|x, y| x.subject == y.subject).peekable();
    let mut first_site = 0;
    for (subject, _) in scene.refractors() {
        let sites = first_site..first_site + layout.sites[first_site..].partition_point(|s| s.subject <= subject);
        first_site = sites.end;
        let cells = cells.next_if(|cells| cells[0].subject == subject).unwrap_or_default();
        // One patch without contacts: it meets nothing.
        if cells.is_empty() && sites.len() == 1 && layout.sites[sites.start].settled.is_empty() {
            continue;
        }
        sites.for_each(|site| tally.add(&votes[site].surroundings(&layout.sites[site])));
        cells.iter().for_each(|surroundings| tally.add(surroundings));
        tally.drain(|other, seen| {
            if other == subject {
                return;
            }
            let (a, b) = (subject.min(other), subject.max(other));
            if seen.inside && seen.outside {
                found.push(Encounter { a, b, meeting: Meeting::Overlap });
            }
            // Masked pieces do not tell what they lie in, so the surfaces themselves are compared.
            let may_be_copy = seen.same && !seen.inside && !seen.outside && !seen.opposed;
            if may_be_copy && have_same_surface(scene, a, b) {
                found.push(Encounter { a, b, meeting: Meeting::Copy });
            } else if seen.same || seen.opposed {
                found.push(Encounter { a, b, meeting: Meeting::Touch });
            }
        });
    }
    // A crossing may be smaller than any cell.
    found.extend(layout.crossing.iter().map(|&(a, b)| Encounter { a, b, meeting: Meeting::Overlap }));
    found.sort_unstable();
    found.dedup();
    found
}

/// What the pieces of one refractor's surface say about the others.
struct Tally {
    /// Of every object, with the number of telling pieces that name it.
    seen: Vec<(Seen, usize)>,
    /// The objects that some piece names.
    named: Vec<ObjectId>,
    /// Number of pieces that are not masked. Such a piece lies outside every refractor that it names on neither side; a masked piece tells
    /// nothing about what it does not name.
    telling: usize,
}

impl Tally {
    fn new(objects: usize) -> Self {
        Self { seen: vec![(Seen::default(), 0); objects], named: Vec::new(), telling: 0 }
    }

    fn add(&mut self, piece: &Surroundings) {
        self.telling += usize::from(!piece.is_masked);
        for &other in &piece.outer {
            let is_inside = piece.inner.binary_search(&other).is_ok();
            let seen = self.name(other, piece.is_masked);
            *(if is_inside { &mut seen.inside } else { &mut seen.opposed }) = true;
        }
        for &other in piece.inner.iter().filter(|other| piece.outer.binary_search(other).is_err()) {
            self.name(other, piece.is_masked).same = true;
        }
    }

    fn name(&mut self, other: ObjectId, is_masked: bool) -> &mut Seen {
        let (seen, count) = &mut self.seen[other.0 as usize];
        if !(seen.inside || seen.same || seen.opposed) {
            self.named.push(other);
        }
        *count += usize::from(!is_masked);
        seen
    }

    /// Hands over what has been seen, in the order of objects, and starts anew.
    fn drain(&mut self, mut visit: impl FnMut(ObjectId, Seen)) {
        self.named.sort_unstable();
        for other in self.named.drain(..) {
            let (mut seen, count) = std::mem::take(&mut self.seen[other.0 as usize]);
            seen.outside = count < self.telling;
            visit(other, seen);
        }
        self.telling = 0;
    }
}
