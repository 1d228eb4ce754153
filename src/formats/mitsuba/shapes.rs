//! Shapes, alone, in groups and as instances.

use glam::{DAffine2, DAffine3, DMat2, DVec2, DVec3};

use super::bsdf::{Material, NamedIor, material};
use super::emitters::strength;
use super::transform::transform_of;
use super::tree::Node;
use super::values::{UPSIDE_DOWN, flag_of, number_of, text_of, vector};
use super::{Reader, medium};
use crate::formats::importing::media::Side;
use crate::formats::importing::place::{Placed, placed_mesh, shining};
use crate::formats::importing::{MOST_OBJECTS, Matter, at, shapes};
use crate::scene::SceneError;
use crate::scene::description::{Light, MeshPart, Refractor};

const MOST_DEPTH: usize = 16;

pub(super) fn add<'t>(reader: &mut Reader<'_, 't>, node: &'t Node) -> Result<(), SceneError> {
    within(reader, node, &DAffine3::IDENTITY, "", 0)
}

/// Adds a shape that `outer` is applied to, within something called `group`.
fn within<'t>(
    reader: &mut Reader<'_, 't>,
    node: &'t Node,
    outer: &DAffine3,
    group: &str,
    depth: usize,
) -> Result<(), SceneError> {
    reader.visits += 1;
    if depth > MOST_DEPTH || reader.visits > 4 * MOST_OBJECTS {
        return Err(at(&node.place, "too many shapes stand in each other"));
    }
    match node.kind.as_str() {
        // It is there where instances of it are.
        "shapegroup" if depth == 0 => Ok(()),
        "shapegroup" | "merge" => {
            let parts = reader.children(node)?.into_iter().filter(|(_, child)| child.tag == "shape");
            parts
                .collect::<Vec<_>>()
                .into_iter()
                .try_for_each(|(_, child)| within(reader, child, outer, group, depth + 1))
        }
        "instance" => {
            let matrix = *outer * transform_of(node, "to_world")?;
            let found = reader.children(node)?.into_iter().find(|(_, child)| child.tag == "shape");
            let Some((_, shape)) = found else { return Err(at(&node.place, "an instance needs a shape group")) };
            within(reader, shape, &matrix, &node.id, depth + 1)
        }
        _ => one(reader, node, outer, group),
    }
}

/// A shape with its surface.
struct Found {
    placed: Placed,
    /// Whether its normals point to the side from which its faces are clockwise.
    is_flipped: bool,
    /// Of a mesh, its file's stem.
    stem: String,
}

fn one<'t>(reader: &mut Reader<'_, 't>, node: &'t Node, outer: &DAffine3, group: &str) -> Result<(), SceneError> {
    let matrix = *outer * transform_of(node, "to_world")?;
    if !(matrix.is_finite() && matrix.matrix3.determinant() != 0.0) {
        return Err(at(&node.place, "the shape's transform leaves no volume"));
    }
    let Some(Found { mut placed, is_flipped, stem }) = surface(reader, node, &matrix)? else { return Ok(()) };
    let children = reader.children(node)?;
    let bsdf = children.iter().find(|(_, child)| child.tag == "bsdf").map(|(_, child)| *child);
    let emitter = children.iter().find(|(_, child)| child.tag == "emitter").map(|(_, child)| *child);
    let medium_of = |name: &str| {
        children.iter().find(|(known, child)| *known == name && child.tag == "medium").map(|(_, child)| *child)
    };
    let sides = [medium_of("interior"), medium_of("exterior")];
    let [interior, exterior] = sides.map(|side| side.map(|node| medium::medium(reader, node)).transpose());
    let (interior, exterior) = (interior?, exterior?);
    let bsdf_id = bsdf.map_or("", |bsdf| bsdf.id.as_str());
    let name = [node.id.as_str(), group, stem.as_str(), bsdf_id].into_iter().find(|name| !name.is_empty());
    let name = name.unwrap_or(&node.kind).to_owned();
    if let Some(emitter) = emitter {
        let radiance = strength(reader, emitter, "radiance")?;
        if is_flipped && matches!(placed.shape, crate::scene::description::Shape::Sphere { .. }) {
            reader.importer.note(
                "flipped_light",
                &node.place,
                "a sphere shines outward here, though its normals are flipped",
            );
        }
        let around = medium::around(reader, emitter)?.or(exterior);
        let light = Light::of_radiance(radiance);
        return reader.importer.add(&name, shining(placed, is_flipped), Matter::Light { light, around }, &node.place);
    }
    let material = bsdf.map_or_else(|| Ok(Material::unspecified()), |bsdf| material(reader, bsdf))?;
    placed.is_smooth &= !flag_of(node, "face_normals")?;
    let side = |ior: Option<NamedIor>, medium: Option<Side>, otherwise: &str| {
        let absorption = medium.as_ref().and_then(|medium| medium.absorption);
        let by_ior = ior.as_ref().map_or("", |ior| ior.name.as_str());
        let by_medium = medium.as_ref().map_or("", |medium| medium.name.as_str());
        let name = [by_medium, by_ior, otherwise].into_iter().find(|name| !name.is_empty()).unwrap_or_default();
        Side { ior: ior.as_ref().map(|ior| ior.ior), absorption, name: name.to_owned(), ..Side::default() }
    };
    let matter = match material {
        Material::Dielectric { inside, outside, name, refractor } => {
            // No medium begins at a thin wall.
            let interior = interior.filter(|_| !refractor.thin);
            let (inside, outside) = (side(Some(inside), interior, &name), side(Some(outside), exterior, ""));
            Matter::Refractor { refractor, inside, outside }
        }
        Material::Null => {
            let (inside, outside) = (side(None, interior, ""), side(None, exterior, ""));
            // Around what is taken for clear there is nothing to see.
            if inside.absorbs_as(&outside) {
                return Ok(());
            }
            Matter::Refractor { refractor: Refractor::of(""), inside, outside }
        }
        Material::Solid(solid) => Matter::Solid(solid),
    };
    reader.importer.add(&name, placed, matter, &node.place)
}

/// The surface of a shape; `None` for one that is left out, which is said.
fn surface(reader: &mut Reader<'_, '_>, node: &Node, matrix: &DAffine3) -> Result<Option<Found>, SceneError> {
    let flips = flag_of(node, "flip_normals")?;
    let is_mirrored = matrix.matrix3.determinant() < 0.0;
    let found = |placed: Placed, is_flipped: bool| {
        let is_inward = placed.is_inward != is_flipped;
        Ok(Some(Found { is_flipped: is_inward, placed: Placed { is_inward, ..placed }, stem: String::new() }))
    };
    match node.kind.as_str() {
        "ply" | "obj" | "serialized" => {
            let name = text_of(node, "filename")?.ok_or_else(|| at(&node.place, "a mesh needs a `filename`"))?;
            let part = match node.kind.as_str() {
                "serialized" => {
                    let index = number_of(node, "shape_index")?.or(number_of(node, "shapeIndex")?).unwrap_or(0.0);
                    MeshPart::of_group(index.to_string())
                }
                _ => MeshPart::default(),
            };
            let mesh = reader.importer.mesh(name, &part, &node.place)?;
            // Mitsuba takes normals of its own from the order of corners, which a mirroring turns round; those of the file are mirrored with it.
            let has_own = !flag_of(node, "face_normals")? && !mesh.mesh.normals.is_empty();
            let is_flipped = flips != (is_mirrored && !has_own);
            let stem = mesh.name.clone();
            let placed = placed_mesh(&mesh, matrix, is_flipped, true);
            // Of OBJ files v is turned about unless it is said that it shall not be, of PLY files the other way about.
            let flips_uv = match node.property("flip_tex_coords") {
                Some(_) => flag_of(node, "flip_tex_coords")?,
                None => node.kind == "obj",
            };
            let file_uv_from_uv = if flips_uv { UPSIDE_DOWN } else { placed.file_uv_from_uv };
            Ok(Some(Found { placed: Placed { file_uv_from_uv, ..placed }, is_flipped, stem }))
        }
        "sphere" => {
            let center = node.property("center").map_or(Ok(DVec3::ZERO), |center| vector(center, 0.0))?;
            let radius = number_of(node, "radius")?.unwrap_or(1.0);
            let placed = shapes::sphere(center, radius.abs(), matrix);
            // v from the upper pole.
            let file_uv_from_uv = UPSIDE_DOWN * placed.file_uv_from_uv;
            found(Placed { file_uv_from_uv, ..placed }, flips != is_mirrored)
        }
        "rectangle" => found(shapes::rectangle(matrix), flips),
        "disk" => {
            // u is the radius, v goes around.
            let matrix2 = DMat2::from_cols(DVec2::Y, DVec2::NEG_X);
            let file_uv_from_uv = DAffine2 { matrix2, translation: DVec2::X };
            found(Placed { file_uv_from_uv, ..shapes::disk(0.0, 0.0, 1.0, matrix) }, flips)
        }
        "cube" => found(shapes::cube(matrix), flips),
        "cylinder" => {
            let end = |name: &str, otherwise: DVec3| node.property(name).map_or(Ok(otherwise), |p| vector(p, 0.0));
            let (from, to) = (end("p0", DVec3::ZERO)?, end("p1", DVec3::Z)?);
            if from == to {
                return Err(at(&node.place, "the cylinder's ends are the same point"));
            }
            let radius = number_of(node, "radius")?.unwrap_or(1.0).abs();
            found(shapes::tube(from, to, radius, matrix), flips)
        }
        kind => {
            let message = format!("shapes of the type {kind} are left out");
            reader.importer.note("shape", &node.place, message);
            Ok(None)
        }
    }
}
