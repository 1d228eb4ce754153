//! Media: what they absorb.

use super::Reader;
use super::tree::Node;
use super::values::{color_of, number_of};
use crate::formats::importing::media::Side;
use crate::scene::SceneError;

/// What is known of a medium: its absorption and its name, but not its index, which BSDFs have.
pub(super) fn medium<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Side, SceneError> {
    let mut side = Side { absorption: Some([0.0; 3]), name: node.id.clone(), ..Side::default() };
    if node.kind != "homogeneous" {
        let message = format!("media of the type {} are taken for clear", node.kind);
        reader.importer.note("medium", &node.place, message);
        return Ok(side);
    }
    let scale = number_of(node, "scale")?.unwrap_or(1.0);
    let sigma_a = color_of(reader, node, "sigma_a")?;
    let absorption = match (sigma_a, color_of(reader, node, "sigma_t")?) {
        (Some(sigma_a), None) => {
            if color_of(reader, node, "sigma_s")?.is_some_and(|sigma_s| sigma_s != [0.0; 3]) {
                scattering(reader, node);
            }
            sigma_a
        }
        (_, sigma_t) => {
            let sigma_t = sigma_t.unwrap_or([1.0; 3]);
            let albedo = color_of(reader, node, "albedo")?.unwrap_or([0.75; 3]);
            if albedo != [0.0; 3] {
                scattering(reader, node);
            }
            [0, 1, 2].map(|k| sigma_t[k] * (1.0 - albedo[k]))
        }
    };
    let fine = |x: f64| if x.is_finite() { x.max(0.0) } else { 0.0 };
    side.absorption = Some(absorption.map(|sigma| fine(sigma * scale)));
    Ok(side)
}

fn scattering(reader: &mut Reader<'_, '_>, node: &Node) {
    reader.importer.note("scattering", &node.place, "media do not scatter here: they absorb what they would absorb");
}

/// The medium that a sensor or an emitter is declared to be in.
pub(super) fn around<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<Option<Side>, SceneError> {
    let found = reader.children(node)?.into_iter().find(|(_, child)| child.tag == "medium");
    found.map(|(_, child)| medium(reader, child)).transpose()
}
