//! Surfaces painted by what rectification found out about them: the medium on their outer side, their patch, its confidence, its class.
//!
//! Rays go straight through refractors, and a pixel shows one surface on its way: the innermost. Its colour is that of the legend, darker
//! where the surface turns away and along the outlines of everything that the ray goes through, so that what lies in front and behind is
//! seen too. Colours are never blended. They are after Okabe and Ito (2008), which stay apart for colour-blind eyes; words beside the
//! picture say the same.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::color::{along, mixed};
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::rectify::surroundings::Answer;
use crate::rectify::{Patch, PatchKind};
use crate::scene::camera::Camera;
use crate::scene::{MediumId, ObjectId, Surface};
use crate::tracking::Prepared;

/// Colours of media and patches, sRGB, in this order, then from the start.
pub const COLORS: [[u8; 3]; 8] = [
    [0x56, 0xb4, 0xe9],
    [0xe6, 0x9f, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xf0, 0xe4, 0x42],
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0xa6, 0xa6, 0xf0],
];
/// The global medium.
pub const WORLD_COLOR: [u8; 3] = [0x8e, 0x94, 0x9d];
/// The reserved exterior of `naive`, where the global medium is another.
const VACUUM_COLOR: [u8; 3] = [0xdc, 0xe0, 0xe6];
/// Behind everything.
pub const BACKGROUND: [u8; 3] = [0x2b, 0x2e, 0x34];
const NO_INTERFACE: [u8; 3] = [0x58, 0x4c, 0x58];
const SOLID: [u8; 3] = [176, 172, 166];
const LIGHT: [u8; 3] = [255, 244, 205];

/// Shade of a pixel in which an outline lies.
const OUTLINE: f32 = 0.55;
/// Every pixel is a colour of the legend, times at least this.
pub const LEAST_SHADE: f32 = 0.15;
/// Rays of one pixel: a rotated grid.
pub const OFFSETS: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// What the colours say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SurfaceQuantity {
    /// The medium on the outer side, place by place.
    Outside,
    /// The patch.
    Patch,
    /// How sure the pre-trace's rays are of it.
    Confidence,
    /// Whether the patch is clear, null, mixed or masked.
    Class,
}

impl SurfaceQuantity {
    pub const ALL: [Self; 4] = [Self::Outside, Self::Patch, Self::Confidence, Self::Class];

    pub fn name(self) -> &'static str {
        match self {
            Self::Outside => "outside medium",
            Self::Patch => "patches",
            Self::Confidence => "confidence",
            Self::Class => "class",
        }
    }

    /// One sentence for tooltips.
    pub fn about(self) -> &'static str {
        match self {
            Self::Outside => "Every surface in the colour of the medium that rectification found on its outer side.",
            Self::Patch => {
                "Every patch in a colour of its own: a part of a surface with the same surroundings everywhere."
            }
            Self::Confidence => {
                "Every patch by how many of the rays that were shot from it agree about its surroundings."
            }
            Self::Class => {
                "Clear: one medium outside, another inside. Null: the same on both sides. Mixed: crossed by other surfaces. Masked: \
                 coincides with another surface that stands for both."
            }
        }
    }
}

/// What one colour stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tint {
    Medium(MediumId),
    /// Passed over: another surface stands for this one.
    NoInterface,
    /// By the number among the table's patches.
    Patch(u32),
    /// In percent, from 50 to 100.
    Confidence(u8),
    Class(PatchKind),
    Solid,
    Light,
}

impl Tint {
    /// sRGB.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Medium(medium) => medium_color(medium),
            Self::NoInterface => NO_INTERFACE,
            Self::Patch(number) => numbered_color(number),
            Self::Confidence(percent) => confidence_color((f32::from(percent) - 50.0) / 50.0),
            Self::Class(PatchKind::Clear) => COLORS[0],
            Self::Class(PatchKind::Null) => [0xb4, 0xb4, 0xb4],
            Self::Class(PatchKind::Mixed) => COLORS[1],
            Self::Class(PatchKind::Masked) => COLORS[3],
            Self::Solid => SOLID,
            Self::Light => LIGHT,
        }
    }

    /// In words, for a legend.
    pub fn label(self, prepared: &Prepared) -> String {
        let scene = &prepared.scene;
        match self {
            // The scene may be a newer one than the picture.
            Self::Medium(medium) => scene.media.get(medium.0 as usize).map(|m| m.name.clone()).unwrap_or_default(),
            Self::NoInterface => "no interface".to_owned(),
            Self::Patch(number) => match prepared.table.patches.get(number as usize) {
                Some(patch) => {
                    let name = &scene.object(patch.refractor).name;
                    let outside = match patch.outside {
                        Some(medium) => format!("in {}", scene.medium(medium).name),
                        None => patch.kind.name().to_owned(),
                    };
                    format!("{name} {}: {outside}", patch.index)
                }
                None => String::new(),
            },
            Self::Confidence(percent) => format!("{percent} %"),
            Self::Class(kind) => kind.name().to_owned(),
            Self::Solid => "solid".to_owned(),
            Self::Light => "light".to_owned(),
        }
    }
}

/// The colour of a medium, sRGB: the same everywhere in the program.
pub fn medium_color(medium: MediumId) -> [u8; 3] {
    match medium {
        MediumId::WORLD => WORLD_COLOR,
        MediumId::VACUUM => VACUUM_COLOR,
        MediumId(number) => numbered_color(number - 2),
    }
}

/// After one round through the colours darker ones, then paler ones.
pub fn numbered_color(number: u32) -> [u8; 3] {
    let color = COLORS[number as usize % COLORS.len()];
    match number as usize / COLORS.len() % 3 {
        0 => color,
        1 => mixed(color, [0; 3], 0.38),
        _ => mixed(color, [255; 3], 0.45),
    }
}

/// From 0, the rays disagree evenly, to 1, all agree: dark blue through grey to yellow, after the map "cividis" (Nuñez, Anderton and
/// Renslow 2018), which is even to the eye with and without colour blindness.
pub fn confidence_color(part: f32) -> [u8; 3] {
    const STOPS: [[u8; 3]; 5] =
        [[0x00, 0x2a, 0x6b], [0x4b, 0x54, 0x6d], [0x7c, 0x7b, 0x78], [0xb7, 0xa7, 0x6f], [0xff, 0xe9, 0x45]];
    along(&STOPS, part * (STOPS.len() - 1) as f32)
}

/// What is known about a place on a refractor's surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Face<'a> {
    pub refractor: ObjectId,
    pub patch: &'a Patch,
    /// The number of `patch` among the table's patches.
    pub number: u32,
    /// The media on both sides at this very place, also in mixed patches; `None` where the crossing is passed over.
    pub sides: Option<Answer>,
}

impl Face<'_> {
    pub fn tint(&self, quantity: SurfaceQuantity) -> Tint {
        match quantity {
            SurfaceQuantity::Outside => self.sides.map_or(Tint::NoInterface, |sides| Tint::Medium(sides.outside)),
            SurfaceQuantity::Patch => Tint::Patch(self.number),
            SurfaceQuantity::Confidence => {
                Tint::Confidence((self.patch.confidence.clamp(0.5, 1.0) * 100.0).round() as u8)
            }
            SurfaceQuantity::Class => Tint::Class(self.patch.kind),
        }
    }
}

/// What the interface table says of a hit; `None` on solids and lights.
fn face<'a>(prepared: &'a Prepared, point: &SurfacePoint, hit: &Hit) -> Option<Face<'a>> {
    let (scene, table) = (&*prepared.scene, &*prepared.table);
    let refractor = ObjectId(scene.geometry.object_of(hit.primitive));
    if !matches!(scene.object(refractor).surface, Surface::Refractor { .. }) {
        return None;
    }
    let patch = table.patch_of(&scene.geometry, hit.primitive)?;
    // Patches of one refractor stand together.
    let first = table.patches.partition_point(|patch| patch.refractor < refractor);
    let answer = table.look(scene, refractor, point, hit.barycentric);
    let sides = (answer != Answer::MASKED).then_some(answer);
    Some(Face { refractor, patch, number: first as u32 + patch.index, sides })
}

/// The refractors' surfaces along the ray through a point in [0, 1]² of a picture of `size` pixels, front to back, up to the first opaque
/// one. `camera` is in scene coordinates.
pub fn faces_along<'a>(prepared: &'a Prepared, camera: &Camera, size: [u32; 2], point: [f64; 2]) -> Vec<Face<'a>> {
    let geometry = &prepared.scene.geometry;
    let camera = Camera { position: camera.position - geometry.origin, ..*camera };
    let size = DVec2::new(f64::from(size[0]), f64::from(size[1]));
    let ray = camera.ray(size * DVec2::from(point), size, DVec2::ZERO);
    (geometry.all_hits(&ray).iter()).map_while(|hit| face(prepared, &geometry.surface(&ray, hit), hit)).collect()
}

/// What a ray sees.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sight {
    /// `None`: nothing is in the way.
    tint: Option<Tint>,
    /// From [`LEAST_SHADE`] to 1.
    shade: f32,
    /// Of the objects that the ray goes through: where neighbours differ there is an outline.
    layers: u32,
}

/// A pixel: what most of its rays see, so that no colours are blended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Pixel {
    tint: Option<Tint>,
    /// How many more rays than others have seen it, at least, by Boyer and Moore's vote.
    lead: u32,
    /// Sum of the shades of the rays that have seen it, and their number.
    shades: f32,
    rays: u32,
}

impl Pixel {
    fn add(&mut self, tint: Option<Tint>, shade: f32) {
        if self.lead == 0 && self.tint != tint {
            *self = Self { tint, lead: 1, shades: shade, rays: 1 };
        } else if self.tint == tint {
            (self.lead, self.shades, self.rays) = (self.lead + 1, self.shades + shade, self.rays + 1);
        } else {
            self.lead -= 1;
        }
    }

    fn color(&self) -> [u8; 3] {
        let Some(tint) = self.tint else { return BACKGROUND };
        let shade = self.shades / self.rays.max(1) as f32;
        tint.color().map(|x| (f32::from(x) * shade).round() as u8)
    }
}

/// A painted picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Painting {
    pub width: u32,
    pub height: u32,
    pixels: Vec<Pixel>,
    /// Rays for each pixel.
    pub rays: u32,
    /// How many rays saw each colour, most first.
    pub seen: Vec<(Tint, u64)>,
}

impl Painting {
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![Pixel::default(); width as usize * height as usize];
        Self { width, height, pixels, rays: 0, seen: Vec::new() }
    }

    /// sRGB, row 0 at the top: [`BACKGROUND`], or the colour of one of `seen`, darkened.
    pub fn pixels(&self) -> impl Iterator<Item = [u8; 3]> {
        self.pixels.iter().map(Pixel::color)
    }

    /// The colour of a pixel before it is darkened; `None`: nothing is there.
    pub fn tints(&self) -> impl Iterator<Item = Option<Tint>> {
        self.pixels.iter().map(|pixel| pixel.tint)
    }

    /// Adds one ray to every pixel, on rayon's current pool. `camera` is in scene coordinates, and has no lens here. Returns `false` when
    /// `cancel` was set before all was done: the picture is then incomplete and should be dropped.
    pub fn add(
        &mut self,
        prepared: &Prepared,
        camera: &Camera,
        quantity: SurfaceQuantity,
        cancel: &AtomicBool,
    ) -> bool {
        let origin = prepared.scene.geometry.origin;
        let camera = Camera { position: camera.position - origin, aperture_radius: 0.0, ..*camera };
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        let offset = DVec2::from(OFFSETS[self.rays as usize % OFFSETS.len()]);
        let width = (self.width as usize).max(1);
        let nothing = Sight { tint: None, shade: 1.0, layers: 0 };
        let mut sights = vec![nothing; self.pixels.len()];
        sights.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |hits, (row, sights)| {
            if cancel.load(Ordering::Relaxed) {
                return;
            }
            for (column, sight) in sights.iter_mut().enumerate() {
                let ray = camera.ray(DVec2::new(column as f64, row as f64) + offset, size, DVec2::ZERO);
                *sight = sight_along(prepared, &ray, quantity, hits);
            }
        });
        if cancel.load(Ordering::Relaxed) {
            return false;
        }
        let counts = (self.pixels.par_chunks_mut(width).enumerate())
            .map(|(row, pixels)| {
                let mut seen: BTreeMap<Tint, u64> = BTreeMap::new();
                let first = row * width;
                for (index, pixel) in (first..).zip(pixels) {
                    let Sight { tint, shade, layers } = sights[index];
                    let right = sights[if index + 1 < first + width { index + 1 } else { index }];
                    let below = sights.get(index + width).unwrap_or(&sights[index]);
                    let is_outline = right.layers != layers || below.layers != layers;
                    pixel.add(tint, if is_outline { shade * OUTLINE } else { shade });
                    if let Some(tint) = tint {
                        *seen.entry(tint).or_default() += 1;
                    }
                }
                seen
            })
            .reduce(BTreeMap::new, |mut a, b| {
                for (tint, count) in b {
                    *a.entry(tint).or_default() += count;
                }
                a
            });
        let mut all: BTreeMap<Tint, u64> = self.seen.iter().copied().collect();
        for (tint, count) in counts {
            *all.entry(tint).or_default() += count;
        }
        self.seen = all.into_iter().collect();
        self.seen.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        self.rays += 1;
        true
    }
}

/// The surface that stands for a ray: of those that it enters up to the first opaque one, that inside most others; among equals, the smallest
/// object's, where the ray meets it first. Where it enters none, the first that it leaves.
fn sight_along(prepared: &Prepared, ray: &Ray, quantity: SurfaceQuantity, hits: &mut Vec<Hit>) -> Sight {
    let scene = &*prepared.scene;
    hits.clear();
    scene.geometry.for_each_hit(ray, |hit| hits.push(hit));
    hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
    let mut layers: u32 = 0x811c_9dc5;
    // (hit, tint, depth, volume); a depth of `None` is that of a surface that is left.
    let mut best: Option<(&Hit, Tint, Option<i32>, f64)> = None;
    let mut met: Vec<ObjectId> = Vec::new();
    let mut depth = 0;
    for hit in hits.iter() {
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        // FNV-1a.
        layers = (layers ^ (2 * object.0 + u32::from(hit.is_front))).wrapping_mul(0x0100_0193);
        let point = scene.geometry.surface(ray, hit);
        let Some(face) = face(prepared, &point, hit) else {
            if best.is_none() {
                let is_light = matches!(scene.object(object).surface, Surface::Light { .. });
                let tint = if is_light { Tint::Light } else { Tint::Solid };
                return Sight { tint: Some(tint), shade: shade_of(prepared, ray, hit, tint), layers };
            }
            break;
        };
        let tint = face.tint(quantity);
        let volume = scene.object(object).volume;
        let is_first = !met.contains(&object);
        let is_better = match best {
            None => true,
            Some((_, known, _, _)) if tint == Tint::NoInterface && known != Tint::NoInterface => false,
            Some((_, Tint::NoInterface, _, _)) if tint != Tint::NoInterface => true,
            Some((_, _, None, _)) => hit.is_front,
            Some((_, _, Some(deepest), smallest)) => {
                hit.is_front && is_first && (depth > deepest || (depth == deepest && volume < smallest))
            }
        };
        if is_better {
            best = Some((hit, tint, hit.is_front.then_some(depth), volume));
        }
        if is_first {
            met.push(object);
        }
        depth += if hit.is_front { 1 } else { -1 };
    }
    match best {
        Some((hit, tint, ..)) => Sight { tint: Some(tint), shade: shade_of(prepared, ray, hit, tint), layers },
        None => Sight { tint: None, shade: 1.0, layers },
    }
}

/// Darker where a surface turns away.
fn shade_of(prepared: &Prepared, ray: &Ray, hit: &Hit, tint: Tint) -> f32 {
    let geometry = &prepared.scene.geometry;
    let normal = geometry.shading_normal(hit, geometry.surface(ray, hit).normal);
    let cosine = normal.dot(ray.direction).abs().min(1.0) as f32;
    match tint {
        Tint::Light => 1.0,
        Tint::Solid => 0.35 + 0.65 * above(normal, ray.direction) * cosine,
        // What is met from inside is a little darker.
        _ => (if hit.is_front { 1.0 } else { 0.85 }) * (0.7 + 0.3 * cosine),
    }
}

/// A little light from above tells floors from walls: from ¾ to 1.
fn above(normal: DVec3, direction: DVec3) -> f32 {
    let towards = if normal.dot(direction) > 0.0 { -normal } else { normal };
    (0.875 + 0.125 * towards.y) as f32
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::formats;
    use crate::tracking::prepare;

    const SCENE: &str = r#"
[camera]
position = [0, 0, 10]
target = [0, 0, 0]
vertical_fov = 40
[[medium]]
name = "water"
ior = 1.333
[[medium]]
name = "glass"
ior = 1.5
[[refractor]]
name = "pool"
medium = "water"
shape = { box = { min = [-2, -2, -2], max = [2, 0, 2] } }
[[refractor]]
name = "ball"
medium = "glass"
priority = 1
shape = { icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 3 } }
"#;

    fn prepared() -> Prepared {
        let description = formats::parse(SCENE, std::path::Path::new("pool.toml"), &formats::Disk).unwrap();
        prepare(Arc::new(description), None).unwrap()
    }

    fn painted(prepared: &Prepared, quantity: SurfaceQuantity) -> Painting {
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let mut painting = Painting::new(80, 60);
        for _ in OFFSETS {
            assert!(painting.add(prepared, &camera, quantity, &AtomicBool::new(false)));
        }
        painting
    }

    #[test]
    fn the_lower_half_of_a_floating_ball_lies_in_water_place_by_place() {
        let prepared = prepared();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let outside = |y: f64| {
            // The picture is 2 × 10 × tan 20° high at the ball.
            let height = 20.0 * 20.0_f64.to_radians().tan();
            let faces = faces_along(&prepared, &camera, [800, 600], [0.513, 0.5 - y / height]);
            let ball: Vec<_> =
                faces.iter().filter(|face| prepared.scene.object(face.refractor).name == "ball").collect();
            assert_eq!(ball.len(), 2, "in front and behind, at {y}");
            ball.iter()
                .map(|face| prepared.scene.medium(face.sides.expect("it is an interface").outside).name.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(outside(0.6), ["world", "world"]);
        assert_eq!(outside(-0.6), ["water", "water"]);
        // In the row of faces that the water's surface crosses too, above and below it.
        assert_eq!(outside(0.02), ["world", "world"]);
        assert_eq!(outside(-0.05), ["water", "water"]);
    }

    #[test]
    fn every_quantity_has_its_colours_and_its_legend() {
        let prepared = prepared();
        for quantity in SurfaceQuantity::ALL {
            let painting = painted(&prepared, quantity);
            let labels: Vec<String> = painting.seen.iter().map(|(tint, _)| tint.label(&prepared)).collect();
            let expected: &[&str] = match quantity {
                SurfaceQuantity::Outside => &["world", "water"],
                SurfaceQuantity::Class => &["clear", "mixed"],
                SurfaceQuantity::Confidence => &["100 %"],
                SurfaceQuantity::Patch => {
                    &["pool 0: in world", "ball 0: in water", "ball 1: in world", "ball 2: mixed"]
                }
            };
            assert!(expected.iter().all(|word| labels.iter().any(|label| label == word)), "{quantity:?}: {labels:?}");
            assert!(painting.seen.windows(2).all(|pair| pair[0].1 >= pair[1].1), "most first");
            let pixels: Vec<[u8; 3]> = painting.pixels().collect();
            assert_eq!(pixels[0], BACKGROUND);
            assert_ne!(pixels[30 * 80 + 40], BACKGROUND);
        }
    }

    /// Whatever lies behind whatever, and along every outline.
    #[test]
    fn every_pixel_is_a_shade_of_a_colour_of_the_legend() {
        for name in ["iced-water", "nested-spheres", "half-submerged", "lamp-in-ice", "camera-in-water"] {
            let prepared = prepare(Arc::new(formats::open(name).unwrap()), None).unwrap();
            for quantity in SurfaceQuantity::ALL {
                let painting = painted(&prepared, quantity);
                let legend: Vec<Tint> = painting.seen.iter().map(|(tint, _)| *tint).collect();
                for (pixel, tint) in painting.pixels().zip(painting.tints()) {
                    let Some(tint) = tint else {
                        assert_eq!(pixel, BACKGROUND);
                        continue;
                    };
                    assert!(legend.contains(&tint), "{name}, {quantity:?}: {tint:?}");
                    let color = tint.color();
                    let most = (0..3).max_by_key(|&i| color[i]).unwrap();
                    let shade = f32::from(pixel[most]) / f32::from(color[most]);
                    assert!((LEAST_SHADE..=1.0).contains(&shade), "{name}, {quantity:?}: {shade}");
                    for (got, full) in pixel.into_iter().zip(color) {
                        assert!((f32::from(got) - shade * f32::from(full)).abs() <= 1.5, "{pixel:?} of {color:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn inner_surfaces_are_seen_through_outer_ones() {
        let prepared = prepare(Arc::new(formats::open("nested-spheres").unwrap()), None).unwrap();
        let painting = painted(&prepared, SurfaceQuantity::Outside);
        let labels: Vec<String> = painting.seen.iter().map(|(tint, _)| tint.label(&prepared)).collect();
        for outside in ["world", "glass", "water"] {
            assert!(labels.iter().any(|label| label == outside), "{labels:?}");
        }
    }

    #[test]
    fn colours_of_neighbours_are_apart() {
        let distance = |a: [u8; 3], b: [u8; 3]| (0..3).map(|i| a[i].abs_diff(b[i]) as u32).sum::<u32>();
        for number in 0..24 {
            for other in 0..number {
                assert!(distance(Tint::Patch(number).color(), Tint::Patch(other).color()) > 30, "{number} {other}");
            }
        }
        let light = |part: f32| confidence_color(part).map(u32::from).iter().sum::<u32>();
        assert!((0..20).all(|i| light(i as f32 / 20.0) < light((i + 1) as f32 / 20.0)), "surer is brighter");
    }

    #[test]
    fn a_cancelled_picture_says_so() {
        let prepared = prepared();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let mut painting = Painting::new(8, 8);
        assert!(!painting.add(&prepared, &camera, SurfaceQuantity::Class, &AtomicBool::new(true)));
        assert_eq!(painting.rays, 0);
    }
}
