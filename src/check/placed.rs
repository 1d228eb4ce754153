//! Lights without a surface whose surroundings are doubtful, and lights whose second side is lost.

use super::{Problem, names};
use crate::rectify::PatchKind;
use crate::scene::description::{Object, Shape};
use crate::tracking::Prepared;

/// A smaller share of the votes about where a light stands is doubtful.
const CLEAR_SHARE: f64 = 0.75;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let objects = prepared.description.objects.lights().iter().filter(|object| object.visible);
    objects.filter_map(two_sides).chain(places(prepared)).collect()
}

/// Where rectification is in doubt about what a light stands in.
fn places(prepared: &Prepared) -> impl Iterator<Item = Problem> {
    let (scene, table) = (&*prepared.scene, &*prepared.table);
    table.lights.iter().filter(|patch| patch.faces == 0).filter_map(|patch| {
        let name = &scene.object(patch.refractor).name;
        if patch.kind == PatchKind::Mixed {
            let around = names::list_of(scene, &patch.crossed_by);
            return Some(Problem::warning(
                name,
                "light_on_surface",
                format!(
                    "it stands on the surface of {around}, where two media meet: what it shines into differs from one direction to the \
                     other. Move it to one side"
                ),
            ));
        }
        (patch.confidence < CLEAR_SHARE).then(|| {
            Problem::warning(
                name,
                "light_medium_doubtful",
                format!(
                    "the rays that ask what it stands in do not agree: {:.0} % of them say {}. Repair the meshes around it",
                    100.0 * patch.confidence,
                    patch.outside.map_or("nothing", |medium| &scene.medium(medium).name)
                ),
            )
        })
    })
}

/// What a closed shape emits inward gets nowhere.
fn two_sides(object: &Object) -> Option<Problem> {
    let is_closed = !matches!(object.shape, Shape::Quad { .. } | Shape::Mesh { .. });
    (object.light()?.two_sided && object.shape.has_surface() && is_closed).then(|| {
        Problem::advice(
            &object.name,
            "two_sided_and_closed",
            "it emits from both sides, but nothing is inside of it: half of its power is lost there. Remove `two_sided`",
        )
    })
}
