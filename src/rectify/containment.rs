//! Which refractors contain a point: voting rays, each asked by the facing of its first hit of every refractor.

use std::cell::RefCell;

use glam::DVec3;

use crate::geometry::{Ray, uniform_direction};
use crate::rectify::random::Random;
use crate::scene::World;
use crate::scene::world::{MediumId, ObjectId, Surface};

/// Rays of the first round. Odd, so that a vote among them decides.
const FIRST_ROUND: u32 = 3;
/// Rays at the most, where the first ones disagree. Of 15 rays that are each wrong one time in ten, the majority is wrong less than
/// one time in 30,000.
const LAST_ROUND: u32 = 15;
/// Fewer votes than this share make the answer ambiguous.
const CLEAR_SHARE: f64 = 0.75;

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Containment {
    /// In ascending order.
    pub refractors: Vec<ObjectId>,
    /// Whether the rays disagreed about some refractor beyond rare misses.
    pub is_ambiguous: bool,
}

/// Per object: votes for inside, and the nearest hit of the current ray.
#[derive(Default)]
struct Scratch {
    inside: Vec<u32>,
    nearest: Vec<(f64, bool)>,
    touched: Vec<u32>,
    candidates: Vec<u32>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The refractors, other than `except`, that contain `point` (local coordinates). Directions follow from the point alone.
pub fn containment(world: &World, point: DVec3, except: Option<ObjectId>) -> Containment {
    SCRATCH.with_borrow_mut(|scratch| {
        let objects = world.objects.len();
        scratch.inside.resize(objects, 0);
        scratch.nearest.resize(objects, (f64::INFINITY, false));
        let mut random = Random::from_point(point);
        let mut rays = 0;
        let mut goal = FIRST_ROUND;
        while rays < goal {
            let ray = Ray::new(point, uniform_direction([random.next(), random.next()]));
            scratch.vote(world, &ray, except);
            rays += 1;
            if rays == goal && scratch.candidates.iter().any(|&o| scratch.inside[o as usize] != rays) {
                goal = LAST_ROUND;
            }
        }
        scratch.count(rays)
    })
}

impl Scratch {
    /// One ray's votes: a refractor whose first hit is from behind contains the ray's start.
    fn vote(&mut self, world: &World, ray: &Ray, except: Option<ObjectId>) {
        world.geometry.for_each_hit(ray, |hit| {
            let object = world.geometry.object_of(hit.primitive);
            let nearest = &mut self.nearest[object as usize];
            if nearest.0 == f64::INFINITY {
                self.touched.push(object);
            }
            if hit.t < nearest.0 {
                *nearest = (hit.t, hit.is_front);
            }
        });
        for object in self.touched.drain(..) {
            let (_, is_front) = std::mem::replace(&mut self.nearest[object as usize], (f64::INFINITY, false));
            let is_asked = matches!(world.objects[object as usize].surface, Surface::Refractor { .. })
                && except != Some(ObjectId(object));
            if is_asked && !is_front {
                let votes = &mut self.inside[object as usize];
                if *votes == 0 {
                    self.candidates.push(object);
                }
                *votes += 1;
            }
        }
    }

    /// Majorities, and everything back to zero.
    fn count(&mut self, rays: u32) -> Containment {
        let mut answer = Containment::default();
        for object in self.candidates.drain(..) {
            let votes = std::mem::take(&mut self.inside[object as usize]);
            if 2 * votes > rays {
                answer.refractors.push(ObjectId(object));
            }
            let share = f64::from(votes.max(rays - votes)) / f64::from(rays);
            answer.is_ambiguous |= share < CLEAR_SHARE;
        }
        answer.refractors.sort_unstable();
        answer
    }
}

/// Volumes that differ by less than this, relatively, count as equal.
const SAME_VOLUME: f64 = 1e-6;

/// Of the refractors that contain a point, the one whose interior fills it: highest priority, then smallest volume, then the later.
pub fn top(world: &World, refractors: impl IntoIterator<Item = ObjectId>) -> Option<ObjectId> {
    refractors.into_iter().reduce(|a, b| {
        let (low, high) = (a.min(b), a.max(b));
        let (volume_low, volume_high) = (world.object(low).volume, world.object(high).volume);
        match priority(world, low).cmp(&priority(world, high)) {
            std::cmp::Ordering::Less => high,
            std::cmp::Ordering::Greater => low,
            std::cmp::Ordering::Equal if volume_low * (1.0 + SAME_VOLUME) < volume_high => low,
            std::cmp::Ordering::Equal => high,
        }
    })
}

fn priority(world: &World, object: ObjectId) -> i32 {
    match world.object(object).surface {
        Surface::Refractor { priority, .. } => priority,
        _ => i32::MIN,
    }
}

/// The medium that fills the innermost of `refractors`; the global medium if there is none.
pub fn medium_of(world: &World, refractor: Option<ObjectId>) -> MediumId {
    match refractor.map(|id| &world.object(id).surface) {
        Some(Surface::Refractor { medium, .. }) => *medium,
        _ => MediumId::WORLD,
    }
}

/// The medium at a point in space (local coordinates), and whether the answer is ambiguous.
pub fn medium_at(world: &World, point: DVec3) -> (MediumId, bool) {
    let found = containment(world, point, None);
    (medium_of(world, top(world, found.refractors)), found.is_ambiguous)
}
