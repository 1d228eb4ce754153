//! Where the paths of two modes part, and why.
//!
//! Both modes follow the same ray with the same random numbers, so their paths are the same up to the first interface for which they take
//! different media. There [`parting`] says what each takes, what really is on both sides (mode `reference`'s answer), and which fact of the scene
//! misled a mode that is wrong: see [`Cause`].
//!
//! ```no_run
//! # fn f(prepared: &iorect::tracking::Prepared, ray: iorect::geometry::Ray) {
//! use iorect::tracking::Mode;
//! use iorect::transport::{inspect::Follow, parting::compare};
//!
//! let compared = compare(prepared, [Mode::Stack, Mode::Reference], ray, Follow::Transmit, 0, Some(50));
//! match compared.parting {
//!     // "stack took the world (IOR 1) outside ball; it is water (IOR 1.333). The path starts inside pool water, which stack does not know."
//!     Some(parting) => println!("{}", parting.sentence()),
//!     None => println!("the two agree about {} surfaces", compared.path.vertices.len()),
//! }
//! # }
//! ```

mod cause;
#[cfg(test)]
mod tests;
mod words;

pub use cause::Cause;

use super::inspect::{Follow, PathStart, TracedPath, Vertex, VertexEvent, trace};
use crate::rectify::containment::medium_of;
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::reference::{Reference, Surroundings};
use crate::tracking::{Mode, Prepared, Sides, TrackingMode};

/// Surfaces nearer to each other than this share of their size are one place.
const SAME_PLACE: f64 = 1e-6;

/// The first interface for which two modes take different media.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Parting {
    /// Index of the vertex in both paths.
    pub vertex: usize,
    /// Scene coordinates.
    pub position: [f64; 3],
    /// Name of the refractor.
    pub refractor: String,
    #[serde(skip)]
    pub object: ObjectId,
    /// Whether the paths come from outside of it.
    pub is_entering: bool,
    /// What each of the two takes.
    pub claims: [Claim; 2],
    /// What is there: mode `reference`'s answer.
    pub truth: Claim,
    /// Of each of the two what is wrong and why; `None` where it is right.
    pub faults: [Option<Fault>; 2],
}

/// Media on both sides of an interface, seen along the path. All `None` where a mode sees no interface.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Claim {
    pub mode: Mode,
    pub from: Option<String>,
    pub to: Option<String>,
    pub ior_from: Option<f64>,
    pub ior_to: Option<f64>,
    #[serde(skip)]
    pub sides: Option<Sides>,
}

/// A medium in words and numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MediumWord {
    pub name: String,
    pub ior: f64,
}

/// What a mode takes for true and is not.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mistake {
    /// Another medium outside of the surface.
    Outside { took: MediumWord, is: MediumWord },
    /// Another medium inside of it.
    Inside { took: MediumWord, is: MediumWord },
    /// No interface, where there is one.
    Missed { from: MediumWord, to: MediumWord },
    /// Another medium before the surface, which the path was in since it started.
    Before { took: MediumWord, is: MediumWord },
    /// An interface, where one medium is on both sides.
    Invented { from: MediumWord, to: MediumWord, is: MediumWord },
}

/// A mode's mistake at a place, and where it comes from.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Fault {
    pub mode: Mode,
    /// Name of the refractor.
    pub surface: String,
    pub mistake: Mistake,
    pub cause: Cause,
}

/// The paths of one ray in two modes.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Compared {
    #[serde(flatten)]
    pub path: TracedPath,
    /// The second mode's.
    pub against: TracedPath,
    /// `None` where the two are the same.
    pub parting: Option<Parting>,
}

/// Follows a path in two modes, and finds where they part. Parameters as of [`trace`].
pub fn compare(
    prepared: &Prepared,
    modes: [Mode; 2],
    start: impl Into<PathStart>,
    follow: Follow,
    seed: u64,
    max_depth: Option<u32>,
) -> Compared {
    let start = start.into();
    let [path, against] = modes.map(|mode| trace(prepared, mode, start, follow, seed, max_depth));
    let parting = parting(prepared, [&path, &against]);
    Compared { path, against, parting }
}

/// Where two paths of the same ray, with the same random numbers, part. `None` where the modes agree on all that light can tell: media of the
/// same IOR and absorption are one. The first call for a scene prepares mode `reference`, which is asked about that one place and the surfaces
/// before it.
pub fn parting(prepared: &Prepared, paths: [&TracedPath; 2]) -> Option<Parting> {
    let scene = &*prepared.scene;
    let (place, vertex) = first_difference(scene, paths)?;
    let reference = Reference::of(prepared);
    // At a place where surfaces coincide one mode may have turned back at the first.
    let longest = usize::from(place[1].end > place[0].end);
    let truth = Truth::of(&reference, &paths[longest].vertices[place[longest].clone()])?;
    let at = paths.map(|path| path.vertices.get(vertex));
    let met = at.into_iter().flatten().find(|vertex| vertex.ids.crossing.is_some())?;
    let crossing = met.ids.crossing?;
    let claim = |mode: Mode, sides: Option<Sides>| Claim::new(scene, mode, sides.filter(|s| !is_null(scene, *s)));
    let faults = [0, 1].map(|k| {
        let group = &paths[k].vertices[place[k].clone()];
        let after = medium_after(paths[k], place[k].end);
        let before = medium_after(paths[k], place[k].start);
        let has_strayed = paths[k].mode == Mode::Declared && !absorbs_alike(scene, before, truth.sides.from);
        let surface = scene.object(crossing.refractor).name.clone();
        match truth.is_told_by(scene, group, after) {
            true if has_strayed => {
                let [took, is] = [before, truth.sides.from].map(|medium| MediumWord::new(scene, medium));
                let cause = Cause::WrongStart { declared: took.name.clone() };
                return Some(Fault { mode: paths[k].mode, surface, mistake: Mistake::Before { took, is }, cause });
            }
            true => return None,
            false => {}
        }
        let own = at[k].filter(|vertex| vertex.ids.primitive == met.ids.primitive).and_then(|vertex| vertex.ids.sides);
        let mistake = truth.mistake(scene, own, crossing.is_entering, after);
        let cause = cause::cause(prepared, &reference, paths[k], vertex, &place[k], &truth);
        Some(Fault { mode: paths[k].mode, surface, mistake, cause })
    });
    let claims = [0, 1].map(|k| claim(paths[k].mode, at[k].and_then(|vertex| vertex.ids.sides)));
    Some(Parting {
        vertex,
        position: met.position,
        refractor: scene.object(crossing.refractor).name.clone(),
        object: crossing.refractor,
        is_entering: crossing.is_entering,
        claims,
        truth: claim(Mode::Reference, Some(truth.sides)),
        faults,
    })
}

/// The vertices of both paths at the first place where they take different media, and the first of them that differs.
fn first_difference(scene: &Scene, paths: [&TracedPath; 2]) -> Option<([std::ops::Range<usize>; 2], usize)> {
    let mut start = [0, 0];
    // Mode `declared` takes the index on both sides of a surface from the surface: of the medium between, light notices what it absorbs.
    let is_declared = paths.iter().any(|path| path.mode == Mode::Declared);
    let is_same_medium = |a, b| if is_declared { absorbs_alike(scene, a, b) } else { is_alike(scene, a, b) };
    loop {
        let groups = [0, 1].map(|k| start[k]..end_of_place(scene, &paths[k].vertices, start[k]));
        if groups.iter().any(std::ops::Range::is_empty) {
            return None;
        }
        let claims = [0, 1].map(|k| claims_in(scene, &paths[k].vertices[groups[k].clone()]));
        let [before, after] =
            [start, [groups[0].end, groups[1].end]].map(|at| [0, 1].map(|k| medium_after(paths[k], at[k])));
        let is_same = claims[0].len() == claims[1].len()
            && claims[0].iter().zip(&claims[1]).all(|(a, b)| are_alike(scene, *a, *b))
            && [before, after].iter().all(|[a, b]| is_same_medium(*a, *b));
        if !is_same {
            // Up to here both have met the same surfaces.
            let first = start[0].min(start[1]);
            let end = groups[0].end.min(groups[1].end);
            let differs = |index: &usize| {
                let [a, b] = paths.map(|path| &path.vertices[*index]);
                a.ids.primitive != b.ids.primitive || !claims_alike(scene, a.ids.sides, b.ids.sides)
            };
            return Some((groups, (first..end).find(differs).unwrap_or(first)));
        }
        start = [groups[0].end, groups[1].end];
    }
}

/// End of the run of vertices, from `start` on, that are at one place: surfaces that coincide are met one after the other.
fn end_of_place(scene: &Scene, vertices: &[Vertex], start: usize) -> usize {
    let is_same_place = |vertex: &Vertex| {
        let is_refractor = vertex.refractor.is_some();
        is_refractor && vertex.distance <= SAME_PLACE * scene.geometry.radius_of(vertex.ids.object.0)
    };
    let Some(rest) = vertices.get(start + 1..) else { return vertices.len() };
    start + 1 + rest.iter().take_while(|vertex| is_same_place(vertex)).count()
}

/// What is taken at these vertices, but for what light does not notice.
fn claims_in(scene: &Scene, group: &[Vertex]) -> Vec<Sides> {
    group.iter().filter_map(|vertex| vertex.ids.sides).filter(|sides| !is_null(scene, *sides)).collect()
}

/// The medium that a path takes itself to be in before its vertex `index`.
fn medium_after(path: &TracedPath, index: usize) -> MediumId {
    path.vertices.get(index).map_or(path.final_medium_id, |vertex| vertex.ids.medium)
}

/// Whether light loses as much in one medium as in another.
fn absorbs_alike(scene: &Scene, a: MediumId, b: MediumId) -> bool {
    scene.medium(a).absorption == scene.medium(b).absorption
}

/// Whether light does not tell two media from each other.
fn is_alike(scene: &Scene, a: MediumId, b: MediumId) -> bool {
    let [x, y] = [a, b].map(|id| scene.medium(id));
    a == b || (x.ior_minus_one == y.ior_minus_one && x.absorption == y.absorption && x.model == y.model)
}

fn are_alike(scene: &Scene, a: Sides, b: Sides) -> bool {
    is_alike(scene, a.from, b.from) && is_alike(scene, a.to, b.to)
}

fn is_null(scene: &Scene, sides: Sides) -> bool {
    is_alike(scene, sides.from, sides.to)
}

fn claims_alike(scene: &Scene, a: Option<Sides>, b: Option<Sides>) -> bool {
    let [a, b] = [a, b].map(|sides| sides.filter(|sides| !is_null(scene, *sides)));
    match (a, b) {
        (Some(a), Some(b)) => are_alike(scene, a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// What really lies around a place, seen along the path.
struct Truth {
    sides: Sides,
    /// Around the first surface that is met there.
    first: Surroundings,
}

impl Truth {
    /// Around the surfaces that these vertices, all at one place, have met.
    fn of(reference: &Reference<'_>, group: &[Vertex]) -> Option<Self> {
        let mut crossings = group.iter().filter_map(|vertex| vertex.ids.crossing);
        let first_crossing = crossings.next()?;
        let last_crossing = crossings.next_back().unwrap_or(first_crossing);
        let first = reference.surroundings(&first_crossing.point);
        let last = reference.surroundings(&last_crossing.point);
        let medium = |side: &[ObjectId]| medium_of(reference.scene, side.first().copied());
        let from = medium(if first_crossing.is_entering { &first.outside } else { &first.inside });
        let to = medium(if last_crossing.is_entering { &last.inside } else { &last.outside });
        Some(Self { sides: Sides { from, to }, first })
    }

    /// Whether a mode takes what is true at these vertices, and `after` for the medium behind them.
    fn is_told_by(&self, scene: &Scene, group: &[Vertex], after: MediumId) -> bool {
        let claims = claims_in(scene, group);
        let turned_back = group.iter().any(|v| matches!(v.event, VertexEvent::Reflect | VertexEvent::TotalReflection));
        match &claims[..] {
            [] => is_null(scene, self.sides) && is_alike(scene, after, self.sides.to),
            [only] => are_alike(scene, *only, self.sides),
            // Two surfaces at one place that give the truth together.
            [first, .., last] => {
                let is_whole =
                    is_alike(scene, first.to, last.from) && !turned_back && is_alike(scene, first.to, last.to);
                is_whole && are_alike(scene, Sides { from: first.from, to: last.to }, self.sides)
            }
        }
    }

    /// In what `claim` differs from the truth, or `after`, if what is seen is right.
    fn mistake(&self, scene: &Scene, claim: Option<Sides>, is_entering: bool, after: MediumId) -> Mistake {
        let word = |id: MediumId| MediumWord::new(scene, id);
        let Sides { from, to } = self.sides;
        let claim = claim.filter(|claim| !is_null(scene, *claim));
        match claim {
            None if is_null(scene, self.sides) => Mistake::Outside { took: word(after), is: word(to) },
            None => Mistake::Missed { from: word(from), to: word(to) },
            Some(claim) if is_null(scene, self.sides) => {
                Mistake::Invented { from: word(claim.from), to: word(claim.to), is: word(to) }
            }
            Some(claim) => {
                let before = (claim.from, from);
                let behind = (claim.to, to);
                let (outside, inside) = if is_entering { (before, behind) } else { (behind, before) };
                if is_alike(scene, outside.0, outside.1) {
                    Mistake::Inside { took: word(inside.0), is: word(inside.1) }
                } else {
                    Mistake::Outside { took: word(outside.0), is: word(outside.1) }
                }
            }
        }
    }
}

impl Claim {
    fn new(scene: &Scene, mode: Mode, sides: Option<Sides>) -> Self {
        let word = |id: Option<MediumId>| id.map(|id| MediumWord::new(scene, id));
        let (from, to) = (word(sides.map(|sides| sides.from)), word(sides.map(|sides| sides.to)));
        let (ior_from, ior_to) = (from.as_ref().map(|word| word.ior), to.as_ref().map(|word| word.ior));
        Self { mode, from: from.map(|word| word.name), to: to.map(|word| word.name), ior_from, ior_to, sides }
    }
}

impl MediumWord {
    fn new(scene: &Scene, id: MediumId) -> Self {
        let medium = scene.medium(id);
        Self { name: medium.name.clone(), ior: medium.ior() }
    }
}
