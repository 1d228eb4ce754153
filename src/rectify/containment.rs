//! Which refractors contain a point, or lie on a side of a surface: rays vote, by rules that depend on how each refractor encloses its volume.

use std::cell::RefCell;

use glam::DVec3;

use super::face::coincides;
use super::random::Random;
use super::tolerance::largest;
use crate::geometry::{Enclosure, Hit, NO_PRIMITIVE, Ray, SurfacePoint};
use crate::scene::{MediumId, ObjectId, Scene, Surface};

/// Rays of the first round. Odd, so that a vote among them decides.
const FIRST_ROUND: u32 = 3;
/// Rays at the most, where the first ones disagree. Of 15 rays that are each wrong one time in ten, the majority is wrong less than
/// one time in 30,000.
const LAST_ROUND: u32 = 15;
/// Fewer votes than this share make the answer ambiguous.
const CLEAR_SHARE: f64 = 0.75;
/// So is a generalised winding number this close to one half.
const CLEAR_WINDING: f64 = 0.1;

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Containment {
    /// In ascending order.
    pub refractors: Vec<ObjectId>,
    /// Whether the rays disagreed about some refractor beyond rare misses.
    pub is_ambiguous: bool,
}

/// The votes about one refractor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Vote {
    pub refractor: ObjectId,
    /// Rays that found it to contain the start.
    pub inside: u32,
    /// Rays that found anything about it.
    pub asked: u32,
}

impl Vote {
    pub fn is_inside(&self) -> bool {
        2 * self.inside > self.asked
    }

    /// Share of the votes that the majority has, in [0.5, 1]; 1 if nobody was asked.
    pub fn share(&self) -> f64 {
        if self.asked == 0 {
            return 1.0;
        }
        f64::from(self.inside.max(self.asked - self.inside)) / f64::from(self.asked)
    }
}

/// What one ray has met of one object.
#[derive(Clone, Copy)]
struct RayMeeting {
    /// Distance and facing of the first hit.
    t: f64,
    is_front: bool,
    /// Hits from behind less hits from the front.
    exits: i32,
}

const NO_MEETING: RayMeeting = RayMeeting { t: f64::INFINITY, is_front: false, exits: 0 };

/// Counts votes. Reused from question to question, so that asking allocates nothing.
#[derive(Default)]
pub(super) struct Poll {
    meetings: Vec<RayMeeting>,
    met: Vec<u32>,
    votes: Vec<(u32, u32)>,
    /// Refractors with an entry in `votes`.
    candidates: Vec<u32>,
    rays: u32,
    hits: usize,
}

thread_local! {
    static POLL: RefCell<Poll> = RefCell::default();
}

impl Poll {
    fn clear(&mut self, scene: &Scene) {
        for candidate in self.candidates.drain(..) {
            self.votes[candidate as usize] = (0, 0);
        }
        (self.rays, self.hits) = (0, 0);
        self.meetings.resize(scene.objects.len(), NO_MEETING);
        self.votes.resize(scene.objects.len(), (0, 0));
    }

    /// One ray's votes about every refractor. Hits that `is_ignored` names do not count.
    pub(super) fn ask(&mut self, scene: &Scene, ray: &Ray, is_ignored: impl Fn(&Hit) -> bool) {
        self.rays += 1;
        self.look(scene, ray, is_ignored, false);
    }

    /// One ray's votes about sheets only, which do not depend on what else the ray passes through.
    pub(super) fn ask_sheets(&mut self, scene: &Scene, ray: &Ray, is_ignored: impl Fn(&Hit) -> bool) {
        self.look(scene, ray, is_ignored, true);
    }

    fn look(&mut self, scene: &Scene, ray: &Ray, is_ignored: impl Fn(&Hit) -> bool, only_sheets: bool) {
        let mut nearest_opaque = f64::INFINITY;
        let mut hits = 0;
        scene.geometry.for_each_hit(ray, |hit| {
            hits += 1;
            let object = scene.geometry.object_of(hit.primitive);
            if !scene.is_refractor(ObjectId(object)) {
                nearest_opaque = nearest_opaque.min(hit.t);
                return;
            }
            if is_ignored(&hit) {
                return;
            }
            let meeting = &mut self.meetings[object as usize];
            if meeting.t == f64::INFINITY {
                self.met.push(object);
            }
            if hit.t < meeting.t {
                (meeting.t, meeting.is_front) = (hit.t, hit.is_front);
            }
            meeting.exits += if hit.is_front { -1 } else { 1 };
        });
        self.hits += hits;
        for object in self.met.drain(..) {
            let meeting = std::mem::replace(&mut self.meetings[object as usize], NO_MEETING);
            let enclosure = scene.objects[object as usize].enclosure;
            let is_sheet = enclosure == Enclosure::Sheet;
            let is_inside = match enclosure {
                Enclosure::Closed => !meeting.is_front,
                Enclosure::Union => meeting.exits > 0,
                // The sheet may end at the opaque surface: the ray abstains.
                Enclosure::Sheet if nearest_opaque < meeting.t => continue,
                Enclosure::Sheet => !meeting.is_front,
                Enclosure::Holed => continue,
            };
            if is_sheet || (is_inside && !only_sheets) {
                let (inside, asked) = &mut self.votes[object as usize];
                if *asked == 0 {
                    self.candidates.push(object);
                }
                *inside += u32::from(is_inside);
                *asked += 1;
            }
        }
    }

    /// Votes so far about every refractor that any ray found to contain the start, and about every sheet that was met, in ascending order.
    pub(super) fn votes(&self, scene: &Scene) -> Vec<Vote> {
        let mut votes: Vec<Vote> = (self.candidates.iter())
            .map(|&object| {
                let (inside, asked) = self.votes[object as usize];
                // Every ray is a vote about a closed refractor, whether it meets it or not.
                let is_sheet = scene.objects[object as usize].enclosure == Enclosure::Sheet;
                Vote { refractor: ObjectId(object), inside, asked: if is_sheet { asked } else { self.rays } }
            })
            .collect();
        votes.sort_unstable_by_key(|vote| vote.refractor);
        votes
    }

    /// Surfaces that all rays have met so far.
    pub(super) fn hits(&self) -> usize {
        self.hits
    }

    pub(super) fn is_unanimous(&self, scene: &Scene) -> bool {
        self.candidates.iter().all(|&object| {
            let (inside, asked) = self.votes[object as usize];
            let is_sheet = scene.objects[object as usize].enclosure == Enclosure::Sheet;
            inside == if is_sheet { asked } else { self.rays } || inside == 0
        })
    }
}

/// The refractors, other than `except`, that contain `point` (local coordinates). Directions follow from the point alone.
pub fn containment(scene: &Scene, point: DVec3, except: Option<ObjectId>) -> Containment {
    let votes = votes_at(scene, point);
    let nowhere = SurfacePoint { position: point, normal: DVec3::ZERO, primitive: NO_PRIMITIVE };
    settle(scene, &nowhere, votes, except)
}

/// The refractors that lie on a side of a surface: the outer one, or the inner one. Faces that coincide with the surface are no hits: which
/// side they look to is told by the rays that leave on that side. The object itself is asked about on its outer side only if it is a
/// union, and never on the inner.
pub fn containment_beside(scene: &Scene, point: &SurfacePoint, is_outer: bool) -> Containment {
    let own = ObjectId(scene.geometry.object_of(point.primitive));
    let votes = votes_beside(scene, point, is_outer);
    let may_contain_itself = is_outer && scene.object(own).may_contain_itself();
    settle(scene, point, votes, (!may_contain_itself).then_some(own))
}

/// Generalised winding number of a surface with holes around a point; for a point on that very surface, of the point moved off it to the outer
/// side.
pub(super) fn winding_beside(scene: &Scene, holed: ObjectId, point: &SurfacePoint) -> f64 {
    let is_own = point.primitive != NO_PRIMITIVE && scene.geometry.object_of(point.primitive) == holed.0;
    if is_own { winding_on_side(scene, holed, point, true) } else { scene.object(holed).winding_at(point.position) }
}

/// The same where faces of the object coincide with the surface. The point is moved off it: on it rounding would decide between the numbers of
/// the two sides.
fn winding_on_side(scene: &Scene, holed: ObjectId, point: &SurfacePoint, is_outer: bool) -> f64 {
    /// Share of the object's radius: beyond the rounding of vertices.
    const BESIDE: f64 = 1e-6;
    let away = point.normal * (BESIDE * scene.geometry.radius_of(holed.0));
    scene.object(holed).winding_at(point.position + if is_outer { away } else { -away })
}

/// The votes of rays that leave a surface on one side. Faces that coincide with it there are no hits.
fn votes_beside(scene: &Scene, point: &SurfacePoint, is_outer: bool) -> Vec<Vote> {
    let side = SurfacePoint { normal: if is_outer { point.normal } else { -point.normal }, ..*point };
    poll(scene, point.position, |random| outward_ray(&side, random), |hit| is_at_start(scene, point, hit))
}

/// Whether a hit of a ray that leaves `point` is of a face that coincides with that of the point.
pub(super) fn is_at_start(scene: &Scene, point: &SurfacePoint, hit: &Hit) -> bool {
    // A coincident face lies within the tolerance, and a grazing ray may take many times that length to reach it. A hit farther away is of
    // another face.
    const GRAZING: f64 = 32.0;
    let geometry = &*scene.geometry;
    let tolerance = |primitive| largest(geometry, geometry.object_of(primitive));
    hit.t < GRAZING * tolerance(point.primitive).max(tolerance(hit.primitive))
        && coincides(geometry, point.primitive, hit.primitive).is_some()
}

/// Lends this thread's poll, cleared. Clearing costs time for the objects that the last question met, not for all objects.
pub(super) fn with_poll<R>(scene: &Scene, ask: impl FnOnce(&mut Poll) -> R) -> R {
    POLL.with_borrow_mut(|poll| {
        poll.clear(scene);
        ask(poll)
    })
}

fn poll(scene: &Scene, point: DVec3, ray: impl Fn(&mut Random) -> Ray, is_ignored: impl Fn(&Hit) -> bool) -> Vec<Vote> {
    with_poll(scene, |poll| {
        let mut random = Random::from_point(point);
        for _ in 0..FIRST_ROUND {
            poll.ask(scene, &ray(&mut random), &is_ignored);
        }
        if !poll.is_unanimous(scene) {
            for _ in FIRST_ROUND..LAST_ROUND {
                poll.ask(scene, &ray(&mut random), &is_ignored);
            }
        }
        if scene.has_sheets {
            // Rays that miss a sheet are no votes about it, so more are shot; below a sheet only rays back through the object may meet
            // it.
            for _ in 0..LAST_ROUND {
                let ray = ray(&mut random);
                poll.ask_sheets(scene, &ray, &is_ignored);
                poll.ask_sheets(scene, &Ray { direction: -ray.direction, ..ray }, &is_ignored);
            }
        }
        poll.votes(scene)
    })
}

/// Majorities, and the refractors with holes, all but `except`.
fn settle(scene: &Scene, point: &SurfacePoint, votes: Vec<Vote>, except: Option<ObjectId>) -> Containment {
    let mut answer = Containment::default();
    let is_asked = |refractor: ObjectId| Some(refractor) != except;
    for vote in votes.into_iter().filter(|vote| is_asked(vote.refractor)) {
        if vote.is_inside() {
            answer.refractors.push(vote.refractor);
        }
        answer.is_ambiguous |= vote.share() < CLEAR_SHARE;
    }
    for &holed in scene.holed.iter().filter(|holed| is_asked(**holed)) {
        let winding = winding_beside(scene, holed, point);
        if winding > 0.5 {
            answer.refractors.push(holed);
        }
        answer.is_ambiguous |= (winding - 0.5).abs() < CLEAR_WINDING;
    }
    answer.refractors.sort_unstable();
    answer
}

/// Whether `refractor` contains a point on a face of another object, or the outer side of one of its own: one ray where one is enough.
/// Faces that coincide with that face must have been dealt with.
pub fn is_inside(scene: &Scene, refractor: ObjectId, point: &SurfacePoint) -> bool {
    if scene.geometry.sphere_of(refractor.0).is_some() || scene.object(refractor).enclosure != Enclosure::Closed {
        return is_inside_by_vote(scene, refractor, point);
    }
    let ray = outward_ray(point, &mut Random::from_point(point.position));
    scene.geometry.closest_of(&ray, refractor.0).is_some_and(|hit| !hit.is_front)
}

/// [`is_inside`], decided by several rays.
pub fn is_inside_by_vote(scene: &Scene, refractor: ObjectId, point: &SurfacePoint) -> bool {
    if let Some(sphere) = scene.geometry.sphere_of(refractor.0) {
        return point.position.distance_squared(sphere.center) < sphere.radius * sphere.radius;
    }
    match scene.object(refractor).enclosure {
        Enclosure::Closed => {
            let mut random = Random::from_point(point.position);
            let (mut inside, mut rays) = (0, 0);
            while rays < 2 || (inside % rays != 0 && rays < LAST_ROUND) {
                let hit = scene.geometry.closest_of(&outward_ray(point, &mut random), refractor.0);
                inside += u32::from(hit.is_some_and(|hit| !hit.is_front));
                rays += 1;
            }
            2 * inside > rays
        }
        Enclosure::Holed => winding_beside(scene, refractor, point) > 0.5,
        Enclosure::Union | Enclosure::Sheet => {
            let votes = poll(scene, point.position, |random| outward_ray(point, random), |_| false);
            votes.iter().any(|vote| vote.refractor == refractor && vote.is_inside())
        }
    }
}

/// Whether `refractor`, of several parts, fills the outer side of a surface, or the inner side, next to a point where faces of its own may
/// coincide with that surface: rays that leave on that side tell, and those faces are no hits.
pub(super) fn fills_beside(scene: &Scene, refractor: ObjectId, point: &SurfacePoint, is_outer: bool) -> bool {
    if scene.object(refractor).enclosure == Enclosure::Holed {
        return winding_on_side(scene, refractor, point, is_outer) > 0.5;
    }
    let votes = votes_beside(scene, point, is_outer);
    votes.iter().any(|vote| vote.refractor == refractor && vote.is_inside())
}

/// A ray from a surface into its outer side.
pub(super) fn outward_ray(point: &SurfacePoint, random: &mut Random) -> Ray {
    let direction = random.direction();
    let direction = if direction.dot(point.normal) < 0.0 { -direction } else { direction };
    Ray::leaving(point.position, direction, point.primitive)
}

/// Volumes that differ by less than this, relatively, count as equal.
const SAME_VOLUME: f64 = 1e-6;

/// Of the refractors that contain a point, the one whose interior fills it: highest priority, then smallest volume, then the later.
pub fn top(scene: &Scene, refractors: impl IntoIterator<Item = ObjectId>) -> Option<ObjectId> {
    refractors.into_iter().reduce(|a, b| {
        let (low, high) = (a.min(b), a.max(b));
        let (volume_low, volume_high) = (scene.object(low).volume, scene.object(high).volume);
        match scene.priority(low).cmp(&scene.priority(high)) {
            std::cmp::Ordering::Less => high,
            std::cmp::Ordering::Greater => low,
            std::cmp::Ordering::Equal if volume_low < volume_high && !is_same_volume(volume_low, volume_high) => low,
            std::cmp::Ordering::Equal => high,
        }
    })
}

/// Whether two volumes count as equal.
pub fn is_same_volume(a: f64, b: f64) -> bool {
    a.min(b) * (1.0 + SAME_VOLUME) >= a.max(b)
}

/// The medium that fills the innermost of `refractors`; the global medium if there is none.
pub fn medium_of(scene: &Scene, refractor: Option<ObjectId>) -> MediumId {
    match refractor.map(|id| &scene.object(id).surface) {
        Some(Surface::Refractor { medium, .. }) => *medium,
        _ => MediumId::WORLD,
    }
}

/// The votes about what contains a point (local coordinates), as [`containment`] counts them.
pub(super) fn votes_at(scene: &Scene, point: DVec3) -> Vec<Vote> {
    poll(scene, point, |random| Ray::new(point, random.direction()), |_| false)
}

/// The medium at a point in space (local coordinates), and whether the answer is ambiguous.
pub fn medium_at(scene: &Scene, point: DVec3) -> (MediumId, bool) {
    let found = containment(scene, point, None);
    (medium_of(scene, top(scene, found.refractors)), found.is_ambiguous)
}
