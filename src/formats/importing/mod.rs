//! What readers of other renderers' scenes have in common: their objects with the media that they declare on both sides, what could not be taken as
//! it is, and a [`Description`] in the end.
//!
//! Nothing is dropped silently: what has no counterpart is approximated or left out, and said once a kind, with the place of the first.

pub(super) mod environment;
pub(super) mod indices;
pub(super) mod media;
pub(super) mod place;
pub(super) mod shapes;
pub(super) mod spectra;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine2, DAffine3, DVec3};

use self::media::{Side, resolve};
use self::place::{Facing, Placed};
use super::disk::MAX_DATA_BYTES;
use super::files::Input;
use super::mesh::{MeshFile, PartFault};
use super::names::Names;
use super::parts::NoSuchPart;
use super::{compressed, image, mesh, texture};
use crate::geometry::Mesh;
use crate::scene::Place;
use crate::scene::camera::Camera;
use crate::scene::description::{
    CameraDescription, Environment, Import, Light, MeshPart, Object, Objects, Paint, Refractor, Role, Shape, Solid,
    Source, UvTransform,
};
use crate::scene::environment::EnvironmentImage;
use crate::scene::shapes::validate;
use crate::scene::texture::TextureImage;
use crate::scene::{Description, LoadNote, SceneError};

/// Most objects of a scene, instances counted one by one.
pub(super) const MOST_OBJECTS: usize = 1 << 20;

/// What an object is to light, with media as the file declares them.
#[derive(Debug, Clone)]
pub(super) enum Matter {
    Refractor {
        refractor: Refractor,
        inside: Side,
        outside: Side,
    },
    Solid(Solid),
    /// `around` is the medium that the file declares around the light.
    Light {
        light: Light,
        around: Option<Side>,
    },
}

/// A scene that is being put together.
pub(super) struct Importer<'a> {
    /// For people, such as `Mitsuba`.
    format: &'static str,
    pub input: &'a Input<'a>,
    notes: Vec<LoadNote>,
    names: Names,
    objects: Vec<(Object, Matter)>,
    meshes: HashMap<(PathBuf, MeshPart), Arc<FileMesh>>,
    /// Of which parts were taken, for more of them.
    mesh_files: HashMap<PathBuf, MeshFile>,
    textures: HashMap<PathBuf, Arc<TextureImage>>,
    /// Files other than meshes and images that were read.
    files: Vec<PathBuf>,
    /// Where files are looked for beside the scene's folder, by paths from there.
    folders: Vec<PathBuf>,
    pub camera: Option<CameraDescription>,
    /// What the file declares around the camera.
    pub camera_medium: Option<Side>,
    pub environment: Environment,
}

/// A mesh of a file, with what of it was passed over.
#[derive(Debug)]
pub(super) struct FileMesh {
    pub mesh: Arc<Mesh>,
    pub notes: Vec<LoadNote>,
    /// As the scene names it; empty of one that is in no file of its own.
    pub path: PathBuf,
    pub part: MeshPart,
    /// What its object may be called.
    pub name: String,
    pub facing: Facing,
}

impl<'a> Importer<'a> {
    pub fn new(format: &'static str, input: &'a Input<'a>) -> Self {
        Self {
            format,
            input,
            notes: Vec::new(),
            names: Names::default(),
            objects: Vec::new(),
            meshes: HashMap::new(),
            textures: HashMap::new(),
            mesh_files: HashMap::new(),
            files: Vec::new(),
            folders: Vec::new(),
            camera: None,
            camera_medium: None,
            environment: Environment::DEFAULT,
        }
    }

    /// Says that something is not taken as it is. Of one kind and message the first place is kept, and the number.
    pub fn note(&mut self, kind: &'static str, place: &Place, message: impl Into<String>) {
        let message = message.into();
        if let Some(known) = self.notes.iter_mut().find(|note| note.kind == kind && note.message == message) {
            known.count += 1;
            return;
        }
        let is_own = place.file == self.input.path;
        let first_line = place.line_column.map(|(line, _)| line).filter(|_| is_own);
        let message = if is_own { message } else { format!("{message} ({place})") };
        self.notes.push(LoadNote { kind, count: 1, first_line, message });
    }

    /// The bytes of a file that the scene names, uncompressed, and the path by which errors call it.
    pub fn bytes_of(&mut self, named: &str, place: &Place) -> Result<(Vec<u8>, PathBuf), SceneError> {
        let file = self.locate(&self.found(named));
        let bytes = self.input.files.read(&file).map_err(|why| at(place, format!("{} {why}", file.display())))?;
        let bytes = match compressed::is_compressed(&file) {
            true => compressed::gunzip(&bytes, MAX_DATA_BYTES)
                .map_err(|why| at(place, format!("{} {why}", file.display())))?,
            false => bytes.into_owned(),
        };
        Ok((bytes, file))
    }

    /// The bytes of a part of the scene's own text, in another file.
    pub fn part_of_scene(&mut self, named: &str, place: &Place) -> Result<(Vec<u8>, PathBuf), SceneError> {
        let found = self.bytes_of(named, place)?;
        if !self.files.contains(&found.1) {
            self.files.push(found.1.clone());
        }
        Ok(found)
    }

    fn folder(&self) -> &Path {
        self.input.path.parent().unwrap_or(Path::new(""))
    }

    /// By a path from the scene's folder.
    fn locate(&self, path: &Path) -> PathBuf {
        self.input.files.locate(&self.folder().join(path))
    }

    /// The path of a file that the scene names, from the scene's folder: there, or in a folder that it is to be looked for in.
    pub fn found(&self, named: &str) -> PathBuf {
        let named = PathBuf::from(named.replace('\\', "/"));
        if self.folders.is_empty() {
            return named;
        }
        let others = self.folders.iter().map(|folder| folder.join(&named));
        let mut all = std::iter::once(named.clone()).chain(others);
        all.find(|path| self.input.files.read(&self.locate(path)).is_ok()).unwrap_or(named)
    }

    /// Files are looked for in another folder too, which is named from that of the file at `place`.
    pub fn look_in(&mut self, named: &str, place: &Place) {
        let folder = place.file.parent().unwrap_or(Path::new("")).join(named.replace('\\', "/"));
        let folder = folder.strip_prefix(self.folder()).map(Path::to_path_buf).unwrap_or(folder);
        self.folders.push(folder);
    }

    /// The mesh of a file, or a part of it, read once.
    pub fn mesh(&mut self, named: &str, part: &MeshPart, place: &Place) -> Result<Arc<FileMesh>, SceneError> {
        let key = (self.found(named), part.clone());
        if let Some(known) = self.meshes.get(&key) {
            return Ok(Arc::clone(known));
        }
        let path = &key.0;
        if !self.mesh_files.contains_key(path) {
            let file = self.mesh_file(named, path, place)?;
            self.mesh_files.insert(path.clone(), file);
        }
        let located = self.locate(path);
        let (mesh, notes) = match &self.mesh_files[path] {
            file if !part.is_whole() => file.part(part).map_err(|fault| match fault {
                PartFault::Fault(fault) => mesh::error_in(&located, fault),
                PartFault::NoSuchPart(NoSuchPart { message, .. }) => at(place, format!("{named} {message}")),
            })?,
            _ => {
                let whole = self.mesh_files.remove(path).map(MeshFile::whole).expect("it was just read");
                whole.map_err(|fault| mesh::error_in(&located, fault))?
            }
        };
        let facing = Facing::of(&mesh);
        let is_compressed = compressed::is_compressed(path);
        let plain = if is_compressed { path.with_extension("") } else { path.clone() };
        let name = plain.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        // Scene files name no compressed meshes: it is one of the scene's own.
        let path = if is_compressed { PathBuf::new() } else { path.clone() };
        let read = Arc::new(FileMesh { mesh: Arc::new(mesh), notes, path, part: part.clone(), name, facing });
        self.meshes.insert(key, Arc::clone(&read));
        Ok(read)
    }

    fn mesh_file(&mut self, named: &str, path: &Path, place: &Place) -> Result<MeshFile, SceneError> {
        let plain = if compressed::is_compressed(path) { path.with_extension("") } else { path.to_path_buf() };
        // A scene is no mesh: it could name itself.
        let format = mesh::format_of(&plain).ok().filter(|_| mesh::is_mesh(&plain));
        let format = format.ok_or_else(|| at(place, format!("{named} is no mesh that is read")))?;
        let (bytes, file) = self.bytes_of(named, place)?;
        let input = Input { bytes: &bytes, path: &file, files: self.input.files };
        MeshFile::read(&input, format).map_err(|fault| mesh::error_in(&file, fault))
    }

    /// Makes a texture that is looked up by the file's coordinates one that is by those of the shape. Where that cannot be said it has its mean colour.
    fn lay_on(&mut self, paint: &mut Paint, shape: &Shape, file_uv_from_uv: &DAffine2, place: &Place) {
        let mean = paint.mean();
        let Paint::Texture { uv, .. } = paint else { return };
        if matches!(shape, Shape::Mesh { mesh, .. } if !mesh.has_uvs()) {
            let message = "meshes without texture coordinates have the mean colour of their texture";
            self.note("no_texture_coordinates", place, message);
            *paint = Paint::Color(mean);
        } else if let Some(composed) = UvTransform::of_matrix(&(uv.matrix() * *file_uv_from_uv)) {
            *uv = composed;
        } else {
            self.note("texture_transform", place, "textures that are flattened have their mean colour");
            *paint = Paint::Color(mean);
        }
    }

    /// A texture, read once; `None` where it cannot be read, which is said. `uv` makes coordinates in the image, v upwards, of those of the file.
    pub fn texture(&mut self, named: &str, uv: &DAffine2, place: &Place) -> Option<Paint> {
        let path = self.found(named);
        let image = match self.textures.get(&path) {
            Some(known) => Arc::clone(known),
            None => {
                let read = self.bytes_of(named, place).and_then(|(bytes, file)| {
                    texture::decode(&bytes).map_err(|why| at(place, format!("{} {why}", file.display())))
                });
                match read {
                    Ok(image) => Arc::clone(self.textures.entry(path.clone()).or_insert(Arc::new(image))),
                    Err(error) => {
                        let message = format!("a texture cannot be read and is taken for grey: {}", error.message);
                        self.note("texture_unread", place, message);
                        return None;
                    }
                }
            }
        };
        let paint = Paint::texture(path, image);
        match (UvTransform::of_matrix(uv), paint) {
            (Some(uv), Paint::Texture { path, image, tint, .. }) => Some(Paint::Texture { path, image, tint, uv }),
            (_, paint) => {
                self.note("texture_transform", place, "textures that are sheared or flattened have their mean colour");
                Some(Paint::Color(paint.mean()))
            }
        }
    }

    /// The mean of an image, linear; `None` where it cannot be read, which is said.
    pub fn mean_color(&mut self, named: &str, place: &Place) -> Option<[f64; 3]> {
        let read = self.image(named, place);
        match read {
            Ok(image) => {
                let count = image.pixels.len().max(1) as f64;
                let sum = image
                    .pixels
                    .iter()
                    .fold([0.0; 3], |sum: [f64; 3], pixel| [0, 1, 2].map(|k| sum[k] + f64::from(pixel[k])));
                Some(sum.map(|x| x / count))
            }
            Err(error) => {
                self.note(
                    "texture_unread",
                    place,
                    format!("a texture cannot be read and is taken for grey: {}", error.message),
                );
                None
            }
        }
    }

    pub fn image(&mut self, named: &str, place: &Place) -> Result<EnvironmentImage, SceneError> {
        let format = image::format_of(Path::new(named)).map_err(|message| at(place, message))?;
        let (bytes, file) = self.bytes_of(named, place)?;
        let image = image::read(&bytes, format).map_err(|message| SceneError::in_file(&file, message))?;
        if !self.files.contains(&file) {
            self.files.push(file);
        }
        Ok(image)
    }

    /// GGX's α as a scene may have it.
    pub fn roughness(&mut self, alpha: [f64; 2], place: &Place) -> [f64; 2] {
        if alpha.iter().any(|alpha| *alpha > 1.0) {
            self.note("roughness", place, "surfaces rougher than an α of 1 have one of 1");
        }
        alpha.map(|alpha| if alpha.is_finite() { alpha.clamp(0.0, 1.0) } else { 0.0 })
    }

    /// Adds an object. `facing` says whether the file's normals point to the object's outside; where they point inward, what it declares on their
    /// side is inside.
    pub fn add(&mut self, name: &str, placed: Placed, matter: Matter, place: &Place) -> Result<(), SceneError> {
        if self.objects.len() >= MOST_OBJECTS {
            return Err(at(place, format!("the scene has more than {MOST_OBJECTS} objects")));
        }
        let name = self.names.give(name, "object");
        let Placed { mut shape, mut transform, is_inward, is_smooth, with_uvs, file_uv_from_uv } = placed;
        let mut matter = matter;
        if let Matter::Solid(solid) = &mut matter
            && matches!(solid.paint, Paint::Texture { .. })
        {
            if let Some(with_uvs) = with_uvs {
                (shape, transform) = *with_uvs;
            }
            self.lay_on(&mut solid.paint, &shape, &file_uv_from_uv, place);
        }
        validate(&shape).and_then(|()| transform.validate(&shape)).map_err(|fault| at(place, fault.message))?;
        if let Shape::Mesh { path, part, .. } = &mut shape
            && path.as_os_str().is_empty()
        {
            // A mesh that is in no file of its own is one of the scene's: it gets a file when the scene is saved.
            *path = self.input.path.file_name().unwrap_or_default().into();
            *part = MeshPart::of_group(&name);
        }
        let (role, matter): (Role, Matter) = match matter {
            Matter::Refractor { refractor, inside, outside } => {
                // A thin wall is the same from both sides.
                let is_turned = is_inward && !refractor.thin;
                let (inside, outside) = if is_turned { (outside, inside) } else { (inside, outside) };
                let role = Refractor { smooth: is_smooth, ..refractor.clone() };
                (role.into(), Matter::Refractor { refractor, inside, outside })
            }
            Matter::Solid(solid) => (Solid { smooth: is_smooth, ..solid.clone() }.into(), Matter::Solid(solid)),
            Matter::Light { light, around } => (light.clone().into(), Matter::Light { light, around }),
        };
        // Light goes straight through thin walls. They are kept for other renderers, and hidden.
        let visible = !matches!(&role, Role::Refractor(refractor) if refractor.thin);
        let object = Object { name, shape, transform, visible, role };
        self.objects.push((object, matter));
        Ok(())
    }

    /// The scene.
    pub fn finish(mut self) -> Result<Description, SceneError> {
        let path = self.input.path;
        let stem = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        let camera = match self.camera {
            Some(camera) => camera,
            None => {
                let place = Place { file: path.to_owned(), line_column: None };
                self.note(
                    "no_camera",
                    &place,
                    "the scene has no camera that is read: one that sees all of it is put in",
                );
                framing(self.objects.iter().map(|(object, _)| object))
            }
        };
        let (world, media, camera_medium) = resolve(&mut self.objects, self.camera_medium.as_ref());
        let objects: Objects = self.objects.into_iter().map(|(object, _)| object).collect();
        let import = Import { format: self.format, notes: self.notes, files: self.files };
        let description = Description {
            name: stem,
            camera,
            camera_medium,
            world,
            environment: self.environment,
            media,
            objects,
            source: Some(Arc::new(Source::imported(path.to_owned(), import))),
        };
        Camera::new(&description.camera).map_err(|error| SceneError::in_file(path, error.message))?;
        Ok(description)
    }
}

/// A diffuse solid; shares beyond 0 and 1 are clamped.
pub(super) fn diffuse(paint: Paint) -> Solid {
    Solid::of(paint.tinted([1.0; 3]))
}

/// A mirror with GGX's α along u and v.
pub(super) fn mirror(paint: Paint, roughness: [f64; 2]) -> Solid {
    Solid { mirror: true, roughness, ..diffuse(paint) }
}

/// An error at a place.
pub(super) fn at(place: &Place, message: impl Into<String>) -> SceneError {
    match place.line_column {
        Some((line, column)) => SceneError::at(&place.file, line, column, message),
        None => SceneError::in_file(&place.file, message),
    }
}

/// A camera that sees all of the objects.
fn framing<'o>(objects: impl Iterator<Item = &'o Object>) -> CameraDescription {
    let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for object in objects.filter(|object| object.shape.has_surface()) {
        let matrix: DAffine3 = object.transform.matrix();
        let (min, max) = object.shape.bounds();
        for corner in 0..8 {
            let pick = |bit: usize| if corner >> bit & 1 == 1 { max[bit] } else { min[bit] };
            let point = matrix.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
            bounds = (bounds.0.min(point), bounds.1.max(point));
        }
    }
    let blank = CameraDescription::blank();
    let (center, radius) = (bounds.0.midpoint(bounds.1), (bounds.1 - bounds.0).length() / 2.0);
    if !(radius > 0.0 && radius.is_finite() && center.is_finite()) {
        return blank;
    }
    let distance = 1.1 * radius / (blank.vertical_fov.to_radians() / 2.0).sin();
    CameraDescription { position: center + DVec3::new(0.55, 0.5, 1.0).normalize() * distance, target: center, ..blank }
}

/// Calls `read` with a file in which bytes are changed, left out and doubled: a few thousand times, or as often as `IORECT_TEST_MUTATIONS` says.
#[cfg(test)]
pub(super) fn mutations(whole: &[u8], mut read: impl FnMut(&[u8])) {
    let rounds = std::env::var("IORECT_TEST_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(2000_u32);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move |below: usize| {
        // Marsaglia's xorshift.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    const BYTES: &[u8] = b"\"<>[]/$#-.0189eEnNa \n\xff";
    for _ in 0..rounds {
        let mut bytes = whole.to_vec();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            let length = random(24).min(bytes.len() - at);
            match random(5) {
                0 => bytes[at] = BYTES[random(BYTES.len())],
                1 => _ = bytes.drain(at..at + length),
                2 => {
                    let part = bytes[at..at + length].to_vec();
                    let to = random(bytes.len());
                    bytes.splice(to..to, part);
                }
                3 => bytes.truncate(at.max(1)),
                _ => bytes.insert(at, BYTES[random(BYTES.len())]),
            }
            if bytes.is_empty() {
                break;
            }
        }
        read(&bytes);
    }
}
