//! What decides a picture, as one number: SHA-256 over contents, never over names or paths.
//!
//! Two scenes with one fingerprint give the same samples. The reverse does not hold: an unused medium, or an object that is not visible,
//! changes the fingerprint and no picture, which costs no more than a reference that is made again.
//!
//! Every number goes in with its bits, so 0 and −0 are told apart; every list with its length, and every choice with its name, so that
//! no two descriptions can run together. What is hashed are the fields of the scene's tables, each of which is said once for all (see
//! [`super::fields`]), so that none can be forgotten here.

use std::collections::HashMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::DVec3;
use sha2::{Digest, Sha256};

use super::camera::Camera;
use super::description::Description;
use super::environment::EnvironmentImage;
use super::fields::{Entry, Field, Plain, Slot, Visitor};
use super::tables::medium_fields;
use super::texture::TextureImage;
use crate::geometry::Mesh;
use crate::optics::{Ior, medium};

/// A SHA-256 sum, shown as 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// SHA-256 of bytes and nothing else, as other programs take it; see [`Hasher`] for several values in a row.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    pub fn to_bytes(self) -> [u8; 32] {
        self.0
    }

    /// The first 16 digits: enough to tell files of one folder apart.
    pub fn short(&self) -> String {
        self.to_string()[..16].to_owned()
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fingerprint({self})")
    }
}

impl serde::Serialize for Fingerprint {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Fingerprint {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

/// A text that is not 64 hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a fingerprint is 64 hexadecimal digits")]
pub struct NoFingerprint;

impl FromStr for Fingerprint {
    type Err = NoFingerprint;

    fn from_str(text: &str) -> Result<Self, NoFingerprint> {
        if text.len() != 64 || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err(NoFingerprint);
        }
        let mut bytes = [0; 32];
        for (byte, digits) in bytes.iter_mut().zip(text.as_bytes().chunks(2)) {
            let digits = std::str::from_utf8(digits).map_err(|_| NoFingerprint)?;
            *byte = u8::from_str_radix(digits, 16).map_err(|_| NoFingerprint)?;
        }
        Ok(Self(bytes))
    }
}

/// Takes up values, one after the other.
#[derive(Clone)]
pub struct Hasher(Sha256);

impl Hasher {
    /// `kind` says what is hashed, and in which version of its order of fields.
    pub fn new(kind: &str) -> Self {
        let mut hasher = Self(Sha256::new());
        hasher.text(kind);
        hasher
    }

    pub fn finish(self) -> Fingerprint {
        Fingerprint(self.0.finalize().into())
    }

    pub fn text(&mut self, text: &str) {
        self.integer(text.len() as u64);
        self.0.update(text.as_bytes());
    }

    pub fn integer(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    pub fn flag(&mut self, value: bool) {
        self.0.update([u8::from(value)]);
    }

    pub fn number(&mut self, value: f64) {
        self.integer(value.to_bits());
    }

    /// Numbers whose count is known from what they are; lists give their length first.
    pub fn numbers<const N: usize>(&mut self, values: [f64; N]) {
        values.into_iter().for_each(|value| self.number(value));
    }

    pub fn vector(&mut self, value: DVec3) {
        self.numbers(value.to_array());
    }

    /// Bytes of a length that is known from what they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    pub fn fingerprint(&mut self, of_part: Fingerprint) {
        self.0.update(of_part.0);
    }

    /// A list of values of `N` words each, of which there can be millions.
    fn list<T: Copy, const N: usize>(&mut self, values: &[T], words: impl Fn(T) -> [u64; N]) {
        /// Values that are copied together.
        const TOGETHER: usize = 256;
        self.integer(values.len() as u64);
        let mut bytes = Vec::with_capacity(TOGETHER * N * 8);
        for some in values.chunks(TOGETHER) {
            bytes.clear();
            some.iter().for_each(|&value| bytes.extend(words(value).iter().flat_map(|word| word.to_le_bytes())));
            self.0.update(&bytes);
        }
    }
}

impl Description {
    /// Of all that decides what can be seen, but for the camera, which is often moved: see [`Camera::hash_into`]. Contents of meshes and
    /// images count, their paths do not, nor do names.
    pub fn fingerprint(&self) -> Fingerprint {
        let Self {
            name: _,
            camera: _,
            mut camera_medium,
            mut world,
            mut environment,
            mut media,
            mut objects,
            source: _,
        } = self.clone();
        let hasher = Hasher::new("iorect scene 2");
        let mut hasher =
            FieldHasher { hasher, media: HashMap::new(), meshes: HashMap::new(), textures: HashMap::new() };
        world.fields(&mut hasher);
        environment.fields(&mut hasher);
        hasher.hasher.integer(media.len() as u64);
        for medium in &mut media {
            medium_fields(medium, &mut hasher);
        }
        for (index, medium) in media.into_iter().enumerate().rev() {
            // Of equal names, which the loader refuses, the first.
            hasher.media.insert(medium.name, index as u64);
        }
        hasher.hasher.integer(objects.len() as u64);
        for object in objects.iter_mut() {
            hasher.hasher.text(object.kind().name());
            object.fields(&mut hasher);
        }
        let hasher_of_camera: &mut dyn Visitor = &mut hasher;
        hasher_of_camera.maybe_medium("camera medium", &mut camera_medium);
        hasher.hasher.finish()
    }
}

impl Camera {
    pub fn fingerprint(&self) -> Fingerprint {
        let mut hasher = Hasher::new("iorect camera 1");
        self.hash_into(&mut hasher);
        hasher.finish()
    }

    /// All that decides the rays.
    pub fn hash_into(&self, hasher: &mut Hasher) {
        let Self { position, forward, right, up, tan_half_fov, aperture_radius, focus_distance } = *self;
        [position, forward, right, up].into_iter().for_each(|vector| hasher.vector(vector));
        hasher.numbers([tan_half_fov, aperture_radius, focus_distance]);
    }
}

/// Fields that came later than "iorect scene 2".
const NEWER: [&str; 1] = ["thin"];

/// Hashes fields: keys, forms and values.
struct FieldHasher {
    hasher: Hasher,
    /// Media by name: what is named is hashed, not the name.
    media: HashMap<String, u64>,
    /// Meshes that have been read already: thousands of objects may share one.
    meshes: HashMap<*const Mesh, Fingerprint>,
    /// The same of textures.
    textures: HashMap<*const TextureImage, Fingerprint>,
}

impl Visitor for FieldHasher {
    fn field(&mut self, Field { key, slot, is_default }: Field<'_>) -> bool {
        // What a part of a file holds is hashed with its mesh. What is not declared leaves no trace: fingerprints are as they were when nothing could be.
        if matches!(slot, Slot::Name(_) | Slot::PartName(_) | Slot::MaybeMedium(None)) {
            return true;
        }
        // Nor does what is newer than this order of fields, where it says nothing.
        if is_default == Some(true) && NEWER.contains(&key) {
            return true;
        }
        let hasher = &mut self.hasher;
        hasher.text(key);
        match slot {
            Slot::Medium(name) => hasher.integer(self.media.get(name).copied().unwrap_or(u64::MAX)),
            Slot::MaybeMedium(name) => match name.as_deref() {
                None | Some(medium::WORLD) => hasher.text(medium::WORLD),
                Some(name) => hasher.integer(self.media.get(name).copied().unwrap_or(u64::MAX)),
            },
            Slot::Ior(ior) => {
                // The formula and not the entry's name: a later version may know better numbers.
                let model = if let Ior::Catalog(entry) = ior { &entry.model } else { &*ior };
                match model {
                    Ior::Gas(terms) => {
                        hasher.text("gas");
                        hasher.list(terms, |term| term.map(f64::to_bits));
                    }
                    _ => hash_plain(hasher, Slot::Ior(&mut model.clone()).plain().as_ref()),
                }
            }
            Slot::Mesh { mesh, .. } => {
                let of_mesh = self.meshes.entry(Arc::as_ptr(mesh)).or_insert_with(|| of_mesh(mesh));
                hasher.fingerprint(*of_mesh);
            }
            Slot::Image { image, .. } => {
                let EnvironmentImage { width, height, pixels, notes: _ } = &**image;
                hasher.integer(*width as u64);
                hasher.integer(*height as u64);
                hasher.list(pixels, |pixel| pixel.map(|component| u64::from(component.to_bits())));
            }
            Slot::Texture { image, .. } => {
                let of_image = self.textures.entry(Arc::as_ptr(image)).or_insert_with(|| of_texture(image));
                hasher.fingerprint(*of_image);
            }
            Slot::Table(fields) => fields(self),
            slot => hash_plain(hasher, slot.plain().as_ref()),
        }
        true
    }

    fn form(&mut self, _: &[&'static str], current: &'static str, _: Option<&'static str>) -> &'static str {
        self.hasher.text(current);
        current
    }
}

/// Each kind of value begins with a letter of its own.
fn hash_plain(hasher: &mut Hasher, plain: Option<&Plain>) {
    hasher.bytes(match plain {
        None => b"-",
        Some(Plain::Flag(_)) => b"f",
        Some(Plain::Integer(_)) => b"i",
        Some(Plain::Number(_)) => b"n",
        Some(Plain::Text(_)) => b"t",
        Some(Plain::List(_)) => b"l",
        Some(Plain::Table(_)) => b"e",
    });
    match plain {
        None => {}
        Some(Plain::Flag(value)) => hasher.flag(*value),
        Some(Plain::Integer(value)) => hasher.integer(*value as u64),
        Some(Plain::Number(value)) => hasher.number(*value),
        Some(Plain::Text(value)) => hasher.text(value),
        Some(Plain::List(items)) => {
            hasher.integer(items.len() as u64);
            items.iter().for_each(|item| hash_plain(hasher, Some(item)));
        }
        Some(Plain::Table(entries)) => {
            hasher.integer(entries.len() as u64);
            for Entry { key, value, is_default: _ } in entries {
                hasher.text(key);
                hash_plain(hasher, Some(value));
            }
        }
    }
}

fn of_mesh(mesh: &Mesh) -> Fingerprint {
    let Mesh { positions, normals, triangles, uvs } = mesh;
    let mut hasher = Hasher::new("iorect mesh 1");
    hasher.list(positions, |p| p.to_array().map(f64::to_bits));
    hasher.list(normals, |n| n.to_array().map(f64::to_bits));
    hasher.list(triangles, |t| t.map(u64::from));
    // What is not there leaves no trace: fingerprints are as they were before there were texture coordinates.
    if !uvs.is_empty() {
        hasher.list(uvs, |corners| corners.map(|[u, v]| u64::from(u.to_bits()) << 32 | u64::from(v.to_bits())));
    }
    hasher.finish()
}

fn of_texture(image: &TextureImage) -> Fingerprint {
    let mut hasher = Hasher::new("iorect texture 1");
    hasher.integer(image.width() as u64);
    hasher.integer(image.height() as u64);
    hasher.bytes(image.texels().as_flattened());
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::optics::Medium;
    use crate::scene::LoadNote;
    use crate::scene::description::{
        CameraDescription, Environment, Kind, Light, MeshPart, Object, Paint, Quantity, Refractor, Shape, Solid,
        WorldMedium,
    };

    /// A ball of glass in one of water, over a floor.
    fn described() -> Description {
        let ball = |radius: f64| Shape::Sphere { center: DVec3::ZERO, radius };
        let floor = Shape::Quad { center: DVec3::NEG_Y, edge_u: DVec3::Z, edge_v: DVec3::X };
        let medium = |(name, ior): (&str, f64)| Medium {
            name: name.to_owned(),
            ior: Ior::Constant(ior),
            absorption: [0.0, 0.1, 0.2],
        };
        Description {
            name: "Balls".to_owned(),
            camera: CameraDescription::blank(),
            camera_medium: None,
            world: WorldMedium::DEFAULT,
            environment: Environment::Color([1.0; 3]),
            media: [("water", 1.333), ("glass", 1.5)].map(medium).to_vec(),
            objects: [
                Object::new("water", ball(2.0), Refractor::of("water")),
                Object::new("glass", ball(1.0), Refractor::of("glass")),
                Object::new("floor", floor, Solid::of(Paint::Color([0.5; 3]))),
            ]
            .into_iter()
            .collect(),
            source: None,
        }
    }

    #[test]
    fn names_and_places_of_files_do_not_matter() {
        let description = described();
        let before = description.fingerprint();
        let mut renamed = description.clone();
        renamed.name = "Other".into();
        renamed.camera.position.x += 1.0;
        for medium in &mut renamed.media {
            medium.name += " renamed";
        }
        renamed.objects.refractor_roles_mut().for_each(|refractor| refractor.medium += " renamed");
        renamed.objects.iter_mut().for_each(|object| object.name += " renamed");
        assert_eq!(renamed.fingerprint(), before);
    }

    /// Every edit that can show must change it, each in another way.
    #[test]
    fn every_edit_changes_it() {
        let mesh = |z: f64| {
            Arc::new(Mesh {
                positions: vec![DVec3::X, DVec3::Y, DVec3::new(0.0, 0.0, z)],
                normals: vec![],
                triangles: vec![[0, 1, 2]],
                uvs: Vec::new(),
            })
        };
        let mut scene = described();
        scene.objects[0].shape = Shape::mesh("a.ply", mesh(1.0));
        let image = |blue: f32| EnvironmentImage { width: 1, height: 1, pixels: vec![[1.0, 1.0, blue]], notes: vec![] };
        let with_image = |blue: f32| Environment::Image {
            path: "e.hdr".into(),
            image: Arc::new(image(blue)),
            rotation: 0.0,
            scale: 1.0,
        };
        fn refractor(d: &mut Description, index: usize) -> &mut Refractor {
            d.objects[index].refractor_mut().unwrap()
        }
        fn solid(d: &mut Description) -> &mut Solid {
            d.objects.solids_mut()[0].solid_mut().unwrap()
        }
        let spot = |position: DVec3, target: DVec3, inner_angle: f64, outer_angle: f64| {
            Object::new(
                "lamp",
                Shape::Spot { position, target, inner_angle, outer_angle },
                Light::of(Quantity::Intensity, [1.0; 3]),
            )
        };
        scene.objects.push(spot(DVec3::Y, DVec3::ZERO, 10.0, 20.0));
        let light = |object: Object| {
            move |d: &mut Description| {
                d.objects.clear(Kind::Light);
                d.objects.push(object.clone());
            }
        };
        let ball = |quantity, two_sided| {
            let light = Light { two_sided, ..Light::of(quantity, [1.0; 3]) };
            Object::new("lamp", Shape::Sphere { center: DVec3::Y, radius: 1.0 }, light)
        };
        let sun = |angle: f64| {
            let shape = Shape::Directional { direction: DVec3::NEG_Y, angle };
            Object::new("lamp", shape, Light::of(Quantity::Irradiance, [1.0; 3]))
        };
        type Edit<'a> = Box<dyn Fn(&mut Description) + 'a>;
        let edits: Vec<Edit<'_>> = vec![
            Box::new(|_| ()),
            Box::new(|d| d.world.ior = Ior::Constant(1.000_000_1)),
            Box::new(|d| d.world.absorption[2] = 0.5),
            Box::new(|d| d.media[0].absorption[0] += 1e-9),
            Box::new(|d| d.media[0].ior = Ior::Cauchy([1.5, 0.0, 0.0])),
            Box::new(|d| d.media[0].ior = Ior::Sellmeier(vec![[1.5, 0.0]].into())),
            Box::new(|d| refractor(d, 0).medium = refractor(d, 1).medium.clone()),
            Box::new(|d| d.objects[0].shape = Shape::mesh("a.ply", mesh(2.0))),
            Box::new(|d| refractor(d, 0).priority -= 7),
            Box::new(|d| refractor(d, 0).smooth ^= true),
            Box::new(|d| refractor(d, 0).roughness = [0.1; 2]),
            Box::new(|d| refractor(d, 0).roughness = [0.1, 0.2]),
            Box::new(|d| refractor(d, 0).thin = true),
            Box::new(|d| d.objects[0].visible ^= true),
            Box::new(|d| d.objects[0].transform.rotate.y += 1.0),
            Box::new(|d| d.objects.swap(0, 1)),
            Box::new(|d| solid(d).mirror ^= true),
            Box::new(|d| (solid(d).mirror, solid(d).roughness) = (true, [0.1; 2])),
            Box::new(|d| solid(d).paint = Paint::Color([0.125; 3])),
            Box::new(|d| _ = d.objects.remove(0)),
            Box::new(|d| d.environment = Environment::Color([0.25; 3])),
            Box::new(|d| d.environment = with_image(1.0)),
            Box::new(|d| d.environment = with_image(2.0)),
            Box::new(|d| d.objects.lights_mut()[0].light_mut().unwrap().emission.quantity = Quantity::Power),
            Box::new(light(spot(DVec3::Y, DVec3::X, 10.0, 20.0))),
            Box::new(light(spot(DVec3::Z, DVec3::ZERO, 10.0, 20.0))),
            Box::new(light(spot(DVec3::Y, DVec3::ZERO, 5.0, 20.0))),
            Box::new(light(spot(DVec3::Y, DVec3::ZERO, 10.0, 25.0))),
            Box::new(light(ball(Quantity::Radiance, false))),
            Box::new(light(ball(Quantity::Radiance, true))),
            Box::new(light(ball(Quantity::Power, false))),
            Box::new(light(sun(0.0))),
            Box::new(light(sun(0.53))),
            Box::new(|d| refractor(d, 1).outside = Some("water".into())),
            Box::new(|d| refractor(d, 1).outside = Some("world".into())),
            Box::new(|d| d.objects.lights_mut()[0].light_mut().unwrap().outside = Some("water".into())),
            Box::new(|d| d.camera_medium = Some("water".into())),
        ];
        let all: BTreeSet<Fingerprint> = (edits.iter())
            .map(|edit| {
                let mut edited = scene.clone();
                edit(&mut edited);
                edited.fingerprint()
            })
            .collect();
        assert_eq!(all.len(), edits.len());
        // The same contents from another file.
        let mut moved = scene.clone();
        let note = LoadNote { kind: "short_faces", count: 1, first_line: None, message: String::new() };
        moved.objects[0].shape = Shape::Mesh {
            path: "b.obj".into(),
            part: MeshPart::of_group("elsewhere"),
            mesh: mesh(1.0),
            notes: vec![note],
        };
        assert_eq!(moved.fingerprint(), scene.fingerprint());
    }

    #[test]
    fn it_can_be_written_and_read() {
        let fingerprint = Hasher::new("").finish();
        assert_eq!(fingerprint.to_string().parse(), Ok(fingerprint));
        assert_eq!(fingerprint.short().len(), 16);
        for wrong in ["", "12", &"g".repeat(64), &"é".repeat(32), &"+1".repeat(32)] {
            assert_eq!(wrong.parse::<Fingerprint>(), Err(NoFingerprint), "{wrong}");
        }
        // SHA-256 of eight zero bytes, the length of no text.
        let expected = "af5570f5a1810b7af78caf4bc70a660f0df51e42baf91d4de5b2328de0e83dfc";
        assert_eq!(fingerprint.to_string(), expected);
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(Fingerprint::of_bytes(b"abc").to_string(), expected);
    }
}
