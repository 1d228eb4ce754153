//! The path tracer on a graphics processor: the same samples as the CPU's without splitting, in f32.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::device::GpuDevice;
use super::dispatch::{Band, Dispatcher, FilmBuffers, GROUP};
use super::fault::GpuFault;
use super::layout;
use super::pace::{Pace, Tally};
use super::pipeline::{Pipelines, Replacement, STORAGE_BUFFERS};
use super::shader::Variant;
use super::tables;
use super::upload::{CannotUpload, SceneOnGpu};
use crate::rectify::containment::medium_at;
use crate::rectify::start::StartRegion;
use crate::render::film::Film;
use crate::render::renderer::{RenderTask, Renderer, Unsupported};
use crate::render::settings::{Backend, Estimator};
use crate::scene::needs::SceneNeeds;
use crate::scene::{MediumId, Surface};
use crate::tracking::{Events, Mode};
use crate::transport::sampler::{Sampler, Sequence};

/// Scenes that are kept on the device: one for each pane of the window.
const KEPT_SCENES: usize = 6;
/// Buffers that are kept for the next passes.
const KEPT_BUFFERS: usize = 4;
/// Entries of a path's state, at the most.
const MOST_TRACKER_ROOM: u32 = 512;
/// Entries beyond one for each refractor: a refractor that intersects itself is entered several times.
const SPARE_TRACKER_ROOM: u32 = 6;
/// Pixels whose sums are brought back at once, at the most.
const MOST_PIXELS: u32 = 1 << 20;
/// Bytes of one buffer that they take, at the most.
const MOST_BYTES: u64 = 64 << 20;
/// A band has the rows of so many dispatches in which its paths are started. So the last paths of many rows, which take long, are followed
/// together; and no more than a band is lost when a pass is cancelled.
const BAND: u32 = 8;
/// Samples that are summed in f32, at the most.
const MOST_SUMMED: u32 = 64;

/// Renders on one device. Made once for each, and shared: it keeps scenes and compiled shaders.
#[derive(Debug)]
pub struct Gpu {
    pub device: Arc<GpuDevice>,
    pub(super) pipelines: Pipelines,
    scenes: Mutex<Vec<Arc<SceneOnGpu>>>,
    /// Held by who brings a scene onto the device.
    making: Mutex<()>,
    /// Those that no pass uses.
    buffers: Mutex<Vec<FilmBuffers>>,
    /// Why a pass was not finished.
    fault: Mutex<Option<GpuFault>>,
    pace: Mutex<Pace>,
    /// Shaders that have run: drivers may put off some of the compiling until then.
    warm: Mutex<HashSet<Variant>>,
}

impl Gpu {
    pub fn new(device: Arc<GpuDevice>) -> Self {
        Self::with_replacement(device, None)
    }

    /// With shaders whose text is changed: for tests, which plant faults.
    pub fn with_replacement(device: Arc<GpuDevice>, replacement: Option<Replacement>) -> Self {
        let pipelines = Pipelines::new(&device, replacement);
        Self {
            pace: Mutex::new(Pace::new(device.adapter.is_software)),
            device,
            pipelines,
            scenes: Mutex::default(),
            making: Mutex::default(),
            buffers: Mutex::default(),
            fault: Mutex::default(),
            warm: Mutex::default(),
        }
    }

    /// What went wrong, if anything has.
    pub fn fault(&self) -> Option<GpuFault> {
        lock(&self.fault).clone().or_else(|| self.device.fault())
    }

    /// What has been done so far.
    pub fn tally(&self) -> Tally {
        lock(&self.pace).tally()
    }

    fn kept(&self, task: &RenderTask<'_>) -> Option<Arc<SceneOnGpu>> {
        let scenes = lock(&self.scenes);
        scenes.iter().find(|scene| scene.is_of(task.prepared, task.settings.mode)).cloned()
    }

    /// The scene on the device, where it stays until others take its place.
    pub(super) fn scene(&self, task: &RenderTask<'_>) -> Result<Arc<SceneOnGpu>, CannotUpload> {
        if let Some(scene) = self.kept(task) {
            return Ok(scene);
        }
        // Whoever wants the same meanwhile waits for it.
        let _making = lock(&self.making);
        if let Some(scene) = self.kept(task) {
            return Ok(scene);
        }
        let others = lock(&self.scenes).clone();
        let scene = Arc::new(SceneOnGpu::new(&self.device, task.prepared, task.settings.mode, &others)?);
        let mut scenes = lock(&self.scenes);
        scenes.retain(|scene| scene.is_wanted());
        scenes.insert(0, Arc::clone(&scene));
        scenes.truncate(KEPT_SCENES);
        Ok(scene)
    }

    /// Buffers for that many pixels: those of an earlier pass, if no other pass uses them.
    fn film_buffers(&self, pixels: u32, tracker_words: u32) -> Result<Lent<'_>, GpuFault> {
        let mut kept = lock(&self.buffers);
        let buffers = match kept.iter().position(|buffers| buffers.have_room(pixels, tracker_words)) {
            Some(index) => kept.swap_remove(index),
            None => {
                drop(kept);
                FilmBuffers::new(&self.device, pixels, tracker_words)?
            }
        };
        Ok(Lent { buffers: Some(buffers), owner: &self.buffers })
    }

    /// Renders on the device. `None` in place of events: the row was not finished. What is finished is in the film.
    fn render(
        &self,
        task: &RenderTask<'_>,
        film: &mut Film,
        samples: u32,
        cancel: &AtomicBool,
        rows: &mut [Option<Events>],
    ) -> Result<(), GpuFault> {
        let scene = self.scene(task).map_err(|error| match error {
            CannotUpload::DoesNotFit(what) => GpuFault::Refused(format!("{what} does not fit")),
            CannotUpload::Fault(fault) => fault,
        })?;
        let variant = variant(task, scene.tree_depth());
        let pipeline = self.pipelines.get(&self.device, &variant)?;
        let (mut image, is_ambiguous) = image(task, film);
        let ranges = sample_ranges(film, samples);
        // Of all pixels, the one with the most samples decides how long a row takes.
        let count = match &ranges {
            Some(ranges) => ranges.iter().map(|[first, last]| last - first).max().unwrap_or(0),
            None => samples,
        };
        image.has_ranges = u32::from(ranges.is_some());
        (image.first_sample, image.last_sample) = (film.first + film.samples, film.first + film.samples + samples);
        let (width, height) = (film.width, film.height);
        let words = variant.tracker_words();
        let fitting = (MOST_BYTES / FilmBuffers::bytes_per_pixel(words)) as u32;
        let most_rows = (fitting.min(MOST_PIXELS) / width.max(1)).clamp(1, height.max(1));
        let buffers = self.film_buffers(width * most_rows, words)?;
        let dispatcher =
            Dispatcher::new(&self.device, &self.pipelines, &scene, &pipeline, &buffers, ranges.as_deref())?;
        let mut first_row = 0;
        while first_row < height {
            let row_count = (BAND * self.rows_at_once(width)).min(most_rows).min(height - first_row);
            let part = layout::Image { first_row, row_count, ..image };
            // Where sums are exact each sample is added by itself, and taken back if the band is not finished.
            let pixels = (first_row * width) as usize..((first_row + row_count) * width) as usize;
            let before = film.exact.as_ref().map(|exact| {
                (
                    film.sums[pixels.clone()].to_vec(),
                    film.counts[pixels.clone()].to_vec(),
                    exact.sums[pixels.clone()].to_vec(),
                )
            });
            let result = self.render_band(&dispatcher, &part, count, film, is_ambiguous, cancel);
            if let Ok(Some(events)) = result {
                rows[first_row as usize..(first_row + row_count) as usize].fill(Some(Events::default()));
                // Those of the whole band are counted with its first row.
                rows[first_row as usize] = Some(events);
            } else {
                if let (Some((sums, counts, exact)), Some(target)) = (before, &mut film.exact) {
                    film.sums[pixels.clone()].copy_from_slice(&sums);
                    film.counts[pixels.clone()].copy_from_slice(&counts);
                    target.sums[pixels].copy_from_slice(&exact);
                }
                return result.map(|_| ());
            }
            first_row += row_count;
        }
        Ok(())
    }

    /// Renders `count` samples of each pixel of a band, and adds them to the film. `None`: it was cancelled.
    fn render_band(
        &self,
        dispatcher: &Dispatcher<'_>,
        band: &layout::Image,
        count: u32,
        film: &mut Film,
        is_ambiguous: bool,
        cancel: &AtomicBool,
    ) -> Result<Option<Events>, GpuFault> {
        let most_summed = if film.exact.is_some() { 1 } else { MOST_SUMMED };
        let mut events = Events::default();
        let mut sums = Band::new(band.width, band.row_count);
        let mut samples_before = 0;
        while samples_before < count {
            let sample_count = most_summed.min(count - samples_before);
            let part = layout::Image { sample_count, samples_before, ..*band };
            if !self.follow_to_end(dispatcher, part, &mut sums, cancel)? {
                return Ok(None);
            }
            let before = sums.segments();
            dispatcher.bring_back(&mut sums)?;
            lock(&self.pace).count_segments(sums.segments() - before);
            if film.exact.is_some() {
                events += add_band(film, band.first_row, &sums, is_ambiguous);
                sums.clear();
            }
            samples_before += sample_count;
        }
        events += add_band(film, band.first_row, &sums, is_ambiguous);
        Ok(Some(events))
    }

    /// Starts the paths of a band and follows them to their ends, in dispatches of the time of a slice. Returns `false` if it was cancelled.
    fn follow_to_end(
        &self,
        dispatcher: &Dispatcher<'_>,
        band: layout::Image,
        sums: &mut Band,
        cancel: &AtomicBool,
    ) -> Result<bool, GpuFault> {
        let mut part = layout::Image { is_start: 1, ..band };
        let (mut row, mut open) = (0, 0);
        while row < band.row_count {
            part.row_count = self.rows_at_once(band.width).min(band.row_count - row);
            (part.first_place, part.list_out) = (row * band.width, open);
            let Some(left) = self.dispatch(dispatcher, part, sums, cancel)? else { return Ok(false) };
            open += left;
            row += part.row_count;
        }
        part.is_start = 0;
        // The list has two halves: of those paths in one half that are interrupted again, the other is made.
        let pixels = band.width * band.row_count;
        let (mut from, mut to) = (0, pixels);
        while open > 0 {
            let (mut taken, mut still_open) = (0, 0);
            while taken < open {
                part.path_count = lock(&self.pace).threads().max(GROUP * GROUP).min(open - taken);
                (part.list_in, part.list_out) = (from + taken, to + still_open);
                let Some(left) = self.dispatch(dispatcher, part, sums, cancel)? else { return Ok(false) };
                still_open += left;
                taken += part.path_count;
            }
            open = still_open;
            (from, to) = (to, from);
        }
        Ok(true)
    }

    /// One dispatch. Returns how many of its paths are not at their ends; `None` if it was cancelled.
    fn dispatch(
        &self,
        dispatcher: &Dispatcher<'_>,
        mut part: layout::Image,
        sums: &mut Band,
        cancel: &AtomicBool,
    ) -> Result<Option<u32>, GpuFault> {
        if cancel.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let threads = if part.is_start == 1 { part.width * part.row_count } else { part.path_count };
        part.most_steps = lock(&self.pace).steps(threads);
        let start = Instant::now();
        let ran = dispatcher.run(&part, sums)?;
        lock(&self.pace).learn(ran.steps, ran.open, start.elapsed());
        Ok(Some(ran.open))
    }

    /// Rows of an image whose paths one dispatch starts.
    fn rows_at_once(&self, width: u32) -> u32 {
        let rows = lock(&self.pace).threads() / width.max(1);
        rows.clamp(GROUP, MOST_PIXELS).next_multiple_of(GROUP)
    }
}

impl Renderer for Gpu {
    fn require(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        let RenderTask { prepared, camera, settings } = *task;
        let scene = &*prepared.scene;
        if settings.estimator != Estimator::Path {
            return Err(unsupported(&format!("estimator {}", settings.estimator.name()), "use the CPU"));
        }
        if !Variant::has_mode(settings.mode) {
            return Err(unsupported(&format!("mode {}", settings.mode), "the CPU renders it"));
        }
        if self.device.limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            let what = format!("anything on {}, whose shaders reach too few tables,", self.device.adapter.name);
            return Err(unsupported(&what, "use the CPU"));
        }
        if settings.mode == Mode::Rectified {
            let name = |object: crate::scene::ObjectId| scene.object(object).name.clone();
            if let Some(refractor) = prepared.table.asks_more_than_a_ray(scene) {
                let what =
                    format!("{}, whose mesh has holes or overlaps itself where others cross it,", name(refractor));
                return Err(unsupported(&what, "use the CPU, or repair the mesh"));
            }
            if prepared.table.flat().layout.unlisted > 0 {
                let crowded = prepared.table.crowded();
                let where_ = crowded.first().map_or_else(|| "a face".into(), |(object, _)| name(*object));
                let what = format!("a place on {where_} at which too many refractors meet");
                return Err(unsupported(&what, "use the CPU"));
            }
        }
        let position = camera.position - scene.geometry.origin;
        if starts(task, position).whole().is_none() {
            return Err(unsupported("a camera on the surface of a refractor", "use the CPU, or move the camera"));
        }
        let reach = (position.abs().max_element() + camera.focus_distance) * tables::scale_of(&scene.geometry);
        if reach > 1e18 {
            return Err(unsupported("a camera so far from the scene", "use the CPU"));
        }
        if let Some(fault) = self.device.fault() {
            return Err(unsupported("anything any more", &fault.to_string()));
        }
        Ok(())
    }

    fn is_ready(&self, task: &RenderTask<'_>) -> bool {
        let is_compiled = |tree_depth| lock(&self.warm).contains(&variant(task, tree_depth));
        match self.kept(task) {
            Some(scene) => is_compiled(scene.tree_depth()),
            // To bring an edited scene onto the device takes little, and its tree is about as deep as it was.
            None => lock(&self.scenes).iter().any(|scene| is_compiled(scene.tree_depth())),
        }
    }

    fn make_ready(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        self.require(task)?;
        let scene = self.scene(task).map_err(|error| match error {
            CannotUpload::DoesNotFit(what) => unsupported(&what, "use the CPU"),
            CannotUpload::Fault(fault) => unsupported("this scene", &format!("{fault}; use the CPU")),
        })?;
        let variant = variant(task, scene.tree_depth());
        if lock(&self.warm).contains(&variant) {
            return Ok(());
        }
        let compiled = self.pipelines.get(&self.device, &variant);
        let mut film = Film::new(1, 1);
        let ran = compiled.and_then(|_| self.render(task, &mut film, 1, &AtomicBool::new(false), &mut [None]));
        ran.map_err(|fault| unsupported("this scene", &format!("{fault}; use the CPU")))?;
        lock(&self.warm).insert(variant);
        Ok(())
    }

    fn pass(&self, task: &RenderTask<'_>, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        let mut rows = vec![None; film.height as usize];
        let result = self.render(task, film, samples, cancel, &mut rows);
        if film.finish_pass(samples, &rows) {
            return true;
        }
        // Rows that are finished stay: whoever goes on takes what is missing of the same samples.
        if let Err(fault) = result {
            log::warn!("{fault}");
            *lock(&self.fault) = Some(fault);
        }
        false
    }
}

/// Buffers that a pass uses and gives back.
struct Lent<'a> {
    buffers: Option<FilmBuffers>,
    owner: &'a Mutex<Vec<FilmBuffers>>,
}

impl std::ops::Deref for Lent<'_> {
    type Target = FilmBuffers;

    fn deref(&self) -> &FilmBuffers {
        self.buffers.as_ref().expect("they are given back when this is dropped")
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let mut kept = lock(self.owner);
        kept.extend(self.buffers.take());
        let excess = kept.len().saturating_sub(KEPT_BUFFERS);
        kept.drain(..excess);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unsupported(what: &str, instead: &str) -> Unsupported {
    Unsupported { what: what.into(), backend: Backend::Gpu, instead: instead.into() }
}

/// The media that rays start in, for a camera at `position` (local coordinates).
fn starts(task: &RenderTask<'_>, position: glam::DVec3) -> StartRegion {
    let scene = &*task.prepared.scene;
    let told =
        (task.settings.mode == Mode::Declared).then(|| (scene.declared.camera.unwrap_or(MediumId::WORLD), false));
    let ask = |point| told.unwrap_or_else(|| medium_at(scene, point));
    StartRegion::by_asking(scene, position, task.camera.aperture_radius, &ask)
}

/// What the shader of a task has to do.
pub(super) fn variant(task: &RenderTask<'_>, tree_depth: u32) -> Variant {
    let RenderTask { prepared, settings, .. } = *task;
    let (scene, table) = (&*prepared.scene, &*prepared.table);
    let needs = if settings.leave_out { scene.needs } else { SceneNeeds::EVERYTHING.without_impossible(scene) };
    let mode = settings.mode;
    let is_rectified = mode == Mode::Rectified;
    let flat = &*table.flat().layout;
    let can_skip = mode == Mode::Priority || (is_rectified && table.has_passable());
    let refractors = scene.objects.iter().filter(|object| matches!(object.surface, Surface::Refractor { .. })).count();
    // Rounded up, so that scenes that differ little share a shader.
    let up = |number: u32, step: u32| number.div_ceil(step) * step;
    let room = up(refractors as u32 + SPARE_TRACKER_ROOM, 8).min(MOST_TRACKER_ROOM);
    Variant {
        mode,
        tree_depth: up(tree_depth.max(1), 8),
        tracker_room: if Variant::has_state(mode) { room } else { 0 },
        triangles: needs.triangles,
        spheres: needs.spheres,
        smooth_normals: needs.smooth_normals,
        absorption: needs.absorption,
        masked: is_rectified && table.mask().is_some(),
        divided_faces: is_rectified && !flat.faces.is_empty(),
        asked_cells: is_rectified && !flat.asked.is_empty(),
        can_pass: needs.index_matching || can_skip,
        emitters: needs.emitters,
        suns: scene.emitters.has_suns(),
        textures: needs.textures,
        sampled_environment: needs.image_environment && settings.sample_environment,
        environment_kind: match &scene.environment {
            crate::scene::lights::EnvironmentLight::Constant(_) => 0,
            crate::scene::lights::EnvironmentLight::Gradient { .. } => 1,
            crate::scene::lights::EnvironmentLight::Image(_) => 2,
        },
        independent: settings.sampler == Sequence::Independent,
    }
}

/// The image as the shader is given it, but for the part that is rendered; and whether the medium that paths start in is in doubt.
pub(super) fn image(task: &RenderTask<'_>, film: &Film) -> (layout::Image, bool) {
    let RenderTask { prepared, camera, settings } = *task;
    let scene = &*prepared.scene;
    let position = camera.position - scene.geometry.origin;
    let (start_medium, is_ambiguous) = starts(task, position).whole().unwrap_or((MediumId::WORLD, true));
    let scale = tables::scale_of(&scene.geometry);
    let f32s = |v: glam::DVec3| v.as_vec3().to_array();
    let image = layout::Image {
        position: f32s(position * scale),
        aperture_radius: (camera.aperture_radius * scale) as f32,
        forward: f32s(camera.forward),
        focus_distance: (camera.focus_distance * scale) as f32,
        right: f32s(camera.right),
        scale: (2.0 * camera.tan_half_fov / f64::from(film.height)) as f32,
        up: f32s(camera.up),
        start_medium: start_medium.0,
        half_size: [film.width, film.height].map(|side| side as f32 / 2.0),
        width: film.width,
        seed_hash: Sampler::seed_hash(settings.seed),
        max_depth: settings.max_depth.unwrap_or(u32::MAX),
        ..bytemuck::Zeroable::zeroed()
    };
    (image, is_ambiguous)
}

/// The first sample of each pixel and the one after the last, where pixels differ; `None` where they do not.
fn sample_ranges(film: &Film, samples: u32) -> Option<Vec<[u32; 2]>> {
    if film.allocation.is_none() && film.ahead.iter().all(|ahead| *ahead == 0) {
        return None;
    }
    let next = film.next_samples(samples);
    let width = film.width as usize;
    let of = |pixel: usize| {
        let range = next.of_pixel(pixel, film.ahead.get(pixel / width).copied().unwrap_or(0));
        [range.start, range.end.max(range.start)]
    };
    Some((0..film.sums.len()).map(of).collect())
}

/// Adds what a band has to the film. Returns what happened.
fn add_band(film: &mut Film, first_row: u32, band: &Band, is_ambiguous: bool) -> Events {
    let mut events = band.events;
    events.ambiguous += if is_ambiguous { band.samples() } else { 0 };
    let width = film.width as usize;
    for (mut row, pixels) in film.rows().into_iter().skip(first_row as usize).zip(band.sums.chunks(width)) {
        for (column, sums) in pixels.iter().enumerate() {
            row.add_sums(column, sums, &mut events);
        }
    }
    events
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::gpu::device::for_test;
    use crate::render::settings::ImageSettings;
    use crate::scene::camera::Camera;
    use crate::tracking::prepare;

    /// A pass is many dispatches, and once it is cancelled at most one more is begun, whatever its paths do.
    #[test]
    fn a_pass_is_cancelled_within_a_dispatch() {
        let Some(device) = for_test() else { return };
        let gpu = Gpu::new(device);
        let prepared = prepare(Arc::new(crate::formats::open("iced-water").unwrap()), None).unwrap();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let settings = ImageSettings { splits: 0, backend: Backend::Gpu, ..ImageSettings::new(Mode::Naive, 0) };
        let task = RenderTask { prepared: &prepared, camera: &camera, settings: &settings };
        assert_eq!((gpu.is_ready(&task), gpu.make_ready(&task)), (false, Ok(())));
        assert!(gpu.is_ready(&task));
        let (cancel, before) = (AtomicBool::new(false), gpu.tally().dispatches);
        let (mut film, mut at_cancel) = (Film::new(512, 512), 0);
        let is_complete = std::thread::scope(|scope| {
            let pass = scope.spawn(|| gpu.pass(&task, &mut film, 1 << 20, &cancel));
            while gpu.tally().dispatches < before + 3 && !pass.is_finished() {
                std::thread::yield_now();
            }
            cancel.store(true, Ordering::Relaxed);
            at_cancel = gpu.tally().dispatches;
            pass.join().unwrap()
        });
        // One may have been under way already.
        assert!(!is_complete && gpu.fault().is_none());
        assert!((before + 3..=at_cancel + 1).contains(&gpu.tally().dispatches), "{at_cancel}: {:?}", gpu.tally());
    }
}
