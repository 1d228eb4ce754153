//! Scenes back to their files.
//!
//! The text that a scene was read from is edited, so that comments, order and notation survive: only what differs is written anew.
//! What differs is known by reading the old text again.

mod lines;
mod list;
mod merge;
mod paths;
mod tree;

use std::path::Path;

use toml_edit::{DocumentMut, Item, Table, TableLike};

use self::lines::ends_as_in;
use self::merge::{set, update};
use self::tree::Tree;
use super::read::parse_text_only;
use crate::formats::is_of_another_format;
use crate::scene::SceneError;
use crate::scene::description::Description;

/// The scene as a file's text. Relative paths stay as they are. A scene that has not been edited is the text that was read, to the byte.
pub fn to_text(description: &Description) -> String {
    let new = Tree::of(description);
    let source = description.source.as_deref().filter(|source| source.import.is_none());
    let original = source.and_then(|source| {
        let old = parse_text_only(&source.text, &source.path).ok()?;
        Some((source.text.as_str(), source.text.parse::<DocumentMut>().ok()?, Tree::of(&old)))
    });
    match original {
        Some((text, _, old)) if old == new => text.to_owned(),
        Some((text, mut document, old)) => {
            edit(&mut document, &old, &new);
            ends_as_in(text, document.to_string())
        }
        None => {
            let mut document = DocumentMut::new();
            edit(&mut document, &Tree::empty(&new), &new);
            document.to_string()
        }
    }
}

/// Makes `document`, which says `old`, say `new`.
fn edit(document: &mut DocumentMut, old: &Tree, new: &Tree) {
    let root = document.as_table_mut();
    if old.name != new.name {
        set(root, "name", new.name.as_str().into());
    }
    for ((key, old), (_, new)) in old.sections.iter().zip(&new.sections) {
        if old != new {
            update(section(root, key), old, new);
        }
    }
    for ((key, old), (_, new)) in old.lists.iter().zip(&new.lists) {
        list::sync(root, key, old, new);
    }
}

/// Writes the scene to a file, whole or not at all. Paths that are relative to another folder are rewritten, and so are absolute ones of what
/// was added and lies in the file's folder; what a built-in scene names is written beside the file, and
/// meshes and textures within a file of another format into folders beside it, called `NAME-meshes` and `NAME-textures`, and an environment as
/// `NAME-environment.exr`.
///
/// # Errors
/// When a file cannot be written, or its ending is that of another format.
pub fn save(description: &Description, path: &Path) -> Result<(), SceneError> {
    if is_of_another_format(path) {
        return Err(SceneError::in_file(path, "scenes are written as TOML: give the file the ending .toml"));
    }
    let mut copy = description.clone();
    paths::relocate(&mut copy, path)?;
    paths::write(path, to_text(&copy).as_bytes())
}

/// The table of that name, made if it is not there.
fn section<'t>(root: &'t mut Table, key: &str) -> &'t mut dyn TableLike {
    if !root.get(key).is_some_and(Item::is_table_like) {
        let mut table = Table::new();
        if !root.is_empty() {
            table.decor_mut().set_prefix("\n");
        }
        root.insert(key, Item::Table(table));
    }
    root.get_mut(key).and_then(Item::as_table_like_mut).expect("the table was just made")
}

#[cfg(test)]
mod tests;
