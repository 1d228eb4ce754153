//! A straight line through the whole scene: where it crosses surfaces, and what a mode says about their two sides.

use glam::DVec3;

use super::{Edge, Filling, Testimony};
use crate::geometry::{Hit, Ray};
use crate::rectify::object_table::ObjectAnswer;
use crate::scene::{MediumId, ObjectId, Surface};
use crate::tracking::{Crossing, Events, Mode, Prepared, Tracker};

/// An answer that fewer of the pre-trace's rays agree about than this share is doubtful.
const LEAST_CONFIDENCE: f64 = 0.9;

/// A surface that a line crosses.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mark {
    /// Distance along the line.
    at: f64,
    object: ObjectId,
    /// The media before and behind it.
    before: MediumId,
    behind: MediumId,
    /// Whether what is said of the two sides rests on rays that did not agree.
    is_doubtful: [bool; 2],
}

/// A line. Distances are counted from the point that it was asked for, and may be negative.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Line {
    /// Refractors' surfaces, in order.
    marks: Vec<Mark>,
    /// Where surfaces of solids and lights are crossed, in order.
    opaque_marks: Vec<f64>,
    /// The parts of the line that lie in solids and lights.
    opaque: Vec<(f64, f64, Filling)>,
    /// The medium where there is no surface in the way any more; `None` where that cannot be told.
    far: Option<MediumId>,
}

/// What walks along lines.
pub(super) struct Walk<'a, T> {
    pub prepared: &'a Prepared,
    pub mode: Mode,
    pub tracker: &'a T,
}

impl<T: Tracker> Walk<'_, T> {
    pub(super) fn along(&self, through: DVec3, direction: DVec3) -> Line {
        let scene = &*self.prepared.scene;
        let geometry = &*scene.geometry;
        // Below an open sheet nothing need be in the way of what is far inside.
        let exterior = if self.mode == Mode::Naive { MediumId::VACUUM } else { MediumId::WORLD };
        let mut line = Line { far: (!scene.has_sheets).then_some(exterior), ..Line::default() };
        let Some(sphere) = geometry.bounding_sphere() else { return line };
        // From before the scene.
        let start = (sphere.center - through).dot(direction) - 1.01 * sphere.radius - f64::MIN_POSITIVE;
        let ray = Ray::new(through + direction * start, direction);
        let mut hits: Vec<Hit> = Vec::new();
        geometry.for_each_hit(&ray, |hit| hits.push(hit));
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
        let state = T::State::default();
        let mut events = Events::default();
        // Solids and lights that the line is in, and where it entered them.
        let mut entered: Vec<(u32, f64)> = Vec::new();
        for hit in &hits {
            let object = ObjectId(geometry.object_of(hit.primitive));
            let at = start + hit.t;
            let filling = match scene.object(object).surface {
                Surface::Refractor { medium, .. } => {
                    let point = geometry.surface(&ray, hit);
                    let crossing = Crossing {
                        refractor: object,
                        interior: medium,
                        is_entering: hit.is_front,
                        point,
                        barycentric: hit.barycentric,
                    };
                    let ambiguous = events.ambiguous;
                    let Some(sides) = self.tracker.sides(&state, &crossing, &mut events) else { continue };
                    let is_unsure = events.ambiguous > ambiguous || self.confidence(object, hit) < LEAST_CONFIDENCE;
                    let is_doubtful = [is_unsure && hit.is_front, is_unsure && !hit.is_front];
                    line.marks.push(Mark { at, object, before: sides.from, behind: sides.to, is_doubtful });
                    continue;
                }
                Surface::Light { .. } => Filling::Light,
                Surface::Diffuse { .. } | Surface::Mirror { .. } => Filling::Solid,
            };
            line.opaque_marks.push(at);
            match entered.iter().position(|(inside, _)| *inside == object.0) {
                Some(index) if !hit.is_front => {
                    let (_, since) = entered.swap_remove(index);
                    line.opaque.push((since, at, filling));
                }
                None if hit.is_front => entered.push((object.0, at)),
                _ => {}
            }
        }
        line
    }

    /// How sure rectification is of what lies outside at a hit.
    fn confidence(&self, refractor: ObjectId, hit: &Hit) -> f64 {
        let Prepared { scene, table, .. } = self.prepared;
        match self.mode {
            Mode::Rectified => table.patch_of(&scene.geometry, hit.primitive).map_or(1.0, |patch| patch.confidence),
            Mode::RectifiedObject => {
                let answers = &table.object_table(scene).answers;
                answers.get(refractor.0 as usize).map_or(1.0, ObjectAnswer::confidence)
            }
            _ => 1.0,
        }
    }
}

impl Line {
    /// The same with distances in units of `unit`.
    pub(super) fn scaled(mut self, unit: f64) -> Self {
        self.marks.iter_mut().for_each(|mark| mark.at /= unit);
        self.opaque_marks.iter_mut().for_each(|at| *at /= unit);
        self.opaque.iter_mut().for_each(|(from, to, _)| (*from, *to) = (*from / unit, *to / unit));
        self
    }

    /// Whether nothing on it says anything.
    pub(super) fn is_silent(&self) -> bool {
        self.marks.is_empty() && self.far.is_none()
    }

    /// What the last surface before a place and the first one behind it say.
    pub(super) fn sides_of(&self, at: f64) -> [Option<Testimony>; 2] {
        let next = self.marks.partition_point(|mark| mark.at <= at);
        let far = || Some(Testimony { medium: self.far?, object: None, distance: f64::INFINITY, is_doubtful: false });
        let of = |mark: &Mark, is_before: bool| {
            let (medium, is_doubtful) =
                if is_before { (mark.behind, mark.is_doubtful[1]) } else { (mark.before, mark.is_doubtful[0]) };
            Testimony { medium, object: Some(mark.object), distance: (mark.at - at).abs(), is_doubtful }
        };
        let before = next.checked_sub(1).map_or_else(far, |last| Some(of(&self.marks[last], true)));
        [before, self.marks.get(next).map_or_else(far, |mark| Some(of(mark, false)))]
    }

    /// What the place lies in, if that is a solid or a light.
    pub(super) fn opaque_at(&self, at: f64) -> Option<Filling> {
        self.opaque.iter().find(|(from, to, _)| (*from..*to).contains(&at)).map(|(_, _, filling)| *filling)
    }

    /// What is drawn in the pixel around a place with lines of that width.
    pub(super) fn edge_at(&self, at: f64, line_width: f64) -> Option<Edge> {
        let half = 0.5 * line_width.max(1.0);
        let reach = at - half..at + half;
        let first = self.marks.partition_point(|mark| mark.at < reach.start);
        let marks = || self.marks[first..].iter().take_while(|mark| mark.at < reach.end);
        if marks().any(|mark| mark.before != mark.behind) {
            return Some(Edge::Interface);
        }
        let opaque = self.opaque_marks.partition_point(|at| *at < reach.start);
        match self.opaque_marks.get(opaque) {
            Some(at) if *at < reach.end => Some(Edge::Opaque),
            _ => marks().next().map(|_| Edge::Null),
        }
    }
}
