//! The scene as glTF 2.0, for viewers and modellers: volumes as objects, each with the index of its inside. glTF has no word for what lies
//! outside, so nothing is split.

use std::io::Cursor;
use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

use super::files::Bundle;
use super::pieces::{Piece, surface};
use super::scene::{Frame, Lamp, ResolvedScene, ThinWall};
use crate::color::srgb_from_linear;
use crate::formats::texture::to_png;
use crate::geometry::Mesh;
use crate::optics::Ior;
use crate::scene::Albedo;
use crate::scene::camera::Camera;
use crate::scene::texture::TextureImage;
use crate::scene::{MediumId, ObjectId, Surface};

/// Numbers of glTF for components and targets.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
/// The samplers: of chequers, and of images.
const NEAREST: usize = 0;
const LINEAR: usize = 1;

pub fn write(resolved: &ResolvedScene, frame: Frame) -> Bundle {
    let mut writer = Writer::new(resolved);
    writer.scene(frame);
    let mut files = Bundle::new(std::mem::take(&mut writer.notes));
    files.add_main("scene.glb", writer.finish());
    files
}

/// What materials of refractors differ by.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Dielectric {
    medium: MediumId,
    /// The root of α.
    roughness: f64,
    thin: bool,
}

struct Writer<'a> {
    resolved: &'a ResolvedScene,
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<Value>,
    /// Dielectrics that have a material.
    dielectrics: Vec<(Dielectric, usize)>,
    images: Vec<Value>,
    textures: Vec<Value>,
    /// Images of solids that have a texture.
    known_images: Vec<(Arc<TextureImage>, usize)>,
    lights: Vec<Value>,
    cameras: Vec<Value>,
    extensions: Vec<&'static str>,
    notes: Vec<String>,
}

impl<'a> Writer<'a> {
    fn new(resolved: &'a ResolvedScene) -> Self {
        Self {
            resolved,
            bytes: Vec::new(),
            views: Vec::new(),
            accessors: Vec::new(),
            meshes: Vec::new(),
            nodes: Vec::new(),
            materials: Vec::new(),
            dielectrics: Vec::new(),
            images: Vec::new(),
            textures: Vec::new(),
            known_images: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            extensions: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn scene(&mut self, frame: Frame) {
        let scene = self.resolved.scene();
        for (refractor, medium) in scene.refractors() {
            let Some(mesh) = surface(&self.resolved.prepared, refractor).map(Piece::into_mesh) else { continue };
            let thin = self.resolved.description().objects[refractor.0 as usize].refractor().is_some_and(|r| r.thin);
            let dielectric = Dielectric { medium, roughness: self.roughness(refractor), thin };
            let material = self.dielectric(dielectric, 2.0 * scene.geometry.radius_of(refractor.0));
            self.object(refractor, &mesh, &[], material);
        }
        for ThinWall { object, piece, inside: medium, .. } in &self.resolved.walls {
            let dielectric = Dielectric { medium: *medium, roughness: self.roughness(*object), thin: true };
            let material = self.dielectric(dielectric, 0.0);
            self.object(*object, &piece.clone().into_mesh(), &[], material);
        }
        for (object, piece) in &self.resolved.opaque {
            let (mesh, uv) = self.resolved.mesh_with_uv(*object, piece);
            let material = match self.resolved.emission(*object) {
                Some((radiance, two_sided)) => self.glowing(radiance, two_sided),
                None => self.solid(*object),
            };
            self.object(*object, &mesh, &uv, material);
        }
        self.lamps();
        self.camera(frame);
        let mut left_out = Vec::new();
        if !scene.environment.is_black() {
            left_out.push("the environment");
        }
        if scene.medium(MediumId::WORLD).ior_minus_one != 0.0 {
            left_out.push("the global medium's index");
        }
        if scene.refractors().any(|(refractor, _)| scene.priority(refractor) != 0) {
            left_out.push("priorities");
        }
        if !left_out.is_empty() {
            self.notes.push(format!("glTF has no place for {}, which is left out", left_out.join(" and ")));
        }
    }

    /// Adds a mesh and a node for it.
    fn object(&mut self, object: ObjectId, mesh: &Mesh, uv: &[[f64; 2]], material: usize) {
        let origin_is_far = mesh.positions.iter().any(|p| p.as_vec3().as_dvec3() != *p);
        // Relative to the middle of the mesh, so that single precision is enough.
        let middle = if origin_is_far { middle_of(mesh).as_vec3().as_dvec3() } else { DVec3::ZERO };
        let positions: Vec<f32> = mesh.positions.iter().flat_map(|p| (*p - middle).as_vec3().to_array()).collect();
        let bound = |pick: fn(f32, f32) -> f32, from: f32| {
            [0, 1, 2].map(|axis| positions.iter().skip(axis).step_by(3).fold(from, |a, b| pick(a, *b)))
        };
        let (min, max) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let position = self.floats(&positions, 3);
        (self.accessors[position]["min"], self.accessors[position]["max"]) = (json!(min), json!(max));
        let mut attributes = json!({ "POSITION": position });
        if mesh.normals.len() == mesh.positions.len() {
            let normals: Vec<f32> = mesh.normals.iter().flat_map(|n| n.as_vec3().to_array()).collect();
            attributes["NORMAL"] = json!(self.floats(&normals, 3));
        }
        if !uv.is_empty() {
            let has_image = matches!(self.resolved.albedo(object), Some(Albedo::Texture(_)));
            // glTF has v downwards.
            let down = |v: f64| if has_image { 1.0 - v } else { v };
            let uv: Vec<f32> = uv.iter().flat_map(|[u, v]| [*u as f32, down(*v) as f32]).collect();
            attributes["TEXCOORD_0"] = json!(self.floats(&uv, 2));
        }
        let corners: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()).collect();
        let view = self.view(&corners, Some(INDICES));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * mesh.triangles.len(), "type": "SCALAR",
        }));
        let indices = self.accessors.len() - 1;
        let name = &self.resolved.scene().object(object).name;
        self.meshes.push(json!({
            "name": name,
            "primitives": [{ "attributes": attributes, "indices": indices, "material": material }],
        }));
        let mut node = json!({ "name": name, "mesh": self.meshes.len() - 1 });
        if middle != DVec3::ZERO {
            node["translation"] = json!(middle.to_array());
        }
        self.nodes.push(node);
    }

    /// Bytes of the buffer, and the number of their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.views.len() - 1
    }

    fn floats(&mut self, values: &[f32], width: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(VERTICES));
        let kind = if width == 2 { "VEC2" } else { "VEC3" };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / width, "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn uses(&mut self, extension: &'static str) {
        if !self.extensions.contains(&extension) {
            self.extensions.push(extension);
        }
    }

    fn material(&mut self, material: Value) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// glTF's roughness of an object, the root of α.
    fn roughness(&mut self, object: ObjectId) -> f64 {
        let [u, v] = self.resolved.roughness(object);
        if u != v {
            let name = &self.resolved.scene().object(object).name;
            self.notes
                .push(format!("`{name}`: glTF has one roughness for both ways along a surface: it is their mean"));
        }
        // α of the mean is the geometric mean.
        if u == v { u.sqrt() } else { (u * v).sqrt().sqrt() }
    }

    /// The material of a dielectric. `thickness` is what viewers take for it that do not trace rays.
    fn dielectric(&mut self, dielectric: Dielectric, thickness: f64) -> usize {
        if let Some((_, known)) = self.dielectrics.iter().find(|(known, _)| *known == dielectric) {
            return *known;
        }
        let Dielectric { medium, roughness, thin } = dielectric;
        let found = self.resolved.medium(medium);
        let absorption = found.absorption.to_rgb();
        let most = absorption.into_iter().fold(0.0, f64::max);
        // Light loses e^(−1) of the colour that is absorbed most.
        let mut volume = json!({ "thicknessFactor": thickness });
        if most > 0.0 {
            volume["attenuationDistance"] = json!(1.0 / most);
            volume["attenuationColor"] = json!(absorption.map(|a| (-a / most).exp()));
        }
        if found.ior() < 1.0 {
            self.notes.push(format!(
                "`{}` has an index of {}, glTF allows for none below 1: it is written as 1",
                found.name,
                found.ior()
            ));
        }
        let (name, ior) = (found.name.clone(), found.ior().max(1.0));
        let mut extensions = json!({
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_ior": { "ior": ior },
        });
        ["KHR_materials_transmission", "KHR_materials_ior"].into_iter().for_each(|extension| self.uses(extension));
        // Without a volume it is a thin wall.
        if !thin {
            extensions["KHR_materials_volume"] = volume;
            self.uses("KHR_materials_volume");
            if let Some(abbe) = self.abbe_number(medium) {
                extensions["KHR_materials_dispersion"] = json!({ "dispersion": 20.0 / abbe });
                self.uses("KHR_materials_dispersion");
            }
        }
        let material = self.material(json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": roughness,
            },
            "extensions": extensions,
        }));
        self.dielectrics.push((dielectric, material));
        material
    }

    /// Abbe's number of a medium that disperses, and what it does not say.
    fn abbe_number(&mut self, medium: MediumId) -> Option<f64> {
        let index = self.resolved.ior_of(medium);
        let abbe = index.abbe_number();
        let is_whole = matches!(index, Ior::Cauchy([_, _, 0.0])) && abbe.is_some();
        if index.is_dispersive() && !is_whole {
            let name = &self.resolved.medium(medium).name;
            self.notes.push(format!("`{name}`: glTF has Abbe's number for dispersion, and no formula"));
        }
        abbe
    }

    fn glowing(&mut self, radiance: [f64; 3], two_sided: bool) -> usize {
        let most = radiance.into_iter().fold(0.0, f64::max);
        let factor = radiance.map(|c| if most > 0.0 { c / most } else { 0.0 });
        self.uses("KHR_materials_emissive_strength");
        self.material(json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1 },
            "emissiveFactor": factor,
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": most } },
            "doubleSided": two_sided,
        }))
    }

    fn solid(&mut self, object: ObjectId) -> usize {
        let is_mirror = matches!(self.resolved.scene().object(object).surface, Surface::Mirror { .. });
        let (metallic, roughness) = if is_mirror { (1, self.roughness(object)) } else { (0, 1.0) };
        let mut surface = json!({ "metallicFactor": metallic, "roughnessFactor": roughness });
        match self.resolved.albedo(object) {
            Some(Albedo::Color(color)) => {
                let [r, g, b] = color.to_rgb();
                surface["baseColorFactor"] = json!([r, g, b, 1.0]);
            }
            Some(Albedo::Texture(texture)) => {
                let index = self.image_of(&texture.image);
                let [r, g, b] = texture.tint.to_rgb();
                surface["baseColorFactor"] = json!([r, g, b, 1.0]);
                surface["baseColorTexture"] = json!({ "index": index });
            }
            Some(Albedo::Checker { a, b, .. }) => {
                let image = self.chequers(a.to_rgb(), b.to_rgb());
                surface["baseColorTexture"] = json!({ "index": image });
            }
            None => {}
        }
        self.material(json!({ "pbrMetallicRoughness": surface, "doubleSided": true }))
    }

    /// A texture of two by two squares.
    fn chequers(&mut self, a: [f64; 3], b: [f64; 3]) -> usize {
        let byte = |color: [f64; 3]| {
            image::Rgb(color.map(|c| (srgb_from_linear(c as f32).clamp(0.0, 1.0) * 255.0).round() as u8))
        };
        let pixels = image::RgbImage::from_fn(2, 2, |x, y| byte(if x == y { a } else { b }));
        let mut png = Cursor::new(Vec::new());
        // Writing to memory does not fail.
        let _ = pixels.write_to(&mut png, image::ImageFormat::Png);
        self.texture(&png.into_inner(), NEAREST)
    }

    /// The texture of an image, which is written once.
    fn image_of(&mut self, image: &Arc<TextureImage>) -> usize {
        if let Some((_, texture)) = self.known_images.iter().find(|(known, _)| Arc::ptr_eq(known, image)) {
            return *texture;
        }
        let texture = self.texture(&to_png(image), LINEAR);
        self.known_images.push((Arc::clone(image), texture));
        texture
    }

    /// A texture of a PNG file with one of the samplers.
    fn texture(&mut self, png: &[u8], sampler: usize) -> usize {
        let view = self.view(png, None);
        self.images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
        self.textures.push(json!({ "sampler": sampler, "source": self.images.len() - 1 }));
        self.textures.len() - 1
    }

    fn lamps(&mut self) {
        for (object, lamp) in self.resolved.lamps() {
            let name = self.resolved.scene().object(object).name.clone();
            let (rgb, mut light, place, axis) = match lamp {
                Lamp::Point { position, intensity } => (intensity, json!({ "type": "point" }), position, None),
                Lamp::Spot { position, axis, intensity, half_angles: [inner, outer] } => {
                    let outer = outer.clamp(1e-3, 90.0).to_radians();
                    let inner = inner.to_radians().clamp(0.0, 0.999 * outer);
                    let cone = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
                    (intensity, json!({ "type": "spot", "spot": cone }), position, Some(axis))
                }
                Lamp::Directional { direction, irradiance, .. } => {
                    (irradiance, json!({ "type": "directional" }), DVec3::ZERO, Some(direction))
                }
            };
            let most = rgb.into_iter().fold(0.0, f64::max).max(1e-300);
            light["name"] = json!(name);
            light["color"] = json!(rgb.map(|c| c / most));
            light["intensity"] = json!(most);
            self.lights.push(light);
            let mut node = json!({
                "name": name,
                "translation": place.to_array(),
                "extensions": { "KHR_lights_punctual": { "light": self.lights.len() - 1 } },
            });
            if let Some(axis) = axis {
                // A light of glTF shines along −z.
                node["rotation"] =
                    json!(DQuat::from_rotation_arc(DVec3::NEG_Z, axis.normalize_or(DVec3::NEG_Y)).to_array());
            }
            self.nodes.push(node);
            self.uses("KHR_lights_punctual");
        }
        self.notes.extend(self.resolved.notes_of_lamps("glTF", false));
    }

    fn camera(&mut self, frame: Frame) {
        let described = self.resolved.description().camera;
        let Ok(camera) = Camera::new(&described) else { return };
        let yfov = described.vertical_fov.to_radians();
        self.cameras.push(json!({
            "type": "perspective",
            "perspective": {
                "yfov": yfov,
                "aspectRatio": f64::from(frame.width) / f64::from(frame.height),
                "znear": 1e-3 * self.resolved.reach(),
            },
        }));
        let turn = DQuat::from_mat3(&DMat3::from_cols(camera.right, camera.up, -camera.forward));
        self.nodes.push(json!({
            "name": "camera",
            "camera": 0,
            "translation": camera.position.to_array(),
            "rotation": turn.to_array(),
        }));
    }

    /// The file: a header, the description, and the buffer.
    fn finish(mut self) -> Vec<u8> {
        let mut root = json!({
            "asset": { "version": "2.0", "generator": concat!("iorect ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "name": self.resolved.description().name, "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
        });
        let textures = std::mem::take(&mut self.textures);
        // Both are repeated.
        let samplers = match textures.is_empty() {
            true => vec![],
            false => [9728, 9729].map(|filter| json!({ "magFilter": filter, "minFilter": filter })).to_vec(),
        };
        let buffers = if self.bytes.is_empty() { vec![] } else { vec![json!({ "byteLength": self.bytes.len() })] };
        for (name, list) in [
            ("nodes", std::mem::take(&mut self.nodes)),
            ("meshes", std::mem::take(&mut self.meshes)),
            ("materials", std::mem::take(&mut self.materials)),
            ("accessors", std::mem::take(&mut self.accessors)),
            ("bufferViews", std::mem::take(&mut self.views)),
            ("buffers", buffers),
            ("cameras", std::mem::take(&mut self.cameras)),
            ("images", std::mem::take(&mut self.images)),
            ("textures", textures),
            ("samplers", samplers),
        ] {
            // An empty list is not allowed.
            if !list.is_empty() {
                root[name] = Value::Array(list);
            }
        }
        if !self.extensions.is_empty() {
            root["extensionsUsed"] = json!(self.extensions);
        }
        if !self.lights.is_empty() {
            root["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut chunks = Vec::new();
        let mut chunk = |kind: &[u8; 4], bytes: &[u8]| {
            chunks.extend((bytes.len() as u32).to_le_bytes());
            chunks.extend(kind);
            chunks.extend(bytes);
        };
        chunk(b"JSON", &text);
        if !self.bytes.is_empty() {
            chunk(b"BIN\0", &self.bytes);
        }
        let mut file = b"glTF".to_vec();
        file.extend(2u32.to_le_bytes());
        file.extend((12 + chunks.len() as u32).to_le_bytes());
        file.extend(chunks);
        file
    }
}

fn middle_of(mesh: &Mesh) -> DVec3 {
    let around = |(min, max): (DVec3, DVec3), p: &DVec3| (min.min(*p), max.max(*p));
    let (min, max) = mesh.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), around);
    (min + max) / 2.0
}
