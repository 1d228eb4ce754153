//! What is wrong or doubtful in a scene, with advice.

mod crowded;
mod mesh;
mod overlap;

use std::collections::HashSet;

use glam::DVec3;

use crate::optics::IorModel;
use crate::rectify::containment::containment;
use crate::render::Prepared;
use crate::scene::description::{Environment, Refractor};

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
    let mut problems = mesh::problems(prepared);
    problems.extend(overlap::problems(prepared));
    problems.extend(crowded::problems(prepared));
    problems.extend(confidence(prepared));
    problems.extend(media(prepared));
    problems.extend(light(prepared));
    problems.extend(camera(prepared));
    // Stable: findings of one severity stay in the order above.
    problems.sort_by_key(|problem| problem.severity);
    problems
}

/// Patches about whose surroundings the pre-trace's rays disagree.
fn confidence(prepared: &Prepared) -> Vec<Problem> {
    let world = &*prepared.world;
    let doubtful = prepared.table.patches.iter().filter(|patch| patch.confidence < LEAST_CONFIDENCE);
    doubtful
        .map(|patch| {
            let votes: Vec<String> = (patch.votes.iter().filter(|vote| vote.share() < 1.0))
                .map(|vote| {
                    let share = 100.0 * f64::from(vote.inside) / f64::from(vote.asked);
                    format!("{share:.0} % of the rays find it in `{}`", world.object(vote.refractor).name)
                })
                .collect();
            Problem::warning(
                &world.object(patch.refractor).name,
                "low_confidence",
                format!(
                    "what lies outside patch {} is doubtful: {}. Look for holes in the meshes named, and close them",
                    patch.index,
                    votes.join(", ")
                ),
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
