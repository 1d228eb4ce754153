//! Lights.

use glam::{DMat3, DVec3};

use super::materials::color;
use super::state::{Lamp, Reader};
use super::tokens::Parameters;
use crate::formats::importing::environment::Layout;
use crate::formats::importing::place::Placed;
use crate::formats::importing::{Importer, at};
use crate::scene::Place;
use crate::scene::SceneError;
use crate::scene::description::{Environment, Light, MAX_RADIANCE, Quantity, Shape};
use crate::scene::environment::EnvironmentImage;

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
        if parameters.get("portal").is_some() {
            reader.importer.note(
                "portal",
                place,
                "portals of environment maps are left out: they shine from all around",
            );
        }
        let matrix = reader.state.matrix.matrix3;
        if !(matrix.is_finite() && matrix.determinant() != 0.0) {
            return Err(at(place, "the light's transform leaves no directions"));
        }
        match reader.importer.image(name, place) {
            Ok(image) => {
                // The scale is that of all colours.
                let scale = parameters.number("scale").unwrap_or(1.0);
                if !(0.0..=1e60).contains(&scale) {
                    return Err(at(place, format!("`scale` is {scale}, must be 0 or more, and at most 1e60")));
                }
                reader.sky = Some(Sky { image, world_from_local: matrix, scale, place: place.clone() });
                return Ok(());
            }
            Err(error) => {
                let message = format!("an environment map cannot be read and is taken for grey: {}", error.message);
                reader.importer.note("texture_unread", place, message);
                radiance = radiance.map(|radiance| 0.5 * radiance);
            }
        }
    }
    reader.sky = None;
    reader.importer.set_environment(Environment::Color(radiance), place);
    Ok(())
}

/// An environment map, which is turned upright when it is known whether the scene is mirrored.
pub(super) struct Sky {
    image: EnvironmentImage,
    world_from_local: DMat3,
    scale: f64,
    place: Place,
}

impl Sky {
    pub fn add(self, importer: &mut Importer<'_>, is_mirrored: bool) {
        let Self { image, world_from_local, scale, place } = self;
        let layout = if image.width == image.height { Layout::EqualArea } else { Layout::Lying };
        let world_from_scene = DMat3::from_diagonal(DVec3::new(if is_mirrored { -1.0 } else { 1.0 }, 1.0, 1.0));
        let upright = image.upright(layout, world_from_local.inverse() * world_from_scene);
        let [from, to] = [&image, &upright].map(|image| format!("{} × {}", image.width, image.height));
        let what = match layout {
            Layout::EqualArea => "an equal-area square",
            _ => "no square, and taken for one of older versions of pbrt",
        };
        let message =
            format!("the environment map is {what}: its {from} pixels are resampled to {to} by latitude and longitude");
        importer.note("environment_map", &place, message);
        importer.set_environment_image(upright, scale, &place);
    }
}
