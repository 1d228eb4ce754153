//! How time and memory grow with the size of a scene, and time with the number of threads.

mod scenes;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::machine::{available_bytes, forget_peak, peak_bytes, resident_bytes};
use super::progress::Progress;
use super::timing::Timed;
use crate::measure::statistics::power_law;
use crate::render::ImageSettings;
use crate::scene::camera::Camera;
use crate::scene::{Description, SceneError};
use crate::tracking::Mode;
use crate::tracking::{Prepared, prepare};

/// Least memory that can be measured: below it the allocator's reserves hide it.
const LEAST_MEMORY: u64 = 16 << 20;
/// Bytes that a triangle takes at most while a scene is prepared, with room to spare.
const BYTES_PER_TRIANGLE: u64 = 450;

/// What grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    Triangles,
    Nesting,
    Objects,
    Threads,
}

impl Quantity {
    pub const ALL: [Self; 4] = [Self::Triangles, Self::Nesting, Self::Objects, Self::Threads];

    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Nesting => "nesting",
            Self::Objects => "objects",
            Self::Threads => "threads",
        }
    }

    /// The scene that grows, in one sentence.
    pub fn about(self) -> &'static str {
        match self {
            Self::Triangles => "Four nested tori of glass and water, as meshes, divided more and more finely.",
            Self::Nesting => {
                "A Luneburg lens of more and more concentric spheres: a path through it crosses most of them."
            }
            Self::Objects => {
                "More and more balls of glass in a block of water: each must be told what it lies in, and no other ball is it."
            }
            Self::Threads => "The built-in scene that opens by default, on more and more threads.",
        }
    }
}

/// How far, and how long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GrowthPlan {
    pub triangles: Vec<u64>,
    pub nesting: Vec<u64>,
    pub objects: Vec<u64>,
    pub threads: Vec<u64>,
    /// Pixels of the images that are timed.
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    /// Slices of which the median is taken, and seconds of each, at least.
    pub slices: usize,
    pub slice_secs: f64,
}

impl GrowthPlan {
    /// The sizes of one quantity, ascending.
    pub fn sizes(&self, quantity: Quantity) -> &[u64] {
        match quantity {
            Quantity::Triangles => &self.triangles,
            Quantity::Nesting => &self.nesting,
            Quantity::Objects => &self.objects,
            Quantity::Threads => &self.threads,
        }
    }
}

/// One size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GrowthPoint {
    /// As asked for; what the scene comes to where that is not quite possible.
    pub size: u64,
    /// Seconds of tessellating, analysing meshes and building the tree.
    pub build_secs: f64,
    /// Seconds of rectification.
    pub rectify_secs: f64,
    /// Seconds of one sample of one pixel, on all threads together.
    pub sample_secs: f64,
    /// By how much the memory of this process rose for the prepared scene, in bytes; `None` where it cannot be found out or is too little to
    /// be told from the allocator's reserves. What earlier scenes have left in those is used again and does not count: a few hundredths of
    /// the whole at ten million triangles, up to half of it at a million.
    pub memory_bytes: Option<u64>,
    /// The same of the most that it had while the scene was being prepared.
    pub peak_bytes: Option<u64>,
}

/// What is measured at a size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    Build,
    Rectify,
    Sample,
    Memory,
}

impl Measure {
    pub const ALL: [Self; 4] = [Self::Build, Self::Rectify, Self::Sample, Self::Memory];

    pub fn name(self) -> &'static str {
        match self {
            Self::Build => "build",
            Self::Rectify => "rectify",
            Self::Sample => "sample",
            Self::Memory => "memory",
        }
    }

    /// In seconds or bytes.
    pub fn of(self, point: &GrowthPoint) -> Option<f64> {
        match self {
            Self::Build => Some(point.build_secs),
            Self::Rectify => Some(point.rectify_secs),
            Self::Sample => Some(point.sample_secs),
            Self::Memory => point.memory_bytes.map(|bytes| bytes as f64),
        }
    }
}

/// y ~ size^exponent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exponent {
    pub measure: Measure,
    pub exponent: f64,
    /// 95 % interval, if the points scatter independently about the line.
    pub low: f64,
    pub high: f64,
    /// The fit begins here: smaller sizes are decided by what does not grow.
    pub from_size: u64,
    pub points: usize,
}

/// One quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    pub quantity: Quantity,
    pub points: Vec<GrowthPoint>,
    pub exponents: Vec<Exponent>,
    /// Sizes that did not fit into this machine's memory.
    pub too_large: Vec<u64>,
}

impl Growth {
    /// Fits the exponents of what was measured.
    pub fn of(quantity: Quantity, points: Vec<GrowthPoint>, too_large: Vec<u64>) -> Self {
        let exponents = Measure::ALL.into_iter().filter_map(|measure| exponent(quantity, measure, &points)).collect();
        Self { quantity, points, exponents, too_large }
    }
}

/// Over the larger half of the sizes, counted in decades, of which there must be three that were measured. Of threads, time per sample
/// alone grows, from the first.
pub fn exponent(quantity: Quantity, measure: Measure, points: &[GrowthPoint]) -> Option<Exponent> {
    if quantity == Quantity::Threads && measure != Measure::Sample {
        return None;
    }
    let (first, last) = (points.first()?.size as f64, points.last()?.size as f64);
    let from = if quantity == Quantity::Threads { first } else { (first * last).sqrt() };
    let (sizes, values): (Vec<f64>, Vec<f64>) = (points.iter())
        .filter(|point| point.size as f64 >= from)
        .filter_map(|point| Some((point.size as f64, measure.of(point)?)))
        .unzip();
    let law = power_law(&sizes, &values)?;
    let [low, high] = [law.exponent.low, law.exponent.high];
    Some(Exponent {
        measure,
        exponent: law.exponent.value,
        low,
        high,
        from_size: *sizes.first()? as u64,
        points: sizes.len(),
    })
}

/// Whether a size can be measured on this machine.
pub fn fits(quantity: Quantity, size: u64) -> bool {
    quantity != Quantity::Triangles
        || available_bytes().is_none_or(|available| size.saturating_mul(BYTES_PER_TRIANGLE) < available)
}

/// Measures one size on the current pool, or, of threads, on a pool of so many. `None` when cancelled.
///
/// # Errors
/// When a scene cannot be made; those here can.
pub fn measure(
    quantity: Quantity,
    size: u64,
    plan: &GrowthPlan,
    progress: &Progress<'_>,
) -> Result<Option<GrowthPoint>, SceneError> {
    let (description, size) = scenes::of(quantity, size)?;
    if quantity != Quantity::Threads {
        return of_scene(description, size, plan, progress);
    }
    let description = &description;
    let work = || of_scene(description.clone(), size, plan, progress);
    match rayon::ThreadPoolBuilder::new().num_threads(size as usize).build() {
        Ok(pool) => pool.install(work),
        // A system that refuses so many threads has no time to tell.
        Err(error) => {
            log::warn!("{size} threads cannot be started: {error}");
            Ok(None)
        }
    }
}

fn of_scene(
    description: Description,
    size: u64,
    plan: &GrowthPlan,
    progress: &Progress<'_>,
) -> Result<Option<GrowthPoint>, SceneError> {
    let camera = Camera::new(&description.camera)?;
    let (before, has_forgotten) = (resident_bytes(), forget_peak());
    let prepared = prepare(Arc::new(description), None)?;
    let (after, peak) = (resident_bytes(), peak_bytes().filter(|_| has_forgotten));
    let rise = |to: Option<u64>| to?.checked_sub(before?).filter(|&bytes| bytes >= LEAST_MEMORY);
    let (memory_bytes, peak_bytes) = (rise(after), rise(peak));
    let (build_secs, rectify_secs) = best_of_preparing(&prepared, plan)?;
    let settings = ImageSettings::new(Mode::Rectified, plan.seed);
    let mut timed = Timed::new(&prepared, &camera, settings, (plan.width, plan.height));
    let sample_secs = timed.sample_secs(plan.slices, plan.slice_secs, progress);
    Ok(sample_secs.map(|sample_secs| GrowthPoint {
        size,
        build_secs,
        rectify_secs,
        sample_secs,
        memory_bytes,
        peak_bytes,
    }))
}

/// The least times of preparing the scene, which small scenes do several times: the first time pays for pages of memory.
fn best_of_preparing(prepared: &Prepared, plan: &GrowthPlan) -> Result<(f64, f64), SceneError> {
    let mut best = prepared.seconds;
    let mut spent = best.bvh + best.rectify;
    let mut rounds = 1;
    while rounds < 10 && spent < plan.slice_secs {
        let seconds = prepare(Arc::clone(&prepared.description), None)?.seconds;
        best.bvh = best.bvh.min(seconds.bvh);
        best.rectify = best.rectify.min(seconds.rectify);
        spent += seconds.bvh + seconds.rectify;
        rounds += 1;
    }
    Ok((best.bvh, best.rectify))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    fn plan() -> GrowthPlan {
        GrowthPlan {
            triangles: vec![1000, 3000],
            nesting: vec![1, 30],
            objects: vec![1, 27],
            threads: vec![1, 2],
            width: 8,
            height: 8,
            seed: 1,
            slices: 1,
            slice_secs: 1e-5,
        }
    }

    #[test]
    fn every_quantity_is_measured_at_the_size_that_was_asked_for() {
        let progress = Progress { cancel: &AtomicBool::new(false), tell: &|_, _| () };
        for quantity in Quantity::ALL {
            for &size in plan().sizes(quantity) {
                let point = measure(quantity, size, &plan(), &progress).unwrap().unwrap();
                let part = point.size as f64 / size as f64;
                assert!((0.9..1.1).contains(&part), "{quantity:?}: {} for {size}", point.size);
                assert!(point.build_secs > 0.0 && point.rectify_secs > 0.0 && point.sample_secs > 0.0, "{point:?}");
            }
        }
        let cancelled = Progress { cancel: &AtomicBool::new(true), ..progress };
        assert!(measure(Quantity::Objects, 1, &plan(), &cancelled).unwrap().is_none());
    }

    /// A law that is known, with a constant that small sizes show.
    #[test]
    fn exponents_are_those_of_the_larger_sizes() {
        let point = |size: u64| GrowthPoint {
            size,
            build_secs: 1.0 + 1e-6 * (size as f64).powf(1.5),
            rectify_secs: 0.25,
            sample_secs: 2.0 / size as f64,
            memory_bytes: (size > 1_000_000).then_some(100 * size),
            peak_bytes: None,
        };
        let points: Vec<_> = (6..=16).map(|k| point(10_u64.pow(k / 2) * if k % 2 == 1 { 3 } else { 1 })).collect();
        let growth = Growth::of(Quantity::Triangles, points, Vec::new());
        let of = |measure| growth.exponents.iter().find(|exponent| exponent.measure == measure).unwrap();
        assert!((of(Measure::Build).exponent - 1.5).abs() < 0.01, "{:?}", of(Measure::Build));
        assert!(of(Measure::Rectify).exponent.abs() < 1e-9);
        assert!((of(Measure::Sample).exponent + 1.0).abs() < 1e-9);
        assert!((of(Measure::Memory).exponent - 1.0).abs() < 1e-9);
        assert!(of(Measure::Build).from_size >= 300_000);
        assert!(Growth::of(Quantity::Triangles, Vec::new(), Vec::new()).exponents.is_empty());
    }

    #[test]
    fn what_cannot_fit_is_known_before() {
        assert!(fits(Quantity::Triangles, 1000) && fits(Quantity::Nesting, u64::MAX));
        #[cfg(target_os = "linux")]
        assert!(!fits(Quantity::Triangles, u64::MAX / 1000));
    }
}
