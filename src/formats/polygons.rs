//! Meshes from files: what is common to all formats.

use glam::DVec3;

use super::corners::CornerLists;
use super::parts::{NoSuchPart, Parts};
use super::passed_over::{Kind, PassedOver};
use super::polygon::{PATIENCE, triangulate};
use crate::geometry::{CornerUvs, Mesh};
use crate::scene::LoadNote;
use crate::scene::description::MeshPart;
use crate::scene::shapes::MAX_LENGTH;

/// What is wrong in a mesh file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Fault {
    /// 1-based, in text formats.
    pub line: Option<usize>,
    pub message: String,
}

impl Fault {
    pub fn new(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }

    pub fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }
}

/// Texture coordinates as a file has them, with v upwards.
#[derive(Debug, Clone, Default)]
pub(super) enum Uvs {
    #[default]
    None,
    /// One pair for each position.
    OfPositions(Vec<[f32; 2]>),
    /// One pair for each corner of the faces, in the order of their lists; not finite where a corner has none.
    OfCorners(Vec<[f32; 2]>),
}

impl Uvs {
    /// What is of use: a pair for each position or corner, of which at least one is given.
    fn usable(self, positions: usize, corners: usize) -> Self {
        match self {
            Self::OfPositions(pairs) if pairs.len() == positions => Self::OfPositions(pairs),
            Self::OfCorners(pairs) if pairs.len() == corners && pairs.iter().any(|[u, _]| u.is_finite()) => {
                Self::OfCorners(pairs)
            }
            _ => Self::None,
        }
    }

    /// Adds a pair for a position, of which there have been `count`; without one all are given up.
    pub fn push_of_position(&mut self, uv: Option<[f32; 2]>, count: usize) {
        match (&mut *self, uv) {
            (Self::OfPositions(pairs), Some(uv)) if pairs.len() == count => pairs.push(finite(uv)),
            (Self::None, Some(uv)) if count == 0 => *self = Self::OfPositions(vec![finite(uv)]),
            _ => *self = Self::None,
        }
    }
}

/// What is no finite number is 0.
fn finite(uv: [f32; 2]) -> [f32; 2] {
    uv.map(|x| if x.is_finite() { x } else { 0.0 })
}

/// A surface as its file has it. Corners of faces must name vertices that there are: the readers know the place of those that do not.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    pub positions: Vec<DVec3>,
    /// One for each position, or none.
    pub normals: Vec<DVec3>,
    pub uvs: Uvs,
    pub faces: CornerLists,
    /// Strips of triangles, each of which shares two corners with the one before.
    pub strips: CornerLists,
    /// Of the faces; strips belong to none.
    pub parts: Parts,
    /// Files of materials that are named, as they are written.
    pub libraries: Vec<String>,
    pub passed_over: PassedOver,
    /// Vertices that cannot be corners, by index and line: allowed as long as they are none.
    unusable: Vec<(usize, Option<usize>)>,
}

impl Polygons {
    pub fn push_position(&mut self, position: DVec3, line: Option<usize>) {
        if !position.abs().cmple(DVec3::splat(MAX_LENGTH)).all() {
            self.unusable.push((self.positions.len(), line));
        }
        self.positions.push(position);
    }

    /// Leaves out vertices that are not finite or too far away, as many exporters write for what is unused. An error: a face uses one.
    pub fn drop_unusable(&mut self) -> Result<(), Fault> {
        let Some(&(_, first_line)) = self.unusable.first() else { return Ok(()) };
        let is_used = self.used_vertices();
        if let Some(&(vertex, line)) = self.unusable.iter().find(|(vertex, _)| is_used[*vertex]) {
            let [x, y, z] = self.positions[vertex].to_array();
            let message = format!(
                "a face uses this vertex, [{x}, {y}, {z}], whose coordinates must be finite, and at most {MAX_LENGTH:e}"
            );
            let message = if line.is_some() { message } else { format!("vertex {vertex}: {message}") };
            return Err(Fault { line, message });
        }
        self.passed_over.add_many(Kind::UnusableVertices, self.unusable.len() as u64, first_line);
        let mut is_kept = vec![true; self.positions.len()];
        self.unusable.drain(..).for_each(|(vertex, _)| is_kept[vertex] = false);
        let mut next = 0;
        let new_index: Vec<u32> = (is_kept.iter())
            .map(|&is_kept| {
                let index = next;
                next += u32::from(is_kept);
                index
            })
            .collect();
        for corner in self.faces.corners.iter_mut().chain(&mut self.strips.corners) {
            // Lists that make no face may name anything.
            *corner = new_index.get(*corner as usize).copied().unwrap_or_default();
        }
        fn keep<T>(values: &mut Vec<T>, is_kept: &[bool]) {
            let mut kept = is_kept.iter();
            values.retain(|_| kept.next().is_some_and(|&is_kept| is_kept));
        }
        keep(&mut self.positions, &is_kept);
        keep(&mut self.normals, &is_kept);
        if let Uvs::OfPositions(pairs) = &mut self.uvs {
            keep(pairs, &is_kept);
        }
        Ok(())
    }

    /// Adds the faces of another surface, which is changed by `change` before; normals are kept while all have them.
    pub fn append(&mut self, other: &Self, change: impl FnOnce(&mut Self)) -> Result<(), Fault> {
        let mut other = Self {
            positions: other.positions.clone(),
            normals: other.normals.clone(),
            uvs: other.uvs.clone(),
            faces: other.faces.clone(),
            ..Self::default()
        };
        change(&mut other);
        let start = self.positions.len();
        let offset = u32::try_from(start + other.positions.len()).map(|_| start as u32);
        let offset = offset.map_err(|_| Fault::new("the mesh has too many vertices"))?;
        if self.normals.len() == start && other.normals.len() == other.positions.len() {
            self.normals.append(&mut other.normals);
        } else {
            self.normals.clear();
        }
        match (&mut self.uvs, other.uvs) {
            (Uvs::OfPositions(pairs), Uvs::OfPositions(mut more)) if pairs.len() == start => pairs.append(&mut more),
            (Uvs::None, more @ Uvs::OfPositions(_)) if start == 0 => self.uvs = more,
            _ => self.uvs = Uvs::None,
        }
        other.positions.iter().for_each(|position| self.push_position(*position, None));
        for list in other.faces.iter() {
            self.faces.corners.extend(list.corners.iter().map(|corner| corner + offset));
            self.faces.close(None);
        }
        Ok(())
    }

    /// The faces of a part, with the vertices that they use.
    pub fn part(&self, part: &MeshPart) -> Result<Self, NoSuchPart> {
        const UNUSED: u32 = u32::MAX;
        let faces = self.parts.faces(part, self.faces.len())?;
        let mut taken = Self { passed_over: self.passed_over.clone(), ..Self::default() };
        let mut new_index = vec![UNUSED; self.positions.len()];
        let mut old_index = Vec::new();
        for face in faces.iter().cloned().flatten() {
            let list = self.faces.get(face);
            for &corner in list.corners {
                // Lists that make no face may name anything.
                taken.faces.corners.push(match new_index.get_mut(corner as usize) {
                    Some(new) if *new == UNUSED && list.is_face() => {
                        *new = old_index.len() as u32;
                        old_index.push(corner as usize);
                        *new
                    }
                    Some(new) => *new,
                    None => UNUSED,
                });
            }
            taken.faces.close(list.line);
        }
        taken.positions = old_index.iter().map(|&old| self.positions[old]).collect();
        if self.normals.len() == self.positions.len() {
            taken.normals = old_index.iter().map(|&old| self.normals[old]).collect();
        }
        taken.uvs = match &self.uvs {
            Uvs::None => Uvs::None,
            Uvs::OfPositions(pairs) => Uvs::OfPositions(old_index.iter().map(|&old| pairs[old]).collect()),
            Uvs::OfCorners(pairs) => {
                let corners = faces.into_iter().flatten().flat_map(|face| self.faces.corners_of(face));
                Uvs::OfCorners(corners.map(|corner| pairs[corner]).collect())
            }
        };
        let unusable = self.unusable.iter().map(|&(vertex, line)| (new_index[vertex], line));
        taken.unusable = unusable.filter(|(new, _)| *new != UNUSED).map(|(new, line)| (new as usize, line)).collect();
        Ok(taken)
    }

    fn used_vertices(&self) -> Vec<bool> {
        let mut is_used = vec![false; self.positions.len()];
        self.faces.used().chain(self.strips.used()).for_each(|corner| is_used[corner as usize] = true);
        is_used
    }

    /// The normals, of length 1, if they are of use: each vertex that a face uses must have one with a direction.
    fn usable_normals(&mut self) -> Vec<DVec3> {
        let mut normals = std::mem::take(&mut self.normals);
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        if normals.len() != self.positions.len() {
            return Vec::new();
        }
        if normals.contains(&DVec3::ZERO) {
            let is_used = self.used_vertices();
            let unusable = normals.iter().zip(&is_used).filter(|(n, is_used)| **is_used && **n == DVec3::ZERO).count();
            self.passed_over.add_many(Kind::UnusableNormals, unusable as u64, None);
            if unusable > 0 {
                return Vec::new();
            }
            // Nobody sees these.
            normals.iter_mut().filter(|n| **n == DVec3::ZERO).for_each(|n| *n = DVec3::Z);
        }
        normals
    }

    /// The mesh, and what was passed over. An error: there is no face, or one uses what is no vertex or takes too long to be cut.
    pub fn finish(mut self) -> Result<(Mesh, Vec<LoadNote>), Fault> {
        self.drop_unusable()?;
        let normals = self.usable_normals();
        let Self { positions, uvs, faces, strips, mut passed_over, .. } = self;
        let uvs = uvs.usable(positions.len(), faces.corners.len());
        let (triangles, patience) = (Vec::new(), PATIENCE);
        let (passed_over_here, of_triangles) = (&mut passed_over, Vec::new());
        let mut builder = Builder {
            positions: &positions,
            uvs: &uvs,
            triangles,
            of_triangles,
            passed_over: passed_over_here,
            patience,
        };
        for (index, face) in faces.iter().enumerate() {
            builder.push_face(face.corners, faces.corners_of(index).start, face.line)?;
        }
        for strip in strips.iter() {
            builder.push_strip(strip.corners, strip.line);
        }
        let Builder { triangles, of_triangles: uvs, .. } = builder;
        if triangles.is_empty() {
            return Err(without_faces(&passed_over));
        }
        Ok((Mesh { positions, normals, triangles, uvs }, passed_over.into_notes()))
    }
}

/// Why a mesh has no triangles.
fn without_faces(passed_over: &PassedOver) -> Fault {
    if let Some((flat, ..)) = passed_over.first(Kind::DegenerateTriangles) {
        return Fault::new(format!("none of the mesh's {flat} triangles has any area"));
    }
    if let Some((_, line, word)) = passed_over.first(Kind::UnknownStatement) {
        let message = format!("the mesh has no faces, and {word} is no OBJ statement that is read (v, vn, f)");
        return Fault { line, message };
    }
    match passed_over.first(Kind::ShortFaces) {
        Some((_, line, _)) => Fault { line, message: "the mesh has no faces of three corners or more".to_owned() },
        None => Fault::new("the mesh has no faces"),
    }
}

/// Triangles as they come from faces and strips.
struct Builder<'a> {
    positions: &'a [DVec3],
    uvs: &'a Uvs,
    triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the triangles, if there are any.
    of_triangles: Vec<CornerUvs>,
    passed_over: &'a mut PassedOver,
    /// For all faces together.
    patience: usize,
}

impl Builder<'_> {
    /// `first`: which of all corners of faces is the first of these.
    fn push_face(&mut self, corners: &[u32], first: usize, line: Option<usize>) -> Result<(), Fault> {
        match *corners {
            [] | [_] | [_, _] => self.passed_over.add(Kind::ShortFaces, line),
            [a, b, c] => self.push_triangle([a, b, c], Some([0, 1, 2].map(|k| first + k)), line),
            _ => {
                let points: Vec<DVec3> = corners.iter().map(|&i| self.positions[i as usize]).collect();
                let triangles = triangulate(&points, &mut self.patience).ok_or_else(|| {
                    let message = format!(
                        "a face of {} corners takes too long to be cut into triangles, with those before it: cut them",
                        corners.len()
                    );
                    Fault { line, message }
                })?;
                for triangle in triangles {
                    self.push_triangle(triangle.map(|k| corners[k]), Some(triangle.map(|k| first + k)), line);
                }
            }
        }
        Ok(())
    }

    /// Every second triangle of a strip runs the other way about. Corners are repeated where strips are sewn together.
    fn push_strip(&mut self, corners: &[u32], line: Option<usize>) {
        if corners.len() < 3 {
            self.passed_over.add(Kind::ShortFaces, line);
        }
        for (i, corners) in corners.windows(3).enumerate() {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            if a != b && b != c && c != a {
                self.push_triangle(if i % 2 == 0 { [a, b, c] } else { [b, a, c] }, None, line);
            }
        }
    }

    /// `corners`: which corners of faces its own are; of strips `None`.
    fn push_triangle(&mut self, triangle: [u32; 3], corners: Option<[usize; 3]>, line: Option<usize>) {
        let [a, b, c] = triangle.map(|i| self.positions[i as usize]);
        let (u, v) = (b - a, c - a);
        // Scaled by the longest edge, so that tiny triangles are not taken for flat ones by underflow.
        let longest = u.abs().max(v.abs()).max_element();
        let has_area = longest > 0.0 && (u / longest).cross(v / longest) != DVec3::ZERO;
        if has_area {
            self.triangles.push(triangle);
            match (self.uvs, corners) {
                (Uvs::OfPositions(pairs), _) => self.of_triangles.push(triangle.map(|i| pairs[i as usize])),
                (Uvs::OfCorners(pairs), Some(corners)) => self.of_triangles.push(corners.map(|i| finite(pairs[i]))),
                (Uvs::OfCorners(_), None) | (Uvs::None, _) => {}
            }
        } else {
            self.passed_over.add(Kind::DegenerateTriangles, line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygons(positions: &[DVec3], faces: &[&[u32]], strips: &[&[u32]]) -> Polygons {
        let mut polygons = Polygons::default();
        positions.iter().for_each(|p| polygons.push_position(*p, None));
        for (lists, to) in [(faces, &mut polygons.faces), (strips, &mut polygons.strips)] {
            for list in lists {
                to.corners.extend(*list);
                to.close(None);
            }
        }
        polygons
    }

    fn counts(notes: &[LoadNote]) -> Vec<(&'static str, u64)> {
        notes.iter().map(|note| (note.kind, note.count)).collect()
    }

    #[test]
    fn triangles_without_area_are_left_out_and_counted() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 2.0, DVec3::X, DVec3::Y * 1e-200];
        let faces: [&[u32]; 5] = [&[0, 1, 2], &[0, 1, 1], &[0, 1, 3], &[1, 4, 2], &[0, 1, 5]];
        let (mesh, notes) = polygons(&positions, &faces, &[]).finish().unwrap();
        assert_eq!((mesh.triangles, counts(&notes)), (vec![[0, 1, 2], [0, 1, 5]], vec![("degenerate_triangles", 3)]));
    }

    #[test]
    fn strips_keep_their_orientation() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        // Two triangles, sewn to a third by repeated corners; then too short a strip.
        let (mesh, notes) = polygons(&square, &[], &[&[0, 1, 2, 3, 3, 0, 0, 1, 2], &[1, 2]]).finish().unwrap();
        assert_eq!(
            (&mesh.triangles[..], counts(&notes)),
            (&[[0, 1, 2], [2, 1, 3], [0, 1, 2]][..], vec![("short_faces", 1)])
        );
        for t in mesh.triangles {
            let [a, b, c] = t.map(|i| square[i as usize]);
            assert_eq!((b - a).cross(c - a), DVec3::Z);
        }
    }

    #[test]
    fn unusable_vertices_are_left_out_and_the_others_keep_their_places() {
        let far = DVec3::splat(1e19);
        let mut mesh = polygons(
            &[far, DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y, DVec3::Z],
            &[&[1, 2, 4], &[0, 77]],
            &[&[1, 2, 5]],
        );
        mesh.normals = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ZERO, DVec3::Z * 2.0, DVec3::NEG_X];
        let (mesh, notes) = mesh.finish().unwrap();
        assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        assert_eq!(mesh.normals, [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
        assert_eq!(counts(&notes), [("unusable_vertices", 2), ("short_faces", 1)]);
        let used = polygons(&[far, DVec3::ZERO, DVec3::X], &[&[0, 1, 2]], &[]).finish().unwrap_err();
        assert!(used.message.starts_with("vertex 0: a face uses this vertex"), "{}", used.message);
    }

    #[test]
    fn normals_of_unused_vertices_do_not_matter() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let with = |normals: [DVec3; 4]| {
            let polygons = Polygons { normals: normals.to_vec(), ..polygons(&positions, &[&[0, 1, 2]], &[]) };
            polygons.finish().unwrap()
        };
        let (mesh, notes) = with([DVec3::Z, DVec3::Z, DVec3::X, DVec3::ZERO]);
        assert_eq!((&mesh.normals[..3], counts(&notes)), (&[DVec3::Z, DVec3::Z, DVec3::X][..], vec![]));
        let (mesh, notes) = with([DVec3::Z, DVec3::ZERO, DVec3::X, DVec3::ZERO]);
        assert_eq!((mesh.normals.len(), counts(&notes)), (0, vec![("unusable_normals", 1)]));
    }

    #[test]
    fn only_flat_triangles_is_an_error() {
        let message = |faces: &[&[u32]]| polygons(&[DVec3::ZERO, DVec3::X], faces, &[]).finish().unwrap_err().message;
        assert!(message(&[&[0, 1, 0]]).contains("none of the mesh's 1 triangles"));
        assert!(message(&[&[0, 1]]).contains("no faces of three corners"));
        assert_eq!(message(&[]), "the mesh has no faces");
    }
}
