//! The thread that cuts slices, so that the window does not wait: a coarse picture first where a full one takes longer, which is always
//! finished and so follows a plane that is dragged.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use egui::ColorImage;

use super::background::{Background, Bell, Desk, Repaint};
use super::develop::{About, Picture, Source};
use super::settings::PaneContent;
use super::theme::opaque;
use crate::render::slice::{Plane, Slice};
use crate::tracking::{Mode, Prepared};

/// A full picture that takes longer than this has a coarse one before it.
const QUICK: Duration = Duration::from_millis(12);
/// Pixels of a full picture for one of a coarse one, each way.
const COARSE: u32 = 4;

/// What to cut.
#[derive(Debug, Clone, Default)]
pub struct Cutting {
    /// `None`: nothing.
    pub of: Option<Of>,
    /// Each gets a picture.
    pub modes: Vec<Mode>,
}

/// The scene, and where it is cut.
#[derive(Debug, Clone)]
pub struct Of {
    /// Of the report that brought the scene.
    pub epoch: u64,
    pub prepared: Prepared,
    pub plane: Plane,
    pub size: [u32; 2],
    /// In pixels.
    pub line_width: f64,
}

impl Of {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.prepared.scene, &other.prepared.scene)
            && Arc::ptr_eq(&self.prepared.table, &other.prepared.table)
            && (self.plane, self.size, self.line_width) == (other.plane, other.size, other.line_width)
    }
}

impl PartialEq for Cutting {
    fn eq(&self, other: &Self) -> bool {
        let is_same = match (&self.of, &other.of) {
            (Some(a), Some(b)) => a.is(b),
            (None, None) => true,
            _ => false,
        };
        is_same && self.modes == other.modes
    }
}

/// A slice, and what it was cut for.
#[derive(Debug, Clone)]
pub struct CutSlice {
    /// Of the report that brought the scene.
    pub epoch: u64,
    pub slice: Slice,
    /// The size that was asked for; the slice is smaller in a preview.
    pub full_size: [u32; 2],
}

impl CutSlice {
    pub fn is_preview(&self) -> bool {
        self.slice.size != self.full_size
    }
}

type Pictures = BTreeMap<PaneContent, Picture>;

/// The handle to the thread. Dropping it ends the thread.
pub struct Slicer {
    thread: Background<Cutting, Pictures>,
    last: Cutting,
    cancel: Arc<AtomicBool>,
}

impl Slicer {
    /// Starts the thread, which calls `wake` after each picture.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(wake: Repaint) -> std::io::Result<Self> {
        let cancel = Arc::new(AtomicBool::new(false));
        let shared = Arc::clone(&cancel);
        let thread = Background::start("slice", Bell::default(), move |desk| run(desk, &shared, &wake))?;
        Ok(Self { thread, last: Cutting::default(), cancel })
    }

    pub fn set_order(&mut self, order: Cutting) {
        if order != self.last {
            self.thread.set_order(&order);
            self.cancel.store(true, Ordering::Relaxed);
            self.last = order;
        }
    }

    pub fn take_finished(&self) -> Pictures {
        self.thread.take_finished()
    }
}

impl Drop for Slicer {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// How far the picture of a mode is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    Nothing,
    Coarse,
    Full,
}

fn run(desk: &Desk<Cutting, Pictures>, cancel: &AtomicBool, wake: &Repaint) {
    let mut present: Option<Of> = None;
    let mut stages: BTreeMap<Mode, Stage> = BTreeMap::new();
    // How long the last full picture took.
    let mut takes: BTreeMap<Mode, Duration> = BTreeMap::new();
    let mut has_work = false;
    while let Some(order) = desk.wait(has_work.then(Instant::now)) {
        // If a newer order comes between these two, one picture too many is cancelled, and begun anew below.
        cancel.store(false, Ordering::Relaxed);
        let Some(of) = order.of else {
            (present, has_work) = (None, false);
            continue;
        };
        if !present.as_ref().is_some_and(|present| present.is(&of)) {
            stages.clear();
        }
        stages.retain(|mode, _| order.modes.contains(mode));
        present = Some(of.clone());
        let stage_of = |mode: &Mode| stages.get(mode).copied().unwrap_or(Stage::Nothing);
        let behind = order.modes.iter().copied().filter(|mode| stage_of(mode) < Stage::Full);
        let Some(mode) = behind.min_by_key(|mode| (stage_of(mode), *mode)) else {
            has_work = false;
            continue;
        };
        has_work = true;
        let is_slow = takes.get(&mode).is_none_or(|taken| *taken > QUICK);
        let is_coarse = is_slow && stage_of(&mode) == Stage::Nothing;
        let size = if is_coarse { of.size.map(|side| side.div_ceil(COARSE).max(1)) } else { of.size };
        let line_width = if is_coarse { 1.0 } else { of.line_width };
        let never = AtomicBool::new(false);
        // The first picture is always finished, so that there is one.
        let cancel = if stage_of(&mode) == Stage::Nothing { &never } else { cancel };
        let begun = Instant::now();
        if let Some(slice) = Slice::new(&of.prepared, mode, of.plane, size, line_width, cancel) {
            if !is_coarse {
                takes.insert(mode, begun.elapsed());
            }
            stages.insert(mode, if is_coarse { Stage::Coarse } else { Stage::Full });
            let picture = picture(CutSlice { epoch: of.epoch, slice, full_size: of.size });
            desk.put(|finished| _ = finished.insert(PaneContent::Slice(mode), picture));
            wake();
        } else if !cancel.load(Ordering::Relaxed) {
            // A plane that is none.
            stages.insert(mode, Stage::Full);
        }
    }
}

fn picture(cut: CutSlice) -> Picture {
    let size = cut.slice.size.map(|side| side as usize);
    let pixels = cut.slice.pixels.iter().copied().map(opaque).collect();
    let source = Source { slice: Some(Arc::new(cut)), ..Source::default() };
    Picture { image: Arc::new(ColorImage::new(size, pixels)), about: About { source, ..About::default() } }
}
