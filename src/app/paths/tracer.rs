//! The thread that follows paths: the window asks for what it shows now, and gets it when it is there.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2};

use super::Line;
use super::outline::Outlines;
use crate::app::background::{Background, Bell, Desk, Repaint};
use crate::geometry::Ray;
use crate::scene::ObjectId;
use crate::scene::camera::Camera;
use crate::scene::description::CameraDescription;
use crate::session::SceneReport;
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, PathStart, TracedPath, trace};
use crate::transport::parting::{Parting, parting};

/// Segments after which the inspector stops following a path.
pub const MOST_SEGMENTS: u32 = 200;
/// Rays of a bundle.
pub const BUNDLE: u32 = 32;

/// A pixel of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// As films are taken.
    pub camera: CameraDescription,
    /// In pixels.
    pub film_size: [u32; 2],
    /// In [0, 1]² of the film, y down.
    pub point: [f64; 2],
}

impl Viewpoint {
    /// The ray through the middle of the pixel and of the lens.
    pub fn ray(&self) -> Option<Ray> {
        self.ray_beside([0.5; 2], DVec2::ZERO)
    }

    /// Through a point in [0, 1]² of the pixel and a point of the unit disc of the lens. `None` where there is no such camera.
    fn ray_beside(&self, part: [f64; 2], lens: DVec2) -> Option<Ray> {
        let camera = Camera::new(&self.camera).ok().filter(|_| !self.film_size.contains(&0))?;
        let size = UVec2::from(self.film_size).as_dvec2();
        let corner = (size * DVec2::from(self.point)).floor().min(size - 1.0).max(DVec2::ZERO);
        Some(camera.ray(corner + DVec2::from(part), size, lens))
    }
}

/// What is wanted.
#[derive(Debug, Clone)]
pub struct Question {
    pub report: Arc<SceneReport>,
    pub viewpoint: Viewpoint,
    /// The light whose light is followed, instead of the pixel's ray.
    pub light: Option<ObjectId>,
    pub follow: Follow,
    /// Of the random numbers.
    pub seed: u64,
    /// Whether rays around the pixel, or more of the light's, are wanted too.
    pub has_bundle: bool,
    pub modes: Vec<Mode>,
    /// Two of the modes, which are compared.
    pub pair: Option<[Mode; 2]>,
    pub max_depth: u32,
    /// Where the picture is seen from (scene coordinates): what is hidden from there is drawn faintly.
    pub eye: DVec3,
    /// Whether outlines of the objects are wanted.
    pub has_outlines: bool,
}

impl Question {
    /// Whether both are about the same scene, in which nothing else has been found out.
    fn has_scene_of(&self, other: &Self) -> bool {
        let [a, b] = [&self.report.prepared, &other.report.prepared];
        Arc::ptr_eq(&a.scene, &b.scene) && a.table.rays() == b.table.rays()
    }
}

impl PartialEq for Question {
    fn eq(&self, other: &Self) -> bool {
        let key = |q: &Self| (q.viewpoint, q.follow, q.seed, q.has_bundle, q.pair, q.max_depth, q.eye, q.has_outlines);
        self.has_scene_of(other) && key(self) == key(other) && (&self.modes, self.light) == (&other.modes, other.light)
    }
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Traced {
    pub question: Question,
    /// Of each mode the path through the pixel's middle, and then those of the bundle.
    pub lines: BTreeMap<Mode, Vec<Line>>,
    /// Where the pair parts; `None` where there is no pair, or it agrees.
    pub parting: Option<Parting>,
    /// Empty where none are wanted.
    pub outlines: Arc<Outlines>,
}

impl Traced {
    /// A mode's path through the pixel's middle.
    pub fn path(&self, mode: Mode) -> Option<&TracedPath> {
        self.lines.get(&mode)?.first().map(|line| &line.path)
    }
}

type Found = Option<Arc<Traced>>;

/// The thread.
pub type Tracer = Background<Option<Question>, Found>;

/// Starts the thread, which calls `wake` when it has something.
pub fn start(wake: Repaint) -> std::io::Result<Tracer> {
    Background::start("paths", Bell::default(), move |desk| run(desk, &wake))
}

fn run(desk: &Desk<Option<Question>, Found>, wake: &Repaint) {
    let mut last: Found = None;
    while let Some(question) = desk.wait(None) {
        let Some(question) = question else { continue };
        let traced = Arc::new(answer(question, last.as_deref()));
        last = Some(Arc::clone(&traced));
        desk.put(|finished| *finished = Some(traced));
        wake();
    }
}

/// Answers a question; what `last` knows of the same geometry is kept.
pub(super) fn answer(question: Question, last: Option<&Traced>) -> Traced {
    let prepared = &question.report.prepared;
    let starts = starts(&question);
    let follow = |mode: Mode| -> Vec<Line> {
        let each = starts.iter().enumerate().map(|(index, start)| {
            // A bundle by chance is one of different chances.
            let seed = question.seed.wrapping_mul(u64::from(BUNDLE) + 1).wrapping_add(index as u64);
            let path = trace(prepared, mode, *start, question.follow, seed, Some(question.max_depth));
            Line::new(path, &prepared.scene, (index == 0).then_some(question.eye))
        });
        each.collect()
    };
    let lines: BTreeMap<Mode, Vec<Line>> = question.modes.iter().map(|&mode| (mode, follow(mode))).collect();
    let first = |mode: &Mode| lines.get(mode)?.first().map(|line| &line.path);
    let parting = question.pair.and_then(|[a, b]| parting(prepared, [first(&a)?, first(&b)?]));
    let known = last.filter(|last| {
        let [old, new] = [&last.question, &question].map(|q| &q.report.prepared.scene.geometry);
        last.question.has_outlines && Arc::ptr_eq(old, new)
    });
    let outlines = match known {
        Some(known) if question.has_outlines => Arc::clone(&known.outlines),
        None if question.has_outlines => Arc::new(Outlines::of(&prepared.scene)),
        _ => Arc::default(),
    };
    Traced { lines, parting, outlines, question }
}

/// Where the path and those of its bundle start.
fn starts(question: &Question) -> Vec<PathStart> {
    if let Some(light) = question.light {
        let count = if question.has_bundle { BUNDLE as usize + 1 } else { 1 };
        // Each has random numbers of its own.
        return vec![PathStart::Light(light); count];
    }
    let mut rays: Vec<Ray> = question.viewpoint.ray().into_iter().collect();
    if question.has_bundle {
        // Rank-1 lattice of Kronecker type (roots of x⁵ = x + 1): evenly over the pixel and the lens.
        const STEPS: [f64; 4] = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_3];
        for index in 1..=BUNDLE {
            let [x, y, u, v] = STEPS.map(|step| (f64::from(index) * step).fract());
            let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
            rays.extend(question.viewpoint.ray_beside([x, y], DVec2::new(cos, sin) * u.sqrt()));
        }
    }
    rays.into_iter().map(PathStart::Ray).collect()
}
