//! Emitters that stand alone: at a point, in a cone, from afar and all around.

use glam::{DAffine3, DVec3};
use std::sync::Arc;

use super::transform::transform_of;
use super::tree::Node;
use super::values::{color_of, number_of, text_of, vector};
use super::{Reader, medium};
use crate::formats::importing::environment::Layout;
use crate::formats::importing::place::Placed;
use crate::formats::importing::{Matter, at};
use crate::scene::SceneError;
use crate::scene::description::{Environment, Light, MAX_RADIANCE, Quantity, Shape};

/// Cosines nearer to 1 than this are of one direction.
const UPRIGHT: f64 = 1e-9;

pub(super) fn add<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<(), SceneError> {
    let matrix = transform_of(node, "to_world")?;
    let axis = || (matrix.matrix3 * DVec3::Z).normalize_or(DVec3::Z);
    match node.kind.as_str() {
        "constant" => {
            let radiance = strength(reader, node, "radiance")?;
            reader.importer.set_environment(Environment::Color(radiance), &node.place);
            Ok(())
        }
        "envmap" => environment_map(reader, node, &matrix),
        // It belongs to the shapes that refer to it.
        "area" => Ok(()),
        "point" => {
            let position = node.property("position").map_or(Ok(matrix.translation), |place| vector(place, 0.0))?;
            lamp(reader, node, Shape::Point { position }, Quantity::Intensity)
        }
        "spot" => {
            let cutoff = number_of(node, "cutoff_angle")?.unwrap_or(20.0);
            let beam = number_of(node, "beam_width")?.unwrap_or(0.75 * cutoff);
            if node.property("texture").is_some() {
                reader.importer.note("texture", &node.place, "textures of spot lights are left out");
            }
            reader.importer.note("spot", &node.place, "the edge of spot lights falls off a little otherwise here");
            let outer_angle = cutoff.clamp(1e-3, 180.0);
            let position = matrix.translation;
            let inner_angle = beam.clamp(0.0, outer_angle);
            lamp(
                reader,
                node,
                Shape::Spot { position, target: position + axis(), inner_angle, outer_angle },
                Quantity::Intensity,
            )
        }
        "directional" => {
            let direction = node.property("direction").map_or(Ok(axis()), |direction| vector(direction, 0.0))?;
            lamp(reader, node, Shape::Directional { direction, angle: 0.0 }, Quantity::Irradiance)
        }
        kind => {
            let message = format!("emitters of the type {kind} are left out");
            reader.importer.note("emitter", &node.place, message);
            Ok(())
        }
    }
}

/// A colour that may be as strong as a light can be.
pub(super) fn strength<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, name: &str) -> Result<[f64; 3], SceneError> {
    let color = color_of(reader, node, name)?.unwrap_or([1.0; 3]);
    match color.iter().all(|x| (0.0..=MAX_RADIANCE).contains(x)) {
        true => Ok(color),
        false => Err(at(&node.place, format!("`{name}` must be 0 or more, and at most {MAX_RADIANCE:e}"))),
    }
}

fn lamp<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, shape: Shape, quantity: Quantity) -> Result<(), SceneError> {
    let rgb = strength(reader, node, quantity.name())?;
    let around = medium::around(reader, node)?;
    let name = if node.id.is_empty() { format!("{} light", node.kind) } else { node.id.clone() };
    let light = Light::of(quantity, rgb);
    reader.importer.add(&name, Placed::new(shape), Matter::Light { light, around }, &node.place)
}

fn environment_map<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, matrix: &DAffine3) -> Result<(), SceneError> {
    let Some(name) = text_of(node, "filename")?.map(str::to_owned) else {
        return Err(at(&node.place, "an environment map needs a `filename`"));
    };
    let image = reader.importer.image(&name, &node.place)?;
    let scale = number_of(node, "scale")?.unwrap_or(1.0).clamp(0.0, 1e60);
    let axes = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis].map(DVec3::normalize_or_zero);
    let [x, y, z] = axes;
    if !(y.y > 1.0 - UPRIGHT && x.cross(y).dot(z) > 1.0 - UPRIGHT) {
        let scene_from_local = matrix.matrix3;
        if !(scene_from_local.is_finite() && scene_from_local.determinant() != 0.0) {
            return Err(at(&node.place, "the environment map's transform leaves no directions"));
        }
        let image = image.upright(Layout::Upright, scene_from_local.inverse());
        let message = "environment maps stand upright about the y axis: this one, which is tilted, is resampled";
        reader.importer.note("environment_tilt", &node.place, message);
        reader.importer.set_environment_image(image, scale, &node.place);
        return Ok(());
    }
    // It is seen from the other side: the middle of Mitsuba's is at +z, that of ours at −z.
    let turn = (-x.z).atan2(x.x).to_degrees();
    let rotation = (180.0 + turn).rem_euclid(360.0);
    let path = reader.importer.found(&name);
    let environment = Environment::Image { path, image: Arc::new(image), rotation, scale };
    reader.importer.set_environment(environment, &node.place);
    Ok(())
}
