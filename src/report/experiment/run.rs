//! One film of one mode with one seed, looked at each time its samples have doubled.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::sums::Image;
use super::technique::Technique;
use crate::export::ExportError;
use crate::render::{Film, ImageSettings, RenderTask, fingerprint};
use crate::report::progress::Progress;
use crate::report::store::Store;
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// A film at each of the plan's sample counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    pub seed: u64,
    pub levels: Vec<Level>,
    /// At three quarters of the greatest sample count, so that its four quarters can be told apart.
    pub at_three_quarters: Image,
    pub events: Events,
}

/// A film at one sample count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Seconds of rendering up to here.
    pub render_secs: f64,
    pub image: Image,
}

impl Run {
    /// The last image, and what each quarter of its samples alone has come to. `None` of a run with fewer than four samples.
    pub fn quarters(&self) -> Option<(&Image, [Image; 4])> {
        let [.., first, half, whole] = &self.levels[..] else { return None };
        // Means of n samples and of the first m of them: the rest has the mean (n · of_n − m · of_m)/(n − m).
        let rest = |of_n: &[[f32; 3]], n: f32, of_m: &[[f32; 3]], m: f32| {
            let rest = |(x, y): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| (n * x[c] - m * y[c]) / (n - m));
            of_n.iter().zip(of_m).map(rest).collect::<Image>()
        };
        let quarters = [
            first.image.clone(),
            rest(&half.image, 2.0, &first.image, 1.0),
            rest(&self.at_three_quarters, 3.0, &half.image, 2.0),
            rest(&whole.image, 4.0, &self.at_three_quarters, 3.0),
        ];
        Some((&whole.image, quarters))
    }

    /// Whether all images are the same, to the bit.
    pub fn has_images_of(&self, other: &Self) -> bool {
        self.levels.len() == other.levels.len()
            && self.levels.iter().zip(&other.levels).all(|(a, b)| a.image == b.image)
    }
}

/// What runs are made from, but for their seeds.
#[derive(Clone, Copy)]
pub struct Maker<'a> {
    pub prepared: &'a Prepared,
    pub camera: &'a Camera,
    pub plan: &'a Plan,
    pub store: &'a Store,
}

impl Maker<'_> {
    /// Renders, unless `store` has it from earlier: by the same build, with as many threads. `Ok(None)` where `progress` was cancelled.
    ///
    /// # Errors
    /// When the run cannot be kept.
    pub fn run(
        &self,
        mode: Mode,
        technique: Technique,
        seed: u64,
        progress: Progress<'_>,
    ) -> Result<Option<Run>, ExportError> {
        let settings = technique.settings(mode, seed, self.plan.max_depth);
        let inputs = self.inputs(&settings, technique.adaptive);
        self.store.piece("run", &inputs, || Ok(self.render(&settings, technique.adaptive, progress)))
    }

    /// Removes what is kept of a run, if anything is.
    pub fn forget(&self, mode: Mode, technique: Technique, seed: u64) {
        let settings = technique.settings(mode, seed, self.plan.max_depth);
        self.store.forget("run", &self.inputs(&settings, technique.adaptive));
    }

    /// All that decides a run's images, and the number of threads, which decides its times.
    fn inputs(&self, settings: &ImageSettings, adaptive: bool) -> impl Serialize {
        let image = fingerprint(&self.prepared.description, self.camera, self.plan.size, settings);
        (image, adaptive, &self.plan.spp, rayon::current_num_threads())
    }

    fn render(&self, settings: &ImageSettings, adaptive: bool, progress: Progress<'_>) -> Option<Run> {
        let [width, height] = self.plan.size;
        let mut film = if adaptive { Film::adaptive(width, height) } else { Film::new(width, height) };
        let mut render_secs = 0.0;
        let mut levels = Vec::with_capacity(self.plan.spp.len());
        let three_quarters = self.plan.largest_spp() / 4 * 3;
        let mut at_three_quarters = Vec::new();
        for &spp in &self.plan.spp {
            while film.samples < spp {
                let stop = if film.samples < three_quarters { spp.min(three_quarters) } else { spp };
                let samples = (stop - film.samples).min(film.samples_to_decision());
                let start = Instant::now();
                let task = RenderTask { prepared: self.prepared, camera: self.camera, settings };
                if !task.pass(&mut film, samples, progress.cancel) {
                    return None;
                }
                Film::allocate(&mut [&mut film]);
                render_secs += start.elapsed().as_secs_f64();
                if film.samples == three_quarters {
                    at_three_quarters = film.to_rgb();
                }
            }
            levels.push(Level { render_secs, image: film.to_rgb() });
        }
        Some(Run { seed: settings.seed, levels, at_three_quarters, events: film.events })
    }
}
