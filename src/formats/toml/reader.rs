//! Fills in the fields of a scene's tables from TOML.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::ior;
use super::node::{Node, Table};
use crate::formats::files::{Files, Input};
use crate::formats::image;
use crate::formats::mesh::{self, MeshFile, PartFault};
use crate::formats::parts::NoSuchPart;
use crate::formats::suggest::suggestion;
use crate::formats::texture;
use crate::geometry::Mesh;
use crate::optics::{Medium, catalog, medium};
use crate::scene::description::MeshPart;
use crate::scene::environment::EnvironmentImage;
use crate::scene::fields::{Field, Slot, Visitor};
use crate::scene::texture::TextureImage;
use crate::scene::{Fault, LoadNote, SceneError, validate};

/// What the tables of a scene have to do with each other and with files.
pub(super) struct Context<'a> {
    /// Where meshes and images are found; `None` if only the scene's own text is read.
    files: Option<&'a dyn Files>,
    /// That of the scene file.
    folder: &'a Path,
    /// Names of the media, in their order.
    media: Vec<String>,
    known_media: HashSet<String>,
    /// Whether the media could not be found out: then any name may be one.
    has_lost_media: bool,
    /// Names so far, each with what it names.
    names: HashMap<String, &'static str>,
    /// Meshes read so far, with what was passed over in their files: objects that name one file share it.
    meshes: HashMap<(PathBuf, MeshPart), (Arc<Mesh>, Vec<LoadNote>)>,
    /// Textures read so far.
    textures: HashMap<PathBuf, Arc<TextureImage>>,
    /// Files of which parts were taken, for more of them.
    mesh_files: HashMap<PathBuf, MeshFile>,
    /// In the order in which they were found.
    pub errors: Vec<SceneError>,
}

impl<'a> Context<'a> {
    pub fn new(files: Option<&'a dyn Files>, folder: &'a Path) -> Self {
        let (names, meshes, errors) = (HashMap::new(), HashMap::new(), Vec::new());
        let (known_media, mesh_files) = (HashSet::new(), HashMap::new());
        let (has_lost_media, textures, media) = (false, HashMap::new(), Vec::new());
        Self { files, folder, media, known_media, has_lost_media, names, meshes, textures, mesh_files, errors }
    }

    /// Keeps an error; whatever stands for the value that could not be read.
    pub fn report<T: Default>(&mut self, error: SceneError) -> T {
        self.errors.push(error);
        T::default()
    }

    /// From here on names are those of objects, which may name these media; `None` where they could not be found out.
    pub fn set_media(&mut self, media: Option<&[Medium]>) {
        self.has_lost_media = media.is_none_or(|media| media.iter().any(|medium| medium.name.is_empty()));
        self.media = media.unwrap_or_default().iter().map(|medium| medium.name.clone()).collect();
        self.known_media = self.media.iter().cloned().collect();
        self.names.clear();
    }

    fn medium(&self, node: &Node<'_>) -> Result<String, SceneError> {
        let name = node.words()?;
        if self.known_media.contains(name) || self.has_lost_media {
            return Ok(name.to_owned());
        }
        let hint = if matches!(name, medium::WORLD | medium::VACUUM) {
            "; the name is reserved: give this object a [[medium]] of its own, with the same IOR".to_owned()
        } else if let Some(entry) = catalog::find(name) {
            format!("; the catalogue has it: add a [[medium]] with ior = {{ catalog = \"{}\" }}", entry.name)
        } else {
            suggestion(name, self.media.iter().map(String::as_str))
        };
        let list = match &self.media[..] {
            [] => "it has none".to_owned(),
            media => format!("media: {}", media.join(", ")),
        };
        Err(node.error(format!("the scene has no medium `{name}`{hint}; {list}")))
    }

    /// Of a medium of the scene, or of the global one.
    fn medium_or_world(&self, node: &Node<'_>) -> Result<String, SceneError> {
        let name = node.words()?;
        if name == medium::WORLD { Ok(name.to_owned()) } else { self.medium(node) }
    }

    /// `part_node`: where the part is named, by its key.
    fn mesh<'n>(
        &mut self,
        node: &Node<'n>,
        path: PathBuf,
        part: &MeshPart,
        part_node: impl Fn(&str) -> Option<Node<'n>>,
    ) -> Result<(Arc<Mesh>, Vec<LoadNote>), SceneError> {
        let format = mesh::format_of(&path).map_err(|message| node.error(message))?;
        let key = (path, part.clone());
        if let Some(found) = self.meshes.get(&key) {
            return Ok(found.clone());
        }
        let path = &key.0;
        let Some(files) = self.files else { return Ok((Arc::default(), Vec::new())) };
        let file = files.locate(&self.folder.join(path));
        let read = || {
            let bytes =
                files.read(&file).map_err(|message| node.error(format!("the mesh {} {message}", file.display())))?;
            let input = Input { bytes: &bytes, path: &file, files };
            MeshFile::read(&input, format).map_err(|fault| mesh::error_in(&file, fault))
        };
        let (mesh, notes) = if part.is_whole() {
            read()?.whole().map_err(|fault| mesh::error_in(&file, fault))?
        } else {
            if !self.mesh_files.contains_key(path) {
                self.mesh_files.insert(path.clone(), read()?);
            }
            self.mesh_files[path].part(part).map_err(|fault| match fault {
                PartFault::Fault(fault) => mesh::error_in(&file, fault),
                PartFault::NoSuchPart(NoSuchPart { key, message }) => {
                    let message = format!("the mesh {} {message}", path.display());
                    part_node(key).as_ref().unwrap_or(node).error(message)
                }
            })?
        };
        Ok(self.meshes.entry(key).insert_entry((Arc::new(mesh), notes)).get().clone())
    }

    fn texture(&mut self, node: &Node<'_>, path: &Path) -> Result<Option<Arc<TextureImage>>, SceneError> {
        let Some(files) = self.files else { return Ok(None) };
        if let Some(known) = self.textures.get(path) {
            return Ok(Some(Arc::clone(known)));
        }
        let name = || files.locate(&self.folder.join(path)).display().to_string();
        let image = texture::read(path, self.folder, files);
        let image = Arc::new(image.map_err(|message| node.error(format!("the texture {} {message}", name())))?);
        self.textures.insert(path.to_owned(), Arc::clone(&image));
        Ok(Some(image))
    }

    fn image(&self, node: &Node<'_>, path: PathBuf) -> Result<Option<EnvironmentImage>, SceneError> {
        let Some(files) = self.files else { return Ok(None) };
        let format = image::format_of(&path).map_err(|message| node.error(message))?;
        let file = files.locate(&self.folder.join(&path));
        let bytes =
            (files.read(&file)).map_err(|message| node.error(format!("the image {} {message}", file.display())))?;
        image::read(&bytes, format).map(Some).map_err(|message| SceneError::in_file(file, message))
    }
}

/// Reads one table into what `fields` goes through, and keeps all its errors. Whether something is missing is not said of a table with unknown
/// keys, for one of those is probably meant. `is_checked`: whether what only several fields together show is looked at.
pub(super) fn read_table(
    table: Table<'_>,
    kind: &'static str,
    context: &mut Context<'_>,
    is_checked: bool,
    fields: impl FnOnce(&mut dyn Visitor),
) {
    let errors = context.errors.len();
    let mut reader = Reader {
        named: table.clone(),
        table,
        kind,
        context,
        errors,
        keys: Vec::new(),
        missing: Vec::new(),
        is_lost: false,
        has_refused: false,
        has_bad_table: !is_checked,
    };
    fields(&mut reader);
    let Reader { table, keys, missing, has_refused, context, .. } = reader;
    let before = context.errors.len();
    context.errors.extend(table.unknown(&keys));
    if context.errors.len() == before && !has_refused {
        context.errors.extend(missing);
    }
}

/// The tables of `[[kind]]`, each read into a blank value; `None` where there is something else.
pub(super) fn read_list<T>(
    root: &Table<'_>,
    kind: &'static str,
    context: &mut Context<'_>,
    blank: impl Fn() -> T,
    fields: impl Fn(&mut T, &mut dyn Visitor),
) -> Option<Vec<T>> {
    let tables = match root.read(kind, Vec::new(), Node::tables) {
        Ok(tables) => tables,
        Err(error) => return context.report(error),
    };
    let read_one = |table: Table<'_>| {
        let mut value = blank();
        read_table(table.renamed(format!("[[{kind}]]")), kind, context, true, |v| fields(&mut value, v));
        value
    };
    Some(tables.into_iter().map(read_one).collect())
}

struct Reader<'t, 'c, 'f> {
    table: Table<'t>,
    /// The same, as errors call it once its name is known.
    named: Table<'t>,
    /// What the table describes, such as `medium`.
    kind: &'static str,
    context: &'c mut Context<'f>,
    /// Errors that there were before the table.
    errors: usize,
    /// The keys that the table may have.
    keys: Vec<&'static str>,
    /// Errors about keys that are not there.
    missing: Vec<SceneError>,
    /// Whether it is not known which form the table has: what is said of its fields then would be wrong.
    is_lost: bool,
    /// Whether there is a key that other forms have: it probably stands for one that is missing.
    has_refused: bool,
    /// Whether a table that others look at has errors.
    has_bad_table: bool,
}

impl Reader<'_, '_, '_> {
    fn is_sound(&self) -> bool {
        self.context.errors.len() == self.errors && self.missing.is_empty() && !self.is_lost
    }

    fn allow(&mut self, key: &'static str) {
        if !self.keys.contains(&key) {
            self.keys.push(key);
        }
    }

    fn fill(&mut self, node: &Node<'_>, slot: Slot<'_>) -> Result<(), SceneError> {
        match slot {
            Slot::Flag(value) => *value = node.boolean()?,
            Slot::Integer(value) => *value = node.integer(i32::MIN..=i32::MAX)?,
            Slot::Count(value) => *value = node.integer(0..=u32::MAX)?,
            Slot::Number(value, limits) => *value = node.number_within(limits)?,
            Slot::Maybe(value, limits) => *value = Some(node.number_within(limits)?),
            Slot::Numbers(value, limits) => *value = node.numbers_within(limits)?,
            Slot::Both(value, limits) if node.is_number() => *value = [node.number_within(limits)?; 2],
            Slot::Both(value, limits) => *value = node.numbers_within(limits)?,
            Slot::Pair(value, limits) => *value = node.numbers_within(limits)?,
            Slot::Vector(value) => *value = node.numbers()?.into(),
            Slot::Scale(value) if node.is_number() => *value = glam::DVec3::splat(node.number()?),
            Slot::Scale(value) => *value = node.numbers()?.into(),
            Slot::Points(value) => *value = node.items()?.iter().map(Node::numbers).collect::<Result<_, _>>()?,
            Slot::Ior(value) => *value = ior::ior(node)?,
            Slot::Name(value) => *value = self.name(node)?,
            Slot::Medium(value) => *value = self.context.medium(node)?,
            Slot::PartName(value) => *value = Some(node.words()?.to_owned()),
            Slot::MaybeMedium(value) => *value = Some(self.context.medium_or_world(node)?),
            Slot::Mesh { path, part, mesh, notes } => {
                *path = node.words()?.into();
                let words = |key| self.table.get(key).map(|node| node.words().map(str::to_owned)).transpose();
                // A name that is none is an error where its own field is read.
                if let (Ok(group), Ok(material)) = (words("group"), words("material")) {
                    *part = MeshPart { group, material };
                    let table = self.table.clone();
                    (*mesh, *notes) = self.context.mesh(node, path.clone(), part, |key| table.get(key))?;
                }
            }
            Slot::Image { path, image } => {
                *path = node.words()?.into();
                if let Some(read) = self.context.image(node, path.clone())? {
                    *image = Arc::new(read);
                }
            }
            Slot::Texture { path, image } => {
                *path = node.words()?.into();
                if let Some(read) = self.context.texture(node, path)? {
                    *image = read;
                }
            }
            Slot::Table(fields) => {
                let before = self.context.errors.len();
                let is_checked = !self.has_bad_table;
                match node.table() {
                    Ok(table) => read_table(table, self.kind, self.context, is_checked, fields),
                    Err(error) => self.context.report(error),
                }
                self.has_bad_table |= self.context.errors.len() > before;
            }
        }
        Ok(())
    }

    /// Later errors call the table by its name.
    fn name(&mut self, node: &Node<'_>) -> Result<String, SceneError> {
        let (name, kind) = (node.words()?, self.kind);
        // Whatever is wrong with it: who uses the name means this.
        let other = self.context.names.insert(name.to_owned(), kind);
        let message =
            (validate::reserved_name(name, kind)).or_else(|| Some(validate::duplicate_name(name, kind, other?)));
        self.context.errors.extend(message.map(|message| node.error(message)));
        self.named = self.table.clone().renamed(format!("{kind} `{name}`"));
        Ok(name.to_owned())
    }
}

impl Visitor for Reader<'_, '_, '_> {
    fn field(&mut self, Field { key, slot, is_default }: Field<'_>) -> bool {
        self.allow(key);
        let node = self.table.get(key);
        if !self.is_lost {
            match &node {
                Some(node) => {
                    if let Err(error) = self.fill(node, slot) {
                        self.context.errors.push(error);
                    }
                }
                None if is_default.is_none() => self.missing.extend(self.named.need(key).err()),
                None => {}
            }
        }
        node.is_some()
    }

    fn form(&mut self, forms: &[&'static str], current: &'static str, default: Option<&'static str>) -> &'static str {
        forms.iter().for_each(|form| self.allow(form));
        match (&self.table.present(forms)[..], default) {
            ([form], _) => return form,
            ([], Some(default)) => return default,
            ([first, .., last], Some(_)) => {
                let both = format!("{} has both `{first}` and `{last}`; remove one", self.named.name);
                let place = self.table.get(last);
                self.context.errors.push(place.map_or_else(|| self.table.error(&*both), |p| p.error(&*both)));
            }
            (present, None) => {
                let message = format!("{} must have exactly one of {}", self.named.name, forms.join(", "));
                let error = self.table.error(message);
                if present.is_empty() { self.missing.push(error) } else { self.context.errors.push(error) }
            }
        }
        self.is_lost = true;
        current
    }

    fn refuse(&mut self, key: &'static str, why: &str) {
        self.allow(key);
        if let Some(node) = self.table.get(key).filter(|_| !self.is_lost) {
            self.context.errors.push(node.error(why));
            self.has_refused = true;
        }
    }

    fn check(&mut self, check: &dyn Fn() -> Result<(), Fault>) {
        // What is blank would be at fault too.
        if !self.is_sound() || self.has_bad_table || self.context.files.is_none() {
            return;
        }
        if let Err(Fault { key, message }) = check() {
            self.context.errors.push(match self.table.get(key) {
                Some(node) => node.error(message),
                None => self.table.error(message),
            });
        }
    }
}
