//! The pieces of a mesh file as objects: what each is made of, by the file's material library where there is one. What has an image for its colour
//! is opaque unless it is said that light goes through.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::files::Input;
use super::mesh::{MeshFile, PartFault, error_in};
use super::names::Names;
use super::obj::mtl::{self, Material};
use super::texture;
use crate::geometry::Mesh;
use crate::optics::{Ior, Medium, catalog};
use crate::scene::description::{Light, MAX_RADIANCE, MeshPart, Paint, Refractor, Role, Solid, UvTransform};
use crate::scene::fields::IOR;
use crate::scene::texture::TextureImage;
use crate::scene::{LoadNote, SceneError};

/// Least share of light that a filter lets through, as far as it is taken for a filter.
const LEAST_FILTER: f64 = 1e-3;

/// One object of a mesh file.
#[derive(Debug)]
pub(super) struct Piece {
    pub name: String,
    pub part: MeshPart,
    pub mesh: Mesh,
    pub notes: Vec<LoadNote>,
    pub role: Role,
    /// What a refractor is made of, which has its medium's name.
    pub medium: Option<Medium>,
}

/// What the libraries of a file say.
#[derive(Debug, Default)]
struct Library {
    materials: HashMap<String, Material>,
    /// The images of materials, by what they call them; `None`: one that cannot be read.
    images: HashMap<String, Option<(PathBuf, Arc<TextureImage>)>>,
    notes: Vec<LoadNote>,
}

/// The pieces of the mesh file: by its materials, or else by its groups, or all in one. `stem` names what has no name.
pub(super) fn pieces(file: MeshFile, stem: &str, input: &Input<'_>) -> Result<Vec<Piece>, SceneError> {
    let parts = file.pieces();
    let mut library = Library::read(file.libraries(), input);
    library.read_images(input);
    let fault = |fault| match fault {
        PartFault::Fault(fault) => error_in(input.path, fault),
        PartFault::NoSuchPart(missing) => SceneError::in_file(input.path, missing.message),
    };
    let (mut taken, mut left_out) = (Vec::new(), Vec::new());
    if parts.len() > 1 {
        for part in parts {
            let name = part.material.clone().or_else(|| part.group.clone()).unwrap_or_default();
            match file.part(&part) {
                Ok((mesh, notes)) => taken.push((name, part, mesh, notes)),
                // Such as one whose faces are all flat.
                Err(PartFault::Fault(fault)) => {
                    left_out.push(LoadNote::new("part", 1, format!("the part {name} is left out: {}", fault.message)));
                }
                Err(other) => return Err(fault(other)),
            }
        }
    }
    let only_material = file.only_material();
    if taken.len() < 2 {
        let (mesh, notes) = file.whole().map_err(|f| fault(PartFault::Fault(f)))?;
        taken = vec![(stem.to_owned(), MeshPart::default(), mesh, notes)];
    }
    let is_single = taken.len() == 1;
    let material_of = |part: &MeshPart| {
        let name = if is_single { only_material.as_ref() } else { part.material.as_ref() };
        name.and_then(|name| library.materials.get(name))
    };
    let is_textured = |material: &Material| !material.is_glass() && material.image.is_some();
    let any_glass = taken.iter().any(|(_, part, ..)| material_of(part).is_some_and(Material::is_glass));
    let (mut names, mut notes) = (Names::default(), library.notes.clone());
    notes.append(&mut left_out);
    let is_taken_for_glass = |part: &MeshPart| {
        material_of(part).is_some_and(|material| material.light().is_none() && !is_textured(material))
    };
    if !any_glass && !is_single && taken.iter().any(|(_, part, ..)| is_taken_for_glass(part)) {
        let message = "the materials say of no part that it lets light through, so all that emit none and have no image are shown as glass";
        notes.push(LoadNote::new("no_glass", 1, message.to_owned()));
    }
    let piece = |(name, part, mesh, own_notes): (String, MeshPart, Mesh, Vec<LoadNote>)| {
        let material = material_of(&part);
        let name = names.give(&name, stem);
        let is_smooth = !mesh.normals.is_empty();
        let mut notes: Vec<LoadNote> = own_notes.into_iter().chain(notes.iter().cloned()).collect();
        let (role, medium) = match material {
            Some(material) if !is_single && material.light().is_some() => {
                let radiance = material.light().unwrap_or_default();
                (Light::of_radiance(radiance.map(|component| component.clamp(0.0, MAX_RADIANCE))).into(), None)
            }
            Some(material) if is_textured(material) || (any_glass && !material.is_glass()) => {
                let mirror = material.metallic.is_some_and(|metallic| metallic > 0.5);
                let paint = library.paint(material, &mesh, &mut notes);
                (Role::from(Solid { mirror, smooth: is_smooth, ..Solid::of(paint) }), None)
            }
            _ => {
                let medium = medium(&name, material, &mesh, &mut notes);
                (Refractor { smooth: is_smooth, ..Refractor::of(&medium.name) }.into(), Some(medium))
            }
        };
        Piece { name, part, mesh, notes, role, medium }
    };
    Ok(taken.into_iter().map(piece).collect())
}

/// What a piece of glass is made of: catalogue glass where the material does not say.
fn medium(name: &str, material: Option<&Material>, mesh: &Mesh, notes: &mut Vec<LoadNote>) -> Medium {
    let glass = catalog::find("glass").map_or(Ior::Constant(1.5), Ior::Catalog);
    let Some(material) = material else { return Medium { name: name.to_owned(), ior: glass, absorption: [0.0; 3] } };
    // Programs write 1 where nobody has said anything.
    let ior = material.ior.filter(|ior| *ior != 1.0 && (IOR.is_fine)(*ior)).map_or(glass, Ior::Constant);
    let mut absorption = [0.0; 3];
    let used = || mesh.triangles.iter().flatten().map(|&corner| mesh.positions[corner as usize]);
    let (min, max) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let extent = (max - min).min_element();
    if let Some(tint) = material.tint().filter(|_| extent > 0.0 && extent.is_finite()) {
        absorption = tint.map(|share| -share.clamp(LEAST_FILTER, 1.0).ln().min(0.0) / extent);
        let message = "`Tf` is taken for what passes through a part where it is thinnest as a whole: set the absorption of its medium";
        notes.push(LoadNote::new("filter", 1, message.to_owned()));
    }
    if absorption.iter().any(|sigma| !sigma.is_finite()) {
        absorption = [0.0; 3];
    }
    Medium { name: name.to_owned(), ior, absorption }
}

impl Library {
    /// Of the libraries that a mesh file names, in its folder. One that is not there is noted.
    fn read(named: &[String], input: &Input<'_>) -> Self {
        let mut library = Self::default();
        let folder = input.path.parent().unwrap_or(Path::new(""));
        let bytes_of = |name: &str| {
            let file = input.files.locate(&folder.join(name.replace('\\', "/")));
            input.files.read(&file).map_err(|why| (file, why))
        };
        for statement in named {
            // Several files, or one whose name has spaces.
            let words: Vec<&str> = statement.split_ascii_whitespace().collect();
            let names = if words.len() > 1 && bytes_of(statement).is_err() { words } else { vec![statement.as_str()] };
            for name in names {
                match bytes_of(name) {
                    Ok(bytes) => library.add(&bytes, name),
                    Err((file, why)) => library.miss(file, &why),
                }
            }
        }
        library
    }

    fn add(&mut self, bytes: &[u8], name: &str) {
        let (materials, unread) = mtl::read(&super::encoding::without_mark(bytes));
        if unread > 0 {
            let message = format!("{unread} values of {name} could not be read and were passed over");
            self.notes.push(LoadNote::new("material_values", unread, message));
        }
        for material in materials {
            self.materials.entry(material.name.clone()).or_insert(material);
        }
    }

    /// Reads the images of materials, from the folder of the mesh file.
    fn read_images(&mut self, input: &Input<'_>) {
        let folder = input.path.parent().unwrap_or(Path::new(""));
        let names: Vec<String> =
            self.materials.values().filter_map(|material| Some(material.image.as_ref()?.file.clone())).collect();
        for name in names {
            if self.images.contains_key(&name) {
                continue;
            }
            let path = PathBuf::from(name.replace('\\', "/"));
            let image = match texture::read(&path, folder, input.files) {
                // Saved elsewhere, the scene must still find it.
                Ok(image) => {
                    let file = folder.join(&path);
                    Some((std::path::absolute(&file).unwrap_or(file), Arc::new(image)))
                }
                Err(why) => {
                    let message = format!("the image {name} is left out, and `Kd` alone colours what has it: it {why}");
                    self.notes.push(LoadNote::new("texture", 1, message));
                    None
                }
            };
            self.images.insert(name, image);
        }
    }

    /// What a material reflects: its colour, and the image that it is multiplied by.
    fn paint(&self, material: &Material, mesh: &Mesh, notes: &mut Vec<LoadNote>) -> Paint {
        let color = material.color.map(|color| color.map(|share| share.clamp(0.0, 1.0)));
        let image = material.image.as_ref().and_then(|image| Some((image, self.images.get(&image.file)?.clone()?)));
        let Some((about, (path, image))) = image else { return Paint::Color(color.unwrap_or([0.8; 3])) };
        // Programs write black where the image alone is meant.
        let tint = color.filter(|color| *color != [0.0; 3]).unwrap_or([1.0; 3]);
        let uv = UvTransform { scale: about.scale, rotate: 0.0, offset: about.offset };
        let paint = Paint::Texture { path, image, tint, uv };
        if !mesh.has_uvs() {
            let message = "the faces have no texture coordinates, so the mean colour of the image is taken";
            notes.push(LoadNote::new("no_texture_coordinates", 1, message.to_owned()));
            return Paint::Color(paint.mean());
        }
        if about.is_clamped {
            let message = "the image is repeated beyond its edges, where the material says that it ends";
            notes.push(LoadNote::new("texture_wrap", 1, message.to_owned()));
        }
        paint
    }

    fn miss(&mut self, file: PathBuf, why: &str) {
        let message = format!("the materials in {} are not known, so parts are glass: it {why}", file.display());
        self.notes.push(LoadNote::new("material_library", 1, message));
    }
}
