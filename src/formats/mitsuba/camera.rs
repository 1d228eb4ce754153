//! Sensors: the first is the camera.

use super::transform::transform_of;
use super::tree::Node;
use super::values::{number_of, text_of};
use super::{Reader, medium};
use crate::formats::importing::at;
use crate::scene::SceneError;
use crate::scene::description::CameraDescription;

/// Of a film that gives none.
const FILM: [f64; 2] = [768.0, 576.0];
/// Diagonal of 35 mm film, which focal lengths are given for, in mm.
const DIAGONAL: f64 = 43.266_615_305_567_87;
/// Of a sensor that gives neither.
const DEFAULT_FOCAL_LENGTH: f64 = 50.0;

pub(super) fn read<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<(), SceneError> {
    if reader.importer.camera.is_some() {
        reader.importer.note("sensor", &node.place, "of several sensors the first is the camera");
        return Ok(());
    }
    let is_thin_lens = node.kind == "thinlens";
    if !is_thin_lens && node.kind != "perspective" {
        let message = format!("sensors of the type {} are taken for a perspective camera", node.kind);
        reader.importer.note("sensor", &node.place, message);
    }
    let matrix = transform_of(node, "to_world")?;
    if matrix.matrix3.determinant() < 0.0 {
        reader.importer.note("mirrored", &node.place, "the camera's transform mirrors the picture, which is not done");
    }
    // It looks along z, with x to the left.
    let forward = (matrix.matrix3 * glam::DVec3::Z).try_normalize();
    let forward = forward.ok_or_else(|| at(&node.place, "the camera's transform has no direction"))?;
    let up = (matrix.matrix3 * glam::DVec3::Y).normalize_or(forward.any_orthonormal_vector());
    let focus = number_of(node, "focus_distance")?.filter(|distance| is_thin_lens && *distance > 0.0);
    for name in ["principal_point_offset_x", "principal_point_offset_y"] {
        if number_of(node, name)?.is_some_and(|offset| offset != 0.0) {
            reader.importer.note("shift", &node.place, "the shift of the camera's principal point is left out");
        }
    }
    let aperture = if is_thin_lens { number_of(node, "aperture_radius")?.unwrap_or(0.0) } else { 0.0 };
    reader.importer.camera = Some(CameraDescription {
        position: matrix.translation,
        target: matrix.translation + forward * focus.unwrap_or(1.0),
        up,
        vertical_fov: vertical_fov(reader, node)?,
        aperture_radius: aperture.max(0.0),
        focus_distance: None,
    });
    reader.importer.camera_medium = medium::around(reader, node)?;
    Ok(())
}

/// Degrees over the picture's height.
fn vertical_fov<'t>(reader: &Reader<'_, 't>, node: &'t Node) -> Result<f64, SceneError> {
    let film = reader.children(node)?.into_iter().find(|(_, child)| child.tag == "film").map(|(_, film)| film);
    let mut size = FILM;
    if let Some(film) = film {
        for (name, side) in ["width", "height"].into_iter().zip(&mut size) {
            *side = number_of(film, name)?.filter(|side| *side >= 1.0).unwrap_or(*side);
        }
    }
    let [width, height] = size;
    let (degrees, axis) = match number_of(node, "fov")? {
        Some(degrees) => (degrees, text_of(node, "fov_axis")?.unwrap_or("x")),
        None => {
            let text = text_of(node, "focal_length")?;
            let millimetres = text.and_then(|text| text.trim().trim_end_matches("mm").trim().parse::<f64>().ok());
            let length = millimetres.filter(|length| *length > 0.0).unwrap_or(DEFAULT_FOCAL_LENGTH);
            (2.0 * (0.5 * DIAGONAL / length).atan().to_degrees(), "diagonal")
        }
    };
    if !(degrees > 0.0 && degrees < 180.0) {
        return Err(at(&node.place, format!("`fov` is {degrees}, must be between 0 and 180")));
    }
    // What the angle spans, in heights of the picture.
    let span = match axis {
        "y" => 1.0,
        "diagonal" => width.hypot(height) / height,
        "smaller" => width.min(height) / height,
        "larger" => width.max(height) / height,
        _ => width / height,
    };
    Ok(2.0 * ((0.5 * degrees.to_radians()).tan() / span).atan().to_degrees())
}
