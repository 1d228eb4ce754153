//! The lane that paints surfaces: coarse pictures of every quantity first, then full ones, then more rays for each pixel.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::job::{Job, LaneMessage, MAX_DIVISOR, attempted, cancellable, divisor_for, of_another_epoch};
use super::mailbox::{Mailbox, Taken};
use super::{Board, News, PaintedSurfaces, Wake};
use crate::render::surfaces::{OFFSETS, Painting, SurfaceQuantity};

/// Seconds that a ray is expected to take before one has been timed.
const UNTIMED_SECONDS: f64 = 1e-5;
/// Fraction of the time for first pictures that they are planned to take; the rest is slack, since other lanes use the cores at the same time.
const FIRST_PICTURE_SHARE: f64 = 0.5;
/// As in the other lanes: a first picture is finished even if it is out of date by then.
const FIRST_PASS_GRACE: Duration = Duration::from_millis(60);

/// A job and how far it has come.
struct Progress {
    job: Job,
    paintings: BTreeMap<SurfaceQuantity, Painting>,
}

/// Serves messages until the mailbox is closed.
pub(super) fn run_painter(pool: &rayon::ThreadPool, mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake) {
    let mut progress: Option<Progress> = None;
    let mut seconds_per_ray = UNTIMED_SECONDS;
    loop {
        match mailbox.wait(progress.as_ref().and_then(Progress::next).map(|_| Duration::ZERO)) {
            Taken::Closed => return,
            Taken::Empty => {}
            Taken::Message(None) => progress = None,
            Taken::Message(Some(job)) => match &mut progress {
                // The same scene from the same camera: what is painted stays, whatever else is wanted now.
                Some(p) if p.job.request.epoch == job.request.epoch => {
                    p.job = *job;
                    p.publish_again(board, wake);
                }
                _ => progress = Some(Progress { job: *job, paintings: BTreeMap::new() }),
            },
        }
        let Some(p) = &mut progress else { continue };
        let Some(quantity) = p.next() else { continue };
        let epoch = p.job.request.epoch;
        if attempted(epoch, board, wake, || p.advance(quantity, pool, mailbox, board, &mut seconds_per_ray)) {
            wake(News::Images);
        } else {
            progress = None;
        }
    }
}

impl Progress {
    /// How far a quantity has come: 0 is nothing, 1 a coarse picture, then one more with each ray.
    fn stage(&self, quantity: SurfaceQuantity) -> u32 {
        let [width, height] = self.job.request.size;
        match self.paintings.get(&quantity) {
            None => 0,
            Some(painting) if [painting.width, painting.height] != [width, height] => 1,
            Some(painting) => 1 + painting.rays,
        }
    }

    /// What to do next: the quantity that is farthest behind.
    fn next(&self) -> Option<SurfaceQuantity> {
        // Paused, there is one whole picture.
        let last = if self.job.request.is_paused { 2 } else { OFFSETS.len() as u32 + 1 };
        let wanted = self.job.request.surfaces.iter().copied();
        wanted.map(|quantity| (self.stage(quantity), quantity)).filter(|(stage, _)| *stage < last).min().map(|(_, q)| q)
    }

    /// Puts on the board what has left it while it was not wanted.
    fn publish_again(&self, board: &Board, wake: &Wake) {
        let mut state = board.lock();
        let mut has_news = false;
        for quantity in &self.job.request.surfaces {
            if let Some(painting) = self.paintings.get(quantity)
                && painting.rays > 0
                && !state.paintings.contains_key(quantity)
            {
                state.paintings.insert(*quantity, Arc::new(self.painted(*quantity, painting.clone())));
                has_news = true;
            }
        }
        drop(state);
        if has_news {
            wake(News::Images);
        }
    }

    fn painted(&self, quantity: SurfaceQuantity, painting: Painting) -> PaintedSurfaces {
        PaintedSurfaces { epoch: self.job.request.epoch, quantity, full_size: self.job.request.size, painting }
    }

    /// One ray for each pixel of one picture. `false` when a newer message has cancelled it.
    fn advance(
        &mut self,
        quantity: SurfaceQuantity,
        pool: &rayon::ThreadPool,
        mailbox: &Mailbox<LaneMessage>,
        board: &Board,
        seconds_per_ray: &mut f64,
    ) -> bool {
        let full = self.job.request.size;
        let stage = self.stage(quantity);
        let begun = Instant::now();
        if stage < 2 {
            // The first pictures of all quantities share the time.
            let is_missing = |quantity: &&SurfaceQuantity| !self.paintings.contains_key(quantity);
            let missing = self.job.request.surfaces.iter().filter(is_missing).count();
            let divisor = if stage == 0 {
                let pixels = full.map(f64::from).iter().product::<f64>();
                let left = (self.job.first_image_due(begun) - begun).as_secs_f64() / missing.max(1) as f64;
                divisor_for(pixels * *seconds_per_ray, FIRST_PICTURE_SHARE * left).min(MAX_DIVISOR)
            } else {
                1
            };
            let [width, height] = full.map(|side| side.div_ceil(divisor).max(1));
            self.paintings.insert(quantity, Painting::new(width, height));
        }
        let Some(painting) = self.paintings.get_mut(&quantity) else { return false };
        let grace_end = if stage == 0 { begun + FIRST_PASS_GRACE } else { begun };
        let job = &self.job;
        let is_complete = cancellable(pool, mailbox, of_another_epoch(job.request.epoch), grace_end, None, |cancel| {
            painting.add(&job.prepared, &job.camera, quantity, cancel)
        });
        if is_complete {
            let rays = f64::from(painting.width) * f64::from(painting.height);
            *seconds_per_ray = begun.elapsed().as_secs_f64() / rays;
            let painting = painting.clone();
            let painted = self.painted(quantity, painting);
            let mut state = board.lock();
            let is_stale = state.paintings.get(&quantity).is_some_and(|old| old.epoch > painted.epoch);
            if !is_stale {
                state.paintings.insert(quantity, Arc::new(painted));
            }
        }
        is_complete
    }
}
