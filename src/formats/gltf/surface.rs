//! The surfaces of a glTF file's meshes: triangles, strips and fans.

use glam::DVec3;

use super::container::Container;
use super::schema::{Mesh, Primitive};
use super::textures;
use crate::formats::polygons::{Fault, Polygons, Uvs};
use crate::formats::tally::Tally;
use crate::scene::description::MeshPart;

/// Most vertices and triangles that one file may amount to, each as often as it is used.
const MAX_ELEMENTS: u64 = 1 << 27;

/// What an object counts for beside its vertices and triangles.
pub const OBJECT: usize = 100;

/// What may still be made of a file: a few bytes can ask for the same numbers many times.
#[derive(Debug)]
pub struct Budget(u64);

impl Default for Budget {
    fn default() -> Self {
        Self(MAX_ELEMENTS)
    }
}

impl Budget {
    pub fn take(&mut self, elements: u64) -> Result<(), String> {
        let left = self.0.checked_sub(elements);
        self.0 = left.ok_or_else(|| format!("the file makes more than {MAX_ELEMENTS} vertices and triangles"))?;
        Ok(())
    }
}

/// Which primitives of a mesh are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    All,
    /// Those of one material, or of none.
    Material(Option<usize>),
}

impl Container {
    pub fn mesh(&self, index: usize) -> Result<&Mesh, Fault> {
        let meshes = &self.root.meshes;
        meshes.get(index).ok_or_else(|| Fault::new(format!("there is no mesh {index}: there are {}", meshes.len())))
    }

    /// The faces of a mesh as it stands in the file, without any node's transform, and none but vertices that they use.
    pub fn surface(
        &self,
        index: usize,
        wanted: Wanted,
        budget: &mut Budget,
        tally: &mut Tally,
    ) -> Result<Polygons, Fault> {
        let mesh = self.mesh(index)?;
        let mut polygons = Polygons::default();
        let numbers = match wanted {
            Wanted::All => &(0..mesh.primitives.len()).collect::<Vec<usize>>(),
            Wanted::Material(material) => self.primitives_of(index, material),
        };
        for &number in numbers {
            let primitive = &mesh.primitives[number];
            self.add(primitive, &mesh.name, &mut polygons, budget, tally).map_err(|why| {
                Fault::new(format!("{}, primitive {number}: {why}", called("mesh", index, &mesh.name)))
            })?;
        }
        let named = called("mesh", index, &mesh.name);
        polygons.drop_unusable().map_err(|fault| Fault::new(format!("{named}: {}", fault.message)))?;
        polygons.part(&MeshPart::default()).map_err(|missing| Fault::new(missing.message))
    }

    /// The mean colour of the vertices of what a mesh has of a material, 1 where they have none.
    pub fn mean_vertex_color(
        &self,
        mesh: usize,
        material: Option<usize>,
        budget: &mut Budget,
        tally: &mut Tally,
    ) -> Result<[f64; 3], String> {
        let (mut sum, mut count, mut has_colors) = ([0.0; 3], 0, false);
        for &number in self.primitives_of(mesh, material) {
            let attributes = &self.root.meshes[mesh].primitives[number].attributes;
            let vertices = attributes.get("POSITION").and_then(|index| self.root.accessors.get(*index));
            let vertices = vertices.map_or(0, |accessor| accessor.count);
            match attributes.get("COLOR_0") {
                // Colours that cannot be read are none: the mesh is what matters.
                Some(&accessor) => {
                    has_colors = true;
                    for color in self.colors(accessor, budget).unwrap_or_default() {
                        count += 1;
                        (0..3).for_each(|channel| sum[channel] += color[channel]);
                    }
                }
                None => {
                    count += vertices;
                    sum = sum.map(|sum| sum + vertices as f64);
                }
            }
        }
        if !has_colors || count == 0 {
            return Ok([1.0; 3]);
        }
        tally.add("vertex_colors", "colours of vertices stand for their average", &self.root.meshes[mesh].name);
        let mean = sum.map(|sum| sum / count as f64);
        Ok(mean.map(|share| if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }))
    }

    fn add(
        &self,
        primitive: &Primitive,
        name: &str,
        polygons: &mut Polygons,
        budget: &mut Budget,
        tally: &mut Tally,
    ) -> Result<(), String> {
        let mode = primitive.mode.unwrap_or(4);
        match mode {
            0..=3 => {
                tally.add("lines_and_points", "lines and points are left out", name);
                return Ok(());
            }
            4..=6 => {}
            _ => return Err(format!("has the mode {mode}, which is none")),
        }
        let Some(&position) = primitive.attributes.get("POSITION") else {
            tally.add("no_positions", "what has no positions is left out", name);
            return Ok(());
        };
        if !primitive.targets.is_empty() {
            tally.add("morph_targets", "morph targets are left out: meshes have their basic form", name);
        }
        let positions = self.vectors(position, budget)?;
        let normals = match primitive.attributes.get("NORMAL") {
            Some(&accessor) => self.vectors(accessor, budget)?,
            None => Vec::new(),
        };
        if !normals.is_empty() && normals.len() != positions.len() {
            return Err(format!("has {} positions but {} normals", positions.len(), normals.len()));
        }
        let count = positions.len();
        let uvs = match textures::coordinates(self, primitive) {
            Some((accessor, change)) => {
                // Those that cannot be read are missed where a texture asks for them.
                let uvs = self.pairs(accessor, budget).unwrap_or_default();
                if uvs.len() == count { uvs.into_iter().map(change).collect() } else { Vec::new() }
            }
            None => Vec::new(),
        };
        let indices = match primitive.indices {
            Some(accessor) => self.indices(accessor, budget)?,
            None => (0..u32::try_from(count).map_err(|_| "has too many vertices")?).collect(),
        };
        if let Some(index) = indices.iter().find(|index| **index as usize >= count) {
            return Err(format!("names vertex {index}, but there are {count} (counted from 0)"));
        }
        let start = polygons.positions.len();
        let offset = u32::try_from(start).ok().filter(|offset| offset.checked_add(count as u32).is_some());
        let offset = offset.ok_or("has too many vertices")?;
        // Normals are of use if all primitives have them.
        let has_normals = !normals.is_empty() && polygons.normals.len() == start;
        if has_normals {
            polygons.normals.extend(normals);
        } else {
            polygons.normals.clear();
        }
        // As of normals.
        if uvs.is_empty() && count > 0 {
            polygons.uvs = Uvs::None;
        }
        for (index, uv) in uvs.into_iter().enumerate() {
            polygons.uvs.push_of_position(Some(uv.map(|x| x as f32)), start + index);
        }
        positions.into_iter().for_each(|position| polygons.push_position(position, None));
        let mut push = |corners: [u32; 3]| {
            polygons.faces.corners.extend(corners.map(|corner| corner + offset));
            polygons.faces.close(None);
        };
        let is_one = |[a, b, c]: [u32; 3]| a != b && b != c && c != a;
        match mode {
            4 => {
                if indices.len() % 3 != 0 {
                    tally.add("incomplete_triangles", "corners after the last whole triangle are left out", name);
                }
                indices.chunks_exact(3).for_each(|corners| push([corners[0], corners[1], corners[2]]));
            }
            // Corners are repeated where strips are sewn together. Every second triangle runs the other way about.
            5 => indices.windows(3).enumerate().for_each(|(i, corners)| {
                let corners = [corners[0], corners[1], corners[2]];
                if is_one(corners) {
                    push(if i % 2 == 0 { corners } else { [corners[1], corners[0], corners[2]] });
                }
            }),
            _ => indices.windows(2).skip(1).for_each(|corners| {
                let corners = [corners[0], corners[1], indices[0]];
                if is_one(corners) {
                    push(corners);
                }
            }),
        }
        Ok(())
    }
}

/// Moves a surface; the winding is reversed where the matrix mirrors.
pub fn moved(polygons: &mut Polygons, world: &glam::DAffine3) {
    let matrix = world.matrix3;
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let sign = matrix.determinant().signum();
    let cofactors = glam::DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    polygons.normals.iter_mut().for_each(|normal| *normal = (cofactors * *normal).normalize_or(DVec3::Y));
    let positions = std::mem::take(&mut polygons.positions);
    positions.into_iter().for_each(|position| polygons.push_position(world.transform_point3(position), None));
    if sign < 0.0 {
        // All faces are triangles.
        polygons.faces.corners.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
        if let Uvs::OfCorners(uvs) = &mut polygons.uvs {
            uvs.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
        }
    }
}

/// What errors call a thing: `mesh 3 (Cup)`.
pub fn called(what: &str, index: usize, name: &str) -> String {
    match name {
        "" => format!("{what} {index}"),
        name => format!("{what} {index} ({})", crate::formats::lines::shown(name.as_bytes())),
    }
}
