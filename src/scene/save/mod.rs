//! Scenes back to their files.
//!
//! The text that a scene was read from is edited, so that comments, order and notation survive: only what differs is written anew.
//! What differs is known by reading the old text again.

mod paths;
mod value;

use std::io::Write;
use std::path::{Path, PathBuf};

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

use self::value::ToValue;
use super::SceneError;
use super::description::{
    CameraDescription, Description, Environment, Light, Paint, Refractor, Solid, Transform, WorldMedium,
};
use super::load;
use crate::optics::{IorModel, Medium};

/// What some editors begin a file with.
const MARK: &str = "\u{feff}";

/// The scene as a file's text. Relative paths stay as they are.
pub fn to_text(description: &Description) -> String {
    let original = description.source.as_deref().and_then(|source| {
        let old = load::parse_text_only(&source.text, &source.path).ok()?;
        Some((source.text.parse::<DocumentMut>().ok()?, old))
    });
    let (mut document, old) = original.map_or_else(|| (DocumentMut::new(), None), |(text, old)| (text, Some(old)));
    let root = document.as_table_mut();
    let old = old.as_ref();

    field(root, "name", old.map(|o| &o.name), &description.name, None);
    camera(section(root, "camera"), old.map(|o| &o.camera), &description.camera);
    if old.map_or(&default_world(), |o| &o.world) != &description.world {
        world(section(root, "world"), old.map(|o| &o.world), &description.world);
    }
    if !same_environment(old.map_or(&Environment::Color([0.0; 3]), |o| &o.environment), &description.environment) {
        environment(section(root, "environment"), &description.environment);
    }
    let media = List { key: "medium", name: |m: &Medium| &m.name, write: medium };
    media.sync(root, old.map(|o| &o.media[..]), &description.media);
    let refractors = List { key: "refractor", name: |r: &Refractor| &r.name, write: refractor };
    refractors.sync(root, old.map(|o| &o.refractors[..]), &description.refractors);
    let solids = List { key: "solid", name: |s: &Solid| &s.name, write: solid };
    solids.sync(root, old.map(|o| &o.solids[..]), &description.solids);
    let lights = List { key: "light", name: |l: &Light| &l.name, write: light };
    lights.sync(root, old.map(|o| &o.lights[..]), &description.lights);
    in_form_of(description.source.as_deref().map_or("", |source| &source.text), document.to_string())
}

/// The text with the byte-order mark and the line ends of the original, which are no part of a document.
fn in_form_of(original: &str, text: String) -> String {
    let has_crlf = original.contains('\n') && original.matches('\n').count() == original.matches("\r\n").count();
    let text = if has_crlf { text.replace('\n', "\r\n") } else { text };
    if original.starts_with(MARK) { format!("{MARK}{text}") } else { text }
}

/// Writes the scene to a file, beside it first and then renamed, so that the file is never half written. Paths that are relative to
/// another folder are rewritten; what a built-in scene names is written beside the file.
///
/// # Errors
/// When a file cannot be written.
pub fn save(description: &Description, path: &Path) -> Result<(), SceneError> {
    let mut copy = description.clone();
    paths::relocate(&mut copy, path)?;
    write_atomically(path, to_text(&copy).as_bytes())
}

fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    // A link is written through, not replaced.
    let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let attempt = || -> std::io::Result<()> {
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            // As any new file, less what the umask takes; a temporary file would be for its owner alone.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut file = builder.tempfile_in(&folder)?;
        file.write_all(bytes)?;
        if let Ok(existing) = std::fs::metadata(&path) {
            file.as_file().set_permissions(existing.permissions())?;
        }
        file.as_file().sync_all()?;
        file.persist(&path)?;
        Ok(())
    };
    attempt().map_err(|error| SceneError::in_file(path.clone(), format!("cannot be written: {error}")))
}

/// Sets `key` unless it already says so: where `new` is what the file had (`old`), or the default of a key that is not there.
fn field<T: ToValue + PartialEq>(table: &mut dyn TableLike, key: &str, old: Option<&T>, new: &T, default: Option<&T>) {
    let is_there = table.contains_key(key);
    if old == Some(new) || (!is_there && default == Some(new)) {
        return;
    }
    set(table, key, new.to_value());
}

/// Puts a value in the place of an old one, keeping the comments around it.
fn set(table: &mut dyn TableLike, key: &str, mut new: Value) {
    if let Some(Item::Value(old)) = table.get_mut(key) {
        *new.decor_mut() = old.decor().clone();
        *old = new;
    } else {
        table.insert(key, Item::Value(new));
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
    WorldMedium { ior: IorModel::Constant(1.0), absorption: [0.0; 3] }
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
    field(table, "ior", old.map(|o| &o.ior), &new.ior, Some(&IorModel::Constant(1.0)));
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

fn medium(table: &mut Table, old: Option<&Medium>, new: &Medium) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    field(table, "ior", old.map(|o| &o.ior), &new.ior, None);
    field(table, "absorption", old.map(|o| &o.absorption), &new.absorption, Some(&[0.0; 3]));
}

fn refractor(table: &mut Table, old: Option<&Refractor>, new: &Refractor) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    field(table, "medium", old.map(|o| &o.medium), &new.medium, None);
    shape(table, old.map(|o| &o.shape), &new.shape);
    field(table, "priority", old.map(|o| &o.priority), &new.priority, Some(&0));
    field(table, "smooth", old.map(|o| &o.smooth), &new.smooth, Some(&false));
    visible(table, old.map(|o| o.visible), new.visible);
    field(table, "transform", old.map(|o| &o.transform), &new.transform, Some(&Transform::IDENTITY));
}

fn solid(table: &mut Table, old: Option<&Solid>, new: &Solid) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    shape(table, old.map(|o| &o.shape), &new.shape);
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
    visible(table, old.map(|o| o.visible), new.visible);
    field(table, "transform", old.map(|o| &o.transform), &new.transform, Some(&Transform::IDENTITY));
}

fn light(table: &mut Table, old: Option<&Light>, new: &Light) {
    field(table, "name", old.map(|o| &o.name), &new.name, None);
    shape(table, old.map(|o| &o.shape), &new.shape);
    field(table, "radiance", old.map(|o| &o.radiance), &new.radiance, None);
    visible(table, old.map(|o| o.visible), new.visible);
    field(table, "transform", old.map(|o| &o.transform), &new.transform, Some(&Transform::IDENTITY));
}

/// Only said of what is not: an object that is shown again loses the key.
fn visible(table: &mut Table, old: Option<bool>, new: bool) {
    if new && old == Some(false) {
        table.remove("visible");
    } else {
        field(table, "visible", old.as_ref(), &new, Some(&true));
    }
}

fn shape(table: &mut Table, old: Option<&super::description::Shape>, new: &super::description::Shape) {
    if !old.is_some_and(|old| value::same_shape(old, new)) {
        set(table, "shape", new.to_value());
    }
}

/// How an array of tables is brought up to date.
struct List<T> {
    key: &'static str,
    name: fn(&T) -> &str,
    write: fn(&mut Table, Option<&T>, &T),
}

impl<T> List<T> {
    /// Each entry keeps the table that had its name; one that was renamed in its place keeps its place's.
    fn sync(&self, root: &mut Table, old: Option<&[T]>, new: &[T]) {
        let old = old.unwrap_or_default();
        let mut tables: Vec<Option<Table>> = match root.get(self.key).cloned().map(Item::into_array_of_tables) {
            Some(Ok(array)) => array.into_iter().map(Some).collect(),
            _ => Vec::new(),
        };
        // Were they not alike, the file would not have been read.
        tables.resize_with(old.len(), || None);
        let name = self.name;
        let was_at = |wanted: &str| old.iter().position(|o| name(o) == wanted);
        let is_kept = |wanted: &str| new.iter().any(|n| name(n) == wanted);
        let sources: Vec<Option<usize>> = new
            .iter()
            .enumerate()
            .map(|(i, n)| was_at(name(n)).or_else(|| old.get(i).filter(|o| !is_kept(name(o))).map(|_| i)))
            .collect();
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
