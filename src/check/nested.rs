//! Parts of a mesh that lie in another part of it.

use super::Spot;
use crate::rectify::PatchKind;
use crate::rectify::subjects::primitives_of;
use crate::scene::ObjectId;
use crate::tracking::Prepared;

/// The components of a refractor of which nothing is to be seen because the refractor itself lies on both sides, and a sphere around them;
/// `None` if there are none.
pub(super) fn hidden(prepared: &Prepared, object: ObjectId) -> Option<(u64, Spot)> {
    let scene = &*prepared.scene;
    let topology = scene.object(object).topology.as_ref()?;
    let mut is_hidden = vec![true; topology.components as usize];
    for (face, &component) in primitives_of(&scene.geometry, object).zip(&topology.component_of_face) {
        let is_between_itself = prepared.table.patch_of(&scene.geometry, face).is_some_and(|patch| {
            patch.kind == PatchKind::Null
                && patch.outside_refractor == Some(object)
                && patch.inside_refractor == Some(object)
        });
        is_hidden[component as usize] &= is_between_itself;
    }
    let count = is_hidden.iter().filter(|hidden| **hidden).count() as u64;
    let faces = primitives_of(&scene.geometry, object).zip(&topology.component_of_face);
    let hidden = faces.filter(|(_, component)| is_hidden[**component as usize]);
    let corners = hidden.flat_map(|(face, _)| scene.geometry.corners(face));
    (count > 0).then(|| (count, Spot::around(corners, scene.geometry.origin)))
}
