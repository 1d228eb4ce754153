//! What kind of surface a mesh is: its components, its boundary, whether it crosses itself, which way it looks; and its repair where the
//! intent is plain.
//!
//! Vertices are the same if their positions are bit-equal; a tolerance would collapse thin shells. Only the rims of a surface, where it has
//! an edge without a neighbour, are joined across a few roundings ([`seam`]). Everything here is in object space and in f64, so a
//! transform changes nothing.
//!
//! The *boundary* is that of the surface as a chain of oriented faces: edges along which as many faces run one way as the other cancel. A
//! surface without boundary winds around every point a whole number of times, whatever else is odd about it. Where there is a boundary,
//! the *gap* decides: the least area found to close its loops ([`mod@fill`]), as a share of the surface's own area (0.05 where 5 % of the
//! triangles are missing, 0.2 for a cube without its lid, ½ for a hemisphere, 1 for a flat sheet).

mod boundary;
mod components;
mod connect;
mod crossing;
mod fill;
mod nesting;
mod partners;
mod repeats;
mod seam;

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;

use self::boundary::{HalfEdge, Loop};
use self::components::{Components, run_the_same_way};
use self::connect::Edges;
use self::crossing::Crossings;
use self::fill::{Filling, fill};
use self::nesting::{Body, Verdict};
use super::Mesh;
use super::hierarchy::{Extent, Hierarchy};
use super::triangle::area_vector;

/// No face, where the index of one is asked for.
pub const NONE: u32 = u32::MAX;

/// Most triangles, and most vertices, that a mesh may have: three half-edges of each are counted in 32 bits.
pub const MAX_FACES: usize = 1 << 30;

/// A surface with a larger gap than this encloses nothing: it is a sheet.
pub const GAP_OF_SHEET: f64 = 1.0 / 3.0;

/// A boundary of a smaller gap than this has length and no area: slits, such as remain where a vertex lies on another face's edge.
const GAP_OF_SLITS: f64 = 1e-9;

/// How membership in what a surface encloses is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Enclosure {
    /// No boundary, no crossings, components apart or proper cavities: by the facing of the first hit.
    #[default]
    Closed,
    /// No boundary, but crossings, touching faces, or outward components within outward ones: by the signed count of crossings.
    Union,
    /// A boundary that closes in the mind, gap up to [`GAP_OF_SHEET`]: by the generalised winding number.
    Holed,
    /// An open surface, or none at all: by the facing of the first hit, where rays that meet something opaque first abstain.
    Sheet,
}

named! {
    /// What was found in a mesh.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum FindingKind {
        /// Faces with two corners at one place, left out. Counted in faces.
        DegenerateTriangles = "degenerate_triangles",
        /// Faces over the same corners as another that looks the same way, left out. Counted in faces.
        DuplicateTriangles = "duplicate_triangles",
        /// Faces over the same corners as another that looks the other way: both were left out, or one of each two if the whole mesh is made
        /// of such pairs. Counted in pairs.
        DoubleFaces = "double_faces",
        /// Faces that looked the other way than their neighbours, turned over. Counted in faces.
        MixedOrientation = "mixed_orientation",
        /// Components, such as a Möbius strip, whose faces cannot all look one way; left as they were. Counted in components.
        OneSided = "one_sided",
        /// Components that looked inward without being cavities, turned over. Counted in components.
        InsideOut = "inside_out",
        /// Edges with a face on one side only, or whose faces do not look the same way. Counted in edges.
        OpenMesh = "open_mesh",
        /// Edges of three or more faces. Counted in edges.
        NonManifold = "non_manifold",
        /// Pairs of faces that cross; at least so many.
        SelfIntersection = "self_intersection",
        /// Components that look inward within one that looks outward: holes in the material. Counted in components.
        Cavity = "cavity",
        /// Components that look outward within one that looks outward: they have the same material on both sides. Counted in components.
        NestedComponents = "nested_components",
        /// It is closed and encloses no volume, or has no faces. Counted in components.
        ZeroVolume = "zero_volume",
    }
}

/// One kind of finding, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    pub kind: FindingKind,
    pub count: u64,
    /// A sphere around the place, in object space: all of it, or the largest or first of many.
    pub center: DVec3,
    pub radius: f64,
}

/// A mesh's analysis. Faces are those of the repaired mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Topology {
    /// Number of components: parts joined by edges that exactly two faces share.
    pub components: u32,
    /// Numbered in the order of their first faces.
    pub component_of_face: Vec<u32>,
    /// Face across edge k, which joins corners k and k + 1; [`NONE`] where the edge is not shared by exactly two faces. (Where a transform
    /// mirrors the mesh, its triangles' last two corners are exchanged, and edge k of a face is its edge 2 − k.)
    pub neighbours: Vec<[u32; 3]>,
    /// Corners, as indices into the mesh's positions: of vertices at the same place the first.
    pub vertices: Vec<[u32; 3]>,
    pub enclosure: Enclosure,
    /// Enclosed volume in object space, ≥ 0, holes closed by flat fans, overlaps counted twice; 0 for a sheet.
    pub volume: f64,
    /// The area that would close the boundary over the surface's own; 0 without boundary.
    pub gap: f64,
    /// In the order of [`FindingKind`], one of each kind at the most.
    pub findings: Vec<Finding>,
    /// The repaired mesh, if it differs from the one that was analysed.
    pub repaired: Option<Arc<Mesh>>,
}

impl Topology {
    /// Analyses and repairs a mesh of unknown making. Every coordinate must be finite, every index in range, and no more than [`MAX_FACES`].
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Analysis::new(mesh).run(true)
    }

    /// Analyses a mesh that is made from a shape's numbers: it crosses itself nowhere and looks the right way. Faces whose corners rounding
    /// has made one, as in a tiny shape far away, are left out all the same.
    pub fn of_shape(mesh: &Mesh) -> Self {
        Analysis::new(mesh).run(false)
    }

    pub fn finding(&self, kind: FindingKind) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.kind == kind)
    }
}

/// [`Topology::neighbours`] of a mesh that is not analysed, given by the corners of its triangles. Where these are bit-equal they are the same.
pub fn neighbours(corners: &[[DVec3; 3]]) -> Vec<[u32; 3]> {
    let first_at = connect::weld(corners.as_flattened());
    connect::connect(first_at.as_chunks().0, first_at.len()).neighbours
}

/// A mesh on its way.
struct Analysis<'a> {
    mesh: &'a Mesh,
    /// As the mesh has them, but for vertices that were joined at seams.
    positions: Cow<'a, [DVec3]>,
    /// The faces that are left, as the mesh has them.
    triangles: Cow<'a, [[u32; 3]]>,
    /// For each vertex the one that stands for its place.
    first_at: Vec<u32>,
    /// The faces that are left, by those vertices.
    faces: Vec<[u32; 3]>,
    findings: Vec<Finding>,
}

impl<'a> Analysis<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let first_at = connect::weld(&mesh.positions);
        let faces = mesh.triangles.iter().map(|t| t.map(|i| first_at[i as usize])).collect();
        let (positions, triangles) = (Cow::Borrowed(&mesh.positions[..]), Cow::Borrowed(&mesh.triangles[..]));
        Self { mesh, positions, triangles, first_at, faces, findings: Vec::new() }
    }

    fn run(mut self, is_repaired: bool) -> Topology {
        self.drop_degenerate();
        let mut edges = connect::connect(&self.faces, self.positions.len());
        if is_repaired {
            edges = self.join_seams(edges);
        }
        if is_repaired && edges.has_twins {
            self.drop_repeats();
            edges = connect::connect(&self.faces, self.positions.len());
        }
        partners::find(&mut edges, &self.faces, &self.triangles, &self.positions);
        let components = components::components(&self.faces, &edges, |face| area_vector(self.corners(face)).length());
        let mixed = if is_repaired { &components.turned[..] } else { &[] };
        self.turn(&mut edges, |face| mixed.get(face).copied().unwrap_or_default());

        let mut half_edges = self.half_edges(&edges, &components);
        let (parts, mut loops) = self.parts(&components, &mut half_edges);
        let mut filling = fill(&loops, &self.positions, self.reference());
        let all = self.extent(|_| true);
        let size = (all.max - all.min).length();
        let area: f64 = parts.iter().map(|part| part.area).sum();
        let bodies: Vec<Option<Body>> = parts.iter().map(|part| part.body(size)).collect();
        let (mut crossings, mut verdicts) = (Crossings::default(), vec![Verdict::default(); bodies.len()]);
        if is_repaired {
            let (faces, positions, of_face) = (&self.faces, &self.positions, &components.of_face);
            let tree = Hierarchy::build(faces.len(), |face| self.corners(face as usize));
            crossings = crossing::crossings(&tree, faces, positions, of_face);
            verdicts = nesting::judge(&bodies, &tree, faces, of_face, positions, &crossings.meetings);
        }
        // What encloses something only as a whole is turned as a whole.
        let sum_of_volumes = || parts.iter().map(|part| part.volume).sum::<f64>();
        if is_repaired && bodies.iter().all(Option::is_none) && filling.area <= GAP_OF_SHEET * area {
            let is_turned = sum_of_volumes() + filling.volume < -rounding_of_volume(area, size);
            verdicts.iter_mut().for_each(|verdict| verdict.is_turned = is_turned);
        }
        self.turn(&mut edges, |face| verdicts[components.of_face[face] as usize].is_turned);

        // Where components share edges, the boundaries that they have alone may cancel.
        if !edges.crowds.is_empty() && components.count > 1 {
            half_edges = self.half_edges(&edges, &components);
            loops = boundary::loops(&boundary::uncancelled(&half_edges), &self.positions);
            filling = fill(&loops, &self.positions, self.reference());
        }
        let gap = if loops.is_empty() { 0.0 } else { filling.area / area };
        let is_union = !crossings.pairs.is_empty()
            || crossings.touches
            || crossings.is_given_up
            || !edges.crowds.is_empty()
            || verdicts.iter().any(|v| v.winding.max(v.winding_outside) > 1);
        let enclosure = match gap {
            _ if self.faces.is_empty() => Enclosure::Sheet,
            ..=GAP_OF_SLITS if is_union => Enclosure::Union,
            ..=GAP_OF_SLITS => Enclosure::Closed,
            ..=GAP_OF_SHEET => Enclosure::Holed,
            _ => Enclosure::Sheet,
        };
        let volume = if enclosure == Enclosure::Sheet {
            0.0
        } else if bodies.iter().any(Option::is_some) {
            let signed =
                |(body, verdict): (&Body, &Verdict)| if verdict.is_turned { -body.volume } else { body.volume };
            (bodies.iter().zip(&verdicts)).filter_map(|(b, v)| Some(signed((b.as_ref()?, v)))).sum::<f64>().abs()
        } else {
            // Rounding leaves something of what is flat.
            let volume = (sum_of_volumes() + filling.volume).abs();
            if volume > rounding_of_volume(area, size) { volume } else { 0.0 }
        };

        self.report_turned(mixed, &components, &verdicts);
        self.report_boundary(&loops, &edges, &half_edges);
        self.report_crossings(&crossings);
        self.report_nesting(&components, &verdicts);
        if volume == 0.0 && enclosure != Enclosure::Sheet || self.faces.is_empty() {
            self.report(FindingKind::ZeroVolume, u64::from(components.count.max(1)), all);
        }
        self.findings.sort_by_key(|finding| finding.kind);
        let repaired = self.repaired_mesh();
        Topology {
            components: components.count,
            component_of_face: components.of_face,
            neighbours: edges.neighbours,
            vertices: self.faces,
            enclosure,
            volume,
            gap,
            findings: self.findings,
            repaired,
        }
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        // Written out: the compiler leaves `map` a function of its own here, which costs a tenth of everything.
        let [a, b, c] = self.faces[face];
        let at = |v: u32| self.positions[v as usize];
        [at(a), at(b), at(c)]
    }

    /// The point that volumes are measured from: one of the mesh, so that a far mesh keeps its digits.
    fn reference(&self) -> DVec3 {
        self.faces.first().map_or(DVec3::ZERO, |face| self.positions[face[0] as usize])
    }

    fn extent(&self, is_meant: impl Fn(usize) -> bool) -> Extent {
        let faces = (0..self.faces.len()).filter(|&face| is_meant(face));
        Extent::of(faces.flat_map(|face| self.corners(face)))
    }

    fn report(&mut self, kind: FindingKind, count: u64, extent: Extent) {
        let (center, radius) = if extent.min.x <= extent.max.x {
            ((extent.min + extent.max) / 2.0, (extent.max - extent.min).length() / 2.0)
        } else {
            (DVec3::ZERO, 0.0)
        };
        self.findings.push(Finding { kind, count, center, radius });
    }

    /// Says what was found at some faces, if there are any.
    fn report_faces(&mut self, kind: FindingKind, count: usize, faces: &[u32]) {
        if count > 0 {
            let extent = Extent::of(faces.iter().flat_map(|&face| self.corners(face as usize)));
            self.report(kind, count as u64, extent);
        }
    }

    /// Leaves out some faces.
    fn keep(&mut self, is_kept: &[bool]) {
        if !is_kept.contains(&false) {
            return;
        }
        let keep = |list: &[[u32; 3]]| -> Vec<[u32; 3]> {
            list.iter().zip(is_kept).filter(|(_, kept)| **kept).map(|(t, _)| *t).collect()
        };
        self.faces = keep(&self.faces);
        self.triangles = Cow::Owned(keep(&self.triangles));
    }

    /// Leaves out the faces with two equal corners, and says so.
    fn drop_degenerate(&mut self) {
        let lines: Vec<u32> = (0..self.faces.len() as u32).filter(|&face| is_line(self.faces[face as usize])).collect();
        self.report_faces(FindingKind::DegenerateTriangles, lines.len(), &lines);
        self.drop_lines();
    }

    /// Leaves out the faces with two equal corners.
    fn drop_lines(&mut self) {
        let is_kept: Vec<bool> = self.faces.iter().map(|&face| !is_line(face)).collect();
        self.keep(&is_kept);
    }

    /// Joins vertices that differ by rounding: the ends of edges without length, then the rims of seams, from the nearest to the farthest that
    /// may be one. Faces that this makes lines are left out.
    fn join_seams(&mut self, mut edges: Edges) -> Edges {
        let extent = self.extent(|_| true);
        if let Some(short) = seam::short_edges(&self.faces, &self.positions, seam::rounding(extent)) {
            self.join(&short);
            edges = connect::connect(&self.faces, self.positions.len());
        }
        if edges.neighbours.iter().all(|across| !across.contains(&NONE)) {
            return edges;
        }
        for reach in seam::reaches(&self.positions, extent) {
            if let Some(joints) = seam::joints(&self.faces, &edges, &self.positions, reach) {
                self.join(&joints);
                edges = connect::connect(&self.faces, self.positions.len());
            }
        }
        edges
    }

    /// Makes each vertex one with the vertex that stands for it.
    fn join(&mut self, stands_for: &[u32]) {
        let positions = self.positions.to_mut();
        for (index, first) in self.first_at.iter_mut().enumerate() {
            let joined = stands_for[*first as usize];
            if joined != *first {
                *first = joined;
                positions[index] = positions[joined as usize];
            }
        }
        self.faces.iter_mut().for_each(|face| *face = face.map(|v| stands_for[v as usize]));
        self.drop_lines();
    }

    /// Leaves out repeated faces that are none, and says so.
    fn drop_repeats(&mut self) {
        let repeats = repeats::decide(&self.faces);
        self.report_faces(FindingKind::DuplicateTriangles, repeats.duplicates.len(), &repeats.duplicates);
        self.report_faces(FindingKind::DoubleFaces, repeats.doubles.len(), repeats.doubles.as_flattened());
        self.keep(&repeats.is_kept);
    }

    /// Turns faces over.
    fn turn(&mut self, edges: &mut Edges, is_turned: impl Fn(usize) -> bool) {
        for face in 0..self.faces.len() {
            if is_turned(face) {
                self.faces[face].swap(1, 2);
                self.triangles.to_mut()[face].swap(1, 2);
                edges.neighbours[face].swap(0, 2);
            }
        }
    }

    /// Half-edges whose opposite is not the only other: those that may be the boundary.
    fn half_edges(&self, edges: &Edges, components: &Components) -> Vec<HalfEdge> {
        let mut found = Vec::new();
        for (index, (face, neighbours)) in self.faces.iter().zip(&edges.neighbours).enumerate() {
            let component = components.of_face[index];
            for (k, &other) in neighbours.iter().enumerate() {
                let is_doubtful = components.one_sided[component as usize];
                if other == NONE || is_doubtful && run_the_same_way(&self.faces, index, k, other as usize) {
                    found.push(HalfEdge { component, from: face[k], to: face[(k + 1) % 3] });
                }
            }
        }
        found
    }

    /// Sums over each component, with what fills the loops that bound it alone, and all these loops.
    fn parts(&self, components: &Components, half_edges: &mut [HalfEdge]) -> (Vec<Part>, Vec<Loop>) {
        let reference = self.reference();
        let mut parts = vec![Part::NOTHING; components.count as usize];
        for (index, &component) in components.of_face.iter().enumerate() {
            let corners = self.corners(index);
            let part = &mut parts[component as usize];
            let normal = area_vector(corners);
            part.area += normal.length() / 2.0;
            part.volume += (corners[0] - reference).dot(normal) / 6.0;
            if components.count > 1 {
                for p in corners {
                    let height = p.dot(nesting::UP);
                    if height > part.height {
                        (part.top, part.height) = (p, height);
                    }
                }
            }
        }
        half_edges.sort_unstable();
        let mut all = Vec::new();
        for own in half_edges.chunk_by(|a, b| a.component == b.component) {
            let loops = boundary::loops(&boundary::uncancelled(own), &self.positions);
            let part = &mut parts[own[0].component as usize];
            part.filling = fill(&loops, &self.positions, reference);
            all.extend(loops);
        }
        (parts, all)
    }

    /// Says which faces look another way than they did.
    fn report_turned(&mut self, mixed: &[bool], components: &Components, verdicts: &[Verdict]) {
        let is_mixed = |face: usize| mixed.get(face).copied().unwrap_or_default();
        let mut has_mixed = vec![false; components.count as usize];
        for (face, &component) in components.of_face.iter().enumerate() {
            has_mixed[component as usize] |= is_mixed(face);
        }
        let is_over = |component: u32| verdicts[component as usize].is_turned;
        let is_turned = |face: usize| {
            let component = components.of_face[face];
            has_mixed[component as usize] && is_mixed(face) != is_over(component)
        };
        let turned = (0..self.faces.len()).filter(|&face| is_turned(face)).count() as u64;
        if turned > 0 {
            let extent = self.extent(is_turned);
            self.report(FindingKind::MixedOrientation, turned, extent);
        }
        self.report_components(FindingKind::InsideOut, components, |c| is_over(c) && !has_mixed[c as usize]);
        self.report_components(FindingKind::OneSided, components, |c| components.one_sided[c as usize]);
    }

    fn report_components(&mut self, kind: FindingKind, components: &Components, is_meant: impl Fn(u32) -> bool) {
        let count = (0..components.count).filter(|&component| is_meant(component)).count() as u64;
        if count > 0 {
            let extent = self.extent(|face| is_meant(components.of_face[face]));
            self.report(kind, count, extent);
        }
    }

    fn report_boundary(&mut self, loops: &[Loop], edges: &Edges, half_edges: &[HalfEdge]) {
        // The place is that of the widest loop.
        let width = |l: &Loop| (l.extent.max - l.extent.min).length();
        let widest = loops.iter().reduce(|a, b| if width(b) > width(a) { b } else { a });
        if let Some(widest) = widest {
            self.report(FindingKind::OpenMesh, boundary::uncancelled(half_edges).len() as u64, widest.extent);
        }
        if !edges.crowds.is_empty() {
            let mut sides: Vec<(u32, u32)> = half_edges.iter().map(|h| (h.from.min(h.to), h.from.max(h.to))).collect();
            sides.sort_unstable();
            let first = sides.chunk_by(|a, b| a == b).find(|edge| edge.len() > 2).map_or((0, 0), |edge| edge[0]);
            let place = Extent::of([first.0, first.1].map(|v| self.positions[v as usize]));
            self.report(FindingKind::NonManifold, edges.crowds.len() as u64, place);
        }
    }

    fn report_crossings(&mut self, crossings: &Crossings) {
        if let Some(first) = crossings.pairs.first() {
            let [a, b] = first.map(|face| Extent::of(self.corners(face as usize)));
            let common = Extent { min: a.min.max(b.min), max: a.max.min(b.max) };
            self.report(FindingKind::SelfIntersection, crossings.pairs.len() as u64, common);
        }
    }

    fn report_nesting(&mut self, components: &Components, verdicts: &[Verdict]) {
        let windings = |c: u32| [verdicts[c as usize].winding_outside, verdicts[c as usize].winding];
        self.report_components(FindingKind::Cavity, components, |c| windings(c) == [1, 0]);
        self.report_components(FindingKind::NestedComponents, components, |c| windings(c).iter().all(|w| *w > 0));
    }

    fn repaired_mesh(&self) -> Option<Arc<Mesh>> {
        if matches!((&self.positions, &self.triangles), (Cow::Borrowed(_), Cow::Borrowed(_))) {
            return None;
        }
        let mut mesh = Mesh {
            positions: self.positions.to_vec(),
            normals: self.mesh.normals.clone(),
            triangles: self.triangles.to_vec(),
            // A refractor has no texture.
            uvs: Vec::new(),
        };
        // Normals that were right for faces that have been turned are so no more.
        if !mesh.normals.is_empty() {
            let mut around = vec![DVec3::ZERO; mesh.positions.len()];
            for triangle in &mesh.triangles {
                let normal = area_vector(triangle.map(|i| mesh.positions[i as usize]));
                triangle.iter().for_each(|&i| around[i as usize] += normal);
            }
            for (normal, faces) in mesh.normals.iter_mut().zip(around) {
                if normal.dot(faces) < 0.0 {
                    *normal = -*normal;
                }
            }
        }
        Some(Arc::new(mesh))
    }
}

/// What is summed over the faces of a component.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    area: f64,
    /// Enclosed if it is closed, else what must be added to that of the gap.
    volume: f64,
    /// The highest vertex along [`nesting::UP`].
    top: DVec3,
    height: f64,
    /// What would close it.
    filling: Filling,
}

impl Part {
    const NOTHING: Self = Self {
        area: 0.0,
        volume: 0.0,
        top: DVec3::ZERO,
        height: f64::NEG_INFINITY,
        filling: Filling { area: 0.0, volume: 0.0 },
    };

    /// What it encloses, if anything; `size` is the mesh's diagonal.
    fn body(&self, size: f64) -> Option<Body> {
        let volume = self.volume + self.filling.volume;
        let encloses =
            self.filling.area <= GAP_OF_SHEET * self.area && volume.abs() > rounding_of_volume(self.area, size);
        encloses.then_some(Body { volume, top: self.top, height: self.height })
    }
}

fn is_line([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// Volumes are sums of products of an area vector and a distance: this much of them may be rounding.
fn rounding_of_volume(area: f64, size: f64) -> f64 {
    1e-14 * area * size
}
