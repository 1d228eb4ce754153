//! Cameras and lights of a glTF file.

use glam::DVec3;

use super::container::Container;
use super::nodes::Placed;
use super::schema::Light as Punctual;
use super::surface::called;
use crate::formats::names::Names;
use crate::formats::tally::Tally;
use crate::scene::description::{CameraDescription, Light, MAX_RADIANCE, Object, Quantity, Shape};

/// What Blender multiplies watts by, lumens for each, from version 3.6 of its exporter on.
const BLENDERS_EFFICACY: f64 = 683.0;
/// Least distance from a camera to what it looks at, as a share of the scene's radius.
const LEAST_DISTANCE: f64 = 0.01;

impl Container {
    /// The first camera of the scene that shows in perspective. What it looks at is as far away as the middle of the scene.
    pub fn camera(
        &self,
        placed: &[Placed],
        (center, radius): (DVec3, f64),
        tally: &mut Tally,
    ) -> Result<Option<CameraDescription>, String> {
        let mut found = None;
        for Placed { node, world, .. } in placed {
            let node = &self.root.nodes[*node];
            let Some(index) = node.camera else { continue };
            let cameras = &self.root.cameras;
            let camera =
                cameras.get(index).ok_or_else(|| format!("there is no camera {index}: there are {}", cameras.len()))?;
            let Some(perspective) = camera.perspective.as_ref().filter(|_| camera.kind != "orthographic") else {
                tally.add("orthographic_camera", "cameras without perspective are left out", &node.name);
                continue;
            };
            let (position, forward) = (world.translation, (-world.matrix3.z_axis).try_normalize());
            let (Some(forward), Some(up)) = (forward, world.matrix3.y_axis.try_normalize()) else {
                tally.add("flat_camera", "cameras that are scaled to nothing are left out", &node.name);
                continue;
            };
            let vertical_fov = perspective.yfov.to_degrees();
            if !(vertical_fov > 0.0 && vertical_fov < 180.0) {
                return Err(format!("{} has the field of view {}", called("camera", index, ""), perspective.yfov));
            }
            if found.is_some() {
                tally.add("more_cameras", "cameras after the first are left out", &node.name);
                continue;
            }
            let distance = (center - position).dot(forward).max(LEAST_DISTANCE * radius);
            let distance = if distance > 0.0 && distance.is_finite() { distance } else { 1.0 };
            found = Some(CameraDescription {
                position,
                target: position + forward * distance,
                up,
                vertical_fov,
                ..CameraDescription::blank()
            });
        }
        Ok(found)
    }

    /// The lights of KHR_lights_punctual, where they stand.
    pub fn lights(&self, placed: &[Placed], names: &mut Names, tally: &mut Tally) -> Result<Vec<Object>, String> {
        let lights = &self.root.extensions.lights.lights;
        let by_blender = blender_version(&self.root.asset.generator).is_some_and(|version| version >= (3, 6));
        let mut objects = Vec::new();
        for Placed { node, world, .. } in placed {
            let node = &self.root.nodes[*node];
            let Some(reference) = &node.extensions.light else { continue };
            let index = reference.light;
            let light =
                lights.get(index).ok_or_else(|| format!("there is no light {index}: there are {}", lights.len()))?;
            let name = names.give(if node.name.trim().is_empty() { &light.name } else { &node.name }, "light");
            let direction = (-world.matrix3.z_axis).normalize_or(DVec3::NEG_Z);
            let Some((shape, quantity)) = shape(light, world.translation, direction) else {
                tally.add("light", "lights of other kinds than point, spot and directional are left out", &name);
                continue;
            };
            if light.range.is_some() {
                tally.add("light_range", "lights reach farther than their range", &name);
            }
            let factor = if by_blender { 1.0 / BLENDERS_EFFICACY } else { 1.0 };
            tally.add(
                "light_units",
                if by_blender {
                    "candela and lux are taken for W/sr and W/m² by 683 lumens a watt, as Blender writes them"
                } else {
                    "candela and lux are taken for as many W/sr and W/m²"
                },
                &name,
            );
            let intensity = light.intensity.unwrap_or(1.0) * factor;
            let rgb = light.color.unwrap_or([1.0; 3]).map(|share| (share * intensity).clamp(0.0, MAX_RADIANCE));
            objects.push(Object::new(name, shape, Light::of(quantity, rgb)));
        }
        Ok(objects)
    }
}

/// The shape of a light that stands at `position` and looks along `direction`.
fn shape(light: &Punctual, position: DVec3, direction: DVec3) -> Option<(Shape, Quantity)> {
    Some(match light.kind.as_str() {
        "point" => (Shape::Point { position }, Quantity::Intensity),
        "directional" => (Shape::Directional { direction, angle: 0.0 }, Quantity::Irradiance),
        "spot" => {
            let outer = light.spot.outer_cone_angle.unwrap_or(std::f64::consts::FRAC_PI_4);
            // Half angles, as ours. A cone without width has no light.
            let outer_angle = outer.to_degrees().clamp(1e-3, 90.0);
            let inner_angle = light.spot.inner_cone_angle.to_degrees().clamp(0.0, outer_angle);
            // So far away that the place of the target is as exact as that of the light.
            let target = position + direction * position.abs().max_element().max(1.0);
            (Shape::Spot { position, target, inner_angle, outer_angle }, Quantity::Intensity)
        }
        _ => return None,
    })
}

/// Major and minor version of the exporter, of a file from Blender: `Khronos glTF Blender I/O v4.2.70`.
fn blender_version(generator: &str) -> Option<(u32, u32)> {
    let (_, version) = generator.split_once("Blender I/O v")?;
    let mut numbers = version.split(|c: char| !c.is_ascii_digit()).map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_blenders_exporter() {
        assert_eq!(blender_version("Khronos glTF Blender I/O v4.2.70"), Some((4, 2)));
        assert_eq!(blender_version("Khronos glTF Blender I/O v1.8.19"), Some((1, 8)));
        assert_eq!(blender_version("Khronos glTF Blender I/O v"), None);
        assert_eq!(blender_version("obj2gltf"), None);
    }
}
