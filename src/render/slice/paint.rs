//! Colours of a slice. Every pixel has exactly one of those that the legend names.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::{Cell, Cut, Edge, Filling, Plane, Slice};
use crate::render::surfaces::medium_color;
use crate::scene::MediumId;
use crate::tracking::{Mode, Prepared};

/// Inside of opaque objects.
pub const SOLID_COLOR: [u8; 3] = [0x52, 0x50, 0x4d];
const LIGHT_COLOR: [u8; 3] = [0xff, 0xf4, 0xcd];
const LINE_COLOR: [u8; 3] = [0x0c, 0x0d, 0x10];

/// Width of the stripes of a doubtful place, in pixels along a row.
const STRIPE: u32 = 5;
/// Every so many-th pixel along a row is dark where an answer rests on rays that did not agree.
const HATCH: u32 = 7;

/// A colour of a slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Ink {
    Medium(MediumId),
    Solid,
    Light,
    /// Surfaces, and the hatching of places whose answer rests on rays that did not agree.
    Line,
}

impl Ink {
    /// sRGB.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Medium(medium) => medium_color(medium),
            Self::Solid => SOLID_COLOR,
            Self::Light => LIGHT_COLOR,
            Self::Line => LINE_COLOR,
        }
    }

    /// In words, for a legend. Media with their IOR.
    pub fn label(self, prepared: &Prepared) -> String {
        match self {
            Self::Medium(id) => match prepared.scene.media.get(id.0 as usize) {
                Some(medium) => format!("{}  {:.4}", medium.name, medium.ior()),
                // The scene may be a newer one than the picture.
                None => String::new(),
            },
            Self::Solid => "solid".to_owned(),
            Self::Light => "light".to_owned(),
            Self::Line => "surface".to_owned(),
        }
    }

    fn of(cell: &Cell, x: u32, y: u32) -> Self {
        match cell.edge {
            Some(Edge::Null) if (x / 2 + y / 2) % 2 == 1 => {}
            Some(_) => return Self::Line,
            None => {}
        }
        match (cell.filling, cell.rival) {
            (Filling::Solid, _) => Self::Solid,
            (Filling::Light, _) => Self::Light,
            (Filling::Medium(_), Some(rival)) if (x + y) / STRIPE % 2 == 1 => Self::Medium(rival),
            (Filling::Medium(_), None) if cell.is_doubtful && (x + y).is_multiple_of(HATCH) => Self::Line,
            (Filling::Medium(medium), _) => Self::Medium(medium),
        }
    }
}

/// What the colours of some rows are.
#[derive(Default)]
struct Tally {
    seen: BTreeMap<Ink, u64>,
    media_pixels: u64,
    doubtful_pixels: u64,
    has_null_edges: bool,
}

impl Tally {
    fn plus(mut self, other: Self) -> Self {
        for (ink, count) in other.seen {
            *self.seen.entry(ink).or_default() += count;
        }
        self.media_pixels += other.media_pixels;
        self.doubtful_pixels += other.doubtful_pixels;
        self.has_null_edges |= other.has_null_edges;
        self
    }
}

pub(super) fn paint(cut: &Cut<'_>, mode: Mode, plane: Plane, line_width: f64, cancel: &AtomicBool) -> Option<Slice> {
    let [width, height] = cut.size;
    let mut pixels = vec![[0; 3]; width as usize * height as usize];
    let tally = (pixels.par_chunks_mut(width as usize).zip(0..height).map(|(row, y)| {
        let mut tally = Tally::default();
        if cancel.load(Ordering::Relaxed) {
            return tally;
        }
        // Colours come in runs.
        let mut run: Option<(Ink, u64)> = None;
        for ((x, cell), pixel) in (0..).zip(cut.row(y, line_width)).zip(row) {
            let ink = Ink::of(&cell, x, y);
            *pixel = ink.color();
            match &mut run {
                Some((same, count)) if *same == ink => *count += 1,
                _ => {
                    if let Some((ink, count)) = run.replace((ink, 1)) {
                        *tally.seen.entry(ink).or_default() += count;
                    }
                }
            }
            tally.has_null_edges |= cell.edge == Some(Edge::Null);
            // What a line covers is neither.
            if matches!(cell.filling, Filling::Medium(_)) && cell.edge.is_none() {
                tally.media_pixels += 1;
                tally.doubtful_pixels += u64::from(cell.is_doubtful);
            }
        }
        if let Some((ink, count)) = run {
            *tally.seen.entry(ink).or_default() += count;
        }
        tally
    }))
    .reduce(Tally::default, Tally::plus);
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let mut seen: Vec<(Ink, u64)> = tally.seen.into_iter().collect();
    seen.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    let Tally { media_pixels, doubtful_pixels, has_null_edges, .. } = tally;
    Some(Slice { mode, plane, size: cut.size, pixels, seen, media_pixels, doubtful_pixels, has_null_edges })
}
