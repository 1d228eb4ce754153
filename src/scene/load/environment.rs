//! The `[environment]` section.

use std::path::PathBuf;
use std::sync::Arc;

use super::files::Files;
use super::image;
use super::node::{Node, Table};
use crate::scene::SceneError;
use crate::scene::description::Environment;
use crate::scene::environment::EnvironmentImage;

/// The most by which an image is multiplied: its brightest pixel, of f32, then stays below the most radiance.
const MAX_SCALE: f64 = 1e60;

pub(super) fn environment(root: &Table<'_>, files: Files<'_>) -> Result<Environment, SceneError> {
    const FORMS: [&str; 3] = ["color", "gradient", "image"];
    let Some(node) = root.get("environment") else { return Ok(Environment::Color([0.0; 3])) };
    let table = node.table()?.renamed("[environment]".into());
    table.only(&["color", "gradient", "image", "rotation", "scale"])?;
    let [form] = table.present(&FORMS)[..] else {
        return Err(node.error(format!("[environment] must have exactly one of {}", FORMS.join(", "))));
    };
    if form != "image"
        && let Some(key) = table.present(&["rotation", "scale"]).first()
    {
        return Err(table
            .need(key)?
            .error(format!("`{key}` belongs to an `image`, but this environment has a `{form}`")));
    }
    let node = table.need(form)?;
    match form {
        "color" => node.radiance().map(Environment::Color),
        "gradient" => {
            let table = node.table()?;
            table.only(&["zenith", "horizon", "nadir"])?;
            let color = |key| table.need(key)?.radiance();
            Ok(Environment::Gradient { zenith: color("zenith")?, horizon: color("horizon")?, nadir: color("nadir")? })
        }
        _ => {
            let path = PathBuf::from(node.words()?);
            Ok(Environment::Image {
                image: Arc::new(read(&node, &path, files)?),
                path,
                rotation: table.read("rotation", 0.0, Node::number)?,
                scale: table.read("scale", 1.0, |node| {
                    node.number_that(&format!("0 or more, and at most {MAX_SCALE:e}"), |x| {
                        (0.0..=MAX_SCALE).contains(&x)
                    })
                })?,
            })
        }
    }
}

fn read(node: &Node<'_>, path: &std::path::Path, files: Files<'_>) -> Result<EnvironmentImage, SceneError> {
    if matches!(files, Files::Nowhere) {
        return Ok(EnvironmentImage { width: 1, height: 1, pixels: vec![[0.0; 3]], notes: Vec::new() });
    }
    let format = image::format_of(path).map_err(|message| node.error(message))?;
    let located = files.locate(path);
    let bytes = files.read(path).map_err(|message| node.error(format!("the image {} {message}", located.display())))?;
    image::read(&bytes, format).map_err(|message| SceneError::in_file(located, message))
}
