//! What is to be said of each mode in the picture that is shown, found out on a thread of its own.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::background::{Background, Bell, Desk, Repaint};
use crate::check::verdict::{Verdict, judge};
use crate::scene::camera::Camera;
use crate::scene::description::CameraDescription;
use crate::session::SceneReport;
use crate::tracking::Mode;

/// A camera that moves is judged after this long at rest.
const QUIET: Duration = Duration::from_millis(250);

/// The picture that verdicts are wanted of.
#[derive(Debug, Clone, Default)]
pub struct Order {
    pub report: Option<Arc<SceneReport>>,
    pub camera: Option<CameraDescription>,
    /// Of a film, in pixels.
    pub size: [u32; 2],
    pub modes: Vec<Mode>,
}

impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        let is_same_scene = match (&self.report, &other.report) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        is_same_scene && self.camera == other.camera && self.size == other.size && self.modes == other.modes
    }
}

impl Order {
    /// Whether both are of the same picture, whatever modes it is wanted in.
    fn is_of_same_picture(&self, other: &Self) -> bool {
        Self { modes: Vec::new(), ..self.clone() } == Self { modes: Vec::new(), ..other.clone() }
    }
}

/// The verdicts of one picture so far.
#[derive(Debug, Clone, Default)]
pub struct Verdicts {
    pub of: BTreeMap<Mode, Arc<Verdict>>,
}

/// `None` where there is nothing new.
pub type Judge = Background<Order, Option<Verdicts>>;

/// Starts the thread, which calls `wake` when it has something to say.
pub fn start(wake: Repaint) -> std::io::Result<Judge> {
    Background::start("verdicts", Bell::default(), move |desk| work(desk, &wake))
}

fn work(desk: &Desk<Order, Option<Verdicts>>, wake: &Repaint) {
    let mut last = Order::default();
    let mut verdicts = Verdicts::default();
    while let Some(mut order) = desk.wait(None) {
        // While the camera moves or the scene is being edited, the next order follows soon.
        while let Some(later) = desk.wait(Some(Instant::now() + QUIET)) {
            if later == order {
                break;
            }
            order = later;
        }
        if !order.is_of_same_picture(&last) {
            verdicts = Verdicts::default();
            last = order.clone();
            desk.put(|finished| *finished = Some(verdicts.clone()));
            wake();
        }
        let (Some(report), Some(Ok(camera))) = (&order.report, order.camera.as_ref().map(Camera::new)) else {
            continue;
        };
        for mode in order.modes.iter().filter(|mode| !verdicts.of.contains_key(mode)).copied().collect::<Vec<_>>() {
            let mut is_wanted = true;
            judge(&report.prepared, &camera, order.size, mode, |verdict| {
                verdicts.of.insert(mode, Arc::new(verdict.clone()));
                desk.put(|finished| *finished = Some(verdicts.clone()));
                wake();
                is_wanted = desk.order() == order;
                is_wanted
            });
            if !is_wanted {
                // What is not finished is judged again if it is still wanted.
                verdicts.of.remove(&mode);
                break;
            }
        }
    }
}
