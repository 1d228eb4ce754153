//! New objects and new scenes: what the menu Add makes, where it is put, how large it is and what it is called.

pub mod liquid;
mod place;
pub mod profiles;

use glam::DVec3;

use self::liquid::Inside;
use self::place::{Spot, unique_medium_name, unique_name};
use self::profiles::Vessel;
use super::edit::Edit;
use super::objects::{decade, rounded};
use crate::optics::{Ior, Medium, catalog};
use crate::scene::Description;
use crate::scene::description::{
    CameraDescription, Environment, Light, Object, Objects, Paint, Quantity, Refractor, Role, Shape, Solid, Transform,
    WorldMedium,
};
use crate::scene::tables::DEFAULT_VERTICAL_FOV;

/// Segments of new round things: no corner is seen at ordinary sizes.
const SEGMENTS: u32 = 192;
const RINGS: u32 = 96;
/// Priority of new vessels: room below for what is in what fills them.
const VESSEL_PRIORITY: i32 = 2;
/// Name of a new scene until it is saved.
pub const UNTITLED: &str = "Untitled";
/// Share of the inside that a liquid fills at first.
pub const DEFAULT_FILL: f64 = 0.7;

named! {
    /// A shape to begin with.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Body {
        Sphere = "sphere",
        Box = "box",
        Cylinder = "cylinder",
        Torus = "torus",
    }
}

impl Body {
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Box, Self::Cylinder, Self::Torus];
}

/// What the menu Add makes of numbers alone. (Meshes and images come from files.)
#[derive(Debug, Clone, PartialEq)]
pub enum Addition {
    /// A refractor of the selected refractor's medium, or of glass.
    Refractor(Body),
    /// A vessel of glass.
    Vessel(Vessel),
    /// Water in the vessel of that name, up to a share of its depth in (0, 1).
    Liquid(String, f64),
    /// It floats in the selected refractor, or in the last one of water.
    IceCube,
    /// A large plane to stand on.
    Floor,
    Solid(Body),
    BallLight,
    /// A panel above that shines down.
    PanelLight,
    /// A point above.
    PointLight,
    /// A cone from above.
    SpotLight,
    /// Light from afar.
    Sun,
}

impl Addition {
    /// In the menu, and the name of what it makes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Refractor(body) => body.name(),
            Self::Vessel(vessel) => vessel.name,
            Self::Liquid(..) => "water",
            Self::IceCube => "ice cube",
            Self::Floor => "floor",
            Self::Solid(body) => match body {
                Body::Sphere => "solid sphere",
                Body::Box => "solid box",
                Body::Cylinder => "solid cylinder",
                Body::Torus => "solid torus",
            },
            Self::BallLight => "ball light",
            Self::PanelLight => "panel light",
            Self::PointLight => "point light",
            Self::SpotLight => "spot light",
            Self::Sun => "sun",
        }
    }

    /// The edit that adds it to a scene that `view` looks at.
    ///
    /// # Errors
    /// Why it cannot be made, in words for the user.
    pub fn edit(
        &self,
        description: &Description,
        view: &CameraDescription,
        selected: Option<&str>,
    ) -> Result<Edit, String> {
        let selected = selected.and_then(|name| description.objects.find(name));
        let spot = Spot::of(description, view, selected);
        let size = spot.size;
        let role = |medium: &str, priority| Refractor { priority, smooth: true, ..Refractor::of(medium) };
        let (object, medium) = match self {
            Self::Refractor(body) => {
                let medium = selected.and_then(Object::refractor).map_or("glass", |refractor| &refractor.medium);
                let smooth = *body != Body::Box;
                let role = Refractor { smooth, ..Refractor::of(medium) };
                (spot.standing(self.name(), shape(*body, size), role), medium)
            }
            Self::Vessel(vessel) => {
                let profile = vessel.profile(spot.vessel_height());
                let shape = Shape::Lathe { profile, segments: SEGMENTS };
                (spot.standing(self.name(), shape, role("glass", VESSEL_PRIORITY)), "glass")
            }
            Self::Liquid(vessel, share) => (liquid(description, vessel, *share)?, "water"),
            Self::IceCube => (ice_cube(description, &spot, selected), "ice"),
            Self::Floor => {
                let side = rounded(30.0 * size, decade(size));
                let (edge_u, edge_v) = (DVec3::Z * side, DVec3::X * side);
                let shape = Shape::Quad { center: DVec3::ZERO, edge_u, edge_v };
                let mut floor = Object::new(self.name(), shape, Solid::of(Paint::Color([0.55, 0.5, 0.45])));
                floor.transform.translate = spot.floor();
                (floor, "")
            }
            Self::Solid(body) => {
                let solid = Solid { smooth: *body != Body::Box, ..Solid::of(Paint::Color([0.7, 0.25, 0.15])) };
                (spot.standing(self.name(), shape(*body, size), solid), "")
            }
            Self::BallLight => {
                let radius = rounded(0.2 * size, 0.1 * decade(size));
                let shape = Shape::Sphere { center: DVec3::ZERO, radius };
                let mut light = Object::new(self.name(), shape, Light::of_radiance([20.0; 3]));
                light.transform.translate = spot.above(0.9);
                (light, "")
            }
            Self::PanelLight => {
                let side = rounded(1.5 * size, 0.1 * decade(size));
                let (edge_u, edge_v) = (DVec3::X * side, DVec3::Z * side);
                let shape = Shape::Quad { center: DVec3::ZERO, edge_u, edge_v };
                let mut light = Object::new(self.name(), shape, Light::of_radiance([5.0; 3]));
                light.transform.translate = spot.above(2.5);
                (light, "")
            }
            Self::PointLight => {
                let shape = Shape::Point { position: spot.above(1.5) };
                (Object::new(self.name(), shape, Light::of(Quantity::Power, [spot.power(); 3])), "")
            }
            Self::SpotLight => {
                let (position, target) = (spot.above(2.5), spot.above(0.0));
                let shape = Shape::Spot { position, target, inner_angle: 15.0, outer_angle: 25.0 };
                (Object::new(self.name(), shape, Light::of(Quantity::Power, [spot.power(); 3])), "")
            }
            Self::Sun => {
                let shape = Shape::Directional { direction: DVec3::new(1.0, -2.0, -1.0), angle: 0.53 };
                (Object::new(self.name(), shape, Light::of(Quantity::Irradiance, [3.0, 2.8, 2.5])), "")
            }
        };
        Ok(add(description, object, medium))
    }
}

/// The edit that adds an object under a name of its own, with its medium from the catalogue where the scene has none of that name.
fn add(description: &Description, mut object: Object, medium: &str) -> Edit {
    object.name = unique_name(description, &object.name);
    let is_new = !medium.is_empty() && description.medium(medium).is_none();
    let medium = is_new.then(|| {
        // By the name of an object's medium that the scene does not have: one of the catalogue.
        let ior = catalog::find(medium).map_or(Ior::Constant(1.5), Ior::Catalog);
        Medium { name: medium.to_owned(), ior, absorption: [0.0; 3] }
    });
    Edit::Add(Box::new(object), medium)
}

/// The objects of a mesh file, scaled to the view together. A single refractor is of the selected refractor's medium, or of glass.
pub fn mesh_edit(
    description: &Description,
    view: &CameraDescription,
    selected: Option<&str>,
    mut objects: Vec<(Object, Option<Medium>)>,
) -> Edit {
    let selected = selected.and_then(|name| description.objects.find(name));
    let spot = Spot::of(description, view, selected);
    let corners = objects.iter().map(|(object, _)| object.shape.bounds());
    let (min, max) = corners.reduce(|all, one| (all.0.min(one.0), all.1.max(one.1))).unwrap_or_default();
    // A mesh may come in any unit.
    let mut whole = Object::new("", Shape::Box { min, max }, Solid::of(Paint::Color([0.0; 3])));
    let factor = spot.size / (max - min).max_element();
    if factor.is_finite() && factor > 0.0 && !(0.2..=5.0).contains(&factor) {
        whole.transform.scale = DVec3::splat(rounded(factor, 0.1 * decade(factor)));
    }
    spot.stand(&mut whole);
    objects.iter_mut().for_each(|(object, _)| object.transform = whole.transform);
    if let [(object, _)] = &mut objects[..]
        && let Some(refractor) = object.refractor_mut()
    {
        let medium = selected.and_then(Object::refractor).map_or("glass", |refractor| &refractor.medium);
        medium.clone_into(&mut refractor.medium);
        return add(description, object.clone(), medium);
    }
    // Names are taken one after the other.
    let mut scene = description.clone();
    for (object, medium) in &mut objects {
        object.name = unique_name(&scene, &object.name);
        if let (Some(medium), Some(refractor)) = (medium.as_mut(), object.refractor_mut()) {
            medium.name = unique_medium_name(&scene, &medium.name);
            medium.name.clone_into(&mut refractor.medium);
            scene.media.push(medium.clone());
        }
        scene.objects.push(object.clone());
    }
    Edit::AddAll(objects)
}

/// The edit that adds a copy of an object beside it; `None` if there is none of that name.
pub fn duplicate(description: &Description, name: &str) -> Option<Edit> {
    let mut copy = description.objects.find(name)?.clone();
    let (min, max) = super::objects::scene_bounds(&copy);
    let width = max.x - min.x;
    copy.transform.translate.x += rounded(1.1 * width, 0.1 * decade(width));
    Some(add(description, copy, ""))
}

/// A shape of that size whose middle is the origin.
fn shape(body: Body, size: f64) -> Shape {
    let center = DVec3::ZERO;
    let part = |share: f64| rounded(share * size, 0.01 * decade(size));
    match body {
        Body::Sphere => Shape::Sphere { center, radius: part(0.5) },
        Body::Box => Shape::Box { min: DVec3::splat(-part(0.45)), max: DVec3::splat(part(0.45)) },
        Body::Cylinder => Shape::Cylinder { center, radius: part(0.35), height: part(1.0), segments: SEGMENTS },
        Body::Torus => Shape::Torus { center, major: part(0.38), minor: part(0.14), segments: SEGMENTS, rings: RINGS },
    }
}

/// Water in a vessel.
fn liquid(description: &Description, vessel: &str, share: f64) -> Result<Object, String> {
    let Some(object) = description.objects.find(vessel) else {
        return Err("Select a vessel to fill, such as a tumbler, or add one first.".to_owned());
    };
    let cannot = |why: String| format!("{vessel} cannot be filled: {why}.");
    if object.transform.rotate.x != 0.0 || object.transform.rotate.z != 0.0 {
        return Err(cannot(
            "it is tilted, and the surface of a liquid is level. Set its rotation about x and z to 0".into(),
        ));
    }
    let priority = object.refractor().map_or(0, |refractor| refractor.priority);
    let shape = Inside::of(&object.shape).and_then(|inside| inside.filled(share)).map_err(cannot)?;
    let mut water = Object::new("water", shape, Refractor::of("water"));
    // Below the vessel's, with room between the two for ice.
    if let Some(refractor) = water.refractor_mut() {
        refractor.smooth = object.is_smooth();
        refractor.priority = priority.saturating_sub(2);
    }
    water.transform = object.transform;
    Ok(water)
}

/// The vessel that a liquid fills as the menu makes it, and to what share of its depth.
pub fn vessel_of<'a>(description: &'a Description, liquid: &Object) -> Option<(&'a Object, Inside, f64)> {
    description.objects.refractors().iter().find_map(|vessel| {
        if vessel.name == liquid.name || vessel.transform != liquid.transform {
            return None;
        }
        let inside = Inside::of(&vessel.shape).ok()?;
        let share = inside.share_of(&liquid.shape)?;
        Some((vessel, inside, share))
    })
}

/// Ice that floats in a liquid with a tenth of its height above the surface, or stands where new things do if there is none.
fn ice_cube(description: &Description, spot: &Spot, selected: Option<&Object>) -> Object {
    let is_water = |object: &&Object| object.refractor().is_some_and(|refractor| refractor.medium == "water");
    let liquid = (selected.filter(|object| is_water(object)))
        .or_else(|| description.objects.refractors().iter().rev().find(is_water));
    let Some(liquid) = liquid else {
        return spot.standing("ice cube", shape(Body::Box, 0.4 * spot.size), Refractor::of("ice"));
    };
    let (min, max) = super::objects::scene_bounds(liquid);
    let extent = max - min;
    let width = extent.x.min(extent.z);
    // Three stand around the middle without touching.
    let half = (0.13 * width).min(0.4 * extent.y);
    let half = rounded(half, 0.01 * decade(half)).max(f64::MIN_POSITIVE);
    let priority = liquid.refractor().map_or(0, |refractor| refractor.priority.saturating_add(1));
    let shape = Shape::Box { min: DVec3::splat(-half), max: DVec3::splat(half) };
    let mut ice = Object::new("ice cube", shape, Refractor { priority, ..Refractor::of("ice") });
    // Each is turned another way.
    let is_ice = |object: &&Object| object.refractor().is_some_and(|refractor| refractor.medium == "ice");
    let count = description.objects.refractors().iter().filter(is_ice).count();
    let (sin, cos) = (std::f64::consts::TAU * count as f64 / 3.0).sin_cos();
    let middle = (min + max) / 2.0 + DVec3::new(cos, 0.0, sin) * 0.22 * width;
    // Further ones are below.
    let depth = 2.2 * half * (count / 3) as f64;
    let place = DVec3::new(middle.x, max.y - 0.8 * half - depth, middle.z);
    let step = 0.01 * decade(half);
    let rotate = DVec3::new(0.0, (20.0 + 35.0 * count as f64) % 90.0, 0.0);
    ice.transform = Transform { rotate, translate: place.map(|x| rounded(x, step)), ..ice.transform };
    ice
}

/// An empty, lit scene with a floor.
pub fn empty_scene() -> Description {
    let floor = Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 40.0, edge_v: DVec3::X * 40.0 };
    let panel = Shape::Quad {
        center: DVec3::new(-2.5, 5.0, -2.0),
        edge_u: DVec3::new(2.4, 0.0, 0.0),
        edge_v: DVec3::new(0.0, -1.0, 2.0),
    };
    let objects: Objects = [
        Object::new(
            "floor",
            floor,
            Solid::of(Paint::Checker { a: [0.5, 0.44, 0.38], b: [0.42, 0.36, 0.3], size: 0.5 }),
        ),
        Object::new("window", panel, Role::Light(Light::of_radiance([7.0, 6.6, 6.0]))),
    ]
    .into_iter()
    .collect();
    Description {
        name: UNTITLED.to_owned(),
        camera: CameraDescription {
            position: DVec3::new(0.0, 2.2, 4.6),
            target: DVec3::new(0.0, 0.6, 0.0),
            vertical_fov: DEFAULT_VERTICAL_FOV,
            ..CameraDescription::blank()
        },
        camera_medium: None,
        world: WorldMedium::DEFAULT,
        environment: Environment::Gradient { zenith: [0.7, 0.8, 1.0], horizon: [0.5, 0.55, 0.6], nadir: [0.1; 3] },
        media: Vec::new(),
        objects,
        source: None,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::edit::ObjectEdit;
    use crate::app::objects::scene_bounds;
    use crate::check::verdict::judge;
    use crate::tracking::Mode;

    fn add_to(scene: &mut Description, addition: &Addition, selected: Option<&str>) {
        let edit = addition.edit(scene, &scene.camera, selected).unwrap_or_else(|why| panic!("{addition:?}: {why}"));
        *scene = edit.apply(scene).unwrap_or_else(|why| panic!("{addition:?}: {why}")).expect("something new");
    }

    fn everything() -> Vec<Addition> {
        let all = Vessel::ALL.map(Addition::Vessel).into_iter();
        all.chain(Body::ALL.map(Addition::Refractor))
            .chain(Body::ALL.map(Addition::Solid))
            .chain([Addition::IceCube, Addition::Floor, Addition::BallLight, Addition::PanelLight])
            .collect()
    }

    /// At any scale of the view.
    #[test]
    fn whatever_is_added_can_be_compiled() {
        for scale in [1e-6, 0.01, 1.0, 300.0, 1e7] {
            let mut scene = empty_scene();
            scene.camera.position *= scale;
            scene.camera.target *= scale;
            for addition in everything() {
                add_to(&mut scene, &addition, None);
            }
            crate::scene::compile::compile(&scene, None).unwrap_or_else(|error| panic!("at {scale}: {error}"));
        }
    }

    /// The scene of the title, from nothing: ice in water in glass, and rectification says so.
    #[test]
    fn iced_water_from_an_empty_scene() {
        let mut scene = empty_scene();
        add_to(&mut scene, &Addition::Vessel(profiles::TUMBLER), None);
        add_to(&mut scene, &Addition::Liquid("tumbler".into(), DEFAULT_FILL), None);
        add_to(&mut scene, &Addition::IceCube, Some("water"));
        add_to(&mut scene, &Addition::IceCube, None);
        let names: Vec<&str> = scene.objects.refractors().iter().map(|object| &*object.name).collect();
        assert_eq!(names, ["tumbler", "water", "ice cube", "ice cube 2"]);
        let media: Vec<&str> = scene.media.iter().map(|medium| &*medium.name).collect();
        assert_eq!(media, ["glass", "water", "ice"]);
        // It floats: a small part is above the surface.
        let top = |name: &str| scene_bounds(scene.objects.find(name).unwrap()).1.y;
        let ice = scene_bounds(scene.objects.find("ice cube").unwrap());
        let above = (top("water") - ice.0.y) / (ice.1.y - ice.0.y);
        assert!((0.85..0.95).contains(&above), "{above}");
        let prepared = crate::tracking::prepare(Arc::new(scene.clone()), None).unwrap();
        let outside = |name: &str| {
            let (id, _) = prepared.scene.refractors().find(|(id, _)| prepared.scene.object(*id).name == name).unwrap();
            let patches = prepared.table.patches_of(id);
            let mut media: Vec<&str> =
                patches.iter().filter_map(|patch| Some(&*prepared.scene.medium(patch.outside?).name)).collect();
            media.sort_unstable();
            media.dedup();
            media
        };
        assert_eq!(outside("ice cube"), ["water", "world"]);
        assert_eq!(outside("ice cube 2"), ["water", "world"]);
        assert!(outside("water").contains(&"glass"), "{:?}", outside("water"));
        // The ice crosses the water's upper side, which therefore has no one answer; each path through it is right all the same.
        let camera = crate::scene::camera::Camera::new(&scene.camera).unwrap();
        judge(&prepared, &camera, [80, 60], Mode::Rectified, |verdict| {
            assert!(verdict.is_right(), "{}", verdict.explanation());
            true
        });
        let mut of_stack = None;
        judge(&prepared, &camera, [80, 60], Mode::Stack, |verdict| {
            of_stack = Some(verdict.clone());
            true
        });
        let cause = of_stack.and_then(|verdict| Some(verdict.findings.first()?.fault.cause.name()));
        assert_eq!(cause, Some("overlap"));
    }

    #[test]
    fn a_liquid_knows_its_vessel_until_either_changes() {
        let mut scene = empty_scene();
        add_to(&mut scene, &Addition::Vessel(profiles::WINE_GLASS), None);
        add_to(&mut scene, &Addition::Liquid("wine glass".into(), 0.4), None);
        let water = scene.objects.find("water").unwrap();
        let (vessel, inside, share) = vessel_of(&scene, water).unwrap();
        assert!(vessel.name == "wine glass" && (share - 0.4).abs() < 1e-9);
        let fuller = Edit::Object("water".into(), ObjectEdit::Shape(inside.filled(0.6).unwrap()));
        let fuller = fuller.apply(&scene).unwrap().unwrap();
        assert!((vessel_of(&fuller, fuller.objects.find("water").unwrap()).unwrap().2 - 0.6).abs() < 1e-9);
        let moved = Transform { translate: DVec3::X, ..Transform::IDENTITY };
        let moved = ObjectEdit::Transform(crate::app::Manipulation::Move, moved);
        let moved = Edit::Object("wine glass".into(), moved).apply(&scene).unwrap().unwrap();
        assert!(vessel_of(&moved, moved.objects.find("water").unwrap()).is_none());
        let tilted = Transform { rotate: DVec3::X * 5.0, ..Transform::IDENTITY };
        let tilted = ObjectEdit::Transform(crate::app::Manipulation::Rotate, tilted);
        let tilted = Edit::Object("wine glass".into(), tilted).apply(&scene).unwrap().unwrap();
        let why = Addition::Liquid("wine glass".into(), 0.5).edit(&tilted, &scene.camera, None).unwrap_err();
        assert!(why.contains("tilted"), "{why}");
    }

    #[test]
    fn a_duplicate_stands_beside_the_original() {
        let mut scene = empty_scene();
        add_to(&mut scene, &Addition::Refractor(Body::Torus), None);
        scene = duplicate(&scene, "torus").unwrap().apply(&scene).unwrap().unwrap();
        let [a, b] = ["torus", "torus 2"].map(|name| scene.objects.find(name).unwrap());
        assert_eq!((&a.shape, &a.role), (&b.shape, &b.role));
        assert!(scene_bounds(a).1.x < scene_bounds(b).0.x);
        assert!(duplicate(&scene, "soup").is_none());
    }
}
