//! Lights.

use glam::DVec3;

use super::materials::color;
use super::state::{Lamp, Reader};
use super::tokens::Parameters;
use crate::formats::importing::at;
use crate::formats::importing::place::Placed;
use crate::scene::Place;
use crate::scene::SceneError;
use crate::scene::description::{Environment, Light, MAX_RADIANCE, Quantity, Shape};

/// The light of the shapes that follow.
pub(super) fn area(reader: &mut Reader<'_>, parameters: &Parameters, place: &Place) -> Result<Light, SceneError> {
    if parameters.get("filename").is_some() {
        reader.importer.note("texture", place, "textures of lights are left out");
    }
    let rgb = strength(reader, parameters, "L", place)?;
    Ok(Light { two_sided: parameters.flag("twosided"), ..Light::of_radiance(rgb) })
}

fn strength(
    reader: &mut Reader<'_>,
    parameters: &Parameters,
    name: &str,
    place: &Place,
) -> Result<[f64; 3], SceneError> {
    if ["power", "illuminance"].iter().any(|name| parameters.get(name).is_some()) {
        reader.importer.note(
            "power",
            place,
            "powers and illuminances of lights are left out: their colours count as they are",
        );
    }
    let scale = parameters.number("scale").unwrap_or(1.0);
    let rgb = color(reader, parameters, name)?.unwrap_or([1.0; 3]).map(|x| x * scale);
    match rgb.iter().all(|x| (0.0..=MAX_RADIANCE).contains(x)) {
        true => Ok(rgb),
        false => Err(at(place, format!("`{name}` must be 0 or more, and at most {MAX_RADIANCE:e}"))),
    }
}

pub(super) fn light(
    reader: &mut Reader<'_>,
    kind: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<(), SceneError> {
    let matrix = reader.state.matrix;
    let point = |name: &str, otherwise: DVec3| matrix.transform_point3(parameters.point(name).unwrap_or(otherwise));
    let (name, shape, quantity, strength_name) = match kind {
        "infinite" => return infinite(reader, parameters, place),
        "point" => ("point light", Shape::Point { position: point("from", DVec3::ZERO) }, Quantity::Intensity, "I"),
        "spot" => {
            let number = |name: &str, otherwise: f64| parameters.number(name).unwrap_or(otherwise);
            let outer_angle = number("coneangle", 30.0).clamp(1e-3, 180.0);
            let inner_angle = (outer_angle - number("conedeltaangle", 5.0)).clamp(0.0, outer_angle);
            reader.importer.note("spot", place, "the edge of spot lights falls off a little otherwise here");
            let (position, target) = (point("from", DVec3::ZERO), point("to", DVec3::Z));
            ("spot light", Shape::Spot { position, target, inner_angle, outer_angle }, Quantity::Intensity, "I")
        }
        "distant" => {
            let direction = point("to", DVec3::Z) - point("from", DVec3::ZERO);
            ("distant light", Shape::Directional { direction, angle: 0.0 }, Quantity::Irradiance, "L")
        }
        "goniometric" | "projection" => {
            reader.importer.note("texture", place, "textures of lights are left out");
            ("light", Shape::Point { position: point("from", DVec3::ZERO) }, Quantity::Intensity, "I")
        }
        kind => {
            let message = format!("lights of the type {kind} are left out");
            reader.importer.note("emitter", place, message);
            return Ok(());
        }
    };
    let light = Light::of(quantity, strength(reader, parameters, strength_name, place)?);
    let medium = reader.state.media[1].clone();
    reader.lamp(Lamp { name, placed: Placed::new(shape), light, medium, place: place.clone() });
    Ok(())
}

fn infinite(reader: &mut Reader<'_>, parameters: &Parameters, place: &Place) -> Result<(), SceneError> {
    let mut radiance = strength(reader, parameters, "L", place)?;
    if let Some(name) = parameters.text("filename") {
        let message = "environment maps are in equal-area squares, which are not read: their mean colour is taken";
        reader.importer.note("environment_map", place, message);
        let mean = reader.importer.mean_color(name, place).unwrap_or([0.5; 3]);
        radiance = [0, 1, 2].map(|k| (radiance[k] * mean[k]).clamp(0.0, MAX_RADIANCE));
    }
    if reader.importer.environment != Environment::DEFAULT {
        reader.importer.note("environment", place, "of several environments the last is taken");
    }
    reader.importer.environment = Environment::Color(radiance);
    Ok(())
}
