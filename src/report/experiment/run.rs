//! One film of one mode with one seed, looked at each time its samples have doubled.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::data::Technique;
use super::plan::Plan;
use crate::export::ExportError;
use crate::render::{Cpu, Film, ImageSettings, RenderTask, Renderer, fingerprint};
use crate::report::checked::{Reader, Writer};
use crate::report::progress::Progress;
use crate::report::store::Store;
use crate::scene::camera::Camera;
use crate::scene::fingerprint::Hasher;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// Linear RGB, row 0 at the top.
pub type Image = Vec<[f32; 3]>;

/// A film at each of the plan's sample counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    pub seed: u64,
    pub levels: Vec<Level>,
    /// At three quarters of the greatest sample count, so that its four quarters can be told apart.
    pub at_three_quarters: Image,
    pub events: Events,
}

/// A film at one sample count.
#[derive(Debug, Clone, PartialEq)]
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
        let path = self.path(&settings, technique.adaptive);
        if let Some(run) = self.read(&path, seed) {
            return Ok(Some(run));
        }
        let Some(run) = self.render(&settings, technique.adaptive, progress) else { return Ok(None) };
        write(&path, &run)?;
        Ok(Some(run))
    }

    /// Removes what is kept of a run, if anything is.
    pub fn forget(&self, mode: Mode, technique: Technique, seed: u64) {
        let path = self.path(&technique.settings(mode, seed, self.plan.max_depth), technique.adaptive);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                log::warn!("{}: cannot be removed ({error}); it is of no more use", path.display());
            }
            _ => {}
        }
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
                if !Cpu.pass(
                    &RenderTask { prepared: self.prepared, camera: self.camera, settings },
                    &mut film,
                    samples,
                    progress.cancel,
                ) {
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

    fn path(&self, settings: &ImageSettings, adaptive: bool) -> PathBuf {
        let mut hasher = Hasher::new("iorect run 2");
        hasher.fingerprint(fingerprint(&self.prepared.description, self.camera, self.plan.size, settings));
        hasher.flag(adaptive);
        hasher.integer(self.plan.spp.len() as u64);
        self.plan.spp.iter().for_each(|&spp| hasher.integer(u64::from(spp)));
        // Decides no image, but every time.
        hasher.integer(rayon::current_num_threads() as u64);
        self.store.file("run", hasher.finish())
    }

    /// `None` where nothing fitting is kept.
    fn read(&self, path: &Path, seed: u64) -> Option<Run> {
        let mut reader = Reader::open(path)?;
        let run = self.parse(&mut reader, seed).filter(|_| reader.is_at_end());
        if run.is_none() {
            log::warn!("{}: is not the run that its name says; it is made again", path.display());
        }
        run
    }

    fn parse(&self, reader: &mut Reader, seed: u64) -> Option<Run> {
        let events = reader.events()?;
        let pixels = self.plan.size.iter().map(|&side| side as usize).product();
        let at_three_quarters = parse_image(reader, pixels)?;
        let mut level = || Some(Level { render_secs: reader.number()?, image: parse_image(reader, pixels)? });
        let levels = (0..self.plan.spp.len()).map(|_| level()).collect::<Option<_>>()?;
        Some(Run { seed, levels, at_three_quarters, events })
    }
}

fn parse_image(reader: &mut Reader, pixels: usize) -> Option<Vec<[f32; 3]>> {
    (0..pixels).map(|_| Some([reader.single()?, reader.single()?, reader.single()?])).collect()
}

fn write(path: &Path, run: &Run) -> Result<(), ExportError> {
    let mut writer = Writer::default();
    writer.events(&run.events);
    run.at_three_quarters.iter().flatten().for_each(|&component| writer.single(component));
    for Level { render_secs, image } in &run.levels {
        writer.number(*render_secs);
        image.iter().flatten().for_each(|&component| writer.single(component));
    }
    writer.keep(path)
}
