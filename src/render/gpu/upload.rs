//! Scenes in the memory of the graphics processor. What an edit has not changed stays there: an edit of media uploads kilobytes.

use std::sync::{Arc, Weak};

use super::device::GpuDevice;
use super::fault::GpuFault;
use super::pipeline::{SceneLayout, uniform_usage};
use super::tables::{self, AnswerTables, FlatWords, GeometryTables, LightTables};
use crate::geometry::{Geometry, Mesh};
use crate::rectify::InterfaceTable;
use crate::rectify::flat::FlatLayout;
use crate::scene::lights::ImageLight;
use crate::scene::texture::{TextureCoordinates, TextureImage};
use crate::scene::{ObjectId, Scene};
use crate::tracking::{Mode, Prepared};

/// Nodes of the tree that may wait to be visited, at the most: each thread has room for them.
const MOST_TREE_DEPTH: u32 = 256;

/// Why a scene is not there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CannotUpload {
    /// What the adapter does not hold, in words that fit before "cannot be rendered".
    DoesNotFit(String),
    Fault(GpuFault),
}

impl From<GpuFault> for CannotUpload {
    fn from(fault: GpuFault) -> Self {
        Self::Fault(fault)
    }
}

/// Tables with the buffers that hold them, in the order of their bindings.
#[derive(Debug)]
struct Part<T> {
    tables: T,
    buffers: Vec<wgpu::Buffer>,
}

/// A scene on the device, for one mode.
#[derive(Debug)]
pub struct SceneOnGpu {
    geometry: Arc<Part<GeometryTables>>,
    flat: Arc<Part<FlatWords>>,
    lights: Arc<Part<LightTables>>,
    answers: Arc<Part<AnswerTables>>,
    pub scene: wgpu::Buffer,
    of: Sources,
}

/// An object with the image on it, and the mesh whose texture coordinates it has.
type KnownTexture = (ObjectId, Weak<TextureImage>, Option<Weak<Mesh>>);

/// What it was made from. Weak, so that nothing is kept alive; an address is not used again while somebody remembers it.
#[derive(Debug, Clone)]
struct Sources {
    geometry: Weak<Geometry>,
    flat: Weak<FlatLayout>,
    image: Option<Weak<ImageLight>>,
    emitters: Vec<ObjectId>,
    /// Images with what they are laid on, by object.
    textures: Vec<KnownTexture>,
    scene: Weak<Scene>,
    table: Weak<InterfaceTable>,
    /// What lies outside of objects is as this mode has it; `None`: it does not ask.
    outsides_of: Option<Mode>,
}

impl Sources {
    fn of(prepared: &Prepared, mode: Mode) -> Self {
        let scene = &*prepared.scene;
        Self {
            geometry: Arc::downgrade(&scene.geometry),
            flat: Arc::downgrade(&prepared.table.flat().layout),
            image: scene.environment.image().map(Arc::downgrade),
            emitters: scene.emitters.iter().filter_map(|(light, _)| light.object()).collect(),
            textures: textures_of(scene),
            scene: Arc::downgrade(&prepared.scene),
            table: Arc::downgrade(&prepared.table),
            outsides_of: Some(mode).filter(|mode| matches!(mode, Mode::Declared | Mode::RectifiedObject)),
        }
    }

    fn has_geometry_of(&self, other: &Self) -> bool {
        self.geometry.ptr_eq(&other.geometry)
    }

    fn has_flat_of(&self, other: &Self) -> bool {
        self.has_geometry_of(other) && self.flat.ptr_eq(&other.flat)
    }

    fn has_lights_of(&self, other: &Self) -> bool {
        let is_same_image = match (&self.image, &other.image) {
            (Some(a), Some(b)) => a.ptr_eq(b),
            (None, None) => true,
            _ => false,
        };
        self.has_geometry_of(other)
            && is_same_image
            && self.emitters == other.emitters
            && self.textures.len() == other.textures.len()
            && self.textures.iter().zip(&other.textures).all(is_same_texture)
    }

    fn has_answers_of(&self, other: &Self) -> bool {
        let is_same_scene = self.scene.ptr_eq(&other.scene) && self.table.ptr_eq(&other.table);
        is_same_scene && self.outsides_of == other.outsides_of
    }
}

/// The images of solids.
fn textures_of(scene: &Scene) -> Vec<KnownTexture> {
    (0..scene.objects.len() as u32)
        .filter_map(|index| {
            let texture = scene.albedo(ObjectId(index))?.texture()?;
            let mesh = match &texture.coordinates {
                TextureCoordinates::Triangles { mesh, .. } => Some(Arc::downgrade(mesh)),
                TextureCoordinates::Spherical { .. } => None,
            };
            Some((ObjectId(index), Arc::downgrade(&texture.image), mesh))
        })
        .collect()
}

fn is_same_texture((a, b): (&KnownTexture, &KnownTexture)) -> bool {
    let is_same_mesh = match (&a.2, &b.2) {
        (Some(a), Some(b)) => a.ptr_eq(b),
        (None, None) => true,
        _ => false,
    };
    a.0 == b.0 && a.1.ptr_eq(&b.1) && is_same_mesh
}

impl SceneOnGpu {
    /// Whether it is this one.
    pub fn is_of(&self, prepared: &Prepared, mode: Mode) -> bool {
        let of = Sources::of(prepared, mode);
        self.of.has_flat_of(&of) && self.of.has_lights_of(&of) && self.of.has_answers_of(&of)
    }

    /// Whether anybody still has what it was made from.
    pub fn is_wanted(&self) -> bool {
        self.of.geometry.strong_count() > 0 && self.of.scene.strong_count() > 0 && self.of.table.strong_count() > 0
    }

    /// Nodes that may wait to be visited in its tree.
    pub fn tree_depth(&self) -> u32 {
        self.geometry.tables.depth
    }

    /// Uploads what none of the `others` has.
    ///
    /// # Errors
    /// When it does not fit.
    pub fn new(gpu: &GpuDevice, prepared: &Prepared, mode: Mode, others: &[Arc<Self>]) -> Result<Self, CannotUpload> {
        let of = Sources::of(prepared, mode);
        let scene = &*prepared.scene;
        let scale = tables::scale_of(&scene.geometry);
        let geometry = match others.iter().find(|other| other.of.has_geometry_of(&of)) {
            Some(other) => Arc::clone(&other.geometry),
            None => {
                let has_smooth = scene.needs.smooth_normals;
                let mut tables = GeometryTables::new(&scene.geometry, has_smooth);
                let buffers = vec![
                    buffer(gpu, "the tree", &tables.nodes)?,
                    buffer(gpu, "the triangles", &tables.triangles)?,
                    buffer(gpu, "the faces", &tables.faces)?,
                    buffer(gpu, "the normals", &tables.corner_normals)?,
                    buffer(gpu, "the spheres", &tables.spheres)?,
                ];
                tables.forget_arrays();
                Arc::new(Part { tables, buffers })
            }
        };
        let flat = match others.iter().find(|other| other.of.has_flat_of(&of)) {
            Some(other) => Arc::clone(&other.flat),
            None => {
                let table = &prepared.table;
                let mut tables = FlatWords::new(&table.flat().layout, &table.asked_planes(scene), scale);
                let buffers = vec![buffer(gpu, "the interface table", &tables.words)?];
                tables.words = Vec::new();
                Arc::new(Part { tables, buffers })
            }
        };
        let lights = match others.iter().find(|other| other.of.has_lights_of(&of)) {
            Some(other) => Arc::clone(&other.lights),
            None => {
                let mut tables = LightTables::new(scene, &geometry.tables.slots);
                let buffers = vec![buffer(
                    gpu,
                    if tables.textures.is_empty() { "the environment" } else { "the images" },
                    &tables.words,
                )?];
                tables.words = Vec::new();
                Arc::new(Part { tables, buffers })
            }
        };
        let answers = match others.iter().find(|other| other.of.has_lights_of(&of) && other.of.has_answers_of(&of)) {
            Some(other) => Arc::clone(&other.answers),
            None => {
                let tables = AnswerTables::new(prepared, &lights.tables, of.outsides_of);
                let buffers = vec![
                    buffer(gpu, "the answers of the interface table", &tables.answers)?,
                    buffer(gpu, "the objects", &tables.objects)?,
                    buffer(gpu, "the media", &tables.media)?,
                    buffer(gpu, "the interfaces", &tables.interfaces)?,
                    buffer(gpu, "the lights", &tables.emitters)?,
                ];
                Arc::new(Part { tables, buffers })
            }
        };
        if geometry.tables.depth > MOST_TREE_DEPTH {
            return Err(CannotUpload::DoesNotFit("a scene with so many surfaces in one place".into()));
        }
        let words = tables::scene_of(scene, &geometry.tables, &flat.tables, &lights.tables, &answers.tables);
        if let Some(what) = tables::too_large_for_f32(&geometry.tables, &words, &answers.tables) {
            return Err(CannotUpload::DoesNotFit(what.into()));
        }
        let scene = gpu.attempt(|_| gpu.filled_buffer("scene", uniform_usage(gpu), bytemuck::bytes_of(&words)))?;
        Ok(Self { geometry, flat, lights, answers, scene, of })
    }

    /// The bindings of group 0, the image being in `image`.
    pub fn bind(&self, gpu: &GpuDevice, layout: &SceneLayout, image: &wgpu::Buffer) -> wgpu::BindGroup {
        let buffers = (self.geometry.buffers.iter())
            .chain(&self.flat.buffers)
            .chain(&self.answers.buffers)
            .chain(&self.lights.buffers);
        layout.bind(gpu, [image, &self.scene].into_iter().chain(buffers))
    }
}

/// A buffer that shaders read; of nothing, one that holds a few zeros, because a binding may not be empty.
fn buffer<T: bytemuck::Pod>(gpu: &GpuDevice, what: &str, contents: &[T]) -> Result<wgpu::Buffer, CannotUpload> {
    const NOTHING: [u8; 128] = [0; 128];
    let contents: &[u8] = if contents.is_empty() { &NOTHING } else { bytemuck::cast_slice(contents) };
    let limits = &gpu.limits;
    let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    if contents.len() as u64 > most {
        let megabytes = |bytes: u64| bytes.div_ceil(1 << 20);
        return Err(CannotUpload::DoesNotFit(format!(
            "a scene of this size ({what} needs {} MiB, and {} has {} for one table)",
            megabytes(contents.len() as u64),
            gpu.adapter.name,
            megabytes(most),
        )));
    }
    Ok(gpu.attempt(|_| gpu.filled_buffer(what, wgpu::BufferUsages::STORAGE, contents))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Ior;
    use crate::render::gpu::device::for_test;
    use crate::tracking::prepare;

    /// What an edit has not changed is not uploaded again.
    #[test]
    fn an_edit_of_an_index_uploads_answers_only() {
        let Some(gpu) = for_test() else { return };
        let description = crate::formats::open("half-submerged").unwrap();
        let before = prepare(Arc::new(description.clone()), None).unwrap();
        let first = Arc::new(SceneOnGpu::new(&gpu, &before, Mode::Rectified, &[]).unwrap());
        assert!(first.is_of(&before, Mode::Rectified) && first.is_wanted());
        let others = [Arc::clone(&first)];

        // Another mode has the same tables, but for what lies outside each object.
        let in_stack = SceneOnGpu::new(&gpu, &before, Mode::Stack, &others).unwrap();
        assert!(Arc::ptr_eq(&in_stack.answers, &first.answers));
        let by_object = SceneOnGpu::new(&gpu, &before, Mode::RectifiedObject, &others).unwrap();
        assert!(Arc::ptr_eq(&by_object.geometry, &first.geometry) && !Arc::ptr_eq(&by_object.answers, &first.answers));

        let mut edited = description.clone();
        edited.media[0].ior = Ior::Constant(1.4);
        let after = prepare(Arc::new(edited), Some(&before)).unwrap();
        assert!(!first.is_of(&after, Mode::Rectified));
        let second = SceneOnGpu::new(&gpu, &after, Mode::Rectified, &others).unwrap();
        assert!(Arc::ptr_eq(&first.geometry, &second.geometry));
        assert!(Arc::ptr_eq(&first.flat, &second.flat) && Arc::ptr_eq(&first.lights, &second.lights));
        assert!(!Arc::ptr_eq(&first.answers, &second.answers));
        let bytes: u64 = second.answers.buffers.iter().map(wgpu::Buffer::size).sum();
        assert!(bytes < 256 << 10, "{bytes}");

        let mut moved = description;
        moved.objects.refractors_mut()[0].transform.translate.x += 0.1;
        let after = prepare(Arc::new(moved), Some(&before)).unwrap();
        let third = SceneOnGpu::new(&gpu, &after, Mode::Rectified, &others).unwrap();
        assert!(!Arc::ptr_eq(&first.geometry, &third.geometry) && !Arc::ptr_eq(&first.lights, &third.lights));
        drop(before);
        assert!(!first.is_wanted());
    }
}
