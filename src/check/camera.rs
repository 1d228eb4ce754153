//! Where the camera stands.

use super::Problem;
use crate::rectify::containment::containment;
use crate::tracking::Prepared;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let found = containment(scene, prepared.description.camera.position - scene.geometry.origin, None);
    let mut problems = Vec::new();
    if found.is_ambiguous {
        problems.push(Problem::warning(
            "camera",
            "camera_ambiguous",
            "it cannot be told for certain which refractors contain the camera: it stands on a surface, or in an open mesh",
        ));
    }
    if !found.refractors.is_empty() {
        let names: Vec<String> = found.refractors.iter().map(|&id| format!("`{}`", scene.object(id).name)).collect();
        problems.push(Problem::advice(
            "camera",
            "camera_inside",
            format!(
                "the camera is inside {}: `naive`, `stack` and `priority` begin each path as if it were not, `rectified` and `reference` do not",
                names.join(", ")
            ),
        ));
    }
    problems
}
