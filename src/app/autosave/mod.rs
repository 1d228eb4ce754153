//! Edits that no file has are kept in the program's data folder, some seconds after they were made, so that they survive a crash: the next
//! start offers them. On a thread of its own: the window never waits for the disk.

mod slot;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use self::slot::{Found, Slot};
use super::background::{Background, Bell, Desk, Repaint};
use crate::scene::Description;

/// Where autosaves are kept; `None` where the system names no folder for such things.
pub fn folder() -> Option<PathBuf> {
    eframe::storage_dir("iorect").map(|folder| folder.join("autosave"))
}

/// Edits are written after this long without another one.
const QUIET: Duration = Duration::from_secs(2);
/// However many edits follow each other, they are written after this long.
const LONGEST: Duration = Duration::from_secs(10);

/// An edited scene that no file has.
#[derive(Debug, Clone)]
pub struct Edits {
    pub description: Arc<Description>,
    /// Where "Save" writes.
    pub path: Option<PathBuf>,
}

impl PartialEq for Edits {
    fn eq(&self, other: &Self) -> bool {
        // Scenes are large; an edit makes another allocation.
        Arc::ptr_eq(&self.description, &other.description) && self.path == other.path
    }
}

/// What is to be kept.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Order {
    /// `None`: nothing that is not in a file. What was kept is removed.
    pub edits: Option<Edits>,
    /// Where to keep it, after edits of an earlier instance have been restored; `None`: in a place of its own.
    pub slot: Option<Arc<Slot>>,
}

/// What the thread has to say.
#[derive(Debug, Default)]
pub struct Report {
    /// Left behind by instances that have gone; said once, at the start.
    pub found: Vec<Found>,
    /// Why edits cannot be kept, in words.
    pub failure: Option<String>,
}

pub type Autosaver = Background<Order, Report>;

/// Starts the thread, which keeps edits in `folder` and calls `wake` when it has something to say. When it is dropped with edits that no
/// file has, they are written at once and stay.
pub fn start(folder: PathBuf, wake: Repaint) -> std::io::Result<Autosaver> {
    Background::start("autosave", Bell::default(), move |desk| {
        let found = Found::all(&folder);
        if !found.is_empty() {
            desk.put(|report| report.found = found);
            wake();
        }
        Keeper { folder, slot: None, kept: None, first_change: None, order: Order::default() }.run(desk, &wake);
    })
}

struct Keeper {
    folder: PathBuf,
    slot: Option<Arc<Slot>>,
    /// What is in the slot, or could not be put there.
    kept: Option<Edits>,
    /// Of the edits that are not in the slot yet.
    first_change: Option<Instant>,
    order: Order,
}

impl Keeper {
    fn run(&mut self, desk: &Desk<Order, Report>, wake: &Repaint) {
        let mut due = None;
        let say = |failure: Option<String>| {
            if failure.is_some() {
                desk.put(|report| report.failure = failure);
                wake();
            }
        };
        while let Some(order) = desk.wait(due) {
            due = self.follow(order);
            if due.is_some_and(|due| due <= Instant::now()) {
                say(self.keep());
                due = None;
            }
        }
        if self.follow(desk.order()).is_some() {
            say(self.keep());
        }
    }

    /// Takes an order in; returns when its edits are to be written, if they are not.
    fn follow(&mut self, order: Order) -> Option<Instant> {
        let before = std::mem::replace(&mut self.order, order);
        if self.order.slot != before.slot
            && let Some(slot) = self.order.slot.clone()
            && let Some(own) = self.slot.replace(slot)
        {
            own.remove();
        }
        match &self.order.edits {
            None => {
                if self.kept.take().is_some() || self.order.slot.is_some() {
                    // Dropped with the order, a slot that was taken over is free for others.
                    self.slot.take().inspect(|slot| slot.remove());
                }
                self.first_change = None;
                None
            }
            edits if *edits == self.kept => {
                self.first_change = None;
                None
            }
            edits => {
                let now = Instant::now();
                let first = *self.first_change.get_or_insert(now);
                let is_new = *edits != before.edits;
                let latest = first + LONGEST;
                Some(if is_new { latest.min(now + QUIET) } else { now })
            }
        }
    }

    /// Writes the edits; returns why that could not be done.
    fn keep(&mut self) -> Option<String> {
        self.first_change = None;
        self.kept.clone_from(&self.order.edits);
        let edits = self.kept.as_ref()?;
        let slot = match &self.slot {
            Some(slot) => Ok(Arc::clone(slot)),
            None => Slot::claim(&self.folder).map(Arc::new).map_err(|error| cannot(&self.folder, &error.to_string())),
        };
        let written = slot.and_then(|slot| {
            self.slot = Some(Arc::clone(&slot));
            slot.write(edits).map_err(|reason| cannot(slot.path(), &reason))
        });
        written.err()
    }
}

fn cannot(path: &Path, reason: &str) -> String {
    format!("Edits are not safe from a crash until they are saved: {} cannot be written: {reason}", path.display())
}
