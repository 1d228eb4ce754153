//! Shapes.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::files::Files;
use super::mesh;
use super::node::{Node, Table};
use crate::geometry::Mesh;
use crate::scene::description::Shape;
use crate::scene::shapes::{self, DEFAULT_RINGS, DEFAULT_SEGMENTS};
use crate::scene::{LoadNote, SceneError};

const SHAPES: [&str; 8] = ["sphere", "icosphere", "box", "cylinder", "torus", "lathe", "quad", "mesh"];

/// Meshes read so far, with what was passed over in their files: objects that name one file share it.
pub(super) type MeshCache = HashMap<PathBuf, (Arc<Mesh>, Vec<LoadNote>)>;

pub(super) fn shape(node: &Node<'_>, files: Files<'_>, cache: &mut MeshCache) -> Result<Shape, SceneError> {
    let table = node.table()?;
    table.only(&SHAPES)?;
    let [kind] = table.present(&SHAPES)[..] else {
        return Err(node.error(format!("`shape` must have exactly one of {}", SHAPES.join(", "))));
    };
    let node = table.need(kind)?;
    if kind == "mesh" {
        return read_mesh(&node, files, cache);
    }
    let table = node.table()?;
    let shape = numbers(kind, &table)?;
    shapes::validate(&shape).map_err(|fault| match table.get(fault.key) {
        Some(node) => node.error(fault.message),
        None => node.error(fault.message),
    })?;
    Ok(shape)
}

fn numbers(kind: &str, table: &Table<'_>) -> Result<Shape, SceneError> {
    let vec3 = |key| table.need(key)?.vec3();
    let number = |key| table.need(key)?.number();
    let whole = |key, default: u32| table.read(key, default, |node| node.integer(0..=u32::MAX));
    Ok(match kind {
        "sphere" => {
            table.only(&["center", "radius"])?;
            Shape::Sphere { center: vec3("center")?, radius: number("radius")? }
        }
        "icosphere" => {
            table.only(&["center", "radius", "subdivisions"])?;
            Shape::Icosphere {
                center: vec3("center")?,
                radius: number("radius")?,
                subdivisions: table.need("subdivisions")?.integer(0..=u32::MAX)?,
            }
        }
        "box" => {
            table.only(&["min", "max"])?;
            Shape::Box { min: vec3("min")?, max: vec3("max")? }
        }
        "cylinder" => {
            table.only(&["center", "radius", "height", "segments"])?;
            Shape::Cylinder {
                center: vec3("center")?,
                radius: number("radius")?,
                height: number("height")?,
                segments: whole("segments", DEFAULT_SEGMENTS)?,
            }
        }
        "torus" => {
            table.only(&["center", "major", "minor", "segments", "rings"])?;
            Shape::Torus {
                center: vec3("center")?,
                major: number("major")?,
                minor: number("minor")?,
                segments: whole("segments", DEFAULT_SEGMENTS)?,
                rings: whole("rings", DEFAULT_RINGS)?,
            }
        }
        "lathe" => {
            table.only(&["profile", "segments"])?;
            let points = table.need("profile")?.items()?;
            Shape::Lathe {
                profile: points.iter().map(Node::numbers).collect::<Result<_, _>>()?,
                segments: whole("segments", DEFAULT_SEGMENTS)?,
            }
        }
        _ => {
            table.only(&["center", "edge_u", "edge_v"])?;
            Shape::Quad { center: vec3("center")?, edge_u: vec3("edge_u")?, edge_v: vec3("edge_v")? }
        }
    })
}

fn read_mesh(node: &Node<'_>, files: Files<'_>, cache: &mut MeshCache) -> Result<Shape, SceneError> {
    let path = PathBuf::from(node.words()?);
    let format = mesh::Format::of(&path).map_err(|message| node.error(message))?;
    let found = match cache.get(&path) {
        Some(found) => found.clone(),
        None => {
            let read = if matches!(files, Files::Nowhere) {
                (Arc::default(), Vec::new())
            } else {
                let bytes = files
                    .read(&path)
                    .map_err(|message| node.error(format!("the mesh {} {message}", files.locate(&path).display())))?;
                let (mesh, notes) = mesh::read(&bytes, format).map_err(|fault| {
                    let file = files.locate(&path);
                    match fault.line {
                        Some(line) => SceneError::at(file, line, 1, fault.message),
                        None => SceneError::in_file(file, fault.message),
                    }
                })?;
                (Arc::new(mesh), notes)
            };
            cache.insert(path.clone(), read.clone());
            read
        }
    };
    let (mesh, notes) = found;
    let shape = Shape::Mesh { path, mesh, notes };
    if !matches!(files, Files::Nowhere) {
        shapes::validate(&shape).map_err(|fault| node.error(fault.message))?;
    }
    Ok(shape)
}
