//! Scenes from TOML.
//!
//! Every error names file, line and column where it has them. Nothing that a file asks for is ignored: an unknown key is an error
//! that lists the valid ones, a feature that is not built yet is refused as such.

use std::path::Path;
use std::sync::Arc;

use toml_edit::Document;

use super::node::{Node, Table, Text};
use super::reader::{Context, read_list, read_table};
use crate::formats::encoding::utf16;
use crate::formats::files::Files;
use crate::scene::SceneError;
use crate::scene::description::{CameraDescription, Description, Environment, Kind, Object, Source, WorldMedium};
use crate::scene::fields::Visitor;
use crate::scene::tables::{blank_medium, medium_fields};

/// A scene from the bytes of its file, which must be text in UTF-8.
pub fn read(bytes: &[u8], path: &Path, files: &dyn Files) -> Result<Description, SceneError> {
    if utf16(bytes).is_some() {
        return Err(SceneError::in_file(path, "is text in UTF-16: scene files are TOML in UTF-8, so save it in that"));
    }
    let text = str::from_utf8(bytes).map_err(|error| {
        let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        let (line, column) = Text { path, text: &valid }.line_column(valid.len());
        SceneError::at(path, line, column, "is not text: scene files are TOML in UTF-8")
    })?;
    parse(text, path, files)
}

/// A scene from the text of its TOML file; `path` and `files` as in [`read`].
///
/// # Errors
/// When the scene or a file that it names cannot be used.
pub fn parse(text: &str, path: &Path, files: &dyn Files) -> Result<Description, SceneError> {
    parse_with(text, path, Some(files))
}

/// A scene without the contents of its meshes and images: what its text alone says.
pub(super) fn parse_text_only(text: &str, path: &Path) -> Result<Description, SceneError> {
    parse_with(text, path, None)
}

fn parse_with(text: &str, path: &Path, files: Option<&dyn Files>) -> Result<Description, SceneError> {
    let place = Text { path, text };
    let document = Document::parse(text).map_err(|error| {
        let message = error.message().trim().replace('\n', ", ");
        match error.span() {
            Some(span) => place.error(span.start, message),
            None => SceneError::in_file(path, message),
        }
    })?;
    let root = Table::root(&place, document.as_table());
    root.only(&[&["name", "camera", "world", "environment", "medium"][..], &Kind::ALL.map(Kind::name)].concat())?;

    let stem = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let mut context = Context::new(files, path.parent().unwrap_or(Path::new("")));
    let media = read_list(&root, "medium", &mut context, blank_medium, medium_fields)?;
    context.set_media(&media);
    let mut objects = Vec::new();
    for kind in Kind::ALL {
        objects.extend(read_list(&root, kind.name(), &mut context, || Object::blank(kind), Object::fields)?);
    }
    let mut section = |key: &'static str, node: Node<'_>, fields: &mut dyn FnMut(&mut dyn Visitor)| {
        read_table(node.table()?.renamed(format!("[{key}]")), key, &mut context, fields)
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
            is_builtin: files.is_some_and(Files::is_builtin),
        })),
    })
}
