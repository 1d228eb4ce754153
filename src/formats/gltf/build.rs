//! Makes the objects of a glTF file's scene, with their media.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DAffine3;

use super::container::Container;
use super::file::{MATERIALS, NO_MATERIAL, Pointer};
use super::materials::{self, Look};
use super::nodes::{Placed, transform};
use super::surface::{Budget, OBJECT, Wanted, called, moved};
use super::textures::{BaseColor, Images};
use crate::formats::files::Input;
use crate::formats::names::Names;
use crate::formats::polygons::{Fault, Polygons};
use crate::formats::tally::Tally;
use crate::geometry::Mesh;
use crate::optics::Medium;
use crate::scene::LoadNote;
use crate::scene::description::{
    Light, MeshPart, Object, Objects, Paint, Refractor, Role, Shape, Solid, Transform, UvTransform,
};

/// A mesh with what was passed over in it; `None` where it has no faces.
type Piece = Option<(Arc<Mesh>, Vec<LoadNote>)>;

/// Meshes of a file by their places in it and by material.
type Pieces = HashMap<(usize, Option<usize>), Piece>;

/// Makes the objects.
pub struct Builder<'a> {
    container: &'a Container,
    /// As scenes in the file's folder name it.
    path: PathBuf,
    pieces: Pieces,
    looks: HashMap<Option<usize>, Look>,
    /// The mean colours of vertices.
    vertex_colors: HashMap<(usize, Option<usize>), [f64; 3]>,
    /// The names of the media of materials.
    media_of: HashMap<Option<usize>, String>,
    images: Images,
    budget: Budget,
    pub names: Names,
    media_names: Names,
    pub media: Vec<Medium>,
    pub objects: Objects,
    pub tally: Tally,
}

impl<'a> Builder<'a> {
    pub fn new(container: &'a Container, input: &Input<'_>) -> Self {
        Self {
            container,
            path: input.path.file_name().map(PathBuf::from).unwrap_or_default(),
            pieces: HashMap::new(),
            looks: HashMap::new(),
            vertex_colors: HashMap::new(),
            media_of: HashMap::new(),
            images: Images::default(),
            budget: Budget::default(),
            names: Names::default(),
            media_names: Names::default(),
            media: Vec::new(),
            objects: Objects::default(),
            tally: Tally::default(),
        }
    }

    /// The objects of a node: one for each material of its mesh.
    pub fn add(&mut self, place: &Placed) -> Result<(), Fault> {
        let node = &self.container.root.nodes[place.node];
        let Some(mesh) = node.mesh else { return Ok(()) };
        let name = called("node", place.node, &node.name);
        let of_node = |message: String| Fault::new(format!("{name}: {message}"));
        self.container.mesh(mesh).map_err(|fault| of_node(fault.message))?;
        let materials = self.container.materials_of(mesh);
        let transform = transform(&place.world);
        if transform.is_none() {
            let what = "what is sheared or flattened by its nodes has its mesh in the scene's coordinates";
            self.tally.add("sheared", what, &node.name);
        }
        for &material in materials {
            self.budget.take(OBJECT as u64).map_err(of_node)?;
            let Some((mesh_data, notes)) = self.piece(mesh, material)? else { continue };
            let (pointer, mesh_data, transform) = match transform {
                Some(transform) => (Pointer::Mesh(mesh), mesh_data, transform),
                None => {
                    let Some(moved) = self.baked(mesh, material, &place.world)? else { continue };
                    (Pointer::NodeMesh(place.node), moved, Transform::IDENTITY)
                }
            };
            let own_name = match node.name.trim() {
                "" => self.container.mesh(mesh)?.name.trim(),
                name => name,
            };
            let own_name = match (own_name, material) {
                ("", _) => format!("node {}", place.node),
                (name, Some(material)) if materials.len() > 1 => {
                    format!("{name} {}", materials::name(self.container, material))
                }
                (name, _) => name.to_owned(),
            };
            let role = self.role(mesh, material, &mesh_data).map_err(of_node)?;
            let material = match material {
                Some(index) => Some(format!("{MATERIALS}{index}")),
                None if materials.len() > 1 => Some(NO_MATERIAL.to_owned()),
                None => None,
            };
            let part = MeshPart { group: Some(pointer.name()), material };
            let shape = Shape::Mesh { path: self.path.clone(), part, mesh: mesh_data, notes };
            let object = Object { transform, ..Object::new(self.names.give(&own_name, "object"), shape, role) };
            self.objects.push(object);
        }
        Ok(())
    }

    /// A mesh that several nodes may use.
    fn piece(&mut self, mesh: usize, material: Option<usize>) -> Result<Piece, Fault> {
        if let Some(known) = self.pieces.get(&(mesh, material)) {
            return Ok(known.clone());
        }
        let surface = self.container.surface(mesh, Wanted::Material(material), &mut self.budget, &mut self.tally)?;
        let piece = self.finished(surface, mesh)?.map(|(mesh, notes)| (Arc::new(mesh), notes));
        self.pieces.insert((mesh, material), piece.clone());
        Ok(piece)
    }

    /// The same in the scene's coordinates.
    fn baked(&mut self, mesh: usize, material: Option<usize>, world: &DAffine3) -> Result<Option<Arc<Mesh>>, Fault> {
        let mut surface =
            self.container.surface(mesh, Wanted::Material(material), &mut self.budget, &mut self.tally)?;
        moved(&mut surface, world);
        Ok(self.finished(surface, mesh)?.map(|(mesh, _)| Arc::new(mesh)))
    }

    fn finished(&mut self, mut surface: Polygons, mesh: usize) -> Result<Option<(Mesh, Vec<LoadNote>)>, Fault> {
        let name = &self.container.mesh(mesh)?.name;
        surface.drop_unusable().map_err(|f| Fault::new(format!("{}: {}", called("mesh", mesh, name), f.message)))?;
        // Without unusable vertices, faces without area are all that can be wrong.
        match surface.finish() {
            Ok(finished) => Ok(Some(finished)),
            Err(_) => {
                self.tally.add("no_area", "meshes without any area are left out", name);
                Ok(None)
            }
        }
    }

    /// What vertices of a mesh multiply the colour of a material by.
    fn vertex_color(&mut self, mesh: usize, material: Option<usize>) -> Result<[f64; 3], String> {
        if let Some(known) = self.vertex_colors.get(&(mesh, material)) {
            return Ok(*known);
        }
        let mean = self.container.mean_vertex_color(mesh, material, &mut self.budget, &mut self.tally)?;
        self.vertex_colors.insert((mesh, material), mean);
        Ok(mean)
    }

    fn role(&mut self, index: usize, material: Option<usize>, mesh: &Mesh) -> Result<Role, String> {
        let look = match self.looks.entry(material) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(free) => {
                free.insert(materials::look(self.container, material, &self.path, &mut self.images, &mut self.tally)?)
            }
        };
        let smooth = !mesh.normals.is_empty();
        Ok(match look.clone() {
            Look::Opaque { color, image, is_mirror, roughness } => {
                let of_vertices = self.vertex_color(index, material)?;
                let color = std::array::from_fn(|channel| color[channel] * of_vertices[channel]);
                let name = || material.map(|index| materials::name(self.container, index)).unwrap_or_default();
                let paint = match image {
                    Some(image) => painted(image, color, mesh, &name(), &mut self.tally),
                    None => Paint::Color(color),
                };
                let roughness = [if is_mirror { roughness } else { 0.0 }; 2];
                Solid { mirror: is_mirror, roughness, smooth, ..Solid::of(paint) }.into()
            }
            Look::Light { radiance, is_double_sided } => {
                // The inward side of what is closed is seen by nobody.
                let two_sided = is_double_sided && !is_closed(mesh);
                Light { two_sided, ..Light::of_radiance(radiance) }.into()
            }
            Look::Glass { ior, absorption, roughness, thin } => {
                let medium = self.media_of.entry(material).or_insert_with(|| {
                    let name = material.map(|index| materials::name(self.container, index)).unwrap_or_default();
                    let name = self.media_names.give(&name, "glass");
                    self.media.push(Medium { name: name.clone(), ior, absorption });
                    name
                });
                Refractor { smooth, roughness: [roughness; 2], thin, ..Refractor::of(medium.clone()) }.into()
            }
        })
    }
}

/// An image on a mesh, as far as it can be laid on it.
fn painted(image: BaseColor, tint: [f64; 3], mesh: &Mesh, name: &str, tally: &mut Tally) -> Paint {
    let BaseColor { path, image, is_repeated } = image;
    let paint = Paint::Texture { path, image, tint, uv: UvTransform::IDENTITY };
    if !mesh.has_uvs() {
        let what = "meshes without texture coordinates have the average colour of their image";
        tally.add("no_texture_coordinates", what, name);
        return Paint::Color(paint.mean());
    }
    const BEYOND: std::ops::RangeInclusive<f32> = -1e-3..=1.001;
    if !is_repeated && mesh.uvs.as_flattened().as_flattened().iter().any(|x| !BEYOND.contains(x)) {
        tally.add("wrap", "images that are mirrored or clamped beyond their edges are repeated", name);
    }
    paint
}

/// Whether every edge of a face is one of another face, the other way about. Vertices at one place are one.
fn is_closed(mesh: &Mesh) -> bool {
    // −0 and 0 are one place.
    let place = |corner: u32| (mesh.positions[corner as usize] + 0.0).to_array().map(f64::to_bits);
    let mut open: HashMap<_, i64> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(place);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (edge, way) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *open.entry(edge).or_default() += way;
        }
    }
    open.values().all(|balance| *balance == 0)
}
