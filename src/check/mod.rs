//! What is wrong or doubtful in a scene, with advice.

mod camera;
mod confidence;
mod crowded;
mod declared;
mod enclosed;
mod film;
mod flush;
mod index;
mod lamp;
mod media;
mod mesh;
mod names;
mod nested;
mod notes;
mod overlap;
mod placed;
mod rims;
mod samples;
mod unrendered;
pub mod verdict;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::DVec3;

pub use self::unrendered::unrendered;

use crate::rectify::{Cancelled, Progress};
use crate::scene::LoadNote;
use crate::scene::description::{Environment, Light, Object, Paint};
use crate::tracking::Prepared;

/// How bad a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The scene cannot be rendered.
    Error,
    /// The picture may be wrong.
    Warning,
    /// Something that the author may not have meant.
    Advice,
}

/// A place in the scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spot {
    /// In scene coordinates.
    pub center: DVec3,
    /// Radius of the region concerned, in scene units, > 0.
    pub radius: f64,
}

impl Spot {
    /// Around places whose coordinates count from `origin`.
    fn around(places: impl Iterator<Item = DVec3>, origin: DVec3) -> Self {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = places.fold(none, |(min, max), place| (min.min(place), max.max(place)));
        Self { center: (min + max) / 2.0 + origin, radius: (max - min).length() / 2.0 }
    }
}

/// One finding.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Problem {
    pub severity: Severity,
    /// The object, medium or key concerned, by name; several are separated by commas.
    #[serde(rename = "where")]
    pub place: String,
    /// A stable word for the kind of problem, such as `unused_medium`.
    pub kind: &'static str,
    /// What is wrong and what to do about it.
    pub message: String,
    /// Where it can be seen, if it is not everywhere on the objects concerned.
    pub spot: Option<Spot>,
}

impl Problem {
    fn warning(place: impl Into<String>, kind: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, place: place.into(), kind, message: message.into(), spot: None }
    }

    /// The same problem, to be seen within `radius` of `center` (scene coordinates).
    #[must_use]
    fn at(self, center: DVec3, radius: f64) -> Self {
        Self { spot: Some(Spot { center, radius }), ..self }
    }

    fn advice(place: impl Into<String>, kind: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Advice, place: place.into(), kind, message: message.into(), spot: None }
    }
}

/// Everything doubtful that can be found in a scene that could be prepared, worst first. Takes milliseconds, or some tenths of a second
/// where meshes have a million triangles; with thousands of objects in each other seconds.
pub fn check(prepared: &Prepared) -> Vec<Problem> {
    check_watched(prepared, &Progress::new()).expect("nobody can cancel it")
}

/// [`check`], which can be ended early.
///
/// # Errors
/// When `progress` is cancelled.
pub fn check_watched(prepared: &Prepared, progress: &Progress) -> Result<Vec<Problem>, Cancelled> {
    let mut doubts = confidence::doubts(prepared);
    let rims = rims::joined(prepared);
    let mut problems = mesh::problems(prepared, &rims, &mut doubts);
    progress.go_on()?;
    let encounters = prepared.table.encounters(&prepared.scene);
    let parts: [&dyn Fn() -> Vec<Problem>; 16] = [
        &|| notes::problems(prepared),
        &|| overlap::problems(prepared, &encounters, &rims),
        &|| crowded::problems(prepared),
        &|| declared::problems(prepared, &rims, progress),
        &|| confidence::problems(prepared, &doubts),
        &|| film::problems(prepared, progress),
        &|| enclosed::problems(prepared),
        &|| index::problems(prepared),
        &|| flush::problems(prepared, &encounters).into_iter().collect(),
        &|| media::problems(prepared),
        &|| unrendered(&prepared.description),
        &|| light(prepared),
        &|| textures(prepared),
        &|| lamp::problems(prepared),
        &|| placed::problems(prepared),
        &|| camera::problems(prepared),
    ];
    for part in parts {
        progress.go_on()?;
        problems.extend(part());
    }
    progress.go_on()?;
    // Stable: findings of one severity stay in the order above.
    problems.sort_by_key(|problem| problem.severity);
    Ok(problems)
}

/// Each once, in ascending order.
fn distinct<T: Ord>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    BTreeSet::from_iter(all).into_iter().collect()
}

fn light(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let mut problems = Vec::new();
    if let Environment::Image { path, image, .. } = &description.environment {
        problems.extend(image.notes.iter().map(|note| image_note(&path.to_string_lossy(), note)));
    }
    let is_dark_around = match &description.environment {
        Environment::Color(color) => *color == [0.0; 3],
        Environment::Gradient { zenith, horizon, nadir } => [zenith, horizon, nadir] == [&[0.0; 3]; 3],
        Environment::Image { image, scale, .. } => *scale == 0.0 || image.pixels.iter().all(|p| *p == [0.0; 3]),
    };
    if is_dark_around && description.objects.iter().filter_map(Object::light).all(Light::is_black) {
        problems.push(Problem::advice(
            "scene",
            "no_light",
            "nothing emits, so the picture is black: add an [environment] or a [[light]]",
        ));
    }
    problems
}

/// What reading the images of solids replaced, once for each file.
fn textures(prepared: &Prepared) -> Vec<Problem> {
    let notes: BTreeMap<&Path, &[LoadNote]> = (prepared.description.objects.iter())
        .filter_map(|object| match &object.solid()?.paint {
            Paint::Texture { path, image, .. } => Some((path.as_path(), &*image.notes)),
            Paint::Color(_) | Paint::Checker { .. } => None,
        })
        .collect();
    let problem = |path: &Path, note: &LoadNote| image_note(&path.to_string_lossy(), note);
    notes.into_iter().flat_map(|(path, notes)| notes.iter().map(move |note| problem(path, note))).collect()
}

/// What reading an image replaced is doubtful; what it converted or passed over may not have been meant.
fn image_note(path: &str, note: &LoadNote) -> Problem {
    match note.kind {
        "clipped_pixels" | "replaced_pixels" | "clipped_texels" => Problem::warning(path, note.kind, &note.message),
        kind => Problem::advice(path, kind, &note.message),
    }
}

#[cfg(test)]
mod tests;
