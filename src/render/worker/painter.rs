//! The lane that paints surfaces: coarse pictures of every quantity first, then full ones, then more rays for each pixel.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::lane::{Job, LaneMessage, cancellable};
use super::mailbox::{Mailbox, Taken};
use super::{Board, News, PaintedSurfaces, Wake, guarded};
use crate::render::surfaces::{OFFSETS, Painting, SurfaceQuantity};

/// Pixels of a first picture.
const COARSE_PIXELS: u64 = 40_000;
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
    loop {
        let taken =
            if progress.as_ref().is_some_and(|p| p.next().is_some()) { mailbox.take() } else { mailbox.wait().into() };
        match taken {
            Taken::Closed => return,
            Taken::Empty => {}
            Taken::Message(LaneMessage::Hold) => progress = None,
            Taken::Message(LaneMessage::Render(job)) => match &mut progress {
                // The same scene from the same camera: what is painted stays, whatever else is wanted now.
                Some(p) if p.job.request.epoch == job.request.epoch => {
                    p.paintings.retain(|quantity, _| job.request.surfaces.contains(quantity));
                    p.job = *job;
                }
                _ => progress = Some(Progress { job: *job, paintings: BTreeMap::new() }),
            },
        }
        let Some(p) = &mut progress else { continue };
        let Some(quantity) = p.next() else { continue };
        match guarded(|| Ok(p.advance(quantity, pool, mailbox, board))) {
            Ok(true) => wake(News::Images),
            Ok(false) => progress = None,
            Err(error) => {
                board.lock().failure = Some((p.job.request.epoch, error));
                progress = None;
                wake(News::Scene);
            }
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
        let last = OFFSETS.len() as u32 + 1;
        let wanted = self.job.request.surfaces.iter().copied();
        wanted.map(|quantity| (self.stage(quantity), quantity)).filter(|(stage, _)| *stage < last).min().map(|(_, q)| q)
    }

    /// One ray for each pixel of one picture. `false` when a newer message has cancelled it.
    fn advance(
        &mut self,
        quantity: SurfaceQuantity,
        pool: &rayon::ThreadPool,
        mailbox: &Mailbox<LaneMessage>,
        board: &Board,
    ) -> bool {
        let full = self.job.request.size;
        let pixels = |divisor: u32| full.map(|side| u64::from(side.div_ceil(divisor))).iter().product::<u64>();
        let stage = self.stage(quantity);
        let mut divisor = 1;
        while stage == 0 && pixels(divisor) > COARSE_PIXELS && divisor < 16 {
            divisor *= 2;
        }
        if stage < 2 {
            let [width, height] = full.map(|side| side.div_ceil(divisor).max(1));
            self.paintings.insert(quantity, Painting::new(width, height));
        }
        let Some(painting) = self.paintings.get_mut(&quantity) else { return false };
        let grace_end = if stage == 0 { Instant::now() + FIRST_PASS_GRACE } else { Instant::now() };
        let job = &self.job;
        let is_complete = cancellable(pool, mailbox, job.request.epoch, grace_end, None, |cancel| {
            painting.add(&job.prepared, &job.camera, quantity, cancel)
        });
        if is_complete {
            let painted =
                PaintedSurfaces { epoch: job.request.epoch, quantity, full_size: full, painting: painting.clone() };
            let mut state = board.lock();
            let is_stale = state.paintings.get(&quantity).is_some_and(|old| old.epoch > painted.epoch);
            if !is_stale {
                state.paintings.insert(quantity, Arc::new(painted));
            }
        }
        is_complete
    }
}
