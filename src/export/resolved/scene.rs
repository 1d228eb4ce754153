//! A scene with every interface resolved: what the writers of all formats take, each in its own words.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use glam::{DVec3, Vec2};

use super::files::Bundle;
use super::pieces::{Interface, Piece, interfaces, surface, with_meshes};
use crate::formats::texture::to_png;
use crate::geometry::{Mesh, Ray};
use crate::optics::Ior;
use crate::rectify::start::start;
use crate::scene::Albedo;
use crate::scene::camera::Camera;
use crate::scene::description::{Description, Object, Paint, Shape, Solid};
use crate::scene::lights::Light;
use crate::scene::texture::{SurfaceTexture, TextureCoordinates, TextureImage, spherical_corners};
use crate::scene::{MediumId, ObjectId, Scene, SceneError, SceneMedium, Surface};
use crate::tracking::{Prepared, prepare};

/// The scene, its interfaces, and what cannot be said of it elsewhere.
pub struct ResolvedScene {
    pub prepared: Prepared,
    pub interfaces: Vec<Interface>,
    /// Solids, and lights with a surface.
    pub opaque: Vec<(ObjectId, Piece)>,
    /// Walls without an inside that are hidden here, and are written as what they are.
    pub walls: Vec<ThinWall>,
    pub camera_medium: MediumId,
    /// Short names of the objects' files, each once.
    names: Vec<String>,
    /// What is approximated, and what is left out.
    pub notes: Vec<String>,
}

/// A wall without an inside: light goes straight through it, and is reflected.
#[derive(Debug, Clone)]
pub struct ThinWall {
    pub object: ObjectId,
    pub piece: Piece,
    /// What it is made of.
    pub inside: MediumId,
    /// What is declared around it, or else the world.
    pub outside: MediumId,
}

/// A light without a surface, in scene coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lamp {
    Point {
        position: DVec3,
        intensity: [f64; 3],
    },
    /// Half angles in degrees, the inner one first; `axis` is a unit vector.
    Spot {
        position: DVec3,
        axis: DVec3,
        intensity: [f64; 3],
        half_angles: [f64; 2],
    },
    /// `direction` is that of the light's rays; `angle` is the full one that it is seen under, in degrees.
    Directional {
        direction: DVec3,
        irradiance: [f64; 3],
        angle: f64,
    },
}

/// The picture that a scene for another renderer asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    pub width: u32,
    pub height: u32,
    /// Of each pixel.
    pub samples: u32,
}

impl ResolvedScene {
    /// # Errors
    /// When the scene is impossible.
    pub fn new(description: &Arc<Description>) -> Result<Self, SceneError> {
        let (prepared, spheres) = with_meshes(description)?;
        let mut notes = Vec::new();
        if !spheres.is_empty() {
            notes.push(format!("{} became meshes, so that they can be cut where others cross them", list(&spheres)));
        }
        let crowded: Vec<String> = (prepared.table.crowded().into_iter())
            .map(|(object, _)| prepared.scene.object(object).name.clone())
            .collect();
        if !crowded.is_empty() {
            let what = "have faces that very many others meet, which are not cut: each has the media of its middle";
            notes.push(format!("{} {what}", list(&crowded)));
        }
        let scene = &*prepared.scene;
        let camera = Camera::new(&prepared.description.camera)?;
        let eye = Ray::new(camera.position - scene.geometry.origin, camera.forward);
        let camera_medium = start(scene, eye).medium;
        let is_opaque = |id: &ObjectId| !scene.is_refractor(*id);
        let opaque = (0..scene.objects.len() as u32)
            .map(ObjectId)
            .filter(is_opaque)
            .filter_map(|id| Some((id, surface(&prepared, id)?)))
            .collect();
        let interfaces = interfaces(&prepared);
        let names = file_names(scene);
        let walls = thin_walls(description)?;
        Ok(Self { interfaces, opaque, walls, camera_medium, names, notes, prepared })
    }

    pub fn scene(&self) -> &Scene {
        &self.prepared.scene
    }

    pub fn description(&self) -> &Description {
        &self.prepared.description
    }

    pub fn medium(&self, id: MediumId) -> &SceneMedium {
        self.scene().medium(id)
    }

    /// The index of a medium as the scene has it, at all wavelengths.
    pub fn ior_of(&self, id: MediumId) -> &Ior {
        const ONE: Ior = Ior::Constant(1.0);
        match id {
            MediumId::WORLD => &self.description().world.ior,
            id => id.0.checked_sub(2).and_then(|k| self.description().media.get(k as usize)).map_or(&ONE, |m| &m.ior),
        }
    }

    /// GGX's α of an object along u and v.
    pub fn roughness(&self, object: ObjectId) -> [f64; 2] {
        self.description().objects[object.0 as usize].roughness()
    }

    /// Media at interfaces whose index differs between wavelengths, by name.
    pub fn dispersive(&self) -> Vec<String> {
        let sides = self.interfaces.iter().flat_map(|interface| [interface.inside, interface.outside]);
        let sides = sides.chain(self.walls.iter().map(|wall| wall.inside));
        let media = sides.filter(|id| self.ior_of(*id).is_dispersive()).collect::<BTreeSet<_>>();
        media.into_iter().map(|id| self.medium(id).name.clone()).collect()
    }

    /// What is to be said of thin walls where `format` has a word for them.
    pub fn notes_of_walls(&self, format: &str) -> Vec<String> {
        let name = |object: &Object| object.name.clone();
        let hidden: Vec<String> = self.walls.iter().map(|wall| self.scene().object(wall.object).name.clone()).collect();
        let is_body = |object: &&Object| object.visible && object.refractor().is_some_and(|refractor| refractor.thin);
        let bodies: Vec<String> = self.description().objects.iter().filter(is_body).map(name).collect();
        let mut notes = Vec::new();
        if !hidden.is_empty() {
            notes.push(format!("{}: hidden here, and written as thin walls", list(&hidden)));
        }
        if !bodies.is_empty() {
            let advice = "hide what is to be a thin wall there";
            notes
                .push(format!("{}: thin walls are bodies in {format} as they are shown here; {advice}", list(&bodies)));
        }
        notes
    }

    /// A short name of an object, of letters, digits and dashes, that no other object has.
    pub fn name(&self, object: ObjectId) -> &str {
        &self.names[object.0 as usize]
    }

    /// The media that absorb and occur: those that need a description of their own.
    pub fn absorbing(&self) -> Vec<MediumId> {
        let mut all: Vec<MediumId> = (self.interfaces.iter())
            .flat_map(|interface| [interface.outside, interface.inside])
            .chain([self.camera_medium])
            .chain((0..self.scene().objects.len() as u32).map(|object| self.medium_around(ObjectId(object))))
            .filter(|medium| !self.medium(*medium).absorption.is_black())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    pub fn absorbs(&self, medium: MediumId) -> bool {
        !self.medium(medium).absorption.is_black()
    }

    /// What most of a light's surface lies in, or what a light without a surface stands in.
    pub fn medium_around(&self, light: ObjectId) -> MediumId {
        let patches = self.prepared.table.lights.iter().filter(|patch| patch.refractor == light);
        let largest = patches.filter(|patch| patch.outside.is_some()).max_by(|a, b| a.area.total_cmp(&b.area));
        largest.and_then(|patch| patch.outside).unwrap_or(MediumId::WORLD)
    }

    /// Lights without a surface, with their objects.
    pub fn lamps(&self) -> Vec<(ObjectId, Lamp)> {
        let origin = self.scene().geometry.origin;
        let shape = |id: ObjectId| &self.description().objects[id.0 as usize].shape;
        (self.scene().emitters.iter())
            .filter_map(|(light, _)| match light {
                Light::Point(light) => {
                    let (position, intensity) = (light.position + origin, light.intensity.to_rgb());
                    Some((light.object, Lamp::Point { position, intensity }))
                }
                Light::Spot(light) => {
                    let Shape::Spot { inner_angle, outer_angle, .. } = *shape(light.object) else { return None };
                    let (position, intensity) = (light.position + origin, light.intensity.to_rgb());
                    let half_angles = [inner_angle, outer_angle];
                    Some((light.object, Lamp::Spot { position, axis: light.axis, intensity, half_angles }))
                }
                Light::Directional(light) => {
                    let Shape::Directional { angle, .. } = *shape(light.object) else { return None };
                    let (direction, irradiance) = (-light.to_light, light.irradiance.to_rgb());
                    Some((light.object, Lamp::Directional { direction, irradiance, angle }))
                }
                Light::Area(_) | Light::Environment(_) => None,
            })
            .collect()
    }

    /// What is to be said of lights without a surface in `format`, whose suns have no extent. `has_other_edges`: its spots fade otherwise than here.
    pub fn notes_of_lamps(&self, format: &str, has_other_edges: bool) -> Vec<String> {
        let lamps = self.lamps();
        let names = |is_it: &dyn Fn(&Lamp) -> bool| -> Vec<String> {
            let some = lamps.iter().filter(|(_, lamp)| is_it(lamp));
            some.map(|(object, _)| self.scene().object(*object).name.clone()).collect()
        };
        let suns = names(&|lamp| matches!(lamp, Lamp::Directional { angle, .. } if *angle > 0.0));
        let spots = names(&|lamp| has_other_edges && matches!(lamp, Lamp::Spot { .. }));
        let of_suns = format!("suns have no extent in {format}; all of the light comes from one direction");
        let of_spots = format!("between their two angles spots fade otherwise in {format}");
        let note =
            |(names, what): (Vec<String>, String)| (!names.is_empty()).then(|| format!("{}: {what}", list(&names)));
        [(suns, of_suns), (spots, of_spots)].into_iter().filter_map(note).collect()
    }

    /// The mesh of something opaque, and its texture coordinates where it is chequered, two squares to a unit, or has an image.
    pub fn mesh_with_uv(&self, object: ObjectId, piece: &Piece) -> (Mesh, Vec<[f64; 2]>) {
        let mut mesh = piece.clone().into_mesh();
        let (origin, u_axis, v_axis) = match self.albedo(object) {
            Some(&Albedo::Checker { origin, u_axis, v_axis, .. }) => (origin, u_axis, v_axis),
            Some(Albedo::Texture(texture)) => {
                if let TextureCoordinates::Spherical { object_from_world } = &texture.coordinates {
                    let directions = |t: &[u32; 3]| t.map(|i| *object_from_world * mesh.normals[i as usize]);
                    let placed = |uv: [f32; 2]| texture.transform.transform_point2(Vec2::from(uv).as_dvec2());
                    let corners = |t| spherical_corners(directions(t)).map(|uv| placed(uv).as_vec2().to_array());
                    let uvs = mesh.triangles.iter().map(corners).collect();
                    mesh.uvs = uvs;
                }
                let (mesh, uv) = mesh.with_uv_of_positions();
                return (mesh, uv.into_iter().map(|pair| pair.map(f64::from)).collect());
            }
            _ => return (mesh, Vec::new()),
        };
        let from = self.scene().geometry.origin + origin;
        let uv = mesh.positions.iter().map(|p| [0.5 * (*p - from).dot(u_axis), 0.5 * (*p - from).dot(v_axis)]);
        let uv = uv.collect();
        (mesh, uv)
    }

    /// The albedo of a solid.
    pub fn albedo(&self, object: ObjectId) -> Option<&Albedo> {
        self.scene().albedo(object)
    }

    /// Whether an object needs texture coordinates.
    pub fn is_varied(&self, object: ObjectId) -> bool {
        matches!(self.albedo(object), Some(Albedo::Checker { .. } | Albedo::Texture(_)))
    }

    /// The radiance of a light with a surface, and whether it shines on both sides.
    pub fn emission(&self, object: ObjectId) -> Option<([f64; 3], bool)> {
        match self.scene().object(object).surface {
            Surface::Light { radiance, two_sided } => Some((radiance.to_rgb(), two_sided)),
            _ => None,
        }
    }

    /// The radius of a sphere around everything, and what lies beyond it the camera included.
    pub fn reach(&self) -> f64 {
        let geometry = &self.scene().geometry;
        let eye = self.description().camera.position - geometry.origin;
        geometry.bounding_sphere().map_or(1.0, |bounds| bounds.radius + bounds.center.distance(eye)).max(1e-30)
    }
}

/// The images of an exported scene, each written once.
#[derive(Debug, Default)]
pub struct TextureFiles(Vec<(Arc<TextureImage>, Option<[f64; 3]>, String)>);

impl TextureFiles {
    /// The path of an image below the folder of `files`, where it is written. `name` is that of the object. An image is written multiplied by its tint.
    pub fn path(&mut self, texture: &SurfaceTexture, name: &str, files: &mut Bundle) -> String {
        let tint = Some(texture.tint.to_rgb()).filter(|tint| *tint != [1.0; 3]);
        let same = self.0.iter().find(|(image, known, _)| Arc::ptr_eq(image, &texture.image) && *known == tint);
        if let Some((.., path)) = same {
            return path.clone();
        }
        let path = format!("textures/{name}.png");
        let bytes = match tint {
            Some(tint) => to_png(&texture.image.tinted(tint)),
            None => to_png(&texture.image),
        };
        files.add(&path, bytes);
        self.0.push((Arc::clone(&texture.image), tint, path.clone()));
        path
    }
}

/// Names in a sentence.
pub fn list(names: &[String]) -> String {
    const MOST: usize = 4;
    let mut unique: Vec<&String> = Vec::new();
    names.iter().for_each(|name| {
        if !unique.contains(&name) {
            unique.push(name);
        }
    });
    let shown: Vec<String> = unique.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    match unique.len().saturating_sub(MOST) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// The thin walls that are hidden, where they stand.
fn thin_walls(description: &Description) -> Result<Vec<ThinWall>, SceneError> {
    let medium = |name: &str| {
        let index = description.media.iter().position(|medium| medium.name == name);
        index.map_or(MediumId::WORLD, |index| MediumId(index as u32 + 2))
    };
    let is_wall = |object: &Object| !object.visible && object.refractor().is_some_and(|refractor| refractor.thin);
    let walls = || description.objects.iter().zip(0..).filter(|(object, _)| is_wall(object));
    if walls().next().is_none() {
        return Ok(Vec::new());
    }
    // Alone and as solids, which nothing is asked of.
    let solid = |object: &Object| {
        let role = Solid { smooth: object.is_smooth(), ..Solid::of(Paint::Color([0.5; 3])) };
        Object { visible: true, role: role.into(), ..object.clone() }
    };
    let objects = walls().map(|(object, _)| solid(object)).collect();
    let alone = prepare(Arc::new(Description { objects, camera_medium: None, ..description.clone() }), None)?;
    Ok((walls().zip(0..))
        .filter_map(|((object, index), place)| {
            let piece = surface(&alone, ObjectId(place))?;
            let inside = medium(&object.refractor()?.medium);
            let outside = object.outside().map_or(MediumId::WORLD, medium);
            Some(ThinWall { object: ObjectId(index), piece, inside, outside })
        })
        .collect())
}

fn file_names(scene: &Scene) -> Vec<String> {
    let mut counts: HashMap<String, u32> = HashMap::new();
    (scene.objects.iter())
        .map(|object| {
            let mut name: String = (object.name.chars().take(60))
                .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
                .collect();
            name = name.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-");
            if name.is_empty() {
                name = "object".into();
            }
            let count = counts.entry(name.clone()).or_default();
            *count += 1;
            // A name that ends in a number of its own might be another's with one added.
            if *count == 1 { name } else { format!("{name}--{count}") }
        })
        .collect()
}
