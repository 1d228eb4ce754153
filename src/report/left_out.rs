//! What a scene does not need and is therefore left out, and what that saves: the same images rendered both ways, by turns.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::{Ratio, Timed, pairs};
use crate::rectify::InterfaceTable;
use crate::render::choice::{KnownAdapter, Work};
use crate::render::{Backend, Film, ImageSettings};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::{Mode, Prepared};

/// What is measured, and how long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeftOutPlan {
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    /// Pairs of slices, one with and one without.
    pub pairs: usize,
    /// Seconds of one slice, at least.
    pub slice_secs: f64,
    /// Whether each need that is left out is also put back alone.
    pub each: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Needs that the scene has not, by name.
    pub left_out: Vec<String>,
    pub width: u32,
    pub height: u32,
    /// Samples per pixel that the compared images had.
    pub samples: u32,
    /// Time of a sample with nothing left out over that of the shipped program. 1: nothing is saved.
    pub render: Ratio,
    /// Whether both images are the same to the last bit.
    pub images_are_equal: bool,
    /// Time of rectification with the pre-trace that is left out over that without; `None` where it is needed.
    pub rectify: Option<Ratio>,
    /// Whether rectification answered the same; `None` with `rectify`.
    pub tables_are_equal: Option<bool>,
    /// Needs put back one by one.
    pub each: Vec<OneNeed>,
    /// The same of the graphics processor; `None` without one, or where it cannot render the scene.
    #[serde(default)]
    pub graphics: Option<OnGraphics>,
}

/// What leaving out saves on the graphics processor, where it makes shaders shorter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OnGraphics {
    /// Name and interface.
    pub adapter: String,
    /// Whether it computes on the CPU.
    pub is_software: bool,
    /// As [`LeftOut::render`], without splits.
    pub render: Ratio,
    pub images_are_equal: bool,
    pub each: Vec<OneNeed>,
}

/// What leaving out one need saves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OneNeed {
    pub need: String,
    /// As [`LeftOut::render`], or of rectification for `nesting`.
    pub ratio: Ratio,
    pub images_are_equal: bool,
}

/// How a need is left out, in words; `None` for a name that is none.
pub fn how(need: &str) -> Option<&'static str> {
    Some(match need {
        "nesting" => "no pre-trace: nothing can lie in anything, so the answer is known without rays",
        "absorption" => "no distance is kept and no exponential taken on the way between surfaces",
        "index_matching" => "shadow rays stop at the first surface, because every surface bends light",
        "smooth_normals" => "no normals are kept, and none interpolated",
        "spheres" => {
            "always empty, costs nothing: the tree of spheres has no node, so that no switch can show a saving"
        }
        "triangles" => {
            "always empty, costs nothing: the tree of triangles has no node, so that no switch can show a saving"
        }
        "emitters" => {
            "there is no lamp to choose: neither way shoots a shadow ray towards one, so that no switch can show a saving"
        }
        "image_environment" => {
            "there is no image to choose directions from: neither way does, so that no switch can show a saving"
        }
        "textures" => "there is no image on a solid: neither way looks one up, so that no switch can show a saving",
        _ => return None,
    })
}

/// Whether tracing has a switch for the need. The other pieces are empty where they are not needed, or belong to rectification.
fn is_switched_while_tracing(need: &str) -> bool {
    matches!(need, "absorption" | "index_matching" | "smooth_normals" | "emitters" | "image_environment")
}

/// Measures one scene on the current pool. `None` when cancelled.
pub fn measure(
    prepared: &Prepared,
    camera: &Camera,
    plan: &LeftOutPlan,
    adapter: Option<&KnownAdapter>,
    progress: &Progress<'_>,
) -> Option<LeftOut> {
    let scene = &prepared.scene;
    let names = scene.needs.left_out();
    let by_cpu = Renders { prepared, camera, plan, backend: Backend::Cpu };
    let (render, images_are_equal, samples) = by_cpu.put_back(SceneNeeds::EVERYTHING, progress)?;
    let pretraced = if scene.needs.nesting { None } else { Some(pretrace(scene, plan, progress)?) };
    let (rectify, tables_are_equal) = pretraced.unzip();
    let each = by_cpu.each(progress)?;
    let graphics = match adapter {
        Some(adapter) => on_graphics(&Renders { backend: Backend::Gpu, ..by_cpu }, adapter, progress)?,
        None => None,
    };
    Some(LeftOut {
        left_out: names.into_iter().map(str::to_owned).collect(),
        width: plan.width,
        height: plan.height,
        samples,
        render,
        images_are_equal,
        rectify,
        tables_are_equal,
        each,
        graphics,
    })
}

/// What is rendered both ways.
#[derive(Clone, Copy)]
struct Renders<'a> {
    prepared: &'a Prepared,
    camera: &'a Camera,
    plan: &'a LeftOutPlan,
    backend: Backend,
}

impl Renders<'_> {
    fn settings(&self, leave_out: bool) -> ImageSettings {
        let usual = ImageSettings { leave_out, ..ImageSettings::new(Mode::Rectified, self.plan.seed) };
        let splits = if self.backend == Backend::Gpu { 0 } else { usual.splits };
        ImageSettings { backend: self.backend, splits, ..usual }
    }

    /// Each need put back alone, if that is wanted. `None` when cancelled.
    fn each(&self, progress: &Progress<'_>) -> Option<Vec<OneNeed>> {
        let scene = &self.prepared.scene;
        let mut each = Vec::new();
        for need in scene.needs.left_out().into_iter().filter(|_| self.plan.each) {
            // What the scene has no data for cannot be put back.
            let needs = scene.needs.with(need).without_impossible(scene);
            if is_switched_while_tracing(need) && needs != scene.needs {
                let (ratio, images_are_equal, _) = self.put_back(needs, progress)?;
                each.push(OneNeed { need: need.to_owned(), ratio, images_are_equal });
            }
        }
        Some(each)
    }

    /// The scene rendered with `needs` and with its own, by turns: time of a sample with `needs` over that with its own, whether the images are
    /// equal, and of how many samples per pixel they are. `None` when cancelled, or where the backend fails.
    fn put_back(&self, needs: SceneNeeds, progress: &Progress<'_>) -> Option<(Ratio, bool, u32)> {
        let Self { prepared, camera, plan, backend } = *self;
        let size = (plan.width, plan.height);
        let is_everything = needs == SceneNeeds::EVERYTHING;
        // All needs together are put back as `--leave-out off` does it.
        let changed = match is_everything {
            true => prepared.clone(),
            false => Prepared { scene: Arc::new(Scene { needs, ..Scene::clone(&prepared.scene) }), ..prepared.clone() },
        };
        let mut with = Timed::new(&changed, camera, self.settings(!is_everything), size);
        let mut without = Timed::new(prepared, camera, self.settings(true), size);
        if backend == Backend::Gpu {
            for timed in [&with, &without] {
                let settings = &[timed.settings];
                let size = [plan.width, plan.height];
                Work { prepared: timed.prepared, camera, settings, size, samples: None }.make_ready().ok()?;
            }
        }
        let samples = without.samples_for(plan.slice_secs, progress)?;
        // Both start again, so that they end with the same samples.
        without.film = Film::new(plan.width, plan.height);
        let times = pairs(plan.pairs, || with.slice(samples, progress), || without.slice(samples, progress))?;
        let is_by_it = [&with, &without].iter().all(|timed| timed.film.backend == Some(backend));
        is_by_it.then_some((Ratio::of(&times)?, are_equal(&with.film, &without.film), with.film.samples))
    }
}

/// `Some(None)` where it cannot render the scene; `None` when cancelled.
fn on_graphics(renders: &Renders<'_>, adapter: &KnownAdapter, progress: &Progress<'_>) -> Option<Option<OnGraphics>> {
    let found = renders.put_back(SceneNeeds::EVERYTHING, progress).and_then(|(render, images_are_equal, _)| {
        let KnownAdapter { label, is_software } = adapter.clone();
        Some(OnGraphics { adapter: label, is_software, render, images_are_equal, each: renders.each(progress)? })
    });
    (!progress.is_cancelled()).then_some(found)
}

/// Rectification with and without the pre-trace that a scene without nesting does not need.
fn pretrace(scene: &Scene, plan: &LeftOutPlan, progress: &Progress<'_>) -> Option<(Ratio, bool)> {
    let mut changed = scene.clone();
    changed.needs.nesting = true;
    let timed = |scene: &Scene| {
        // Small scenes are rectified in microseconds.
        let (start, mut rounds) = (Instant::now(), 0.0);
        while rounds == 0.0 || start.elapsed().as_secs_f64() < plan.slice_secs {
            std::hint::black_box(InterfaceTable::new(scene));
            rounds += 1.0;
        }
        (!progress.is_cancelled()).then(|| start.elapsed().as_secs_f64() / rounds)
    };
    let times = pairs(plan.pairs, || timed(&changed), || timed(scene))?;
    Some((Ratio::of(&times)?, InterfaceTable::new(scene).says_the_same(&InterfaceTable::new(&changed))))
}

/// Whether two films hold the same sums, to the last bit, of the same numbers of samples.
fn are_equal(a: &Film, b: &Film) -> bool {
    let bits = |film: &Film| -> Vec<[u64; 3]> { film.sums.iter().map(|s| s.to_array().map(f64::to_bits)).collect() };
    a.counts == b.counts && a.samples == b.samples && bits(a) == bits(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats;
    use crate::tracking::prepare;
    use std::sync::atomic::AtomicBool;

    fn measured(name: &str, plan: &LeftOutPlan, cancel: bool) -> Option<LeftOut> {
        let prepared = prepare(formats::open(name).unwrap().into(), None).unwrap();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let progress = Progress { cancel: &AtomicBool::new(cancel), tell: &|_, _| () };
        measure(&prepared, &camera, plan, None, &progress)
    }

    const PLAN: LeftOutPlan = LeftOutPlan { width: 16, height: 9, seed: 3, pairs: 2, slice_secs: 1e-4, each: true };

    #[test]
    fn what_is_left_out_changes_no_bit() {
        for name in ["plain-glass", "nested-spheres", "iced-water"] {
            let found = measured(name, &PLAN, false).unwrap();
            assert!(found.images_are_equal && found.samples > 0, "{name}");
            assert!(found.each.iter().all(|one| one.images_are_equal), "{name}: {:?}", found.each);
            assert!(found.render.median > 0.0 && found.render.low <= found.render.high);
            assert!(found.left_out.iter().all(|need| how(need).is_some()));
            assert_eq!(found.rectify.is_some(), found.left_out.iter().any(|need| need == "nesting"), "{name}");
            assert_ne!(found.tables_are_equal, Some(false), "{name}");
        }
        assert!(measured("plain-glass", &PLAN, true).is_none());
    }

    /// The twin: images that differ in one bit are told apart.
    #[test]
    fn one_bit_is_noticed() {
        let film = Film { samples: 1, ..Film::new(4, 4) };
        let mut other = film.clone();
        assert!(are_equal(&film, &other));
        other.sums[7].y = f64::from_bits(1);
        assert!(!are_equal(&film, &other));
        other = film.clone();
        other.sums[7].y = -0.0;
        assert!(!are_equal(&film, &other));
    }

    #[test]
    fn every_need_says_how_it_is_left_out() {
        assert!(SceneNeeds::EVERYTHING.named().iter().all(|(name, _)| how(name).is_some()));
        assert!(how("colour").is_none());
    }
}
