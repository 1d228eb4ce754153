//! Scenes from files: TOML with its meshes and images.
//!
//! Every error names file, line and column where it has them. Nothing that a file asks for is ignored: an unknown key is an error
//! that lists the valid ones, a feature that is not built yet is refused as such.

mod bytes;
mod corners;
mod encoding;
mod environment;
mod files;
pub(crate) mod image;
mod lines;
mod mesh;
mod node;
mod obj;
mod objects;
mod passed_over;
mod ply;
mod polygon;
mod shape;
mod suggest;

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use toml_edit::Document;

pub use self::bytes::{image_from_bytes, mesh_from_bytes};
use self::encoding::Utf16;
use self::files::Files;
pub(super) use self::files::normal;
use self::node::{Node, Table, Text};
use self::suggest::suggestion;
use super::SceneError;
use super::builtin;
use super::camera::Camera;
use super::description::{CameraDescription, Description, Source, WorldMedium};
use super::files::{MAX_SCENE_BYTES, read_or_receive};
use super::shapes::{MAX_LENGTH, MIN_LENGTH};
use crate::optics::ior::IOR_RANGE;
use crate::optics::{Ior, Medium, catalog, medium};

/// Vertical field of view of a camera that gives none, in degrees.
pub const DEFAULT_VERTICAL_FOV: f64 = 40.0;

/// A scene by the name of a built-in one, or by its file's path.
///
/// # Errors
/// When there is no such scene, or it cannot be used.
pub fn open(name_or_path: impl AsRef<Path>) -> Result<Description, SceneError> {
    let path = name_or_path.as_ref();
    let name = path.to_string_lossy();
    if let Some(builtin) = builtin::find(&name) {
        return builtin::description(builtin);
    }
    let looks_like_a_name = path.extension().is_none() && path.components().count() == 1;
    if looks_like_a_name && !path.exists() {
        let names = || builtin::all().iter().map(|scene| scene.name);
        return Err(SceneError::new(format!(
            "there is no file and no built-in scene `{name}`{}; built-in scenes: {}",
            suggestion(&name, names()),
            names().collect::<Vec<_>>().join(", ")
        )));
    }
    file(path)
}

/// A scene from a file, with the meshes and images that it names.
///
/// # Errors
/// When the file or one that it names cannot be read or used.
pub fn file(path: &Path) -> Result<Description, SceneError> {
    let bytes = read_or_receive(path, MAX_SCENE_BYTES).map_err(|error| SceneError::in_file(path, error.to_string()))?;
    if Utf16::of(&bytes).is_some() {
        return Err(SceneError::in_file(path, "is text in UTF-16: scene files are TOML in UTF-8, so save it in that"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let valid = String::from_utf8_lossy(valid);
        let (line, column) = Text { path, text: &valid }.line_column(valid.len());
        SceneError::at(path, line, column, "is not text: scene files are TOML in UTF-8")
    })?;
    parse(&text, path, false)
}

/// A scene from the text of its file. `path` names it in errors, and the files that it names are relative to its folder: on disk,
/// or, if `is_builtin`, among those compiled into the program.
///
/// # Errors
/// When the scene or a file that it names cannot be used.
pub fn parse(text: &str, path: &Path, is_builtin: bool) -> Result<Description, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    parse_with(text, path, if is_builtin { Files::BuiltIn(folder) } else { Files::Disk(folder) })
}

/// A scene without the contents of its meshes and images: what its text alone says.
pub(super) fn parse_text_only(text: &str, path: &Path) -> Result<Description, SceneError> {
    parse_with(text, path, Files::Nowhere)
}

fn parse_with(text: &str, path: &Path, files: Files<'_>) -> Result<Description, SceneError> {
    let place = Text { path, text };
    let document = Document::parse(text).map_err(|error| {
        let message = error.message().trim().replace('\n', ", ");
        match error.span() {
            Some(span) => place.error(span.start, message),
            None => SceneError::in_file(path, message),
        }
    })?;
    let root = Table::root(&place, document.as_table());
    root.only(&["name", "camera", "world", "environment", "medium", "refractor", "solid", "light"])?;

    let stem = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let media = media(&root)?;
    let objects = objects::Reader::new(files, &media).objects(&root)?;
    Ok(Description {
        name: root.read("name", stem, |node| node.words().map(str::to_owned))?,
        camera: camera(&root.need("camera")?.table()?.renamed("[camera]".into()))?,
        world: world(&root)?,
        environment: environment::environment(&root, files)?,
        media,
        objects,
        source: Some(Arc::new(Source {
            path: path.to_path_buf(),
            text: text.to_owned(),
            is_builtin: matches!(files, Files::BuiltIn(_)),
        })),
    })
}

fn camera(table: &Table<'_>) -> Result<CameraDescription, SceneError> {
    table.only(&["position", "target", "up", "vertical_fov", "aperture_radius", "focus_distance"])?;
    let camera = CameraDescription {
        position: table.need("position")?.vec3()?,
        target: table.need("target")?.vec3()?,
        up: table.read("up", glam::DVec3::Y, Node::vec3)?,
        vertical_fov: table.read("vertical_fov", DEFAULT_VERTICAL_FOV, |node| {
            node.number_that("greater than 0 and less than 180 degrees", |x| x > 0.0 && x < 180.0)
        })?,
        aperture_radius: table.read("aperture_radius", 0.0, |node| node.number_that("0 or more", |x| x >= 0.0))?,
        focus_distance: table
            .read("focus_distance", None, |node| node.number_that("greater than 0", |x| x > 0.0).map(Some))?,
    };
    // What only all of it together can show: no direction, or an `up` along it.
    let is_far = |point: glam::DVec3| point.abs().max_element() > MAX_LENGTH;
    let place_of_fault = match camera {
        CameraDescription { position, .. } if is_far(position) => "position",
        CameraDescription { position, target, .. } if is_far(target) || position == target => "target",
        CameraDescription { aperture_radius, .. } if aperture_radius > MAX_LENGTH => "aperture_radius",
        CameraDescription { focus_distance: Some(distance), .. } if !(MIN_LENGTH..=MAX_LENGTH).contains(&distance) => {
            "focus_distance"
        }
        _ => "up",
    };
    Camera::new(&camera).map_err(|error| match table.get(place_of_fault) {
        Some(node) => node.error(error.message),
        None => table.error(error.message),
    })?;
    Ok(camera)
}

fn world(root: &Table<'_>) -> Result<WorldMedium, SceneError> {
    let mut world = WorldMedium { ior: Ior::Constant(1.0), absorption: [0.0; 3] };
    if let Some(node) = root.get("world") {
        let table = node.table()?.renamed("[world]".into());
        table.only(&["ior", "absorption"])?;
        world.ior = table.read("ior", world.ior, ior)?;
        world.absorption = table.read("absorption", world.absorption, Node::non_negative3)?;
    }
    Ok(world)
}

fn media(root: &Table<'_>) -> Result<Vec<Medium>, SceneError> {
    let mut media: Vec<Medium> = Vec::new();
    let mut names = HashSet::new();
    let tables = root.read("medium", Vec::new(), Node::tables)?;
    for table in tables {
        let table = table.renamed("[[medium]]".into());
        table.only(&["name", "ior", "absorption"])?;
        let node = table.need("name")?;
        let name = node.words()?;
        if matches!(name, medium::WORLD | medium::VACUUM) {
            return Err(node.error(format!("`{name}` is a reserved name; call the medium something else")));
        }
        if !names.insert(name) {
            return Err(node.error(format!("there are two media called `{name}`; names must be unique")));
        }
        let table = table.renamed(format!("medium `{name}`"));
        media.push(Medium {
            name: name.to_owned(),
            ior: ior(&table.need("ior")?)?,
            absorption: table.read("absorption", [0.0; 3], Node::non_negative3)?,
        });
    }
    Ok(media)
}

/// A number, or a table with one of the formulas.
fn ior(node: &Node<'_>) -> Result<Ior, SceneError> {
    const FORMS: [&str; 3] = ["catalog", "cauchy", "sellmeier"];
    if !node.is_table() {
        if !node.is_number() {
            // Both forms in one sentence; `number` alone would hide the other.
            return Err(node.error(format!(
                "{} must be a number, or a table with one of {}, such as {{ catalog = \"water\" }}",
                node.name,
                FORMS.join(", ")
            )));
        }
        return node.number_that("greater than 0 (from 1e-6 to 1e6)", |n| IOR_RANGE.contains(&n)).map(Ior::Constant);
    }
    let table = node.table()?;
    table.only(&FORMS)?;
    let model = match table.present(&FORMS)[..] {
        ["catalog"] => {
            let entry = table.need("catalog")?;
            let name = entry.words()?;
            let found = catalog::find(name).ok_or_else(|| {
                let names = || catalog::ALL.iter().map(|entry| entry.name);
                entry.error(format!(
                    "the catalogue has no `{name}`{}; it has: {}",
                    suggestion(name, names()),
                    names().collect::<Vec<_>>().join(", ")
                ))
            })?;
            Ior::Catalog(found)
        }
        ["cauchy"] => Ior::Cauchy(table.need("cauchy")?.numbers()?),
        ["sellmeier"] => {
            let terms = table.need("sellmeier")?;
            let pairs = terms.items()?.iter().map(Node::numbers).collect::<Result<Vec<[f64; 2]>, _>>()?;
            if pairs.is_empty() {
                return Err(terms.error("`sellmeier` is empty, must be one or more pairs [B, C]"));
            }
            Ior::Sellmeier(pairs.into())
        }
        _ => return Err(node.error(format!("{} must have exactly one of {}", node.name, FORMS.join(", ")))),
    };
    let n = model.ior();
    if IOR_RANGE.contains(&n) {
        Ok(model)
    } else {
        Err(node
            .error(format!("the formula gives an IOR of {n} at 587.56 nm, must be greater than 0 (from 1e-6 to 1e6)")))
    }
}
