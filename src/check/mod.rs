//! What is wrong or doubtful in a scene, with advice.

mod mesh;
mod overlap;

use std::collections::HashSet;

use glam::DVec3;

use crate::optics::IorModel;
use crate::rectify::containment::containment;
use crate::render::Prepared;
use crate::scene::description::{Environment, Refractor};
use crate::scene::world::ObjectId;

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

/// Votes below this share of the rays are reported: the answer is doubtful, or the object has more than one surrounding.
const LEAST_CONFIDENCE: f64 = 0.9;

/// Everything doubtful that can be found in a scene that could be prepared, worst first. Takes milliseconds, or some tenths of a second
/// where meshes have a million triangles.
pub fn check(prepared: &Prepared) -> Vec<Problem> {
    let mut problems = mesh::problems(&prepared.description);
    problems.extend(overlap::problems(prepared));
    problems.extend(confidence(prepared));
    problems.extend(priorities(prepared));
    problems.extend(same_medium(prepared));
    problems.extend(media(prepared));
    problems.extend(light(prepared));
    problems.extend(camera(prepared));
    // Stable: findings of one severity stay in the order above.
    problems.sort_by_key(|problem| problem.severity);
    problems
}

/// Objects about whose exterior the pre-trace's rays disagree.
fn confidence(prepared: &Prepared) -> Vec<Problem> {
    let name = |container: Option<ObjectId>| {
        container.map_or("the world".to_owned(), |id| format!("`{}`", prepared.world.object(id).name))
    };
    let doubtful = prepared.table.patches.iter().filter(|patch| patch.rays > 0 && patch.confidence < LEAST_CONFIDENCE);
    doubtful
        .map(|patch| {
            let total: u32 = patch.votes.iter().map(|(_, count)| count).sum();
            let votes: Vec<String> = patch
                .votes
                .iter()
                // Rare misses are no answer.
                .filter(|&&(_, count)| 100 * count >= total)
                .map(|&(container, count)| format!("{} {:.0} %", name(container), f64::from(count) / f64::from(total) * 100.0))
                .collect();
            Problem::warning(
                &prepared.world.object(patch.refractor).name,
                "low_confidence",
                format!(
                    "the rays disagree about what lies outside: {}. Where its surroundings differ from place to place, one exterior for \
                     the whole object, as `rectified` keeps in this version, cannot be right; `reference` can",
                    votes.join(", ")
                ),
            )
        })
        .collect()
}

/// Priorities, which `rectified` does not use yet.
fn priorities(prepared: &Prepared) -> Option<Problem> {
    let names: Vec<&str> =
        prepared.description.refractors.iter().filter(|r| r.priority != 0).map(|r| r.name.as_str()).collect();
    (!names.is_empty()).then(|| {
        Problem::warning(
            names.join(", "),
            "priority_partly_used",
            "priorities decide overlaps in `reference` only so far: `rectified` keeps one exterior per object and does not ask them, \
             `naive` and `stack` have none",
        )
    })
}

/// Objects of the medium that surrounds them.
fn same_medium(prepared: &Prepared) -> Vec<Problem> {
    let invisible = prepared.table.patches.iter().filter(|patch| patch.inside == patch.outside);
    invisible
        .map(|patch| {
            let container = patch.outside_refractor.map_or("the world", |id| &prepared.world.object(id).name);
            Problem::advice(
                &prepared.world.object(patch.refractor).name,
                "same_medium",
                format!("it is of the same medium as `{container}`, which surrounds it, and so cannot be seen"),
            )
        })
        .collect()
}

fn media(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let used: HashSet<&str> = description.refractors.iter().map(|r: &Refractor| r.medium.as_str()).collect();
    let (used, unused): (Vec<_>, Vec<_>) = description.media.iter().partition(|m| used.contains(m.name.as_str()));
    let mut problems: Vec<Problem> = unused
        .iter()
        .map(|m| Problem::advice(&m.name, "unused_medium", "no refractor is made of this medium; remove it or use it"))
        .collect();
    let used = used.iter().map(|m| (m.name.as_str(), &m.ior));
    let dispersive: Vec<(&str, &IorModel)> = ([("world", &description.world.ior)].into_iter().chain(used))
        // A catalogue's entry is asked for by name, and its IOR is shown; a formula was written for its dispersion.
        .filter(|(_, ior)| ior.is_dispersive() && !matches!(ior, IorModel::Catalog(_)))
        .collect();
    if !dispersive.is_empty() {
        let names: Vec<&str> = dispersive.iter().map(|(name, _)| *name).collect();
        let values: Vec<String> = dispersive.iter().map(|(name, ior)| format!("{name} {:.4}", ior.ior())).collect();
        problems.push(Problem::advice(
            names.join(", "),
            "dispersion",
            format!("dispersion is not rendered yet: every colour gets the IOR at 587.56 nm ({})", values.join(", ")),
        ));
    }
    problems
}

fn light(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let mut problems = Vec::new();
    if let Environment::Image { path, image, .. } = &description.environment
        && image.clipped > 0
    {
        problems.push(Problem::warning(
            path.to_string_lossy(),
            "clipped_pixels",
            format!("{} components of the environment image were negative and have been set to 0", image.clipped),
        ));
    }
    let is_dark_around = match &description.environment {
        Environment::Color(color) => *color == [0.0; 3],
        Environment::Gradient { zenith, horizon, nadir } => [zenith, horizon, nadir] == [&[0.0; 3]; 3],
        Environment::Image { image, scale, .. } => *scale == 0.0 || image.pixels.iter().all(|p| *p == [0.0; 3]),
    };
    if is_dark_around && description.lights.iter().all(|light| light.radiance == [0.0; 3]) {
        problems.push(Problem::advice(
            "scene",
            "no_light",
            "nothing emits, so the picture is black: add an [environment] or a [[light]]",
        ));
    }
    problems
}

fn camera(prepared: &Prepared) -> Vec<Problem> {
    let world = &*prepared.world;
    let found = containment(world, prepared.description.camera.position - world.geometry.origin, None);
    let mut problems = Vec::new();
    if found.is_ambiguous {
        problems.push(Problem::warning(
            "camera",
            "camera_ambiguous",
            "it cannot be told for certain which refractors contain the camera: it stands on a surface, or in an open mesh",
        ));
    }
    if !found.refractors.is_empty() {
        let names: Vec<String> = found.refractors.iter().map(|&id| format!("`{}`", world.object(id).name)).collect();
        problems.push(Problem::advice(
            "camera",
            "camera_inside",
            format!(
                "the camera is inside {}: `naive` and `stack` begin each path as if it were not, `rectified` and `reference` do not",
                names.join(", ")
            ),
        ));
    }
    problems
}

#[cfg(test)]
mod tests;
