//! A picture of a plane through the scene, filled with the medium that a mode finds at each place.
//!
//! Straight lines run through the plane, one along each row of pixels and one along each column. Where a line crosses a surface, the mode
//! says which media lie on its two sides. So up to four surfaces speak about a pixel: the next ones to the left, to the right, above and
//! below. Where they do not agree, the place is doubtful. Only modes without state can be asked in this way: the others answer
//! for a path, and not for a place.

mod line;
mod paint;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::line::{Line, Walk};
pub use self::paint::{Ink, SOLID_COLOR};
use crate::rectify::containment::{containment, medium_at};
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::{Mode, Prepared, Tracker, WithTracker};

/// The modes that have an answer for a place.
pub const SLICED_MODES: [Mode; 5] =
    [Mode::Naive, Mode::Declared, Mode::RectifiedObject, Mode::Rectified, Mode::Reference];

/// Where lines run within their pixels: beside the middle by this part of a pixel, so that they do not run along edges and faces
/// that lie on round coordinates.
const BESIDE: f64 = 0.0137;
/// The plane is moved towards the viewer by this part of the scene's radius, and by [`BESIDE`] of a pixel, for the same reason: a face
/// that lies in the plane has one of its sides in the picture.
const LIFT: f64 = 2e-7;

/// A rectangle in the scene, seen from the side that [`Self::normal`] points to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// In the middle of the picture; scene coordinates.
    pub center: DVec3,
    /// Unit vectors along the picture's sides, at right angles.
    pub right: DVec3,
    pub up: DVec3,
    /// Height of the picture in scene units, greater than 0. Its width follows from the picture's shape.
    pub height: f64,
}

impl Plane {
    /// Unit vector towards the viewer.
    pub fn normal(&self) -> DVec3 {
        self.right.cross(self.up)
    }

    /// The place, in scene coordinates, at a point in [0, 1]² (y down) of a picture that is `aspect` times as wide as high.
    pub fn place(&self, aspect: f64, point: DVec2) -> DVec3 {
        let across = self.right * ((point.x - 0.5) * aspect);
        self.center + (across + self.up * (0.5 - point.y)) * self.height
    }

    /// The point of the picture at the foot of a place, and the place's distance from the plane, positive towards the viewer.
    pub fn foot(&self, aspect: f64, place: DVec3) -> (DVec2, f64) {
        let away = place - self.center;
        let across = DVec2::new(away.dot(self.right) / aspect, -away.dot(self.up)) / self.height;
        (across + 0.5, away.dot(self.normal()))
    }

    fn is_sound(&self) -> bool {
        let vectors = [self.center, self.right, self.up];
        vectors.iter().all(|vector| vector.is_finite()) && self.height.is_finite() && self.height > 0.0
    }
}

/// What fills a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Filling {
    Medium(MediumId),
    Solid,
    Light,
}

/// What is drawn over a pixel that a surface passes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Two media meet.
    Interface,
    /// The medium is the same on both sides.
    Null,
    /// Of a solid or a light.
    Opaque,
}

/// One pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    pub filling: Filling,
    /// The medium that the second most surfaces around it speak for, if there is one.
    pub rival: Option<MediumId>,
    /// Whether there is a rival, or the answer rests on rays that did not agree.
    pub is_doubtful: bool,
    pub edge: Option<Edge>,
}

/// What one of the surfaces around a place says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Testimony {
    pub medium: MediumId,
    /// The object whose surface says so; `None`: nothing lies in that direction.
    pub object: Option<ObjectId>,
    /// Pixels to that surface; infinite without one.
    distance: f64,
    is_doubtful: bool,
}

/// A place of a slice, asked alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    pub cell: Cell,
    /// What the next surfaces to the left, to the right, above and below say.
    pub testimonies: Vec<Testimony>,
    /// The refractors that the place lies in, by rays in all directions and whatever the mode, in ascending order.
    pub refractors: Vec<ObjectId>,
}

/// A picture, and what its colours mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    pub mode: Mode,
    pub plane: Plane,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// sRGB, row 0 at the top. Each is the colour of one of `seen`.
    pub pixels: Vec<[u8; 3]>,
    /// How many pixels have each colour, most first.
    pub seen: Vec<(Ink, u64)>,
    /// Pixels that are filled with media, and those of them that are doubtful.
    pub media_pixels: u64,
    pub doubtful_pixels: u64,
    /// Whether some line is dotted: a surface with the same medium on both sides.
    pub has_null_edges: bool,
}

impl Slice {
    /// Cuts the scene, on rayon's current pool. `size` is at least 1 each way; lines are `line_width` pixels wide. `None` when `cancel` was
    /// set before all was done, and for a plane with numbers that are not finite.
    pub fn new(
        prepared: &Prepared,
        mode: Mode,
        plane: Plane,
        size: [u32; 2],
        line_width: f64,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let cut = Cut::new(prepared, mode, plane, size, cancel)?;
        paint::paint(&cut, mode, plane, line_width, cancel)
    }

    /// Share of the places in media that are doubtful, in [0, 1].
    pub fn doubtful_share(&self) -> f64 {
        self.doubtful_pixels as f64 / self.media_pixels.max(1) as f64
    }

    /// The last line of a legend.
    pub fn doubt_in_words(&self) -> String {
        match 100.0 * self.doubtful_share() {
            _ if self.doubtful_pixels == 0 => "no doubt".to_owned(),
            percent if percent < 0.1 => "striped: doubt, < 0.1 %".to_owned(),
            percent => format!("striped: doubt, {percent:.1} %"),
        }
    }
}

/// What a mode finds at a point in [0, 1]² of a slice of `size` pixels; `None` for a plane with numbers that are not finite.
pub fn probe(prepared: &Prepared, mode: Mode, plane: Plane, size: [u32; 2], point: [f64; 2]) -> Option<Probe> {
    let frame = Frame::new(&prepared.scene, plane, size)?;
    let at = DVec2::from(point) * DVec2::from(size.map(f64::from));
    let [row, column] = prepared.with_tracker(
        mode,
        Ask {
            prepared,
            mode,
            lines: |walk: &dyn Walker| {
                [walk.walk(frame.row(at.y), frame.right), walk.walk(frame.column(at.x), frame.down)]
                    .map(|line| line.scaled(frame.pixel))
            },
        },
    );
    let scene = &*prepared.scene;
    let place = frame.origin + (frame.right * at.x + frame.down * at.y) * frame.pixel;
    let votes = votes(&row, &column, at);
    let nowhere = || prepared.with_tracker(mode, AskPlace { scene, place });
    let cell = decide(scene, &votes, nowhere, filling_of_opaque(&row, &column, at));
    Some(Probe {
        cell,
        testimonies: votes.into_iter().flatten().collect(),
        refractors: containment(scene, place, None).refractors,
    })
}

/// The plane in pixels and local coordinates.
struct Frame {
    /// The upper left corner.
    origin: DVec3,
    right: DVec3,
    down: DVec3,
    /// Side of a pixel in scene units.
    pixel: f64,
}

impl Frame {
    fn new(scene: &Scene, plane: Plane, size: [u32; 2]) -> Option<Self> {
        let [width, height] = size.map(f64::from);
        if !plane.is_sound() || width < 1.0 || height < 1.0 {
            return None;
        }
        let pixel = plane.height / height;
        let radius = scene.geometry.bounding_sphere().map_or(0.0, |sphere| sphere.radius);
        let lift = plane.normal() * (LIFT * radius + BESIDE * pixel);
        let corner = plane.place(width / height, DVec2::ZERO);
        let origin = corner - scene.geometry.origin + lift;
        Some(Self { origin, right: plane.right, down: -plane.up, pixel })
    }

    /// Where the line through a height of the picture begins, at its left edge.
    fn row(&self, y: f64) -> DVec3 {
        self.origin + self.down * ((y + BESIDE) * self.pixel)
    }

    fn column(&self, x: f64) -> DVec3 {
        self.origin + self.right * ((x + BESIDE) * self.pixel)
    }
}

/// Every line of a slice.
struct Cut<'a> {
    scene: &'a Scene,
    size: [u32; 2],
    rows: Vec<Line>,
    columns: Vec<Line>,
    /// The medium of pixels that no surface speaks about. It is one and the same for all of them: one comes from each to each along lines that meet
    /// nothing.
    nowhere: MediumId,
}

impl<'a> Cut<'a> {
    fn new(prepared: &'a Prepared, mode: Mode, plane: Plane, size: [u32; 2], cancel: &AtomicBool) -> Option<Self> {
        let scene = &*prepared.scene;
        let frame = Frame::new(scene, plane, size)?;
        let [width, height] = size;
        let lines = |walk: &dyn Walker| -> Option<[Vec<Line>; 2]> {
            let line = |index: u32| {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                Some(
                    match index.checked_sub(height) {
                        None => walk.walk(frame.row(f64::from(index) + 0.5), frame.right),
                        Some(column) => walk.walk(frame.column(f64::from(column) + 0.5), frame.down),
                    }
                    .scaled(frame.pixel),
                )
            };
            let mut rows: Vec<Line> = (0..height + width).into_par_iter().map(line).collect::<Option<_>>()?;
            let columns = rows.split_off(height as usize);
            Some([rows, columns])
        };
        let [rows, columns] = prepared.with_tracker(mode, Ask { prepared, mode, lines })?;
        let silent = |lines: &[Line]| lines.iter().position(Line::is_silent);
        let nowhere = match (silent(&rows), silent(&columns)) {
            (Some(y), Some(x)) => {
                let pixel = DVec2::new(x as f64, y as f64) + 0.5;
                let place = frame.origin + (frame.right * pixel.x + frame.down * pixel.y) * frame.pixel;
                prepared.with_tracker(mode, AskPlace { scene, place })
            }
            _ => MediumId::WORLD,
        };
        Some(Self { scene, size, rows, columns, nowhere })
    }

    /// Pixels of a row.
    fn row(&self, y: u32, line_width: f64) -> impl Iterator<Item = Cell> + '_ {
        let row = &self.rows[y as usize];
        (0..self.size[0]).map(move |x| {
            let column = &self.columns[x as usize];
            let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let opaque = filling_of_opaque(row, column, at);
            let mut cell = decide(self.scene, &votes(row, column, at), || self.nowhere, opaque);
            cell.edge = row.edge_at(at.x, line_width).or_else(|| column.edge_at(at.y, line_width));
            cell
        })
    }
}

/// What the next surfaces to the left, to the right, above and below say.
fn votes(row: &Line, column: &Line, at: DVec2) -> [Option<Testimony>; 4] {
    let ([left, right], [above, below]) = (row.sides_of(at.x), column.sides_of(at.y));
    [left, right, above, below]
}

fn filling_of_opaque(row: &Line, column: &Line, at: DVec2) -> Option<Filling> {
    row.opaque_at(at.x).or_else(|| column.opaque_at(at.y))
}

/// The medium that most speak for; among equals that of the nearest surface.
fn decide(
    scene: &Scene,
    votes: &[Option<Testimony>; 4],
    nowhere: impl FnOnce() -> MediumId,
    opaque: Option<Filling>,
) -> Cell {
    if let Some(filling) = opaque {
        return Cell { filling, rival: None, is_doubtful: false, edge: None };
    }
    // (medium, votes, distance of the nearest)
    let mut candidates: [(MediumId, u32, f64); 4] = [(MediumId::WORLD, 0, f64::INFINITY); 4];
    let mut count = 0;
    for vote in votes.iter().flatten() {
        let medium = one_vacuum(scene, vote.medium);
        match candidates[..count].iter_mut().find(|candidate| candidate.0 == medium) {
            Some(candidate) => *candidate = (medium, candidate.1 + 1, candidate.2.min(vote.distance)),
            None => {
                candidates[count] = (medium, 1, vote.distance);
                count += 1;
            }
        }
    }
    let candidates = &mut candidates[..count];
    candidates.sort_unstable_by(|a, b| b.1.cmp(&a.1).then(a.2.total_cmp(&b.2)).then(a.0.cmp(&b.0)));
    let medium = candidates.first().map_or_else(|| one_vacuum(scene, nowhere()), |first| first.0);
    let rival = candidates.get(1).map(|second| second.0);
    let rests_on_doubt = votes.iter().flatten().any(|vote| vote.is_doubtful);
    Cell { filling: Filling::Medium(medium), rival, is_doubtful: rival.is_some() || rests_on_doubt, edge: None }
}

/// The reserved vacuum is the global medium where that is vacuum too.
fn one_vacuum(scene: &Scene, medium: MediumId) -> MediumId {
    if medium == MediumId::VACUUM && scene.world_is_vacuum { MediumId::WORLD } else { medium }
}

/// Walks lines with a mode that is known by then.
trait Walker: Sync {
    /// The line through a point (local coordinates). Lengths are in scene units.
    fn walk(&self, through: DVec3, direction: DVec3) -> Line;
}

impl<T: Tracker> Walker for Walk<'_, T> {
    fn walk(&self, through: DVec3, direction: DVec3) -> Line {
        self.along(through, direction)
    }
}

/// Calls `lines` with what walks by a mode.
struct Ask<'a, F> {
    prepared: &'a Prepared,
    mode: Mode,
    lines: F,
}

impl<R, F: FnOnce(&dyn Walker) -> R> WithTracker for Ask<'_, F> {
    type Output = R;

    fn run<T: Tracker>(self, tracker: &T) -> R {
        (self.lines)(&Walk { prepared: self.prepared, mode: self.mode, tracker })
    }
}

/// The medium at a place (local coordinates).
struct AskPlace<'a> {
    scene: &'a Scene,
    place: DVec3,
}

impl WithTracker for AskPlace<'_> {
    type Output = MediumId;

    fn run<T: Tracker>(self, tracker: &T) -> MediumId {
        tracker.medium_at(self.place).unwrap_or_else(|| medium_at(self.scene, self.place)).0
    }
}
