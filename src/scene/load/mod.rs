//! Scenes from files: TOML with its meshes and images.
//!
//! Every error names file, line and column where it has them. Nothing that a file asks for is ignored: an unknown key is an error
//! that lists the valid ones, a feature that is not built yet is refused as such.

mod bytes;
mod corners;
mod encoding;
mod files;
pub(crate) mod image;
mod ior;
mod lines;
mod mesh;
mod node;
mod obj;
mod passed_over;
mod ply;
mod polygon;
mod reader;
mod suggest;

use std::path::Path;
use std::sync::Arc;

use toml_edit::Document;

pub use self::bytes::{image_from_bytes, mesh_from_bytes};
use self::encoding::Utf16;
use self::files::Files;
pub(super) use self::files::normal;
use self::node::{Node, Table, Text};
use self::reader::{Context, read, read_list};
use self::suggest::suggestion;
use super::SceneError;
use super::builtin;
use super::description::{self, CameraDescription, Description, Environment, Kind, Object, Source, WorldMedium};
use super::fields::Visitor;
use super::files::{MAX_SCENE_BYTES, read_or_receive};

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
    let mut context = Context::new(files);
    let media = read_list(&root, "medium", &mut context, description::blank_medium, description::medium_fields)?;
    context.set_media(&media);
    let mut objects = Vec::new();
    for kind in Kind::ALL {
        objects.extend(read_list(&root, kind.name(), &mut context, || Object::blank(kind), Object::fields)?);
    }
    let mut section = |key: &'static str, node: Node<'_>, fields: &mut dyn FnMut(&mut dyn Visitor)| {
        read(node.table()?.renamed(format!("[{key}]")), key, &mut context, fields)
    };
    let name = root.read("name", stem, |node| node.words().map(str::to_owned))?;
    let mut camera = CameraDescription::blank();
    section("camera", root.need("camera")?, &mut |v| camera.fields(v))?;
    let mut world = WorldMedium::DEFAULT;
    if let Some(node) = root.get("world") {
        section("world", node, &mut |v| world.fields(v))?;
    }
    let mut environment = Environment::DEFAULT;
    if let Some(node) = root.get("environment") {
        section("environment", node, &mut |v| environment.fields(v))?;
    }
    Ok(Description {
        name,
        camera,
        world,
        environment,
        media,
        objects: objects.into_iter().collect(),
        source: Some(Arc::new(Source {
            path: path.to_path_buf(),
            text: text.to_owned(),
            is_builtin: matches!(files, Files::BuiltIn(_)),
        })),
    })
}
