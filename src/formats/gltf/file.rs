//! A glTF file as a source of meshes for scenes of other formats.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::container::Container;
use super::materials;
use super::nodes::placed;
use super::surface::{Budget, OBJECT, Wanted, moved};
use crate::formats::files::Input;
use crate::formats::mesh::PartFault;
use crate::formats::parts::NoSuchPart;
use crate::formats::polygons::{Fault, Polygons};
use crate::formats::tally::Tally;
use crate::geometry::Mesh;
use crate::scene::LoadNote;
use crate::scene::description::MeshPart;

/// How exact names of materials begin, by their places in the JSON.
pub const MATERIALS: &str = "/materials/";
/// Most nodes one above the other by whose names a mesh is found.
const MOST_ABOVE: usize = 100;
/// What has no material.
pub const NO_MATERIAL: &str = "default";

/// A glTF file as a source of meshes.
#[derive(Debug)]
pub struct File(Container);

impl File {
    pub fn read(input: &Input<'_>) -> Result<Self, Fault> {
        Container::read(input).map(Self)
    }

    /// All triangles of the scene, where they stand in it.
    pub fn whole(&self) -> Result<(Mesh, Vec<LoadNote>), Fault> {
        self.in_world()?.finish()
    }

    /// A part of the mesh: by the name of a node, with all below it, or of a mesh, and by the name of a material. The exact names that
    /// objects of a scene have are understood too.
    pub fn part(&self, part: &MeshPart) -> Result<(Mesh, Vec<LoadNote>), PartFault> {
        let surface = match part.group.as_deref().and_then(Pointer::of) {
            Some(pointer) => {
                let named = part.material.as_deref();
                let wanted = wanted(named).ok_or_else(|| {
                    let message = format!(
                        "has no material `{}`: beside a group by its place, give the material by its own",
                        named.unwrap_or_default()
                    );
                    PartFault::NoSuchPart(NoSuchPart { key: "material", message })
                })?;
                self.at(pointer, wanted).map_err(PartFault::Fault)?
            }
            None => {
                let whole = self.in_world().map_err(PartFault::Fault)?;
                whole.part(part).map_err(PartFault::NoSuchPart)?
            }
        };
        surface.finish().map_err(PartFault::Fault)
    }

    /// What a pointer names.
    fn at(&self, pointer: Pointer, wanted: Wanted) -> Result<Polygons, Fault> {
        let (mut budget, mut tally) = (Budget::default(), Tally::default());
        match pointer {
            Pointer::Mesh(mesh) => self.0.surface(mesh, wanted, &mut budget, &mut tally),
            Pointer::NodeMesh(node) => {
                let placed = placed(&self.0.root)?;
                let missing = || Fault::new(format!("the scene has no node {node} with a mesh"));
                let found = placed.iter().find(|placed| placed.node == node).ok_or_else(missing)?;
                let mesh = self.0.root.nodes[node].mesh.ok_or_else(missing)?;
                let mut surface = self.0.surface(mesh, wanted, &mut budget, &mut tally)?;
                moved(&mut surface, &found.world);
                Ok(surface)
            }
        }
    }

    /// All triangles where they stand. They belong to their nodes, those above them, and their meshes and materials by name.
    fn in_world(&self) -> Result<Polygons, Fault> {
        let (mut budget, mut tally) = (Budget::default(), Tally::default());
        let root = &self.0.root;
        let placed = placed(root)?;
        let mut all = Polygons::default();
        let mut known: HashMap<(usize, Option<usize>), Polygons> = HashMap::new();
        for place in &placed {
            let Some(mesh) = root.nodes[place.node].mesh else { continue };
            let mut names: Vec<&str> = Vec::new();
            let mut above = Some(place);
            while let Some(node) = above.filter(|_| names.len() < MOST_ABOVE) {
                names.push(root.nodes[node.node].name.trim());
                above = node.parent.map(|parent| &placed[parent]);
            }
            names.push(self.0.mesh(mesh)?.name.trim());
            for &material in self.0.materials_of(mesh) {
                let surface = match known.entry((mesh, material)) {
                    Entry::Occupied(found) => found.into_mut(),
                    Entry::Vacant(free) => {
                        free.insert(self.0.surface(mesh, Wanted::Material(material), &mut budget, &mut tally)?)
                    }
                };
                budget.take((surface.positions.len() + surface.faces.len() + OBJECT) as u64).map_err(Fault::new)?;
                let material = material.map(|index| materials::name(&self.0, index));
                let names = names.iter().copied().filter(|name| !name.is_empty());
                all.parts.begin(all.faces.len(), names, material.as_deref());
                all.append(surface, |surface| moved(surface, &place.world))?;
            }
        }
        Ok(all)
    }
}

/// Which primitives the exact name of a material means.
fn wanted(material: Option<&str>) -> Option<Wanted> {
    Some(match material {
        None => Wanted::All,
        Some(NO_MATERIAL) => Wanted::Material(None),
        Some(name) => Wanted::Material(Some(name.strip_prefix(MATERIALS)?.parse().ok()?)),
    })
}

/// An exact name of a mesh in a file, whatever things are called there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pointer {
    /// As it stands in the file, without a node's transform.
    Mesh(usize),
    /// The mesh of a node, where it stands in the scene.
    NodeMesh(usize),
}

impl Pointer {
    fn of(name: &str) -> Option<Self> {
        if let Some(node) = name.strip_prefix("/nodes/") {
            return node.strip_suffix("/mesh")?.parse().ok().map(Self::NodeMesh);
        }
        name.strip_prefix("/meshes/")?.parse().ok().map(Self::Mesh)
    }

    pub fn name(self) -> String {
        match self {
            Self::Mesh(mesh) => format!("/meshes/{mesh}"),
            Self::NodeMesh(node) => format!("/nodes/{node}/mesh"),
        }
    }
}
