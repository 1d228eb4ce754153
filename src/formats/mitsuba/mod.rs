//! Scenes of Mitsuba 3 (`.xml`), and what of older ones is alike.
//!
//! Read is the part that scenes of nested dielectrics use: shapes and their instances with their transforms, dielectrics with the media that are
//! declared on both sides, opaque BSDFs as diffuse surfaces or mirrors, emitters, and the camera. The rest is approximated or left out, and said once
//! a kind.

mod bsdf;
mod camera;
mod emitters;
mod medium;
mod shapes;
#[cfg(test)]
mod tests;
mod transform;
mod tree;
mod values;

use std::collections::HashMap;

use self::tree::Node;
use super::files::Input;
use super::importing::{Importer, at};
use crate::scene::{Description, SceneError};

/// Elements that say how to render, which is not the scene's affair here.
const PASSED_OVER: [&str; 5] = ["integrator", "sampler", "film", "rfilter", "default"];

/// Most references from one element to the next.
const MOST_REFERENCES: usize = 64;

pub(super) fn read(input: &Input<'_>) -> Result<Description, SceneError> {
    let mut importer = Importer::new("Mitsuba", input);
    let root = tree::read(&mut importer)?;
    let ids = tree::ids(&root);
    let mut reader = Reader { importer, ids, visits: 0, colors: 0 };
    for node in &root.children {
        match node.tag.as_str() {
            "shape" => shapes::add(&mut reader, node)?,
            "sensor" => camera::read(&mut reader, node)?,
            "emitter" => emitters::add(&mut reader, node)?,
            // They are read where they are used.
            "bsdf" | "medium" | "texture" | "phase" | "spectrum" | "rgb" => {}
            tag if PASSED_OVER.contains(&tag) => {}
            tag => {
                let message = format!("the scene's element <{tag}> is not read");
                reader.importer.note("left_out", &node.place, message);
            }
        }
    }
    reader.importer.finish()
}

/// What is known while a scene is read.
struct Reader<'a, 't> {
    importer: Importer<'a>,
    /// Elements by their ids.
    ids: HashMap<&'t str, &'t Node>,
    /// Shapes that were looked at, instances and groups too.
    visits: usize,
    /// Colours that the present one stands in.
    colors: usize,
}

impl<'t> Reader<'_, 't> {
    /// The element itself, or the one that a reference names.
    fn resolved(&self, node: &'t Node) -> Result<&'t Node, SceneError> {
        let mut node = node;
        for _ in 0..MOST_REFERENCES {
            if node.tag != "ref" {
                return Ok(node);
            }
            node = self.ids.get(node.id.as_str()).copied().ok_or_else(|| {
                at(&node.place, format!("there is no element with the id `{}`, which is referred to here", node.id))
            })?;
        }
        Err(at(&node.place, "references lead in a circle"))
    }

    /// The children with references resolved, each with the name by which its parent knows it.
    fn children(&self, node: &'t Node) -> Result<Vec<(&'t str, &'t Node)>, SceneError> {
        node.children.iter().map(|child| Ok((child.name.as_str(), self.resolved(child)?))).collect()
    }
}
