//! All primitives of a scene, the trees over them, and every question that is asked of them.

use std::borrow::Cow;
use std::ops::{ControlFlow, Range};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::bvh::Tree;
use super::frame::Frame;
use super::kernel::KernelChoice;
use super::mesh::Mesh;
use super::part::Part;
use super::ray::{Hit, NO_PRIMITIVE, PrimitiveId, Ray};
use super::sphere::Sphere;
use super::triangle::{self, PACK, TrianglePack};

/// The primitives of one object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ObjectRange {
    Triangles(Range<u32>),
    Sphere(PrimitiveId),
}

/// A point on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    pub position: DVec3,
    /// Unit, outward.
    pub normal: DVec3,
    pub primitive: PrimitiveId,
}

/// A set of primitives.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mask {
    bits: Vec<u64>,
}

impl Mask {
    pub fn is_empty(&self) -> bool {
        self.bits.is_empty()
    }

    pub fn insert(&mut self, primitive: PrimitiveId) {
        let word = primitive as usize / 64;
        if word >= self.bits.len() {
            self.bits.resize(word + 1, 0);
        }
        self.bits[word] |= 1 << (primitive % 64);
    }

    /// A bit for each primitive, the lowest first.
    pub fn words(&self) -> impl Iterator<Item = u32> + '_ {
        self.bits.iter().flat_map(|bits| [*bits as u32, (bits >> 32) as u32])
    }

    #[inline]
    pub fn contains(&self, primitive: PrimitiveId) -> bool {
        self.bits.get(primitive as usize / 64).is_some_and(|word| word >> (primitive % 64) & 1 == 1)
    }
}

/// Primitives and trees. Object ids are the indices of the parts it was built from. All coordinates are relative to `origin`.
#[derive(Debug)]
pub struct Geometry {
    /// Scene coordinates of the local origin, which lies amid the objects, so that f32 vertices keep their digits.
    pub origin: DVec3,
    /// The origin is a multiple of it: see [`Frame::step`].
    pub step: f64,
    pub(super) positions: Vec<Vec3>,
    /// Of the vertices of smooth objects; empty where there are none.
    normals: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) spheres: Vec<Sphere>,
    pub(super) object_of_primitive: Vec<u32>,
    ranges: Vec<ObjectRange>,
    /// Lowest and highest coordinates of each object.
    bounds_of_objects: Vec<(DVec3, DVec3)>,
    /// Running sums of triangle areas, restarting at each object.
    areas: Vec<f64>,
    pub(super) triangle_tree: Tree,
    pub(super) packs: Vec<TrianglePack>,
    pub(super) sphere_tree: Tree,
    pub(super) sphere_slots: Vec<u32>,
    bounds: Option<Sphere>,
    /// One of those that are available.
    pub(super) kernel: KernelChoice,
}

/// Triangles that one thread looks at before they are put together: not as many as threads happen to take, since the sign of a zero
/// depends on the order.
const BOUNDS_CHUNK: usize = 1 << 14;

impl Geometry {
    /// Builds everything. Every coordinate is finite, every radius > 0, every index in range.
    ///
    /// Parts that are handed over are let go one by one: building the tree takes most memory, and needs none of them.
    pub fn build<'a>(parts: impl Into<Cow<'a, [Part]>>) -> Self {
        let parts = parts.into();
        let frame = Frame::about(&*parts).unwrap_or_default();
        Self::build_in(frame, parts, None)
    }

    /// [`Self::build`] with local coordinates in that frame. Where the objects have as many primitives as they had `earlier`, its tree is
    /// fitted to their new places, as long as that is about as good as one built anew: hits are the same.
    pub fn build_in<'a>(frame: Frame, parts: impl Into<Cow<'a, [Part]>>, earlier: Option<&Self>) -> Self {
        let parts = parts.into().into_owned();
        let origin = frame.origin;
        let mut geometry = Self {
            origin,
            step: frame.step,
            positions: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            spheres: Vec::new(),
            object_of_primitive: Vec::new(),
            ranges: Vec::with_capacity(parts.len()),
            bounds_of_objects: Vec::new(),
            areas: Vec::new(),
            triangle_tree: Tree::default(),
            packs: Vec::new(),
            sphere_tree: Tree::default(),
            sphere_slots: Vec::new(),
            bounds: None,
            kernel: KernelChoice::best(),
        };
        let any_smooth = parts.iter().any(|p| matches!(p, Part::Mesh { smooth: true, .. }));
        geometry.reserve(&parts, any_smooth);
        let mut object_of_sphere = Vec::new();
        let mut points = Vec::new();
        for (object, part) in parts.into_iter().enumerate() {
            match part {
                Part::Mesh { mesh, smooth } => geometry.add_mesh(object as u32, &mesh, smooth, any_smooth),
                Part::Sphere { center, radius } => {
                    geometry.ranges.push(ObjectRange::Sphere(geometry.spheres.len() as u32));
                    geometry.spheres.push(Sphere { center: center - origin, radius });
                    object_of_sphere.push(object as u32);
                }
                Part::Point(position) => {
                    let none = geometry.triangles.len() as u32;
                    geometry.ranges.push(ObjectRange::Triangles(none..none));
                    points.push((position - origin).as_vec3());
                }
            }
        }
        // Spheres come after the triangles, whose number is known only now.
        let triangles = geometry.triangles.len() as u32;
        geometry.object_of_primitive.extend(object_of_sphere);
        for range in &mut geometry.ranges {
            if let ObjectRange::Sphere(id) = range {
                *id += triangles;
            }
        }
        geometry.bounds_of_objects = geometry.ranges.par_iter().map(|range| geometry.measure_bounds(range)).collect();
        geometry.build_trees(&points, earlier.filter(|earlier| earlier.ranges == geometry.ranges));
        geometry
    }

    /// Room for exactly what `parts` bring: vectors that grow keep up to twice of what they need.
    fn reserve(&mut self, parts: &[Part], any_smooth: bool) {
        let meshes =
            || parts.iter().filter_map(|part| if let Part::Mesh { mesh, .. } = part { Some(mesh) } else { None });
        let vertices: usize = meshes().map(|mesh| mesh.positions.len()).sum();
        let triangles: usize = meshes().map(|mesh| mesh.triangles.len()).sum();
        self.positions.reserve_exact(vertices);
        self.normals.reserve_exact(if any_smooth { vertices } else { 0 });
        self.triangles.reserve_exact(triangles);
        self.areas.reserve_exact(triangles);
        let spheres = parts.iter().filter(|part| matches!(part, Part::Sphere { .. })).count();
        self.object_of_primitive.reserve_exact(triangles + spheres);
    }

    fn add_mesh(&mut self, object: u32, mesh: &Mesh, smooth: bool, any_smooth: bool) {
        let first_vertex = self.positions.len() as u32;
        let first_triangle = self.triangles.len() as u32;
        let origin = self.origin;
        self.positions.par_extend(mesh.positions.par_iter().map(|&p| (p - origin).as_vec3()));
        if any_smooth {
            if smooth && mesh.normals.len() == mesh.positions.len() {
                self.normals.par_extend(mesh.normals.par_iter().map(|n| n.as_vec3()));
            } else {
                // Zero: the face's own normal.
                self.normals.resize(self.positions.len(), Vec3::ZERO);
            }
        }
        self.triangles.par_extend(mesh.triangles.par_iter().map(|t| t.map(|i| i + first_vertex)));
        self.object_of_primitive.resize(self.triangles.len(), object);
        let range = first_triangle..self.triangles.len() as u32;
        let mut areas = std::mem::take(&mut self.areas);
        areas.par_extend(range.clone().into_par_iter().map(|id| self.primitive_area(id)));
        let mut sum = 0.0;
        for area in &mut areas[first_triangle as usize..] {
            sum += *area;
            *area = sum;
        }
        self.areas = areas;
        self.ranges.push(ObjectRange::Triangles(range));
    }

    /// The bounding sphere, where there are primitives, is around `points` too. `earlier` has the same primitives in other places.
    fn build_trees(&mut self, points: &[Vec3], earlier: Option<&Self>) {
        let corners = |t: &[u32; 3]| t.map(|i| self.positions[i as usize]);
        let boxes: Vec<Bounds> = self.triangles.par_iter().map(|t| Bounds::of(corners(t))).collect();
        let (of_triangles, of_spheres) = self.object_of_primitive.split_at(self.triangles.len());
        let refitted = earlier.and_then(|earlier| {
            let ids = |slot: u32| earlier.packs[slot as usize].ids.into_iter().filter(|id| *id != NO_PRIMITIVE);
            earlier
                .triangle_tree
                .refitted(&boxes, ids)
                .map(|tree| (tree, earlier.packs.iter().map(|pack| pack.ids).collect()))
        });
        let (tree, slots): (Tree, Vec<[u32; PACK]>) = refitted.unwrap_or_else(|| {
            let (tree, slots) = Tree::build(&boxes, of_triangles, PACK);
            (tree, slots.primitives.as_chunks().0.to_vec())
        });
        let union = |boxes: &[Bounds]| boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let of_chunks: Vec<Bounds> = boxes.par_chunks(BOUNDS_CHUNK).map(union).collect();
        drop(boxes);
        self.packs = (slots.par_iter())
            .map(|ids| {
                let mut pack = TrianglePack::EMPTY;
                for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != u32::MAX) {
                    pack.set(lane, id, corners(&self.triangles[id as usize]));
                }
                pack
            })
            .collect();
        self.triangle_tree = tree;

        let sphere_boxes: Vec<Bounds> = (self.spheres.iter())
            .map(|s| {
                // Rounded to f32 and grown by the tree's own margin, which covers that rounding.
                let (min, max) = (s.center - s.radius, s.center + s.radius);
                Bounds::of([min.as_vec3(), max.as_vec3()])
            })
            .collect();
        let (tree, slots) = Tree::build(&sphere_boxes, of_spheres, 1);
        self.sphere_tree = tree;
        self.sphere_slots = slots.primitives;

        let all = union(&of_chunks).union(union(&sphere_boxes));
        self.bounds = (!all.is_empty()).then(|| {
            let all = points.iter().fold(all, |all, &point| all.union(Bounds::of([point; 3])));
            let (min, max) = (all.min.as_dvec3(), all.max.as_dvec3());
            Sphere { center: (min + max) / 2.0, radius: (max - min).length() / 2.0 }
        });
    }

    /// Searches with another kernel than the fastest, for comparisons: what is found is the same.
    ///
    /// # Panics
    ///
    /// Unless the kernel is one of those [`KernelChoice::available`].
    pub fn set_kernel(&mut self, kernel: KernelChoice) {
        assert!(KernelChoice::available().contains(&kernel), "this processor cannot run {kernel:?}");
        self.kernel = kernel;
    }

    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub fn sphere_count(&self) -> usize {
        self.spheres.len()
    }

    /// Calls `visit` for every primitive that may meet the box from `min` to `max` (local coordinates), in no particular order: those that
    /// meet it and some that lie near it. Primitives of the object `except` may be left out.
    pub fn for_each_near_box(&self, min: DVec3, max: DVec3, except: Option<u32>, mut visit: impl FnMut(PrimitiveId)) {
        let _ = self.search_near_box(min, max, except, |primitive| {
            visit(primitive);
            ControlFlow::Continue(())
        });
    }

    /// [`Self::for_each_near_box`], until `visit` breaks.
    pub fn search_near_box(
        &self,
        min: DVec3,
        max: DVec3,
        except: Option<u32>,
        mut visit: impl FnMut(PrimitiveId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let except = except.unwrap_or(u32::MAX);
        self.triangle_tree.visit_box(min, max, except, |slot| {
            self.packs[slot as usize].ids.into_iter().filter(|id| *id != NO_PRIMITIVE).try_for_each(&mut visit)
        })?;
        self.sphere_tree
            .visit_box(min, max, except, |slot| visit(self.sphere_slots[slot as usize] + self.triangles.len() as u32))
    }

    /// The surface at a hit of `ray`. The position is taken from the primitive, not from the ray.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let primitive = hit.primitive;
        if let Some(sphere) = self.sphere(primitive) {
            let position = sphere.project(ray.at(hit.t));
            SurfacePoint { position, normal: (position - sphere.center) / sphere.radius, primitive }
        } else {
            let corners = self.corners(primitive);
            let [v, w] = hit.barycentric;
            SurfacePoint {
                position: corners[0] * (1.0 - v - w) + corners[1] * v + corners[2] * w,
                normal: triangle::area_vector(corners).normalize_or_zero(),
                primitive,
            }
        }
    }

    /// The interpolated unit normal at a hit, on the outward side; the geometric `normal` where there is none to interpolate.
    #[inline]
    pub fn shading_normal(&self, hit: &Hit, normal: DVec3) -> DVec3 {
        if self.normals.is_empty() || hit.primitive as usize >= self.triangles.len() {
            return normal;
        }
        let corners = self.triangles[hit.primitive as usize].map(|i| self.normals[i as usize].as_dvec3());
        let [v, w] = hit.barycentric;
        let shading = (corners[0] * (1.0 - v - w) + corners[1] * v + corners[2] * w).normalize_or(normal);
        if shading.dot(normal) > 0.0 { shading } else { normal }
    }

    /// Index of the object that a primitive belongs to.
    #[inline]
    pub fn object_of(&self, primitive: PrimitiveId) -> u32 {
        self.object_of_primitive[primitive as usize]
    }

    /// The primitives of an object.
    pub fn range(&self, object: u32) -> &ObjectRange {
        &self.ranges[object as usize]
    }

    /// The sphere of that id, if it is one.
    #[inline]
    pub fn sphere(&self, primitive: PrimitiveId) -> Option<&Sphere> {
        (primitive as usize).checked_sub(self.triangles.len()).map(|index| &self.spheres[index])
    }

    /// The sphere that an object is, if it is one.
    #[inline]
    pub fn sphere_of(&self, object: u32) -> Option<&Sphere> {
        match self.range(object) {
            ObjectRange::Sphere(id) => self.sphere(*id),
            ObjectRange::Triangles(_) => None,
        }
    }

    /// Corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: PrimitiveId) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| self.positions[i as usize].as_dvec3())
    }

    /// Unit outward normal of a triangle; zero where it has no area.
    pub fn face_normal(&self, triangle: PrimitiveId) -> DVec3 {
        triangle::area_vector(self.corners(triangle)).normalize_or_zero()
    }

    /// Normals at the corners of a triangle, zero where there are none to interpolate.
    pub fn corner_normals(&self, triangle: PrimitiveId) -> [Vec3; 3] {
        if self.normals.is_empty() {
            return [Vec3::ZERO; 3];
        }
        self.triangles[triangle as usize].map(|i| self.normals[i as usize])
    }

    /// The analytic spheres, whose ids follow those of the triangles.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// A sphere around everything; `None` where there are no primitives.
    #[inline]
    pub fn bounding_sphere(&self) -> Option<&Sphere> {
        self.bounds.as_ref()
    }

    /// Lowest and highest coordinates of an object; the highest first, and infinite, where it has no primitives.
    pub fn bounds_of(&self, object: u32) -> (DVec3, DVec3) {
        self.bounds_of_objects[object as usize]
    }

    /// Half of the longest side of an object's box, which its precision is measured by; 0 where it has no primitives.
    pub fn radius_of(&self, object: u32) -> f64 {
        let (min, max) = self.bounds_of(object);
        ((max - min).max_element() / 2.0).max(0.0)
    }

    /// The largest magnitude of an object's local coordinates; 0 where it has no primitives.
    pub fn reach_of(&self, object: u32) -> f64 {
        let (min, max) = self.bounds_of(object);
        if min.x <= max.x { min.abs().max(max.abs()).max_element() } else { 0.0 }
    }

    fn measure_bounds(&self, range: &ObjectRange) -> (DVec3, DVec3) {
        const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        match range {
            ObjectRange::Sphere(id) => self.sphere(*id).map_or(NOTHING, |s| (s.center - s.radius, s.center + s.radius)),
            ObjectRange::Triangles(range) => {
                let union = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
                let of_chunk = |chunk: &[[u32; 3]]| {
                    let corners = chunk.iter().flatten().map(|&i| self.positions[i as usize].as_dvec3());
                    corners.fold(NOTHING, |bounds, p| union(bounds, (p, p)))
                };
                let triangles = &self.triangles[range.start as usize..range.end as usize];
                let of_chunks: Vec<_> = triangles.par_chunks(BOUNDS_CHUNK).map(of_chunk).collect();
                of_chunks.into_iter().fold(NOTHING, union)
            }
        }
    }

    /// Number of primitives of an object.
    pub fn face_count(&self, object: u32) -> u32 {
        match self.range(object) {
            ObjectRange::Triangles(range) => range.len() as u32,
            ObjectRange::Sphere(_) => 1,
        }
    }

    /// Surface area of an object, in scene units squared.
    pub fn area(&self, object: u32) -> f64 {
        match self.range(object) {
            ObjectRange::Triangles(range) => range.clone().next_back().map_or(0.0, |last| self.areas[last as usize]),
            ObjectRange::Sphere(id) => {
                self.sphere(*id).map_or(0.0, |s| 4.0 * std::f64::consts::PI * s.radius * s.radius)
            }
        }
    }

    /// Surface area of a primitive, in scene units squared.
    pub fn primitive_area(&self, primitive: PrimitiveId) -> f64 {
        match self.sphere(primitive) {
            Some(sphere) => 4.0 * std::f64::consts::PI * sphere.radius * sphere.radius,
            None => 0.5 * triangle::area_vector(self.corners(primitive)).length(),
        }
    }

    /// A point of an object's surface, uniform by area, for `u` uniform in [0, 1)³. `None` when the object has no area.
    pub fn sample_surface(&self, object: u32, u: [f64; 3]) -> Option<SurfacePoint> {
        match self.range(object) {
            ObjectRange::Sphere(primitive) => self.sample_primitive(*primitive, [u[0], u[1]]),
            ObjectRange::Triangles(range) => {
                let areas = &self.areas[range.start as usize..range.end as usize];
                let total = *areas.last()?;
                let at = areas.partition_point(|&sum| sum <= u[0] * total).min(areas.len() - 1);
                self.sample_primitive(range.start + at as u32, [u[1], u[2]])
            }
        }
    }

    /// A point of a triangle or sphere, uniform by area, for `u` uniform in [0, 1)². `None` when it has no area.
    pub fn sample_primitive(&self, primitive: PrimitiveId, u: [f64; 2]) -> Option<SurfacePoint> {
        if let Some(sphere) = self.sphere(primitive) {
            let normal = uniform_direction(u);
            return Some(SurfacePoint { position: sphere.center + normal * sphere.radius, normal, primitive });
        }
        let corners = self.corners(primitive);
        // A square folded along its diagonal.
        let [mut v, mut w] = u;
        if v + w > 1.0 {
            (v, w) = (1.0 - v, 1.0 - w);
        }
        let normal = triangle::area_vector(corners).try_normalize()?;
        let position = corners[0] * (1.0 - v - w) + corners[1] * v + corners[2] * w;
        Some(SurfacePoint { position, normal, primitive })
    }
}

/// Uniform unit direction for `u` uniform in [0, 1)².
#[inline]
pub fn uniform_direction(u: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * u[1]).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}
