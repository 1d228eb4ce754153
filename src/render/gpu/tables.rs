//! A scene as the shaders read it: arrays of plain numbers, made on the CPU in f64 and rounded once.
//!
//! Lengths are multiplied by a power of two so that the objects in the middle of the scene have a size near 1: f32 has room on both sides, and a
//! scene that is enlarged by a power of two keeps every bit.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::layout;
use crate::geometry::binary::BinaryTree;
use crate::geometry::{Geometry, ObjectRange};
use crate::rectify::flat::FlatLayout;
use crate::rectify::planes::AskedPlanes;
use crate::scene::Albedo;
use crate::scene::lights::{EnvironmentLight, ImageTables, Light};
use crate::scene::texture::{LINEAR, SurfaceTexture, TextureCoordinates, TextureImage};
use crate::scene::{ObjectId, Scene, Surface};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Mode, Prepared};

/// No object, no primitive.
pub const NOTHING: u32 = u32::MAX;

/// Boxes grow by this share of their largest coordinate, beyond what they have grown by: see `geometry/search.wgsl`.
const BOX_MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// The square of a length up to this is no more than f32 holds.
const MOST_LENGTH: f32 = 1e18;

/// Media of which all pairs are kept.
const MOST_IN_PAIRS: usize = 64;

/// What lengths are multiplied by.
pub fn scale_of(geometry: &Geometry) -> f64 {
    if geometry.step > 0.0 && geometry.step.is_normal() { 1.0 / geometry.step } else { 1.0 }
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn rgb(spectrum: Spectrum) -> [f32; 3] {
    spectrum.to_rgb().map(|x| x as f32)
}

/// What follows from shapes and places.
#[derive(Debug, Default)]
pub struct GeometryTables {
    pub nodes: Vec<layout::Node>,
    pub triangles: Vec<layout::Triangle>,
    pub faces: Vec<layout::Face>,
    /// Empty where no object is smooth.
    pub corner_normals: Vec<layout::CornerNormals>,
    pub spheres: Vec<layout::Sphere>,
    pub root: u32,
    pub depth: u32,
    /// Whether squares of its lengths are more than f32 holds.
    pub is_too_large: bool,
    /// Where each triangle stands in `triangles`, by its id.
    pub slots: Vec<u32>,
}

impl GeometryTables {
    pub fn new(geometry: &Geometry, has_smooth: bool) -> Self {
        let scale = scale_of(geometry) as f32;
        let BinaryTree { nodes, triangles, root, depth } = geometry.binary_tree();
        let corners = |id: u32| geometry.corners(id).map(|corner| f32s(corner * f64::from(scale)));
        let mut slots = vec![0; triangles.len()];
        triangles.iter().enumerate().for_each(|(slot, id)| slots[*id as usize] = slot as u32);
        let primitives = (geometry.triangle_count() + geometry.sphere_count()) as u32;
        let mut tables = Self {
            nodes: nodes
                .par_iter()
                .map(|node| {
                    let [(min0, max0), (min1, max1)] = node.boxes.map(|(min, max)| grown(min * scale, max * scale));
                    let [child0, child1] = node.children;
                    layout::Node { min0, child0, max0, child1, min1, pad0: 0, max1, pad1: 0 }
                })
                .collect(),
            triangles: triangles
                .par_iter()
                .map(|&primitive| {
                    let [a, b, c] = corners(primitive);
                    layout::Triangle { a, primitive, b, object: geometry.object_of(primitive), c, pad: 0 }
                })
                .collect(),
            faces: (0..primitives)
                .into_par_iter()
                .map(|id| {
                    let is_triangle = (id as usize) < geometry.triangle_count();
                    let normal = if is_triangle { f32s(geometry.face_normal(id)) } else { [0.0; 3] };
                    layout::Face { normal, object: geometry.object_of(id) }
                })
                .collect(),
            corner_normals: if has_smooth {
                triangles
                    .par_iter()
                    .map(|&id| {
                        let [a, b, c] = geometry.corner_normals(id).map(|normal| normal.to_array());
                        layout::CornerNormals { a, pad0: 0, b, pad1: 0, c, pad2: 0 }
                    })
                    .collect()
            } else {
                Vec::new()
            },
            spheres: (geometry.spheres().iter())
                .map(|sphere| layout::Sphere {
                    center: f32s(sphere.center * f64::from(scale)),
                    radius: (sphere.radius * f64::from(scale)) as f32,
                })
                .collect(),
            root,
            depth,
            is_too_large: false,
            slots,
        };
        let fits = |v: &[f32; 3]| v.iter().all(|x| x.abs() < MOST_LENGTH);
        tables.is_too_large = !(tables.triangles.par_iter().all(|t| fits(&t.a) && fits(&t.b) && fits(&t.c))
            && tables.spheres.iter().all(|sphere| fits(&sphere.center) && sphere.radius < MOST_LENGTH));
        tables
    }

    /// Once they are uploaded, they only take memory.
    pub fn forget_arrays(&mut self) {
        let Self { root, depth, is_too_large, slots, .. } = std::mem::take(self);
        *self = Self { root, depth, is_too_large, slots, ..Self::default() };
    }
}

fn grown(min: Vec3, max: Vec3) -> ([f32; 3], [f32; 3]) {
    let margin = min.abs().max(max.abs()).max_element() * BOX_MARGIN;
    ((min - margin).to_array(), (max + margin).to_array())
}

/// The arrays of [`crate::rectify::flat`] one after the other, but for the answers, and where each begins.
#[derive(Debug, Default)]
pub struct FlatWords {
    pub words: Vec<u32>,
    pub address_of_primitive: u32,
    pub divided_faces: u32,
    pub cells: u32,
    pub asked: u32,
    pub members: u32,
    pub coincident: u32,
    pub coincident_planes: u32,
    pub opaque_planes: u32,
}

impl FlatWords {
    pub fn new(flat: &FlatLayout, planes: &AskedPlanes, scale: f64) -> Self {
        let mut words = flat.address_of_object.clone();
        let mut add = |more: &[u32]| {
            let first = words.len() as u32;
            words.extend_from_slice(more);
            first
        };
        let plane = |[a, b, c, d]: [f64; 4]| [a, b, c, d * scale].map(|x| (x as f32).to_bits());
        let plane_words = |planes: &[[[f64; 4]; 3]]| -> Vec<u32> {
            planes.iter().flatten().flat_map(|numbers| plane(*numbers)).collect()
        };
        let found = Self {
            address_of_primitive: add(&flat.address_of_primitive),
            divided_faces: add(bytemuck::cast_slice(&flat.faces)),
            cells: add(bytemuck::cast_slice(&flat.nodes)),
            asked: add(bytemuck::cast_slice(&flat.asked)),
            members: add(bytemuck::cast_slice(&flat.members)),
            coincident: add(bytemuck::cast_slice(&flat.coincident)),
            coincident_planes: add(&plane_words(&planes.coincident)),
            opaque_planes: add(&plane_words(&planes.opaque)),
            words: Vec::new(),
        };
        Self { words, ..found }
    }
}

/// What lights are looked up and sampled by, in one array of words, and where each part begins.
#[derive(Debug, Default)]
pub struct LightTables {
    pub words: Vec<u32>,
    /// Of each emitter, in order, where its words begin: of one that is a mesh the running sums of its triangles' areas, from 0 to 1, and behind them the triangles' slots.
    pub areas: Vec<u32>,
    pub texels: u32,
    pub columns: u32,
    pub rows: u32,
    pub row_shares: u32,
    pub guide: u32,
    pub cuts_per_row: u32,
    pub image_size: [u32; 2],
    pub rotation: [f32; 2],
    pub image_scale: f32,
    pub linear_light: u32,
    /// By object: where its texture is described, if it has one.
    pub textures: HashMap<ObjectId, u32>,
}

impl LightTables {
    pub fn new(scene: &Scene, slots: &[u32]) -> Self {
        let mut tables = Self { rotation: [0.0, 1.0], image_size: [1, 1], ..Self::default() };
        for (light, _) in scene.emitters.iter() {
            tables.areas.push(tables.words.len() as u32);
            if let Light::Area(light) = light
                && let ObjectRange::Triangles(range) = scene.geometry.range(light.object.0)
            {
                let mut sum = 0.0;
                let sums = range.clone().map(|id| {
                    sum += scene.geometry.primitive_area(id);
                    ((sum / light.area) as f32).to_bits()
                });
                tables.words.extend(sums);
                tables.words.extend(range.clone().map(|id| slots[id as usize]));
            }
        }
        if let Some(light) = scene.environment.image() {
            tables.add_image(&light.tables());
        }
        tables.add_textures(scene);
        tables
    }

    /// Images of solids, each once, and what describes them on each solid: see `scene/texture.wgsl`.
    fn add_textures(&mut self, scene: &Scene) {
        let textures: Vec<(ObjectId, &SurfaceTexture)> = (0..scene.objects.len() as u32)
            .filter_map(|index| Some((ObjectId(index), &**scene.albedo(ObjectId(index))?.texture()?)))
            .collect();
        if textures.is_empty() {
            return;
        }
        self.linear_light = self.words.len() as u32;
        self.words.extend(LINEAR.iter().map(|value| value.to_bits()));
        let mut images: HashMap<*const TextureImage, u32> = HashMap::new();
        for (object, texture) in textures {
            let image = &texture.image;
            let texels = *images.entry(Arc::as_ptr(image)).or_insert_with(|| {
                let first = self.words.len() as u32;
                self.words.extend(image.texels().iter().map(|texel| u32::from_le_bytes(*texel)));
                first
            });
            // As if there were coordinates for all primitives.
            let mut uvs = 0;
            if let ObjectRange::Triangles(range) = scene.geometry.range(object.0) {
                uvs = (self.words.len() as u32).wrapping_sub(range.start.wrapping_mul(6));
                let corners = range.clone().map(|id| texture.corner_uvs(id).unwrap_or_default());
                self.words.extend(corners.flatten().flat_map(|uv| uv.as_vec2().to_array().map(f32::to_bits)));
            }
            self.textures.insert(object, self.words.len() as u32);
            self.words.extend([texels, image.width() as u32, image.height() as u32, uvs]);
            self.words.extend(texture.transform.to_cols_array().map(|x| (x as f32).to_bits()));
        }
    }

    fn add_image(&mut self, light: &ImageTables<'_>) {
        let ImageTables { image, rotation: (sin, cos), scale, columns, rows, cuts_per_row, cuts } = *light;
        self.image_size = [image.width as u32, image.height as u32];
        self.rotation = [sin as f32, cos as f32];
        self.image_scale = scale as f32;
        self.cuts_per_row = cuts_per_row as u32;
        let words = &mut self.words;
        let mut add = |more: &mut dyn Iterator<Item = u32>| {
            let first = words.len() as u32;
            words.extend(more);
            first
        };
        self.texels = add(&mut image.pixels.iter().flatten().map(|x| x.to_bits()));
        self.columns = add(&mut columns.iter().map(|x| x.to_bits()));
        self.rows = add(&mut rows.iter().map(|x| (*x as f32).to_bits()));
        let share = |row: usize| rows[row] - if row > 0 { rows[row - 1] } else { 0.0 };
        self.row_shares = add(&mut (0..rows.len()).map(|row| (share(row) as f32).to_bits()));
        self.guide = add(&mut cuts.iter().copied());
    }
}

/// What an edit of media, priorities, colours or lights changes: kilobytes.
#[derive(Debug, Default)]
pub struct AnswerTables {
    pub answers: Vec<u32>,
    /// Where in `answers` the mask begins.
    pub mask: u32,
    pub objects: Vec<layout::Object>,
    pub media: Vec<layout::Medium>,
    pub interfaces: Vec<layout::Interface>,
    pub emitters: Vec<layout::Emitter>,
    /// The first emitter from afar that has an extent.
    pub first_sun: u32,
    pub pairs_of_media: u32,
}

impl AnswerTables {
    /// With what lies outside of objects in a mode that asks.
    pub fn new(prepared: &Prepared, lights: &LightTables, outsides_of: Option<Mode>) -> Self {
        let (scene, table) = (&*prepared.scene, &*prepared.table);
        let scale = scale_of(&scene.geometry);
        let mut answers: Vec<u32> =
            table.flat().answers.iter().flat_map(|answer| [answer.outside.0, answer.inside.0]).collect();
        let mask = answers.len() as u32;
        if let Some(masked) = table.mask() {
            answers.extend(masked.words());
            // Up to the last primitive there is a bit for each.
            let primitives = scene.geometry.triangle_count() + scene.geometry.sphere_count();
            answers.resize(answers.len().max(mask as usize + primitives.div_ceil(32)), 0);
        }
        let outsides = match outsides_of {
            Some(Mode::Declared) => scene.declared.outsides(),
            Some(_) => table.object_table(scene).outsides(scene),
            None => Vec::new(),
        };
        let outside = |object: usize| outsides.get(object).map_or(NOTHING, |medium| medium.0);
        let pairs_of_media = if scene.media.len() <= MOST_IN_PAIRS { scene.media.len() } else { 0 };
        let pairs = (0..pairs_of_media as u32).flat_map(|from| (0..pairs_of_media as u32).map(move |to| (from, to)));
        let mut emitter_of = vec![NOTHING; scene.objects.len()];
        let mut cumulative = 0.0;
        let mut emitters = Vec::new();
        let is_sun: Vec<bool> = (scene.emitters.iter())
            .map(|(light, _)| matches!(light, Light::Directional(light) if !light.is_delta()))
            .collect();
        for (index, (light, probability)) in scene.emitters.iter().enumerate() {
            let Some(object) = light.object() else { continue };
            emitter_of[object.0 as usize] = index as u32;
            cumulative += probability;
            emitters.push(layout::Emitter {
                object: object.0,
                first: lights.areas[index],
                probability: probability as f32,
                cumulative: cumulative as f32,
                ..emitter(scene, light, scale)
            });
        }
        // Each sun names the next one.
        let mut first_sun = NOTHING;
        for index in (0..emitters.len()).rev().filter(|&index| is_sun[index]) {
            emitters[index].next_sun = std::mem::replace(&mut first_sun, index as u32);
        }
        Self {
            answers,
            mask,
            objects: (0..scene.objects.len())
                .map(|index| {
                    let id = ObjectId(index as u32);
                    let texture = lights.textures.get(&id).copied().unwrap_or(NOTHING);
                    object(scene, id, emitter_of[index], outside(index), texture, scale)
                })
                .collect(),
            media: (scene.media.iter())
                .map(|medium| {
                    let high = medium.ior_minus_one as f32;
                    let low = (medium.ior_minus_one - f64::from(high)) as f32;
                    let absorption = medium.absorption.to_rgb().map(|sigma| (sigma / scale) as f32);
                    layout::Medium { absorption, pad0: 0, ior_minus_one: [high, low], pad1: [0; 2] }
                })
                .collect(),
            interfaces: pairs
                .map(|(from, to)| {
                    let between =
                        scene.interface(crate::scene::MediumId(from), crate::scene::MediumId(to), Wavelengths::Rgb);
                    let [eta, inverse_eta, e] = between.numbers().map(|x| x as f32);
                    layout::Interface { eta, inverse_eta, e, radiance_factor: between.radiance_factor() as f32 }
                })
                .collect(),
            emitters,
            first_sun,
            pairs_of_media: pairs_of_media as u32,
        }
    }
}

/// What a light is sampled by; where it stands in tables, and how likely it is, are left open.
fn emitter(scene: &Scene, light: Light<'_>, scale: f64) -> layout::Emitter {
    let mut emitter =
        layout::Emitter { sphere: NOTHING, next_sun: NOTHING, ..<layout::Emitter as bytemuck::Zeroable>::zeroed() };
    // Per area of the scene as it is scaled here.
    let scaled = |intensity: Spectrum| rgb(intensity * (scale * scale));
    match light {
        Light::Area(light) => {
            emitter.sphere = sphere_index(scene, light.object);
            if let ObjectRange::Triangles(range) = scene.geometry.range(light.object.0) {
                emitter.triangle_count = range.len() as u32;
            }
            emitter.area = (light.area * scale * scale) as f32;
            emitter.color = rgb(light.radiance);
            emitter.is_two_sided = u32::from(light.two_sided);
        }
        Light::Point(light) => {
            (emitter.kind, emitter.position, emitter.color) =
                (1, f32s(light.position * scale), scaled(light.intensity));
        }
        Light::Spot(light) => {
            (emitter.kind, emitter.position, emitter.color) =
                (2, f32s(light.position * scale), scaled(light.intensity));
            emitter.axis = f32s(light.axis);
            [emitter.inner, emitter.outer] = light.edges().map(|x| x as f32);
        }
        Light::Directional(light) => {
            (emitter.kind, emitter.axis, emitter.outer) = (3, f32s(light.to_light), light.one_minus_cos() as f32);
            emitter.color = rgb(if light.is_delta() { light.irradiance } else { light.disc_radiance() });
        }
        Light::Environment(_) => {}
    }
    emitter
}

/// The index of the sphere that an object is.
fn sphere_index(scene: &Scene, object: ObjectId) -> u32 {
    match scene.geometry.range(object.0) {
        ObjectRange::Sphere(id) => id - scene.geometry.triangle_count() as u32,
        ObjectRange::Triangles(_) => NOTHING,
    }
}

/// `texture`: where its image is described, if it has one.
fn object(scene: &Scene, id: ObjectId, emitter: u32, outside: u32, texture: u32, scale: f64) -> layout::Object {
    let mut object = layout::Object {
        reach: (scene.geometry.reach_of(id.0) * scale) as f32,
        emitter,
        sphere: sphere_index(scene, id),
        outside,
        texture: NOTHING,
        ..bytemuck::Zeroable::zeroed()
    };
    let mut paint = |albedo: &Albedo| match *albedo {
        Albedo::Color(color) => object.color = rgb(color),
        Albedo::Texture(ref image) => {
            (object.color, object.is_varied, object.texture) = (rgb(image.tint), 1, texture);
            if let TextureCoordinates::Spherical { object_from_world } = &image.coordinates {
                // Directions are turned, whatever their length.
                let rows = object_from_world.transpose();
                let length = rows.x_axis.length();
                object.checker_origin = f32s(rows.x_axis / length);
                (object.u_axis, object.v_axis) = (f32s(rows.y_axis / length), f32s(rows.z_axis / length));
            }
        }
        Albedo::Checker { a, b, origin, u_axis, v_axis } => {
            (object.color, object.other_color, object.is_varied) = (rgb(a), rgb(b), 1);
            object.checker_origin = f32s(origin * scale);
            (object.u_axis, object.v_axis) = (f32s(u_axis / scale), f32s(v_axis / scale));
        }
    };
    match &scene.object(id).surface {
        Surface::Refractor { medium, priority, smooth } => {
            (object.medium, object.priority, object.is_smooth) = (medium.0, *priority, u32::from(*smooth));
        }
        Surface::Diffuse { albedo, smooth } => {
            paint(albedo);
            (object.kind, object.is_smooth) = (1, u32::from(*smooth));
        }
        Surface::Mirror { albedo, smooth } => {
            paint(albedo);
            (object.kind, object.is_smooth) = (2, u32::from(*smooth));
        }
        Surface::Light { radiance, .. } => (object.kind, object.color) = (3, rgb(*radiance)),
    }
    object
}

/// The structure that says where everything is.
pub fn scene_of(
    scene: &Scene,
    geometry: &GeometryTables,
    flat: &FlatWords,
    lights: &LightTables,
    answers: &AnswerTables,
) -> layout::Scene {
    let scale = scale_of(&scene.geometry);
    let bounds = scene.geometry.bounding_sphere();
    let (zenith, horizon, nadir) = match &scene.environment {
        EnvironmentLight::Constant(color) => ([0.0; 3], rgb(*color), [0.0; 3]),
        EnvironmentLight::Gradient { zenith, horizon, nadir } => (rgb(*zenith), rgb(*horizon), rgb(*nadir)),
        EnvironmentLight::Image(_) => ([0.0; 3], [0.0; 3], [0.0; 3]),
    };
    layout::Scene {
        root: geometry.root,
        triangle_count: geometry.slots.len() as u32,
        mask: answers.mask,
        pairs_of_media: answers.pairs_of_media,
        bounds_center: bounds.map_or([0.0; 3], |bounds| f32s(bounds.center * scale)),
        bounds_radius: bounds.map_or(0.0, |bounds| (bounds.radius * scale) as f32),
        address_of_primitive: flat.address_of_primitive,
        divided_faces: flat.divided_faces,
        cells: flat.cells,
        asked: flat.asked,
        members: flat.members,
        coincident: flat.coincident,
        coincident_planes: flat.coincident_planes,
        opaque_planes: flat.opaque_planes,
        emitter_count: answers.emitters.len() as u32,
        world_is_vacuum: u32::from(scene.world_is_vacuum),
        texels: lights.texels,
        columns: lights.columns,
        rows: lights.rows,
        row_shares: lights.row_shares,
        guide: lights.guide,
        cuts_per_row: lights.cuts_per_row,
        image_size: lights.image_size,
        rotation: lights.rotation,
        zenith,
        image_scale: lights.image_scale,
        horizon,
        first_sun: answers.first_sun,
        nadir,
        linear_light: lights.linear_light,
    }
}

/// What f32 does not hold of the numbers and of the squares of lengths; `None`: it holds all.
pub fn too_large_for_f32(
    geometry: &GeometryTables,
    scene: &layout::Scene,
    answers: &AnswerTables,
) -> Option<&'static str> {
    let is_finite = |v: &[f32; 3]| v.iter().all(|x| x.is_finite());
    let fits = |v: &[f32; 3]| v.iter().all(|x| x.abs() < MOST_LENGTH);
    let colors = answers.objects.iter().all(|object| is_finite(&object.color) && is_finite(&object.other_color))
        && answers.emitters.iter().all(|emitter| is_finite(&emitter.color));
    let are_near = answers.emitters.iter().all(|emitter| fits(&emitter.position));
    let sky = [scene.zenith, scene.horizon, scene.nadir];
    if geometry.is_too_large || !are_near {
        Some("a scene so much larger than what is in its middle")
    } else if !colors || !sky.iter().all(is_finite) || !scene.image_scale.is_finite() {
        Some("light as bright as 3.4e38")
    } else if !answers.media.iter().all(|medium| is_finite(&medium.absorption)) {
        Some("absorption as strong as 3.4e38")
    } else {
        None
    }
}
