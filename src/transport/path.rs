//! The path tracer: samples of pixels, with any tracker.
//!
//! Paths advance in batches, a segment at a time: the rays of a batch are traced together, which hides the time that memory takes, and paths
//! that leave from the same pixel stay together for some segments.
//!
//! Light is gathered where a path meets it and, at diffuse vertices, by next-event estimation, both weighted by multiple importance
//! sampling (Veach 1997, chapter 9, power heuristic). Radiance is scaled by (n_from/n_to)² at every transmission (chapter 5), apart
//! from the throughput that Russian roulette looks at.

use glam::DVec3;

use super::crossing::Met;
use super::direct::{Receiver, power_heuristic};
use super::sampler::Sampler;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::rectify::start::Start;
use crate::scatter::dielectric::{self, Choice, Scattered};
use crate::scatter::normals::Normals;
use crate::scatter::{diffuse, mirror};
use crate::scene::{MediumId, ObjectId, Paint, Scene, SceneNeeds, Surface};
use crate::tracking::Events;
use crate::tracking::Tracker;

/// Segments after which Russian roulette looks at the throughput.
const ROULETTE_FROM: u32 = 4;
/// Share of the throughput at the first diffuse vertex below which paths are ended at random. What such a path still brings counts against
/// what its pixel shows, so a dark surface seen directly is no reason to end it; at that share the noise of ending it is small.
const ROULETTE_SHARE: f64 = 0.25;
/// Segments after which every path may be ended whatever its throughput, or trapped lossless paths would never end.
const LONG_PATH: u32 = 64;

/// Probability of going on from a segment beyond [`LONG_PATH`]. It starts at 0.95 and rises, so that the chance of lasting k segments
/// more falls as 1/k and the weight of those that do grows no faster than k. With a constant 0.95 that weight grows exponentially: the
/// paths through hundreds of interfaces, which do arrive, would be too rare to find, and the few that are caught between facets for
/// thousands of segments would come back as fireflies. From the ten thousandth on it is constant, which bounds the time of one path;
/// a trapped path lasts some 140 segments more in the mean.
#[inline]
fn survival_of_long_path(segment: u32) -> f64 {
    (1.0 - 1.0 / (f64::from(segment - LONG_PATH) + 19.0)).min(0.9999)
}

/// Least share of a path's light that is worth a path of its own: a branch of less is followed now and then, by chance.
const SPLIT_SHARE: f64 = 0.03;

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
    pub scene: &'a Scene,
    pub tracker: &'a T,
    pub needs: SceneNeeds,
    /// Cap on segments; `u32::MAX` for none.
    pub max_depth: u32,
    /// How many interfaces from the camera on a path may split at, into one that is reflected and one that goes through.
    pub splits: u32,
}

/// Where the path last scattered by a density that light sampling competes with.
#[derive(Clone, Copy)]
struct LastScatter {
    position: DVec3,
    pdf: f64,
}

/// A path on its way, apart from its ray.
#[derive(Clone)]
struct Path<S> {
    sampler: Sampler,
    /// The path that this one is a branch of; its own number if it is none.
    root: u32,
    /// How many times it may still split.
    splits: u32,
    medium: MediumId,
    /// Segments so far, the camera's first being one.
    segment: u32,
    /// Throughput, and apart from it the product of (n_from/n_to)².
    beta: DVec3,
    scale: f64,
    last: Option<LastScatter>,
    /// Throughput below which Russian roulette sets in. A branch's share counts as throughput: a small one is not followed for long.
    roulette_below: f64,
    has_scattered: bool,
    /// Of its root's light at the splits so far.
    share: f64,
    radiance: DVec3,
    state: S,
}

/// Paths that advance together. One worker reuses it from batch to batch.
pub struct Batch<S> {
    /// In the order in which they were added, then the branches that they split off. Those behind `used` are room for later ones.
    paths: Vec<Path<S>>,
    /// Paths that were added.
    count: usize,
    /// These and their branches.
    used: usize,
    /// The paths that have not ended, in order, and their rays.
    alive: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// State of shadow rays.
    shadow: S,
    pub events: Events,
}

impl<S: Default> Default for Batch<S> {
    fn default() -> Self {
        Self {
            paths: Vec::new(),
            count: 0,
            used: 0,
            alive: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            shadow: S::default(),
            events: Events::default(),
        }
    }
}

impl<S: Default> Batch<S> {
    /// So many paths are enough for beams to form and to hide the time that memory takes; more bring little.
    pub const SIZE: usize = 256;

    pub fn is_full(&self) -> bool {
        self.count >= Self::SIZE
    }

    /// Adds a path that starts as `start` says (local coordinates).
    #[inline]
    pub fn add<T: Tracker<State = S>>(&mut self, start: &Start, sampler: Sampler, tracer: &PathTracer<'_, T>) {
        self.events.ambiguous += u64::from(start.is_ambiguous);
        let number = self.count as u32;
        self.alive.push(number);
        self.rays.push(start.ray);
        if self.count == self.paths.len() {
            self.paths.push(Path::new(number, sampler, start.medium));
        }
        let path = &mut self.paths[self.count];
        let state = std::mem::take(&mut path.state);
        *path = Path { state, splits: tracer.splits, ..Path::new(number, sampler, start.medium) };
        tracer.tracker.start(&mut path.state);
        self.count += 1;
        self.used = self.count;
    }

    /// Empties the batch; gives the radiance and the segments of each path that was added, with its branches', in the order in which they were
    /// added.
    pub fn drain(&mut self) -> impl Iterator<Item = (DVec3, u32)> + '_ {
        let count = std::mem::take(&mut self.count);
        let (roots, branches) = self.paths[..std::mem::take(&mut self.used)].split_at_mut(count);
        for branch in branches {
            let root = &mut roots[branch.root as usize];
            root.radiance += branch.radiance;
            root.segment += branch.segment;
        }
        self.alive.clear();
        self.rays.clear();
        roots.iter().map(|path| (path.radiance, path.segment))
    }
}

impl<S: Default> Path<S> {
    fn new(root: u32, sampler: Sampler, medium: MediumId) -> Self {
        Self {
            sampler,
            root,
            splits: 0,
            medium,
            segment: 1,
            beta: DVec3::ONE,
            scale: 1.0,
            last: None,
            roulette_below: ROULETTE_SHARE,
            has_scattered: false,
            share: 1.0,
            radiance: DVec3::ZERO,
            state: S::default(),
        }
    }
}

impl<T: Tracker> PathTracer<'_, T> {
    /// Follows the paths of `batch` to their ends.
    pub fn trace(&self, batch: &mut Batch<T::State>) {
        let Batch { paths, used, alive, rays, hits, shadow, events, .. } = batch;
        while !alive.is_empty() {
            self.closest_many(rays, hits);
            let mut kept = 0;
            let last = alive.len();
            for index in 0..last {
                let number = alive[index];
                let path = &mut paths[number as usize];
                let (ray, hit) = (rays[index], hits[index].as_ref());
                let mut branch = None;
                if let Some(next) = self.advance(path, &ray, hit, shadow, events, &mut branch) {
                    rays[kept] = next;
                    alive[kept] = number;
                    kept += 1;
                }
                if let Some((branch, ray)) = branch {
                    alive.push(*used as u32);
                    rays.push(ray);
                    if *used == paths.len() {
                        paths.push(branch);
                    } else {
                        paths[*used] = branch;
                    }
                    *used += 1;
                }
            }
            alive.drain(kept..last);
            rays.drain(kept..last);
        }
    }

    /// Takes a path to what its ray meets. Returns the ray that it goes on with; `None` where it ends.
    #[inline]
    fn advance(
        &self,
        path: &mut Path<T::State>,
        ray: &Ray,
        hit: Option<&Hit>,
        shadow: &mut T::State,
        events: &mut Events,
        branch: &mut Option<(Path<T::State>, Ray)>,
    ) -> Option<Ray> {
        let scene = self.scene;
        let Some(hit) = hit else {
            path.beta *= self.transmittance(path.medium, ray, f64::INFINITY);
            let weight = path.last.map_or(1.0, |l| power_heuristic(l.pdf, self.environment_pdf(ray.direction)));
            path.radiance += path.beta * scene.environment.radiance(ray.direction) * (path.scale * weight);
            return None;
        };
        path.beta *= self.transmittance(path.medium, ray, hit.t);
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        let surface = &scene.object(object).surface;

        if let Surface::Light { radiance } = *surface {
            if hit.is_front {
                let weight = path.last.map_or(1.0, |l| {
                    let point = scene.geometry.surface(ray, hit);
                    power_heuristic(l.pdf, self.emitter_pdf(l.position, ray.direction, object, &point))
                });
                path.radiance += path.beta * radiance * (path.scale * weight);
            }
            return None;
        }

        let mut met = None;
        if let Surface::Refractor { smooth, .. } = *surface {
            let Met { crossing, interface } = match self.meet(ray, hit, &path.state, path.medium, events) {
                Ok(met) => met,
                Err(behind) => return Some(behind),
            };
            match interface {
                Some((sides, interface)) if !interface.is_matched() => {
                    met = Some((crossing, sides, interface, smooth));
                }
                passed => {
                    // Straight on: the same ray, no depth, no random numbers.
                    self.tracker.transmit(&mut path.state, &crossing);
                    path.medium = passed.map_or(path.medium, |(sides, _)| sides.to);
                    return Some(ray.beyond(hit));
                }
            }
        }

        // From here on the path turns: a new segment.
        if path.segment >= self.max_depth {
            return None;
        }
        let segment = path.segment;
        let dimensions = dimension::FIRST_SEGMENT + (segment - 1) * dimension::PER_SEGMENT;
        path.segment += 1;
        if !path.survives(dimensions) {
            return None;
        }

        if let Some((crossing, sides, interface, smooth)) = met {
            let point = crossing.point;
            let normals = self.normals(hit, &point, smooth);
            let scatter = |choice| dielectric::scatter(&interface, ray.direction, &normals, segment, choice);
            let scattered = match self.split(path, scatter) {
                Some([through, back]) => {
                    let mut reflected = Path { radiance: DVec3::ZERO, last: None, ..path.clone() };
                    reflected.take_share(back.reflectance);
                    path.take_share(1.0 - through.reflectance);
                    *branch = Some((reflected, Ray::leaving(point.position, back.direction, hit.primitive)));
                    through
                }
                None => scatter(Choice::Sample(path.sampler.get_1d(dimensions + dimension::SCATTER))),
            };
            if scattered.is_transmitted {
                self.tracker.transmit(&mut path.state, &crossing);
                path.scale *= interface.radiance_factor();
                path.medium = sides.to;
            }
            path.last = None;
            return Some(Ray::leaving(point.position, scattered.direction, hit.primitive));
        }

        let point = scene.geometry.surface(ray, hit);
        match *surface {
            Surface::Mirror { ref paint, smooth } => {
                let normals = self.normals(hit, &point, smooth);
                path.beta *= albedo(paint, point.position);
                path.last = None;
                let direction = mirror::reflect(ray.direction, &normals);
                Some(Ray::leaving(point.position, direction, hit.primitive))
            }
            Surface::Diffuse { ref paint, smooth } => {
                let normals = self.normals(hit, &point, smooth);
                path.beta *= albedo(paint, point.position);
                if path.beta == DVec3::ZERO {
                    return None;
                }
                if !path.has_scattered {
                    path.roulette_below = ROULETTE_SHARE * path.beta.max_element() / path.share;
                    path.has_scattered = true;
                }
                let receiver = Receiver { point: &point, normals, medium: path.medium, state: &path.state };
                let direct = self.direct(&receiver, dimensions, &path.sampler, shadow);
                path.radiance += path.beta * direct * path.scale;
                let (direction, pdf) =
                    diffuse::sample(&normals, path.sampler.get_2d(dimensions + dimension::DIRECTION));
                path.last = Some(LastScatter { position: point.position, pdf });
                Some(Ray::leaving(point.position, direction, hit.primitive))
            }
            // Dealt with above.
            Surface::Light { .. } | Surface::Refractor { .. } => None,
        }
    }

    /// Both ways on from an interface, through and back, where a path is to split: where both bring enough to be worth a path of their own.
    #[inline]
    fn split(&self, path: &mut Path<T::State>, scatter: impl Fn(Choice) -> Scattered) -> Option<[Scattered; 2]> {
        if path.splits == 0 || path.has_scattered {
            return None;
        }
        let through = scatter(Choice::Transmit);
        if !through.is_transmitted || through.reflectance.min(1.0 - through.reflectance) * path.share <= SPLIT_SHARE {
            return None;
        }
        let back = scatter(Choice::Reflect);
        path.splits -= 1;
        Some([through, back])
    }

    /// The first surface that a ray meets and that may matter to the tracker.
    #[inline]
    pub(super) fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.tracker.mask() {
            Some(mask) => self.scene.geometry.closest_but(ray, mask),
            None => self.scene.geometry.closest(ray),
        }
    }

    /// The same for each ray.
    #[inline]
    fn closest_many(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.resize(rays.len(), None);
        match self.tracker.mask() {
            Some(mask) => self.scene.geometry.closest_many_but(rays, mask, hits),
            None => self.scene.geometry.closest_many(rays, hits),
        }
    }

    /// What is left of light after the part of `ray` from its start to `t`.
    #[inline]
    pub(super) fn transmittance(&self, medium: MediumId, ray: &Ray, t: f64) -> DVec3 {
        if !self.needs.absorption {
            return DVec3::ONE;
        }
        let absorption = self.scene.medium(medium).absorption;
        if absorption == DVec3::ZERO {
            return DVec3::ONE;
        }
        let length = match self.scene.geometry.bounding_sphere() {
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

    /// The normals at a hit that scattering uses, on the side that the ray comes from.
    #[inline]
    pub(super) fn normals(&self, hit: &Hit, point: &SurfacePoint, smooth: bool) -> Normals {
        let outward = if hit.is_front { 1.0 } else { -1.0 };
        let face = point.normal * outward;
        if smooth && self.needs.smooth_normals {
            Normals { face, shading: self.scene.geometry.shading_normal(hit, point.normal) * outward }
        } else {
            Normals::flat(face)
        }
    }
}

impl<S> Path<S> {
    /// Leaves the rest of its light to another branch.
    #[inline]
    fn take_share(&mut self, share: f64) {
        self.beta *= share;
        self.share *= share;
    }

    /// Russian roulette, with the random numbers of the segment that begins at `dimensions`. A survivor's throughput is raised for those that
    /// end.
    #[inline]
    fn survives(&mut self, dimensions: u32) -> bool {
        if self.segment <= ROULETTE_FROM {
            return true;
        }
        let mut survival = (self.beta.max_element() / self.roulette_below).min(1.0);
        if self.segment > LONG_PATH {
            survival = survival.min(survival_of_long_path(self.segment));
        }
        if survival < 1.0 {
            if self.sampler.get_1d(dimensions + dimension::ROULETTE) >= survival {
                return false;
            }
            self.beta /= survival;
        }
        true
    }
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
