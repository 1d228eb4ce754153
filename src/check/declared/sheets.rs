//! Scenes modelled as interfaces: open sheets, each with the media on both of its sides. Nothing lies between a sheet's side and the next surface
//! along a ray, so both must name the same medium there.

use std::collections::BTreeMap;

use super::{is_alike, share, word};
use crate::check::{Problem, samples};
use crate::geometry::{Ray, SurfacePoint};
use crate::rectify::containment::medium_of;
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::Prepared;

/// Rays from each side of a sheet.
const RAYS: u32 = 256;
/// Share of a side's rays that find another medium before it is said.
const LEAST: f64 = 0.02;

/// A side of a surface: its object, and whether it is the outer one.
type Side = (ObjectId, bool);

pub(super) fn problems(prepared: &Prepared, sheets: &[ObjectId]) -> Vec<Problem> {
    let scene = &*prepared.scene;
    // Of each two sides, the rays between them that find two media, as a share of those from one side.
    let mut found: BTreeMap<(Side, Side), f64> = BTreeMap::new();
    for &sheet in sheets.iter().filter(|id| scene.declared.outside(**id).is_some()) {
        for is_outer in [true, false] {
            let side = (sheet, is_outer);
            for (point, direction) in samples::of_surface(&scene.geometry, sheet.0, 0..RAYS) {
                let Some(met) = next_side(scene, &point, direction, is_outer) else { continue };
                if met != side && !is_alike(scene, medium_on(scene, side), medium_on(scene, met)) {
                    *found.entry((side.min(met), side.max(met))).or_default() += 1.0 / f64::from(RAYS);
                }
            }
        }
    }
    found.into_iter().filter(|(_, part)| *part >= LEAST).map(|(sides, part)| problem(scene, sides, part)).collect()
}

/// What is declared on a side.
fn medium_on(scene: &Scene, (object, is_outer): Side) -> MediumId {
    match is_outer {
        true => scene.declared.outside(object).unwrap_or(MediumId::WORLD),
        false => medium_of(scene, Some(object)),
    }
}

/// The refractor's side that a ray from one side of a surface meets first; `None` where that is no refractor, or nothing at all.
fn next_side(scene: &Scene, point: &SurfacePoint, direction: glam::DVec3, is_outer: bool) -> Option<Side> {
    let normal = if is_outer { point.normal } else { -point.normal };
    let direction =
        if direction.dot(normal) < 0.0 { direction - 2.0 * direction.dot(normal) * normal } else { direction };
    let hit = scene.geometry.closest(&Ray::leaving(point.position, direction, point.primitive))?;
    let object = ObjectId(scene.geometry.object_of(hit.primitive));
    scene.is_refractor(object).then_some((object, hit.is_front))
}

fn problem(scene: &Scene, sides: (Side, Side), part: f64) -> Problem {
    let in_words = |side: Side| {
        let which = if side.1 { "outer" } else { "inner" };
        format!("{} on the {which} side of `{}`", word(scene, medium_on(scene, side)), scene.object(side.0).name)
    };
    let [a, b] = [sides.0, sides.1].map(|(object, _)| scene.object(object).name.as_str());
    let place = if a == b { a.to_owned() } else { format!("{a}, {b}") };
    let message = format!(
        "nothing lies between the two, and yet they declare different media there: {}, {}. {} of the rays from one meet the other. Make both \
         declarations the same, or close the gap between the surfaces",
        in_words(sides.0),
        in_words(sides.1),
        share(part.min(1.0), 1.0)
    );
    Problem::warning(place, "declared_contradiction", message)
}
