//! The path tracer: one sample of one pixel, with any tracker.
//!
//! Light is gathered where a path meets it and, at diffuse vertices, by next-event estimation, both weighted by multiple importance
//! sampling (Veach 1997, chapter 9, power heuristic). Radiance is scaled by (n_from/n_to)² at every transmission (chapter 5), apart
//! from the throughput that Russian roulette looks at.

use glam::DVec3;

use super::sampler::Sampler;
use crate::geometry::ray::NO_PRIMITIVE;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::optics::Interface;
use crate::rectify::containment::medium_of;
use crate::render::Events;
use crate::scatter::{dielectric, diffuse};
use crate::scene::SceneNeeds;
use crate::scene::environment::DirectionSample;
use crate::scene::world::{MediumId, ObjectId, Paint, Surface, World};
use crate::tracking::{Crossing, Sides, Tracker};

/// Segments after which Russian roulette looks at the throughput.
const ROULETTE_FROM: u32 = 4;
/// Share of the throughput at the first diffuse vertex below which paths are ended at random. What such a path still brings counts against
/// what its pixel shows, so a dark surface seen directly is no reason to end it; at that share the noise of ending it is small.
const ROULETTE_SHARE: f64 = 0.25;
/// Segments after which every path may be ended whatever its throughput, or trapped lossless paths would never end.
const LONG_PATH: u32 = 64;

/// Roundings of f64, at the scene's size, that two hits of one place differ by at the most.
const ROUNDINGS: f64 = 64.0;

/// Probability of going on from a segment beyond [`LONG_PATH`]. It starts at 0.95 and rises, so that the chance of lasting k segments
/// more falls as 1/k and the weight of those that do grows no faster than k. With a constant 0.95 that weight grows exponentially: the
/// paths through hundreds of interfaces, which do arrive, would be too rare to find, and the few that are caught between facets for
/// thousands of segments would come back as fireflies. From the ten thousandth on it is constant, which bounds the time of one path;
/// a trapped path lasts some 140 segments more in the mean.
#[inline]
fn survival_of_long_path(segment: u32) -> f64 {
    (1.0 - 1.0 / (f64::from(segment - LONG_PATH) + 19.0)).min(0.9999)
}

/// Random dimensions of a path: the camera's, then a block for each segment.
pub mod dimension {
    pub const PIXEL: u32 = 0;
    pub const LENS: u32 = 1;
    pub const FIRST_SEGMENT: u32 = 2;
    pub const PER_SEGMENT: u32 = 6;
    pub const SCATTER: u32 = 0;
    pub const DIRECTION: u32 = 1;
    pub const EMITTER_CHOICE: u32 = 2;
    pub const EMITTER: u32 = 3;
    pub const ENVIRONMENT: u32 = 4;
    pub const ROULETTE: u32 = 5;
}

/// What all samples of an image share.
#[derive(Clone, Copy)]
pub struct PathTracer<'a, T> {
    pub world: &'a World,
    pub tracker: &'a T,
    pub needs: SceneNeeds,
    /// Cap on segments; `u32::MAX` for none.
    pub max_depth: u32,
}

/// What one worker reuses from path to path.
#[derive(Default)]
pub struct Scratch<S> {
    state: S,
    shadow: S,
    pub events: Events,
}

/// Where the path last scattered by a density that light sampling competes with.
#[derive(Clone, Copy)]
struct LastScatter {
    position: DVec3,
    pdf: f64,
}

/// A crossing with all that is known of it.
pub(super) struct Met {
    pub crossing: Crossing,
    /// `None`: the tracker skips it.
    pub interface: Option<(Sides, Interface)>,
}

impl<T: Tracker> PathTracer<'_, T> {
    /// Radiance along `ray` (local coordinates), which starts in the medium `start`.
    #[inline]
    pub fn radiance(&self, mut ray: Ray, start: MediumId, sampler: &Sampler, scratch: &mut Scratch<T::State>) -> DVec3 {
        let world = self.world;
        self.tracker.start(&mut scratch.state);
        let mut medium = start;
        let mut radiance = DVec3::ZERO;
        // Throughput, and apart from it the product of (n_from/n_to)².
        let mut beta = DVec3::ONE;
        let mut scale = 1.0;
        let mut last: Option<LastScatter> = None;
        // Throughput below which Russian roulette sets in.
        let mut threshold = ROULETTE_SHARE;
        let mut has_scattered = false;
        let mut segment = 1;
        loop {
            let Some(hit) = self.closest(&ray) else {
                beta *= self.transmittance(medium, &ray, f64::INFINITY);
                let weight = last.map_or(1.0, |l| power_heuristic(l.pdf, self.environment_pdf(ray.direction)));
                return radiance + beta * world.environment.radiance(ray.direction) * (scale * weight);
            };
            beta *= self.transmittance(medium, &ray, hit.t);
            let object = ObjectId(world.geometry.object_of(hit.primitive));
            let surface = &world.object(object).surface;

            if let Surface::Light { radiance: emitted } = *surface {
                if !hit.is_front {
                    return radiance;
                }
                let weight = last.map_or(1.0, |l| {
                    let point = world.geometry.surface(&ray, &hit);
                    power_heuristic(l.pdf, self.emitter_pdf(l.position, ray.direction, object, &point))
                });
                return radiance + beta * emitted * (scale * weight);
            }

            let mut met = None;
            if let Surface::Refractor { smooth, .. } = *surface {
                let Met { crossing, interface } =
                    match self.meet(&ray, &hit, &scratch.state, medium, &mut scratch.events) {
                        Ok(met) => met,
                        Err(behind) => {
                            ray = behind;
                            continue;
                        }
                    };
                match interface {
                    Some((sides, interface)) if !interface.is_matched() => {
                        met = Some((crossing, sides, interface, smooth));
                    }
                    passed => {
                        // Straight on: the same ray, no depth, no random numbers.
                        self.tracker.transmit(&mut scratch.state, &crossing);
                        medium = passed.map_or(medium, |(sides, _)| sides.to);
                        ray = ray.beyond(&hit);
                        continue;
                    }
                }
            }

            // From here on the path turns: a new segment.
            if segment >= self.max_depth {
                return radiance;
            }
            let dimensions = dimension::FIRST_SEGMENT + (segment - 1) * dimension::PER_SEGMENT;
            segment += 1;
            if segment > ROULETTE_FROM {
                let mut survival = (beta.max_element() / threshold).min(1.0);
                if segment > LONG_PATH {
                    survival = survival.min(survival_of_long_path(segment));
                }
                if survival < 1.0 {
                    if sampler.get_1d(dimensions + dimension::ROULETTE) >= survival {
                        return radiance;
                    }
                    beta /= survival;
                }
            }

            if let Some((crossing, sides, interface, smooth)) = met {
                let point = crossing.point;
                let outward = if hit.is_front { 1.0 } else { -1.0 };
                let shading = self.outward_normal(&hit, &point, smooth) * outward;
                let choice = dielectric::Choice::Sample(sampler.get_1d(dimensions + dimension::SCATTER));
                let scattered = dielectric::scatter(&interface, ray.direction, point.normal * outward, shading, choice);
                if scattered.is_transmitted {
                    self.tracker.transmit(&mut scratch.state, &crossing);
                    scale *= interface.radiance_factor();
                    medium = sides.to;
                }
                ray = Ray::leaving(point.position, scattered.direction, hit.primitive);
                last = None;
                continue;
            }

            let point = world.geometry.surface(&ray, &hit);
            match *surface {
                Surface::Mirror { ref paint, smooth } => {
                    let normal = self.facing_normal(&ray, &hit, &point, smooth);
                    let cos = (-ray.direction.dot(normal)).clamp(0.0, 1.0);
                    beta *= albedo(paint, point.position);
                    let direction = crate::optics::fresnel::reflected(ray.direction, normal, cos);
                    ray = Ray::leaving(point.position, direction, hit.primitive);
                    last = None;
                }
                Surface::Diffuse { ref paint, smooth } => {
                    let normal = self.facing_normal(&ray, &hit, &point, smooth);
                    beta *= albedo(paint, point.position);
                    if beta == DVec3::ZERO {
                        return radiance;
                    }
                    if !has_scattered {
                        threshold = ROULETTE_SHARE * beta.max_element();
                        has_scattered = true;
                    }
                    let direct = self.direct(&point, normal, medium, dimensions, sampler, scratch);
                    radiance += beta * direct * scale;
                    let (direction, pdf) = diffuse::sample(normal, sampler.get_2d(dimensions + dimension::DIRECTION));
                    ray = Ray::leaving(point.position, direction, hit.primitive);
                    last = Some(LastScatter { position: point.position, pdf });
                }
                // Dealt with above.
                Surface::Light { .. } | Surface::Refractor { .. } => return radiance,
            }
        }
    }

    /// The first surface that a ray meets and that may matter to the tracker.
    #[inline]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.tracker.mask() {
            Some(mask) => self.world.geometry.closest_but(ray, mask),
            None => self.world.geometry.closest(ray),
        }
    }

    /// Light that reaches a diffuse point directly, times 1/π and cosine: the albedo is the caller's.
    #[inline]
    fn direct(
        &self,
        point: &SurfacePoint,
        normal: DVec3,
        medium: MediumId,
        dimensions: u32,
        sampler: &Sampler,
        scratch: &mut Scratch<T::State>,
    ) -> DVec3 {
        let world = self.world;
        let mut radiance = DVec3::ZERO;
        // The environment and the emitters are each asked: a choice between them would waste half of the samples where only one is seen.
        if self.needs.image_environment {
            let u = sampler.get_2d(dimensions + dimension::ENVIRONMENT);
            if let Some(sample) = world.environment.sample(u) {
                radiance += self.direct_from(None, &sample, point, normal, medium, scratch);
            }
        }
        if self.needs.emitters {
            let select = sampler.get_1d(dimensions + dimension::EMITTER_CHOICE);
            let u = sampler.get_2d(dimensions + dimension::EMITTER);
            if let Some((object, sample)) = world.emitters.sample(&world.geometry, point.position, select, u) {
                radiance += self.direct_from(Some(object), &sample, point, normal, medium, scratch);
            }
        }
        radiance
    }

    /// Light that reaches a diffuse point from the sampled direction of the emitter `target` (`None`: the environment).
    #[inline]
    fn direct_from(
        &self,
        target: Option<ObjectId>,
        sample: &DirectionSample,
        point: &SurfacePoint,
        normal: DVec3,
        medium: MediumId,
        scratch: &mut Scratch<T::State>,
    ) -> DVec3 {
        let cos = sample.direction.dot(normal);
        // The geometric side decides what can be reached; an interpolated normal must not let light through the surface.
        let is_above = (sample.direction.dot(point.normal) > 0.0) == (normal.dot(point.normal) > 0.0);
        if cos <= 0.0 || !is_above {
            return DVec3::ZERO;
        }
        let ray = Ray::leaving(point.position, sample.direction, point.primitive);
        let Some(transmittance) = self.visibility(ray, target, medium, scratch) else { return DVec3::ZERO };
        let radiance = match target.map(|object| &self.world.object(object).surface) {
            Some(Surface::Light { radiance }) => *radiance,
            _ => self.world.environment.radiance(sample.direction),
        };
        let weight = power_heuristic(sample.pdf, diffuse::pdf(cos));
        radiance * transmittance * (diffuse::pdf(cos) * weight / sample.pdf)
    }

    /// Transmittance from the ray's start to the light `target` (`None`: the environment), through surfaces that do not bend light
    /// and those that the mode skips; `None` when something else is in the way. Arriving at the very object needs no distance to compare with.
    #[inline]
    fn visibility(
        &self,
        mut ray: Ray,
        target: Option<ObjectId>,
        mut medium: MediumId,
        scratch: &mut Scratch<T::State>,
    ) -> Option<DVec3> {
        let world = self.world;
        // Whether the ray may pass through a refractor unbent, and so must look at each one it meets.
        let can_pass = self.needs.index_matching || self.tracker.can_skip();
        if target.is_none() && !can_pass {
            let is_open = match self.tracker.mask() {
                Some(mask) => !world.geometry.is_occluded_but(&ray, f64::INFINITY, mask),
                None => !world.geometry.is_occluded(&ray, f64::INFINITY),
            };
            return is_open.then(|| self.transmittance(medium, &ray, f64::INFINITY));
        }
        let mut transmittance = DVec3::ONE;
        let mut has_state = false;
        loop {
            let Some(hit) = self.closest(&ray) else {
                return target.is_none().then(|| transmittance * self.transmittance(medium, &ray, f64::INFINITY));
            };
            transmittance *= self.transmittance(medium, &ray, hit.t);
            let object = ObjectId(world.geometry.object_of(hit.primitive));
            if Some(object) == target {
                return hit.is_front.then_some(transmittance);
            }
            if !can_pass || !matches!(world.object(object).surface, Surface::Refractor { .. }) {
                return None;
            }
            if !has_state {
                scratch.shadow.clone_from(&scratch.state);
                has_state = true;
            }
            // Events are counted along camera paths only.
            let met = match self.meet(&ray, &hit, &scratch.shadow, medium, &mut Events::default()) {
                Ok(met) => met,
                Err(behind) => {
                    ray = behind;
                    continue;
                }
            };
            if let Some((sides, interface)) = met.interface {
                if !interface.is_matched() {
                    return None;
                }
                medium = sides.to;
            }
            self.tracker.transmit(&mut scratch.shadow, &met.crossing);
            ray = ray.beyond(&hit);
        }
    }

    /// Asks the tracker about a hit of a refractor by a path in `medium`, and counts a crossing that leaves another one. An error is the ray
    /// with which the path goes straight on: what it met is no crossing, and the tracker must not hear of it.
    #[inline]
    pub(super) fn meet(
        &self,
        ray: &Ray,
        hit: &Hit,
        state: &T::State,
        medium: MediumId,
        events: &mut Events,
    ) -> Result<Met, Ray> {
        events.crossings += 1;
        let (crossing, sides) = self.ask(ray, hit, state, events);
        if let Some(sides) = sides
            && !self.world.is_consistent(medium, sides.from)
        {
            if let Some(behind) = self.behind_edge(ray, hit, medium, sides, state) {
                return Err(behind);
            }
            events.inconsistent += 1;
        }
        let ior_minus_one = |medium| self.world.medium(medium).ior_minus_one;
        let interface = sides.map(|s| (s, Interface::new(ior_minus_one(s.from), ior_minus_one(s.to))));
        Ok(Met { crossing, interface })
    }

    /// What the tracker says about a hit of a refractor.
    #[inline]
    fn ask(&self, ray: &Ray, hit: &Hit, state: &T::State, events: &mut Events) -> (Crossing, Option<Sides>) {
        let world = self.world;
        let refractor = ObjectId(world.geometry.object_of(hit.primitive));
        let interior = medium_of(world, Some(refractor));
        let point = world.geometry.surface(ray, hit);
        let crossing = Crossing { refractor, interior, is_entering: hit.is_front, point, barycentric: hit.barycentric };
        let sides = self.tracker.sides(state, &crossing, events);
        (crossing, sides)
    }

    /// At an edge or a corner a ray may meet several faces in one place. A crossing there that does not leave the `medium` that the path is in
    /// is none if the path has just come from that surface in that place, or if the next one does leave that medium, in the same place,
    /// and the two undo each other: the ray grazes the edge, and rounding shows the leaving first. Then gives the ray behind them.
    #[cold]
    fn behind_edge(&self, ray: &Ray, hit: &Hit, medium: MediumId, sides: Sides, state: &T::State) -> Option<Ray> {
        let geometry = &self.world.geometry;
        let scale = geometry.bounding_sphere().map_or(0.0, |s| s.radius) + ray.origin.abs().max_element();
        let is_same_place = |from: f64, to: f64| to - from <= ROUNDINGS * f64::EPSILON * scale;
        let last = if ray.after == NO_PRIMITIVE { ray.from } else { ray.after };
        if last != NO_PRIMITIVE
            && geometry.object_of(last) == geometry.object_of(hit.primitive)
            && is_same_place(ray.t_min, hit.t)
        {
            return Some(ray.beyond(hit));
        }
        // Modes that are wrong come here often, and a search this short costs them little.
        let reach = hit.t + 2.0 * ROUNDINGS * f64::EPSILON * scale;
        if sides.to != medium || !geometry.is_occluded(&ray.beyond(hit), reach) {
            return None;
        }
        let next = self.closest(&ray.beyond(hit)).filter(|next| is_same_place(hit.t, next.t))?;
        let object = ObjectId(geometry.object_of(next.primitive));
        if !matches!(self.world.object(object).surface, Surface::Refractor { .. }) {
            return None;
        }
        let (_, next_sides) = self.ask(ray, &next, state, &mut Events::default());
        let undone = Sides { from: medium, to: sides.from };
        (next_sides == Some(undone)).then(|| ray.beyond(&next))
    }

    /// What is left of light after the part of `ray` from its start to `t`.
    #[inline]
    fn transmittance(&self, medium: MediumId, ray: &Ray, t: f64) -> DVec3 {
        if !self.needs.absorption {
            return DVec3::ONE;
        }
        let absorption = self.world.medium(medium).absorption;
        if absorption == DVec3::ZERO {
            return DVec3::ONE;
        }
        let length = match self.world.geometry.bounding_sphere() {
            // The global medium fills the bounding sphere and no more, or nothing would be left of the environment.
            Some(sphere) if medium == MediumId::WORLD => {
                let whole_line = Ray { t_min: 0.0, ..*ray };
                match sphere.intersect(&whole_line, false) {
                    [Some(enter), Some(leave)] => (t.min(leave) - ray.t_min.max(enter)).max(0.0),
                    _ => 0.0,
                }
            }
            _ => t - ray.t_min,
        };
        if length.is_finite() { (absorption * -length).exp() } else { DVec3::ZERO }
    }

    /// The outward normal that scattering uses.
    #[inline]
    pub(super) fn outward_normal(&self, hit: &Hit, point: &SurfacePoint, smooth: bool) -> DVec3 {
        if smooth && self.needs.smooth_normals {
            self.world.geometry.shading_normal(hit, point.normal)
        } else {
            point.normal
        }
    }

    /// The same, turned to the side that the ray comes from; the geometric normal where the interpolated one would face away.
    #[inline]
    pub(super) fn facing_normal(&self, ray: &Ray, hit: &Hit, point: &SurfacePoint, smooth: bool) -> DVec3 {
        let outward = if hit.is_front { 1.0 } else { -1.0 };
        let normal = self.outward_normal(hit, point, smooth) * outward;
        if normal.dot(ray.direction) < 0.0 { normal } else { point.normal * outward }
    }

    #[inline]
    fn environment_pdf(&self, direction: DVec3) -> f64 {
        if self.needs.image_environment { self.world.environment.pdf(direction) } else { 0.0 }
    }

    #[inline]
    fn emitter_pdf(&self, from: DVec3, direction: DVec3, object: ObjectId, point: &SurfacePoint) -> f64 {
        if !self.needs.emitters {
            return 0.0;
        }
        self.world.emitters.pdf(&self.world.geometry, from, direction, object, point)
    }
}

/// Weight of a sample of density `pdf` against another way of density `other`.
#[inline]
fn power_heuristic(pdf: f64, other: f64) -> f64 {
    pdf * pdf / (pdf * pdf + other * other)
}

#[inline]
fn albedo(paint: &Paint, position: DVec3) -> DVec3 {
    match paint {
        Paint::Color(color) => *color,
        Paint::Checker { a, b, origin, u_axis, v_axis } => {
            let p = position - *origin;
            let squares = p.dot(*u_axis).floor() + p.dot(*v_axis).floor();
            if squares.rem_euclid(2.0) == 0.0 { *a } else { *b }
        }
    }
}
