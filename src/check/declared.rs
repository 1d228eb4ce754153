//! What a scene declares of media, held against what rectification found: a linter for files of renderers that are told both sides of every
//! surface. Of scenes that declare nothing there is nothing to say.

mod sheets;

use std::collections::BTreeMap;

use super::names::{self, brief};
use super::rims::Rims;
use super::{Problem, confidence, samples};
use crate::geometry::Enclosure;
use crate::rectify::containment::{containment, containment_beside, medium_of, top};
use crate::rectify::{Patch, PatchKind, Progress};
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::Prepared;

/// Points of an object at which it is asked what lies on both sides of its mixed patches, and of all objects together where there are many.
const POINTS: std::ops::RangeInclusive<u32> = 64..=1024;
const ALL_POINTS: u32 = 1 << 16;
/// A smaller share of an object's surface is not worth a word: facets of curved surfaces cross each other by so much.
const LEAST: f64 = 0.002;
/// Indices that differ by less, relatively, bend light alike for the eye: air and vacuum do.
const ALIKE: f64 = 5e-4;

/// Incomplete once `progress` is cancelled.
pub(super) fn problems(prepared: &Prepared, rims: &Rims, progress: &Progress) -> Vec<Problem> {
    let scene = &*prepared.scene;
    if scene.declared.is_empty() {
        return Vec::new();
    }
    let refractors = || scene.refractors().map(|(id, _)| id);
    let are_sheets = |id: &ObjectId| scene.object(*id).enclosure == Enclosure::Sheet || rims.contains_key(id);
    let mut problems: Vec<Problem> = Vec::new();
    let is_mixed = |id: &ObjectId| prepared.table.patches_of(*id).iter().any(|patch| patch.kind == PatchKind::Mixed);
    let mixed = refractors().filter(is_mixed).count() as u32;
    let points = (ALL_POINTS / mixed.max(1)).clamp(*POINTS.start(), *POINTS.end());
    for refractor in refractors().filter(|id| !are_sheets(id)) {
        if progress.is_cancelled() {
            return problems;
        }
        let found = Found::of(prepared, refractor, points);
        problems.extend(outside(prepared, refractor, &found));
        problems.extend(inside(prepared, refractor, &found));
    }
    problems.extend(camera(prepared));
    problems.extend(lights(prepared));
    problems.extend(sheets::problems(prepared, &refractors().filter(are_sheets).collect::<Vec<_>>()));
    problems
}

/// What lies on both sides of an object's surface, by area in scene units squared.
#[derive(Debug, Default)]
struct Found {
    outsides: BTreeMap<MediumId, f64>,
    /// Where another refractor fills the inner side.
    fillers: BTreeMap<ObjectId, f64>,
    /// All of it.
    area: f64,
}

impl Found {
    fn of(prepared: &Prepared, object: ObjectId, points: u32) -> Self {
        let (scene, table) = (&*prepared.scene, &*prepared.table);
        let mut found = Self::default();
        let mut mixed = 0.0;
        for patch in table.patches_of(object) {
            found.area += patch.area;
            match (patch.kind, patch.outside) {
                (PatchKind::Mixed, _) => mixed += patch.area,
                (PatchKind::Clear | PatchKind::Null, Some(outside)) => {
                    let filler = patch.inside_refractor.filter(|filler| *filler != object);
                    found.add(patch.area, outside, filler);
                }
                _ => {}
            }
        }
        if mixed > 0.0 {
            let points: Vec<_> = samples::of_surface(&scene.geometry, object.0, 0..points)
                .map(|(point, _)| point)
                .filter(|point| {
                    let patch = table.patch_of(&scene.geometry, point.primitive);
                    patch.is_some_and(|patch| patch.kind == PatchKind::Mixed)
                })
                .collect();
            let each = mixed / points.len().max(1) as f64;
            for point in &points {
                let beside = |is_outer| containment_beside(scene, point, is_outer).refractors;
                let outer = top(scene, beside(true).iter().copied());
                // The object itself is not among what is asked about.
                let inner = top(scene, beside(false).iter().copied().chain([object]));
                found.add(each, medium_of(scene, outer), inner.filter(|filler| *filler != object));
            }
        }
        found
    }

    fn add(&mut self, area: f64, outside: MediumId, filler: Option<ObjectId>) {
        match filler {
            // No interface of its own is there, so nothing lies outside of it.
            Some(filler) => *self.fillers.entry(filler).or_default() += area,
            None => *self.outsides.entry(outside).or_default() += area,
        }
    }
}

/// Whether light takes two media for one, or nearly so.
fn is_alike(scene: &Scene, a: MediumId, b: MediumId) -> bool {
    let [x, y] = [a, b].map(|id| scene.medium(id));
    a == b || (x.absorption == y.absorption && (x.ior() / y.ior() - 1.0).abs() < ALIKE)
}

/// `` `water` (IOR 1.333) ``; media of one index are told apart by what they absorb.
fn word(scene: &Scene, id: MediumId) -> String {
    let medium = scene.medium(id);
    format!("`{}` (IOR {})", medium.name, brief(medium.ior(), 5))
}

/// "83 %", "0.4 %", "all".
fn share(part: f64, all: f64) -> String {
    match 100.0 * part / all {
        percent if percent > 99.5 => "all".to_owned(),
        percent if percent < 9.95 => format!("{} %", brief(percent, 2)),
        percent => format!("{percent:.0} %"),
    }
}

/// Another medium lies outside of an object than is declared.
fn outside(prepared: &Prepared, object: ObjectId, found: &Found) -> Option<Problem> {
    let scene = &*prepared.scene;
    let told = scene.declared.outside(object);
    let declared = told.unwrap_or(MediumId::WORLD);
    let wrong = |medium: MediumId| !is_alike(scene, medium, declared);
    let mut media: Vec<(MediumId, f64)> = found.outsides.iter().map(|(medium, area)| (*medium, *area)).collect();
    media.retain(|(_, area)| *area >= LEAST * found.area);
    media.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let total: f64 = media.iter().map(|(_, area)| area).sum();
    let (most, area) = *media.iter().find(|(medium, _)| wrong(*medium))?;
    let name = &scene.object(object).name;
    let start = match told {
        Some(declared) => format!("it declares {} outside", word(scene, declared)),
        None => format!("it declares nothing outside, which stands for {}", word(scene, declared)),
    };
    let differs = match scene.medium(most).ior() / scene.medium(declared).ior() {
        ratio if (ratio - 1.0).abs() < ALIKE => " The two absorb differently.",
        _ => "",
    };
    let message = if let [_] = media[..] {
        let patches = prepared.table.patches_of(object).len();
        let parts = if patches > 1 { format!(", on every one of its {patches} patches,") } else { String::new() };
        let of = share(area, found.area);
        let of = if of == "all" { "all".to_owned() } else { format!("all that shows ({of})") };
        let renderer = in_renderer(prepared, object, most);
        format!(
            "{start}, but {of} of its surface{parts} lies in {}: declare `{}`.{renderer}{differs}",
            word(scene, most),
            scene.medium(most).name
        )
    } else {
        let list: Vec<String> = (media.iter())
            .map(|(medium, area)| {
                let (share, medium) = (share(*area, total), word(scene, *medium));
                format!("{share} of its surface (area {}) lies in {medium}", brief(*area, 3))
            })
            .collect();
        format!(
            "{start}, but {}: no single exterior is right. Split its mesh where the surroundings change, and declare {} on the parts{differs}",
            list.join(", "),
            names::list(media.iter().map(|(medium, _)| scene.medium(*medium).name.as_str()))
        )
    };
    let problem = match told {
        Some(_) => Problem::warning(name, "declared_outside", message),
        None => Problem::advice(name, "declared_outside", message),
    };
    let patches = prepared.table.patches_of(object);
    let is_wrong = |patch: &&Patch| patch.outside.map_or(patch.kind == PatchKind::Mixed, wrong);
    let largest = patches.iter().filter(is_wrong).max_by(|a, b| a.area.total_cmp(&b.area));
    let spot = largest.filter(|_| patches.len() > 1).map(|patch| confidence::spot(prepared, patch));
    Some(Problem { spot, ..problem })
}

/// What to write in the file of another renderer, so that `found` is outside of an object.
fn in_renderer(prepared: &Prepared, object: ObjectId, found: MediumId) -> String {
    let scene = &*prepared.scene;
    let (inside, outside) = (scene.medium(medium_of(scene, Some(object))), scene.medium(found));
    let (own, around) = (brief(inside.ior(), 5), brief(outside.ior(), 5));
    let absorbs = !outside.absorption.is_black();
    let import = prepared.description.source.as_deref().and_then(|source| source.import.as_ref());
    match import.map(|import| import.format) {
        Some("Mitsuba") => {
            let medium =
                if absorbs { format!(", and the medium `{}` as its exterior", outside.name) } else { String::new() };
            format!(" In Mitsuba: ext_ior = {around}{medium}.")
        }
        // No medium has an index below 1: it is the ratio already, of media that the file does not name.
        Some("pbrt") if inside.ior() < 1.0 => {
            let absolute = brief(inside.ior() * outside.ior(), 5);
            format!(
                " In pbrt: eta = {own} is the ratio {absolute}/{around} already; name the media of both surfaces by MediumInterface, so that it is \
                 known what lies outside."
            )
        }
        Some("pbrt") => {
            let ratio = brief(inside.ior() / outside.ior(), 5);
            format!(" In pbrt: eta = {ratio} ({own}/{around}), and `{}` outside in its MediumInterface.", outside.name)
        }
        Some("glTF") => " Renderers of glTF take the world there: no glTF file can say otherwise.".to_owned(),
        _ => String::new(),
    }
}

/// A part of an object's surface is no interface, because another refractor fills both of its sides or its inner side.
fn inside(prepared: &Prepared, object: ObjectId, found: &Found) -> Option<Problem> {
    let scene = &*prepared.scene;
    scene.declared.outside(object)?;
    let own = medium_of(scene, Some(object));
    let is_other = |filler: &ObjectId| !is_alike(scene, medium_of(scene, Some(*filler)), own);
    let (filler, area) = (found.fillers.iter())
        .filter(|(filler, area)| is_other(filler) && **area >= LEAST * found.area)
        .max_by(|a, b| a.1.total_cmp(b.1))?;
    let (name, filler) = (&scene.object(object).name, &scene.object(*filler).name);
    Some(Problem::advice(
        name,
        "declared_overlap",
        format!(
            "{} of its surface lies inside `{filler}`, which fills the overlap: a renderer that is told {} inside and its declaration outside sees \
             an interface there that is none. Cut that part off",
            share(*area, found.area),
            word(scene, own)
        ),
    ))
}

fn camera(prepared: &Prepared) -> Option<Problem> {
    let scene = &*prepared.scene;
    let found = containment(scene, prepared.description.camera.position - scene.geometry.origin, None);
    let medium = medium_of(scene, top(scene, found.refractors.iter().copied()));
    let told = scene.declared.camera;
    if found.is_ambiguous || is_alike(scene, medium, told.unwrap_or(MediumId::WORLD)) {
        return None;
    }
    let (is, name) = (word(scene, medium), &scene.medium(medium).name);
    let message = match told {
        None => format!(
            "the camera is inside {is}, but the scene declares no medium for it, which stands for `world`: declare `{name}`"
        ),
        Some(told) => {
            format!("the scene declares the camera to be in {}, but it is in {is}: declare `{name}`", word(scene, told))
        }
    };
    Some(Problem::warning("camera", "declared_camera", message))
}

/// Lights that are declared to be elsewhere than they are. The index around a light changes nothing there, so without a declaration only media that
/// absorb are looked at.
fn lights(prepared: &Prepared) -> impl Iterator<Item = Problem> {
    let scene = &*prepared.scene;
    (prepared.table.lights.chunk_by(|a, b| a.refractor == b.refractor)).filter_map(|patches| {
        let light = patches[0].refractor;
        let told = scene.declared.outside(light);
        let declared = told.unwrap_or(MediumId::WORLD);
        let is_wrong = |medium: MediumId| match told {
            Some(_) => !is_alike(scene, medium, declared),
            None => scene.medium(medium).absorption != scene.medium(declared).absorption,
        };
        let wrong = patches.iter().filter(|patch| patch.outside.is_some_and(is_wrong));
        let largest = wrong.max_by(|a, b| a.area.total_cmp(&b.area))?;
        let medium = largest.outside?;
        let start = match told {
            Some(_) => format!("the scene declares it to be in {}", word(scene, declared)),
            None => "the scene declares no medium for this light, which stands for `world`".to_owned(),
        };
        let part = if patches.len() > 1 { "a part of it" } else { "it" };
        let (is, name) = (word(scene, medium), &scene.medium(medium).name);
        Some(Problem::advice(
            &scene.object(light).name,
            "declared_light",
            format!(
                "{start}, but {part} stands in {is}: declare `{name}`, so that its light is absorbed from the start"
            ),
        ))
    })
}

#[cfg(test)]
mod tests;
