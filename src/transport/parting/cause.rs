//! Why a mode is wrong at a place. Nothing is guessed from the mode alone: what its path has crossed is played again to the mode with the knowledge
//! that it lacked, and the containers of each place, which mode `reference` finds, are compared with what the mode can hold.

use std::ops::Range;

use super::{Truth, claims_alike};
use crate::geometry::Enclosure;
use crate::rectify::containment::medium_of;
use crate::rectify::face::coincides;
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::reference::{Reference, Surroundings};
use crate::tracking::{Crossing, Events, Mode, Prepared, Sides, Tracker, WithTracker};
use crate::transport::inspect::{TracedPath, VertexEvent};

/// The fact of the scene that misleads a mode.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The path starts inside refractors, and the mode begins every path with the global medium alone. Told to begin inside them, it is
    /// right here.
    StartsInside {
        /// The innermost first.
        within: Vec<String>,
    },
    /// The mode takes vacuum for what is outside of everything.
    VacuumOutside,
    /// The scene declares another medium outside of an object than there is.
    WrongDeclaration { refractor: String, declared: String },
    /// The scene declares the camera, or a light, to be in another medium than it is.
    WrongStart { declared: String },
    /// The mode has one exterior for an object that has several.
    OneAnswerPerObject {
        refractor: String,
        /// Media on its outer side.
        outsides: Vec<String>,
    },
    /// Two volumes overlap and one of them fills what both contain, which the mode does not know.
    Overlap { hidden: String, filler: String },
    /// Two volumes overlap, and their priorities do not say which of them fills what both contain.
    EqualPriorities { a: String, b: String },
    /// Two surfaces are at one place.
    SurfacesCoincide { a: String, b: String },
    /// A refractor's surface has holes or crosses itself.
    OpenSurface { refractor: String },
    /// It is doubtful what contains the place.
    Doubtful,
    /// None of these.
    Unexplained,
}

impl Cause {
    /// The stable word for its kind.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StartsInside { .. } => "starts_inside",
            Self::VacuumOutside => "vacuum_outside",
            Self::WrongDeclaration { .. } => "wrong_declaration",
            Self::WrongStart { .. } => "wrong_start",
            Self::OneAnswerPerObject { .. } => "one_answer_per_object",
            Self::Overlap { .. } => "overlap",
            Self::EqualPriorities { .. } => "equal_priorities",
            Self::SurfacesCoincide { .. } => "surfaces_coincide",
            Self::OpenSurface { .. } => "open_surface",
            Self::Doubtful => "doubtful",
            Self::Unexplained => "unexplained",
        }
    }
}

/// Why `path` is wrong at its vertices `place`, of which `vertex` is the first that tells, and where `truth` is so.
pub(super) fn cause(
    prepared: &Prepared,
    reference: &Reference<'_>,
    path: &TracedPath,
    vertex: usize,
    place: &Range<usize>,
    truth: &Truth,
) -> Cause {
    let inquiry = Inquiry::new(prepared, reference, path, place, truth);
    let found = match path.mode {
        Mode::Naive => inquiry.of_outside(Cause::VacuumOutside),
        Mode::Declared => inquiry.of_outside(inquiry.declaration(vertex)),
        Mode::Stack | Mode::Priority => inquiry.of_lists(path.mode),
        Mode::RectifiedObject => inquiry.of_one_answer(vertex),
        Mode::Rectified => inquiry.coincidence(place.clone()),
        Mode::Reference => None,
    };
    found.unwrap_or_else(|| if inquiry.is_doubtful(vertex) { Cause::Doubtful } else { Cause::Unexplained })
}

struct Inquiry<'a> {
    prepared: &'a Prepared,
    path: &'a TracedPath,
    place: Range<usize>,
    truth: &'a Truth,
    /// What is around each vertex up to the place's last; `None` where it is not on a refractor.
    surroundings: Vec<Option<Surroundings>>,
}

impl<'a> Inquiry<'a> {
    fn new(
        prepared: &'a Prepared,
        reference: &Reference<'_>,
        path: &'a TracedPath,
        place: &Range<usize>,
        truth: &'a Truth,
    ) -> Self {
        // Modes without state look at no earlier place.
        let first = if matches!(path.mode, Mode::Stack | Mode::Priority) { 0 } else { place.start };
        let surroundings = (0..place.end)
            .map(|index| {
                let crossing = path.vertices[index].ids.crossing.filter(|_| index >= first)?;
                Some(reference.surroundings(&crossing.point))
            })
            .collect();
        Self { prepared, path, place: place.clone(), truth, surroundings }
    }

    fn scene(&self) -> &'a Scene {
        &self.prepared.scene
    }

    fn name(&self, object: ObjectId) -> String {
        self.scene().object(object).name.clone()
    }

    /// Crossings of refractors up to the place's last, with what is around them.
    fn crossings(&self) -> impl Iterator<Item = (usize, Crossing, &Surroundings)> {
        let all = self.surroundings.iter().enumerate();
        all.filter_map(|(index, around)| Some((index, self.path.vertices[index].ids.crossing?, around.as_ref()?)))
    }

    fn declaration(&self, vertex: usize) -> Cause {
        let refractor = self.path.vertices[vertex].ids.object;
        let declared = self.scene().declared.outside(refractor).unwrap_or(MediumId::WORLD);
        Cause::WrongDeclaration {
            refractor: self.name(refractor),
            declared: self.scene().medium(declared).name.clone(),
        }
    }

    /// Of a mode that takes what the surface's own object holds for the interior, and is misled about the exterior by `cause`.
    fn of_outside(&self, cause: Cause) -> Option<Cause> {
        match self.overlap(self.place.start) {
            None => Some(cause),
            Some((hidden, filler)) => self
                .coincidence(self.place.clone())
                .or_else(|| Some(Cause::Overlap { hidden: self.name(hidden), filler: self.name(filler) })),
        }
    }

    fn of_one_answer(&self, vertex: usize) -> Option<Cause> {
        if let Some((hidden, filler)) = self.overlap(self.place.start) {
            let overlap = Cause::Overlap { hidden: self.name(hidden), filler: self.name(filler) };
            return self.coincidence(self.place.clone()).or(Some(overlap));
        }
        let refractor = self.path.vertices[vertex].ids.object;
        let mut outsides = Vec::new();
        let medium_name = |id| self.scene().medium(id).name.clone();
        let mut is_mixed = false;
        for patch in self.prepared.table.patches_of(refractor) {
            is_mixed |= !patch.crossed_by.is_empty();
            outsides.extend(patch.outside.map(medium_name));
            for crossing in &patch.crossed_by {
                outsides.push(medium_name(medium_of(self.scene(), Some(*crossing))));
            }
        }
        // What is true here belongs to them, wherever patches say it or not.
        outsides.push(medium_name(medium_of(self.scene(), self.truth.first.outside.first().copied())));
        outsides.sort_unstable();
        outsides.dedup();
        if is_mixed || outsides.len() > 1 {
            return Some(Cause::OneAnswerPerObject { refractor: self.name(refractor), outsides });
        }
        self.coincidence(self.place.clone())
    }

    fn of_lists(&self, mode: Mode) -> Option<Cause> {
        let (_, first, around) = self.crossings().next()?;
        let start = if first.is_entering { &around.outside } else { &around.inside };
        if !start.is_empty() && self.is_right_from(mode, start) {
            return Some(Cause::StartsInside { within: start.iter().map(|object| self.name(*object)).collect() });
        }
        if let Some(cause) = self.coincidence(0..self.place.end) {
            return Some(cause);
        }
        if let Some((hidden, filler)) = self.overlap_before_or_at(mode) {
            let (hidden, filler) = (self.name(hidden), self.name(filler));
            return Some(match mode {
                Mode::Priority => Cause::EqualPriorities { a: hidden, b: filler },
                _ => Cause::Overlap { hidden, filler },
            });
        }
        let is_open = |object: &ObjectId| self.scene().object(*object).enclosure != Enclosure::Closed;
        let mut crossed = self.crossings().map(|(_, crossing, _)| crossing.refractor);
        crossed.find(is_open).map(|refractor| Cause::OpenSurface { refractor: self.name(refractor) })
    }

    /// Whether the mode would tell the truth at the place had its path entered `start` before it began.
    fn is_right_from(&self, mode: Mode, start: &[ObjectId]) -> bool {
        let sides = self.prepared.with_tracker(mode, Replay { inquiry: self, start });
        let sides = sides.into_iter().flatten().filter(|sides| !claims_alike(self.scene(), Some(*sides), None));
        let told: Vec<Sides> = sides.collect();
        match &told[..] {
            [] => claims_alike(self.scene(), Some(self.truth.sides), None),
            [only] => claims_alike(self.scene(), Some(*only), Some(self.truth.sides)),
            _ => false,
        }
    }

    /// Two refractors of which the first has its surface at the vertex `index`, and the second fills the first's inner side there.
    fn overlap(&self, index: usize) -> Option<(ObjectId, ObjectId)> {
        let refractor = self.path.vertices[index].ids.object;
        let filler = *self.surroundings[index].as_ref()?.inside.first()?;
        (filler != refractor).then_some((refractor, filler))
    }

    /// The first overlap on the way that the mode cannot resolve.
    fn overlap_before_or_at(&self, mode: Mode) -> Option<(ObjectId, ObjectId)> {
        let scene = self.scene();
        let is_unresolved =
            |(a, b): &(ObjectId, ObjectId)| mode == Mode::Stack || scene.priority(*a) == scene.priority(*b);
        self.crossings().filter_map(|(index, ..)| self.overlap(index)).find(is_unresolved)
    }

    /// Surfaces of two refractors that coincide where the path meets one of them. It may have missed the other by rounding.
    fn coincidence(&self, vertices: Range<usize>) -> Option<Cause> {
        let scene = self.scene();
        let geometry = &*scene.geometry;
        self.path.vertices.get(vertices)?.iter().filter_map(|vertex| vertex.ids.crossing).find_map(|crossing| {
            let (own, place) = (crossing.point.primitive, crossing.point.position);
            let margin = super::SAME_PLACE * geometry.radius_of(crossing.refractor.0);
            let mut found = None;
            geometry.for_each_near_box(place - margin, place + margin, Some(crossing.refractor.0), |primitive| {
                let other = ObjectId(geometry.object_of(primitive));
                let is_here = || geometry.distance(primitive, place) <= margin;
                let is_other = other != crossing.refractor && scene.is_refractor(other);
                if is_other && is_here() && coincides(geometry, own, primitive).is_some() {
                    found = Some(other);
                }
            });
            found.map(|other| Cause::SurfacesCoincide { a: self.name(crossing.refractor), b: self.name(other) })
        })
    }

    fn is_doubtful(&self, vertex: usize) -> bool {
        let around = self.surroundings[vertex].as_ref().is_some_and(|around| around.is_doubtful);
        let primitive = self.path.vertices[vertex].ids.primitive;
        let patch = self.prepared.table.patch_of(&self.scene().geometry, primitive);
        around || patch.is_some_and(|patch| patch.confidence < 1.0 || !patch.crossed_by.is_empty())
    }
}

/// A mode that is told again what a path has crossed, after it has been told to enter what the path started in.
struct Replay<'a> {
    inquiry: &'a Inquiry<'a>,
    /// The innermost first.
    start: &'a [ObjectId],
}

impl WithTracker for Replay<'_> {
    /// What the mode says at each vertex of the place.
    type Output = Vec<Option<Sides>>;

    fn run<T: Tracker>(self, tracker: &T) -> Self::Output {
        let Inquiry { path, place, .. } = self.inquiry;
        let mut events = Events::default();
        let mut state = T::State::default();
        tracker.start(&mut state);
        let mut said = Vec::new();
        let mut seeds = self.start.iter().rev();
        for (index, crossing, _) in self.inquiry.crossings() {
            for &refractor in seeds.by_ref() {
                let interior = medium_of(self.inquiry.scene(), Some(refractor));
                tracker.transmit(&mut state, &Crossing { refractor, interior, is_entering: true, ..crossing });
            }
            if place.contains(&index) {
                said.push(tracker.sides(&state, &crossing, &mut events));
            }
            if matches!(path.vertices[index].event, VertexEvent::Transmit | VertexEvent::Skip) {
                tracker.transmit(&mut state, &crossing);
            }
        }
        said
    }
}
