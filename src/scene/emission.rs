//! From the lights of a description to what is sampled.

use std::f64::consts::PI;

use glam::DVec3;

use super::description::{self, Description, MAX_RADIANCE, Quantity, Role, Shape};
use super::error::SceneError;
use super::ids::ObjectId;
use super::lights::{AreaLight, DirectionalLight, Emitter, PointLight, SpotLight, spot_extent};
use super::scene::{Object, Surface};
use crate::geometry::Geometry;
use crate::spectrum::Spectrum;

/// Power of a light that has 1 of what it is measured by, per band. `area` is that of its surface in the scene, in square scene units.
pub fn power_of_unit(shape: &Shape, two_sided: bool, area: f64) -> f64 {
    match *shape {
        Shape::Point { .. } => 4.0 * PI,
        Shape::Spot { inner_angle, outer_angle, .. } => spot_extent(inner_angle, outer_angle),
        _ => PI * area * if two_sided { 2.0 } else { 1.0 },
    }
}

/// The area of an object's surface where it stands, in square scene units; 0 where it has none, or is impossible.
pub fn area(object: &description::Object) -> f64 {
    let matrix = object.transform.matrix();
    if let Shape::Sphere { radius, .. } = object.shape {
        let radius = radius * object.transform.scale.abs().x;
        return 4.0 * PI * radius * radius;
    }
    let mesh = super::shapes::tessellate(&object.shape).ok().flatten().unwrap_or_default();
    let corner = |index: u32| matrix.transform_point3(mesh.positions[index as usize]);
    let of_triangle = |[a, b, c]: [u32; 3]| 0.5 * (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
    mesh.triangles.iter().map(|triangle| of_triangle(*triangle)).sum()
}

/// The radiance of an emitting surface of that area; black of other lights.
///
/// # Errors
/// When its power makes no radiance.
pub(super) fn surface_radiance(
    object: &description::Object,
    light: &description::Light,
    area: f64,
) -> Result<Spectrum, SceneError> {
    let rgb = Spectrum::from_rgb(light.emission.rgb);
    if !object.shape.has_surface() || !object.visible {
        return Ok(Spectrum::ZERO);
    }
    if light.emission.quantity != Quantity::Power {
        return Ok(rgb);
    }
    let radiance = rgb * (1.0 / power_of_unit(&object.shape, light.two_sided, area));
    if rgb.is_black() || radiance.to_rgb().iter().all(|x| *x <= MAX_RADIANCE) {
        return Ok(if rgb.is_black() { rgb } else { radiance });
    }
    Err(SceneError::new(format!(
        "light `{}`: its area is {area:e}, too small for its power; make it larger, or give its `radiance`",
        object.name
    )))
}

/// All lights that emit, in the order of objects.
pub(super) fn emitters(description: &Description, geometry: &Geometry, objects: &[Object]) -> Vec<Emitter> {
    (description.objects.iter().zip(objects).zip(0..))
        .filter(|((described, _), _)| described.visible)
        .filter_map(|((described, object), index)| emitter(described, object, ObjectId(index), geometry))
        .collect()
}

fn emitter(described: &description::Object, object: &Object, id: ObjectId, geometry: &Geometry) -> Option<Emitter> {
    let Role::Light(light) = &described.role else { return None };
    let rgb = Spectrum::from_rgb(light.emission.rgb);
    let intensity = match light.emission.quantity {
        Quantity::Power => rgb * (1.0 / power_of_unit(&described.shape, false, 0.0)),
        _ => rgb,
    };
    let matrix = described.transform.matrix();
    let local = |point: DVec3| matrix.transform_point3(point) - geometry.origin;
    Some(match described.shape {
        Shape::Point { position } => Emitter::Point(PointLight { object: id, position: local(position), intensity }),
        Shape::Spot { position, target, inner_angle, outer_angle } => {
            let axis = matrix.transform_vector3(target - position).normalize_or(DVec3::NEG_Y);
            Emitter::Spot(SpotLight::new(id, local(position), axis, intensity, [inner_angle, outer_angle]))
        }
        Shape::Directional { direction, angle } => {
            let to_light = -matrix.transform_vector3(direction).normalize_or(DVec3::NEG_Y);
            Emitter::Directional(DirectionalLight::new(id, to_light, rgb, angle))
        }
        _ => match object.surface {
            Surface::Light { radiance, two_sided } => {
                Emitter::Area(AreaLight { object: id, radiance, area: geometry.area(id.0), two_sided })
            }
            _ => return None,
        },
    })
}
