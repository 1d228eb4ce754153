//! Transforms: each step is applied after those before it.

use glam::{DAffine3, DMat3, DVec3};

use super::tree::Node;
use super::values::{attribute_vector, numbers, vector};
use crate::formats::importing::at;
use crate::scene::SceneError;

/// The transform that is a property; the identity where it is left out.
pub(super) fn transform_of(node: &Node, name: &str) -> Result<DAffine3, SceneError> {
    match node.property(name) {
        Some(property) if property.tag == "transform" => {
            property.children.iter().try_fold(DAffine3::IDENTITY, |matrix, step| Ok(step_of(step)? * matrix))
        }
        _ => Ok(DAffine3::IDENTITY),
    }
}

fn step_of(node: &Node) -> Result<DAffine3, SceneError> {
    match node.tag.as_str() {
        "translate" => Ok(DAffine3::from_translation(vector(node, 0.0)?)),
        "scale" => Ok(DAffine3::from_scale(vector(node, 1.0)?)),
        "rotate" => {
            let axis = vector(node, 0.0)?;
            let angle = node.attribute("angle").unwrap_or("0");
            let [angle] = numbers(node, angle)?[..] else { return Err(at(&node.place, "`angle` needs one number")) };
            Ok(DAffine3::from_mat3(rotation(axis, angle.to_radians())))
        }
        "lookat" => look_at(node),
        "matrix" => matrix(node),
        tag => Err(at(&node.place, format!("<{tag}> is no step of a transform"))),
    }
}

/// Rodrigues' formula with the axis as it is written: Mitsuba takes it for a unit vector, also where it is none.
fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = angle.sin_cos();
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos)
}

/// The z axis goes from `origin` to `target`, x to the left.
fn look_at(node: &Node) -> Result<DAffine3, SceneError> {
    let need =
        |name: &str| attribute_vector(node, name)?.ok_or_else(|| at(&node.place, format!("<lookat> has no `{name}`")));
    let (origin, target) = (need("origin")?, need("target")?);
    let forward = (target - origin).try_normalize();
    let forward = forward.ok_or_else(|| at(&node.place, "`origin` and `target` are the same point"))?;
    let up = attribute_vector(node, "up")?.filter(|up| *up != DVec3::ZERO);
    let left = up.map_or_else(|| forward.any_orthonormal_vector(), |up| up.cross(forward)).try_normalize();
    let left = left.ok_or_else(|| at(&node.place, "`up` points along the view"))?;
    Ok(DAffine3 { matrix3: DMat3::from_cols(left, forward.cross(left), forward), translation: origin })
}

/// By rows: 16 numbers, or 9 without a translation.
fn matrix(node: &Node) -> Result<DAffine3, SceneError> {
    let all = numbers(node, node.value()?)?;
    let (width, height) = match all.len() {
        16 => (4, 4),
        9 => (3, 3),
        count => return Err(at(&node.place, format!("a matrix needs 16 or 9 numbers, not {count}"))),
    };
    let column = |k: usize| DVec3::new(all[k], all[width + k], all[2 * width + k]);
    if height == 4 && all[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(at(&node.place, "the last row of a matrix must be 0 0 0 1"));
    }
    let translation = if width == 4 { column(3) } else { DVec3::ZERO };
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation })
}
