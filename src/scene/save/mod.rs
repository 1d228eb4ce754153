//! Scenes back to their files.
//!
//! The text that a scene was read from is edited, so that comments, order and notation survive: only what differs is written anew.
//! What differs is known by reading the old text again.

mod lines;
mod merge;
mod paths;
mod value;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use self::lines::ends_as_in;
use self::merge::merge;
use self::value::ToValue;
use super::SceneError;
use super::description::{
    CameraDescription, Description, Environment, Kind, Light, Object, Paint, Refractor, Role, Solid, Transform,
    WorldMedium,
};
use super::load;
use crate::optics::{Ior, Medium};
use crate::writing::write_atomically;

/// The scene as a file's text. Relative paths stay as they are. A scene that has not been edited is the text that was read, to the byte.
pub fn to_text(description: &Description) -> String {
    let original = description.source.as_deref().and_then(|source| {
        let old = load::parse_text_only(&source.text, &source.path).ok()?;
        Some((source.text.as_str(), source.text.parse::<DocumentMut>().ok()?, old))
    });
    match original {
        Some((text, _, old)) if says_the_same(&old, description) => text.to_owned(),
        Some((text, mut document, old)) => {
            edit(&mut document, Some(&old), description);
            ends_as_in(text, document.to_string())
        }
        None => {
            let mut document = DocumentMut::new();
            edit(&mut document, None, description);
            document.to_string()
        }
    }
}

/// Whether `new` is what the text of `old` says, which alone does not hold meshes and images.
fn says_the_same(old: &Description, new: &Description) -> bool {
    let mut new = Description { source: old.source.clone(), ..new.clone() };
    for (new, old) in new.objects.iter_mut().zip(&*old.objects) {
        if value::same_shape(&old.shape, &new.shape) {
            new.shape.clone_from(&old.shape);
        }
    }
    if same_environment(&old.environment, &new.environment) {
        new.environment.clone_from(&old.environment);
    }
    new == *old
}

/// Makes `document`, which says `old`, say `new`.
fn edit(document: &mut DocumentMut, old: Option<&Description>, new: &Description) {
    let root = document.as_table_mut();
    field(root, "name", old.map(|o| &o.name), &new.name, None);
    camera(section(root, "camera"), old.map(|o| &o.camera), &new.camera);
    if old.map_or(&default_world(), |o| &o.world) != &new.world {
        world(section(root, "world"), old.map(|o| &o.world), &new.world);
    }
    if !same_environment(old.map_or(&Environment::Color([0.0; 3]), |o| &o.environment), &new.environment) {
        environment(section(root, "environment"), &new.environment);
    }
    let media = List { key: "medium", name: |m: &Medium| &m.name, write: medium };
    media.sync(root, old.map(|o| &o.media[..]), &new.media);
    for kind in Kind::ALL {
        let objects = List { key: kind.name(), name: |o: &Object| &o.name, write: object };
        objects.sync(root, old.map(|o| o.objects.of(kind)), new.objects.of(kind));
    }
}

/// Writes the scene to a file, whole or not at all. Paths that are relative to another folder are rewritten; what a built-in scene names
/// is written beside the file.
///
/// # Errors
/// When a file cannot be written.
pub fn save(description: &Description, path: &Path) -> Result<(), SceneError> {
    let mut copy = description.clone();
    paths::relocate(&mut copy, path)?;
    write(path, to_text(&copy).as_bytes())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    write_atomically(path, |writer| writer.write_all(bytes)).map_err(|error| SceneError::new(error.to_string()))
}

/// Sets `key` unless it already says so: where `new` is what the file had (`old`), or the default of a key that is not there.
fn field<T: ToValue + PartialEq>(table: &mut dyn TableLike, key: &str, old: Option<&T>, new: &T, default: Option<&T>) {
    let is_there = table.contains_key(key);
    if old == Some(new) || (!is_there && default == Some(new)) {
        return;
    }
    set(table, key, new.to_value());
}

/// Puts a value in the place of an old one, whose notation stays as far as it says the same.
fn set(table: &mut dyn TableLike, key: &str, new: Value) {
    match table.get_mut(key) {
        Some(old) => merge(old, new),
        None => {
            table.insert(key, Item::Value(new));
        }
    }
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

fn default_world() -> WorldMedium {
    WorldMedium { ior: Ior::Constant(1.0), absorption: [0.0; 3] }
}

fn camera(table: &mut dyn TableLike, old: Option<&CameraDescription>, new: &CameraDescription) {
    field(table, "position", old.map(|o| &o.position), &new.position, None);
    field(table, "target", old.map(|o| &o.target), &new.target, None);
    field(table, "up", old.map(|o| &o.up), &new.up, Some(&glam::DVec3::Y));
    field(table, "vertical_fov", old.map(|o| &o.vertical_fov), &new.vertical_fov, Some(&load::DEFAULT_VERTICAL_FOV));
    field(table, "aperture_radius", old.map(|o| &o.aperture_radius), &new.aperture_radius, Some(&0.0));
    match new.focus_distance {
        Some(distance) => {
            field(table, "focus_distance", old.and_then(|o| o.focus_distance.as_ref()), &distance, None);
        }
        None => {
            table.remove("focus_distance");
        }
    }
}

fn world(table: &mut dyn TableLike, old: Option<&WorldMedium>, new: &WorldMedium) {
    field(table, "ior", old.map(|o| &o.ior), &new.ior, Some(&Ior::Constant(1.0)));
    field(table, "absorption", old.map(|o| &o.absorption), &new.absorption, Some(&[0.0; 3]));
}

/// Whether two environments are written alike; the text alone does not hold an image's pixels.
fn same_environment(a: &Environment, b: &Environment) -> bool {
    match (a, b) {
        (
            Environment::Image { path: path_a, rotation: rotation_a, scale: scale_a, .. },
            Environment::Image { path: path_b, rotation: rotation_b, scale: scale_b, .. },
        ) => path_a == path_b && rotation_a == rotation_b && scale_a == scale_b,
        _ => a == b,
    }
}

fn environment(table: &mut dyn TableLike, new: &Environment) {
    let form = match new {
        Environment::Color(_) => "color",
        Environment::Gradient { .. } => "gradient",
        Environment::Image { .. } => "image",
    };
    for other in ["color", "gradient", "image", "rotation", "scale"] {
        if other != form && (form != "image" || !matches!(other, "rotation" | "scale")) {
            table.remove(other);
        }
    }
    match new {
        Environment::Color(color) => set(table, form, color.to_value()),
        Environment::Gradient { zenith, horizon, nadir } => {
            set(table, form, value::inline([("zenith", zenith), ("horizon", horizon), ("nadir", nadir)]));
        }
        Environment::Image { path, rotation, scale, .. } => {
            set(table, form, path.to_value());
            field(table, "rotation", None, rotation, Some(&0.0));
            field(table, "scale", None, scale, Some(&1.0));
        }
    }
}

fn medium(table: &mut dyn TableLike, old: Option<&Medium>, new: &Medium) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    field(table, "ior", old.map(|o| &o.ior), &new.ior, None);
    field(table, "absorption", old.map(|o| &o.absorption), &new.absorption, Some(&[0.0; 3]));
}

fn object(table: &mut dyn TableLike, old: Option<&Object>, new: &Object) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    match &new.role {
        Role::Refractor(new) => refractor(table, old.and_then(Object::refractor), new),
        Role::Solid(new) => solid(table, old.and_then(Object::solid), new),
        Role::Light(new) => light(table, old.and_then(Object::light), new),
    }
    shape(table, old.map(|o| &o.shape), &new.shape);
    visible(table, old.map(|o| o.visible), new.visible);
    transform(table, old.map(|o| &o.transform), &new.transform);
}

fn refractor(table: &mut dyn TableLike, old: Option<&Refractor>, new: &Refractor) {
    field(table, "medium", old.map(|o| &o.medium), &new.medium, None);
    field(table, "priority", old.map(|o| &o.priority), &new.priority, Some(&0));
    field(table, "smooth", old.map(|o| &o.smooth), &new.smooth, Some(&false));
}

fn solid(table: &mut dyn TableLike, old: Option<&Solid>, new: &Solid) {
    if old.map(|o| &o.paint) != Some(&new.paint) {
        let (form, other) = match new.paint {
            Paint::Color(_) => ("color", "checker"),
            Paint::Checker { .. } => ("checker", "color"),
        };
        table.remove(other);
        set(table, form, new.paint.to_value());
    }
    field(table, "mirror", old.map(|o| &o.mirror), &new.mirror, Some(&false));
    field(table, "smooth", old.map(|o| &o.smooth), &new.smooth, Some(&false));
}

fn light(table: &mut dyn TableLike, old: Option<&Light>, new: &Light) {
    field(table, "radiance", old.map(|o| &o.radiance), &new.radiance, None);
}

/// Only said of what is not: an object that is shown again loses the key.
fn visible(table: &mut dyn TableLike, old: Option<bool>, new: bool) {
    if new && old == Some(false) {
        table.remove("visible");
    } else {
        field(table, "visible", old.as_ref(), &new, Some(&true));
    }
}

fn shape(table: &mut dyn TableLike, old: Option<&super::description::Shape>, new: &super::description::Shape) {
    if !old.is_some_and(|old| value::same_shape(old, new)) {
        set(table, "shape", new.to_value());
    }
}

/// Keys that are there stay, also where they say the default.
fn transform(table: &mut dyn TableLike, old: Option<&Transform>, new: &Transform) {
    if old == Some(new) {
        return;
    }
    let there = table.get("transform").and_then(Item::as_table_like);
    let value = value::transform(new, |key| there.is_some_and(|there| there.contains_key(key)));
    if there.is_some() || *new != Transform::IDENTITY {
        set(table, "transform", value);
    }
}

/// How an array of tables is brought up to date.
struct List<T> {
    key: &'static str,
    name: fn(&T) -> &str,
    write: fn(&mut dyn TableLike, Option<&T>, &T),
}

impl<T> List<T> {
    /// Each entry keeps the table that had its name; one that was renamed in its place keeps its place's.
    fn sync(&self, root: &mut Table, old: Option<&[T]>, new: &[T]) {
        let old = old.unwrap_or_default();
        let sources = self.sources(old, new);
        match root.get_mut(self.key) {
            Some(Item::Value(Value::Array(array))) if !new.is_empty() => self.sync_inline(array, old, new, &sources),
            _ => self.sync_tables(root, old, new, sources),
        }
    }

    /// For each new entry the old one whose table it takes over.
    fn sources(&self, old: &[T], new: &[T]) -> Vec<Option<usize>> {
        let name = self.name;
        // Of equal names, which the loader refuses, the first.
        let was_at: HashMap<&str, usize> = old.iter().enumerate().rev().map(|(index, o)| (name(o), index)).collect();
        let kept: HashSet<&str> = new.iter().map(name).collect();
        let renamed = |index: usize| old.get(index).filter(|o| !kept.contains(name(o))).map(|_| index);
        new.iter().enumerate().map(|(index, n)| was_at.get(name(n)).copied().or_else(|| renamed(index))).collect()
    }

    /// In an array of inline tables, as `medium = [{ … }, { … }]`.
    fn sync_inline(&self, array: &mut Array, old: &[T], new: &[T], sources: &[Option<usize>]) {
        let mut tables: Vec<Option<Value>> = array.iter().cloned().map(Some).collect();
        tables.resize_with(old.len(), || None);
        // New ones stand on a line of their own where the last one does, without its comment.
        let prefix = array.iter().last().and_then(|last| last.decor().prefix()?.as_str());
        let prefix = prefix.map(|prefix| prefix[prefix.rfind('\n').unwrap_or(0)..].to_owned());
        let mut values = Vec::with_capacity(new.len());
        for (n, source) in new.iter().zip(sources) {
            let found = source.and_then(|j| tables[j].take().map(|value| (value, &old[j])));
            let (mut value, o) = match found {
                Some((value, o)) => (value, Some(o)),
                None => {
                    let mut value = Value::InlineTable(InlineTable::new());
                    if let Some(prefix) = &prefix {
                        value.decor_mut().set_prefix(prefix.as_str());
                    }
                    (value, None)
                }
            };
            if let Some(table) = value.as_inline_table_mut() {
                let keys = table.len();
                (self.write)(table, o, n);
                if table.len() != keys {
                    table.fmt();
                }
            }
            values.push(value);
        }
        array.clear();
        values.into_iter().for_each(|value| array.push_formatted(value));
    }

    /// In tables of their own, `[[medium]]`.
    fn sync_tables(&self, root: &mut Table, old: &[T], new: &[T], sources: Vec<Option<usize>>) {
        let mut tables: Vec<Option<Table>> = match root.get(self.key).cloned().map(Item::into_array_of_tables) {
            Some(Ok(array)) => array.into_iter().map(Some).collect(),
            _ => Vec::new(),
        };
        // Were they not alike, the file would not have been read.
        tables.resize_with(old.len(), || None);
        let kept: Vec<usize> = sources.iter().flatten().copied().collect();
        if !kept.is_sorted() {
            // A table that moves takes its subtables along only if they are part of it.
            for (_, item) in tables.iter_mut().flatten().flat_map(Table::iter_mut).filter(|(_, item)| item.is_table()) {
                item.make_value();
            }
        }
        // In a file tables of different kinds may alternate: the places stay, whoever takes them.
        let mut positions: Vec<isize> = kept.iter().filter_map(|&j| tables[j].as_ref()?.position()).collect();
        positions.sort_unstable();
        let mut last_position = positions.first().copied();
        let mut positions = positions.into_iter();

        let mut array = ArrayOfTables::new();
        for (n, source) in new.iter().zip(sources) {
            let found = source.and_then(|j| tables[j].take().map(|table| (table, &old[j])));
            let table = match found {
                Some((mut table, o)) => {
                    (self.write)(&mut table, Some(o), n);
                    if table.position().is_some() {
                        table.set_position(positions.next());
                    }
                    last_position = end_position(&table).or(last_position);
                    table
                }
                None => {
                    let mut table = Table::new();
                    table.decor_mut().set_prefix("\n");
                    (self.write)(&mut table, None, n);
                    // Tables of equal position stay in the order of the array.
                    table.set_position(last_position);
                    table
                }
            };
            array.push(table);
        }
        match (array.is_empty(), root.get_mut(self.key)) {
            (true, _) => {
                root.remove(self.key);
            }
            (false, Some(item)) => *item = Item::ArrayOfTables(array),
            (false, None) => {
                root.insert(self.key, Item::ArrayOfTables(array));
            }
        }
    }
}

/// The position of the last of a table and its subtables.
fn end_position(table: &Table) -> Option<isize> {
    table.iter().filter_map(|(_, item)| item.as_table().and_then(end_position)).chain(table.position()).max()
}

#[cfg(test)]
mod tests;
