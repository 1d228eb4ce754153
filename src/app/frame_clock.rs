//! Measures how long frames take while panes render: for the report, and for whoever changes the window.

use std::path::PathBuf;
use std::time::Instant;

use super::screenshot::{Receipt, lock};
use super::state::State;
use crate::report::frame_times::{FrameTimes, Spread};
use crate::report::machine::{self, Machine};

/// Frames that are measured.
const FRAMES: usize = 600;
/// Frames before that, in which fonts and pictures are loaded.
const WARM_UP: usize = 30;

/// Counts frames, writes what they took, and closes the window.
pub struct FrameClock {
    path: PathBuf,
    receipt: Receipt,
    seen: usize,
    interface: Vec<f64>,
    whole: Vec<f64>,
    intervals: Vec<f64>,
    /// When the last frame ended.
    last: Option<Instant>,
    drawn_by: Option<String>,
    samples_before: u32,
}

impl FrameClock {
    pub fn new(path: PathBuf, receipt: Receipt) -> Self {
        Self {
            path,
            receipt,
            seen: 0,
            interface: Vec::new(),
            whole: Vec::new(),
            intervals: Vec::new(),
            last: None,
            drawn_by: None,
            samples_before: 0,
        }
    }

    /// To be called at the end of every frame, which took `secs` of the program's own work; `frame` knows what the one before it took with
    /// drawing. Frames count once every pane has `samples`.
    pub fn tick(&mut self, ctx: &egui::Context, secs: f64, frame: &eframe::Frame, state: &State, samples: u32) {
        let now = Instant::now();
        let interval = self.last.replace(now).map(|last| (now - last).as_secs_f64());
        if lock(&self.receipt).is_some() {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        ctx.request_repaint();
        if samples == 0 {
            return;
        }
        self.seen += 1;
        if self.seen <= WARM_UP {
            self.samples_before = samples;
            return;
        }
        self.interface.push(secs);
        self.whole.extend(frame.info().cpu_usage.map(f64::from));
        self.intervals.extend(interval);
        if self.drawn_by.is_none() {
            self.drawn_by = frame.wgpu_render_state().map(|gpu| gpu.adapter.get_info().name);
        }
        if self.interface.len() == FRAMES {
            let outcome = self.found(ctx, state, samples).map_or_else(
                || Err("no frame was measured".to_owned()),
                |times| times.write(&self.path).map_err(|error| error.to_string()),
            );
            *lock(&self.receipt) = Some(outcome);
        }
    }

    fn found(&mut self, ctx: &egui::Context, state: &State, samples: u32) -> Option<FrameTimes> {
        let window = ctx.content_rect().size() * ctx.pixels_per_point();
        Some(FrameTimes {
            machine: Machine::here(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            is_optimized: !cfg!(debug_assertions),
            date: machine::now(),
            scene: state.document.description().name.clone(),
            window: [window.x, window.y].map(|side| side.round() as u32),
            panes: state.settings.pane_count,
            pane: state.film_size(),
            frames: self.interface.len(),
            samples: samples.saturating_sub(self.samples_before),
            interface: Spread::of(std::mem::take(&mut self.interface))?,
            whole: Spread::of(std::mem::take(&mut self.whole)),
            interval: Spread::of(std::mem::take(&mut self.intervals)),
            drawn_by: self.drawn_by.take(),
        })
    }
}
