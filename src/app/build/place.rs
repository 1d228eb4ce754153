//! Where a new object goes, and how large it is.

use glam::DVec3;

use crate::app::objects::{decade, rounded, scene_bounds};
use crate::scene::Description;
use crate::scene::description::{CameraDescription, Object, Role, Shape};

/// Share of the picture's height that a new object takes.
const SHARE_OF_VIEW: f64 = 0.32;
/// What is larger than so many new objects is a place to stand on, not a thing to stand on.
const LARGE: f64 = 4.0;

/// Places beside the wanted one that are tried before a new object is put into others.
const TRIES: u32 = 24;

type Bounds = (DVec3, DVec3);

/// A place for a new object.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Where it stands if `is_ground`, else its middle.
    place: DVec3,
    is_ground: bool,
    /// Its largest extent.
    pub size: f64,
    /// Boxes of things that are there.
    occupied: Vec<Bounds>,
}

impl Spot {
    /// On the selected solid, or where the camera looks: on what is below that, if there is something.
    pub fn of(description: &Description, view: &CameraDescription, selected: Option<&Object>) -> Self {
        let distance = view.position.distance(view.target);
        let height = 2.0 * distance * (view.vertical_fov.to_radians() / 2.0).tan();
        let size = SHARE_OF_VIEW * height;
        let size = if size.is_finite() && size > 0.0 { rounded(size, 0.1 * decade(size)) } else { 1.0 };
        let step = 0.01 * decade(size);
        let is_large = |(min, max): &Bounds| (*max - *min).max_element() > LARGE * size;
        let is_thing = |object: &&Object| object.visible && !matches!(object.role, Role::Light(_));
        let all = description.objects.iter().filter(is_thing).map(scene_bounds);
        let occupied: Vec<Bounds> = all.filter(|bounds| !is_large(bounds)).collect();
        let on = |object: &Object, at: DVec3| {
            let top = scene_bounds(object).1.y;
            let place = DVec3::new(rounded(at.x, step), top, rounded(at.z, step));
            Self { place, is_ground: true, size, occupied: occupied.clone() }
        };
        let is_solid = |object: &&Object| matches!(object.role, Role::Solid(_));
        if let Some(selected) = selected.filter(is_solid) {
            let (min, max) = scene_bounds(selected);
            // On a table, where the camera looks; on a small thing, on its middle.
            return on(selected, if is_large(&(min, max)) { view.target.clamp(min, max) } else { (min + max) / 2.0 });
        }
        let target = view.target;
        let is_under = |object: &&Object| {
            let (min, max) = scene_bounds(object);
            let is_around = min.x <= target.x && target.x <= max.x && min.z <= target.z && target.z <= max.z;
            is_around && is_large(&(min, max)) && max.y <= target.y + 0.2 * size && max.y > target.y - height
        };
        let grounds = description.objects.iter().filter(is_thing).filter(is_solid).filter(is_under);
        match grounds.max_by(|a, b| scene_bounds(a).1.y.total_cmp(&scene_bounds(b).1.y)) {
            Some(ground) => on(ground, target),
            None => Self { place: target.map(|x| rounded(x, step)), is_ground: false, size, occupied },
        }
    }

    /// A vessel is the largest thing on a table.
    pub fn vessel_height(&self) -> f64 {
        rounded(1.25 * self.size, 0.1 * decade(self.size))
    }

    /// An object of that shape, in its place.
    pub fn standing(&self, name: &str, shape: Shape, role: impl Into<Role>) -> Object {
        let mut object = Object::new(name, shape, role);
        self.stand(&mut object);
        object
    }

    /// Puts an object in its place, or beside it where that is taken.
    pub fn stand(&self, object: &mut Object) {
        object.transform.translate = DVec3::ZERO;
        let (min, max) = scene_bounds(object);
        let middle = (min + max) / 2.0;
        // What stands on something stands on its lowest point.
        let held = if self.is_ground { middle.with_y(min.y) } else { middle };
        let place = self.place - held;
        let width = (max - min).max_element();
        let step = rounded(1.2 * width, 0.1 * decade(width));
        let is_free = |place: &DVec3| {
            let (min, max) = (min + *place, max + *place);
            // Touching, as things on each other do, is no overlap.
            let overlap = |other: &Bounds| max.min(other.1) - min.max(other.0);
            self.occupied.iter().all(|other| overlap(other).min_element() <= 1e-9 * width)
        };
        let places = (0..TRIES).map(|number| place + DVec3::from(beside(number)) * step);
        let place = places.into_iter().find(is_free).unwrap_or(place);
        object.transform.translate = if place.is_finite() { place } else { DVec3::ZERO };
    }

    /// Where a floor is.
    pub fn floor(&self) -> DVec3 {
        if self.is_ground { self.place } else { self.place - DVec3::Y * (self.size / 2.0) }
    }

    /// The power of a light that makes it bright around: it grows with the square of what is to be lit.
    pub fn power(&self) -> f64 {
        let power = 40.0 * self.size * self.size;
        rounded(power, decade(power)).clamp(1e-30, 1e30)
    }

    /// A place so many sizes above.
    pub fn above(&self, sizes: f64) -> DVec3 {
        self.place + DVec3::Y * rounded(sizes * self.size, 0.1 * decade(self.size))
    }
}

/// `name`, with a number behind it where the scene has an object of that name.
pub fn unique_name(description: &Description, name: &str) -> String {
    unique(name, "object", |name| description.objects.find(name).is_none())
}

/// `name`, with a number behind it where the scene has a medium of that name.
pub fn unique_medium_name(description: &Description, name: &str) -> String {
    unique(name, "medium", |name| description.medium(name).is_none())
}

fn unique(name: &str, otherwise: &str, is_free: impl Fn(&str) -> bool) -> String {
    let words = name.trim();
    let words = if words.is_empty() || matches!(words, "world" | "vacuum") { otherwise } else { words };
    if is_free(words) {
        return words.to_owned();
    }
    // "ball 2" is followed by "ball 3".
    let base = words.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
    let base = if base.is_empty() { words } else { base };
    (2_u64..).map(|number| format!("{base} {number}")).find(|name| is_free(name)).unwrap_or_default()
}

/// Places on a square grid in the plane y = 0, nearest first: the middle, right and left of it, before and behind it, and so on.
fn beside(number: u32) -> [f64; 3] {
    const RING: [[f64; 2]; 8] =
        [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    let Some(number) = number.checked_sub(1) else { return [0.0; 3] };
    let ring = f64::from(number / 8 + 1);
    let [x, z] = RING[number as usize % 8];
    [ring * x, 0.0, ring * z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::build::{Addition, Body, empty_scene};
    use crate::app::edit::Edit;

    fn after(description: &Description, edit: &Edit) -> Description {
        edit.apply(description).unwrap().expect("something is added")
    }

    /// Wherever the camera looks: what is added stands on the floor, in the picture, beside what is there already.
    #[test]
    fn new_things_stand_on_the_floor_beside_each_other() {
        for target in [DVec3::new(0.0, 0.6, 0.0), DVec3::new(1.3, 0.2, -2.0)] {
            let mut scene = empty_scene();
            let view = CameraDescription { target, position: target + DVec3::new(0.5, 1.5, 4.0), ..scene.camera };
            for _ in 0..4 {
                for body in Body::ALL {
                    let edit = Addition::Refractor(body).edit(&scene, &view, None).unwrap();
                    scene = after(&scene, &edit);
                }
            }
            let bounds: Vec<Bounds> = scene.objects.refractors().iter().map(scene_bounds).collect();
            assert_eq!(bounds.len(), 16);
            for (i, a) in bounds.iter().enumerate() {
                assert!(a.0.y.abs() < 1e-9, "{i} does not stand on the floor: {}", a.0.y);
                for b in &bounds[..i] {
                    assert!((a.1.min(b.1) - a.0.max(b.0)).min_element() <= 1e-6, "{i} overlaps another");
                }
            }
            // The first is in the middle of the picture and takes a good part of it.
            let middle = (bounds[0].0 + bounds[0].1) / 2.0;
            assert!(middle.with_y(target.y).distance(target) < 0.02, "{middle} {target}");
            let height = bounds[0].1.y - bounds[0].0.y;
            assert!((0.2..1.0).contains(&(height / view.position.distance(target))), "{height}");
        }
    }

    #[test]
    fn a_small_solid_is_stood_on_and_without_ground_things_hover() {
        let mut scene = empty_scene();
        let view = scene.camera;
        scene = after(&scene, &Addition::Solid(Body::Box).edit(&scene, &view, None).unwrap());
        let top = scene_bounds(scene.objects.find("solid box").unwrap()).1;
        scene = after(&scene, &Addition::Refractor(Body::Sphere).edit(&scene, &view, Some("solid box")).unwrap());
        let ball = scene_bounds(scene.objects.find("sphere").unwrap());
        assert!((ball.0.y - top.y).abs() < 1e-9);
        scene.objects.clear(crate::scene::description::Kind::Solid);
        scene.objects.clear(crate::scene::description::Kind::Refractor);
        scene = after(&scene, &Addition::Refractor(Body::Torus).edit(&scene, &view, None).unwrap());
        let (min, max) = scene_bounds(scene.objects.find("torus").unwrap());
        assert!(((min + max) / 2.0).distance(view.target) < 0.01);
    }

    #[test]
    fn names_are_new_and_counted_on() {
        let mut scene = empty_scene();
        let view = scene.camera;
        for expected in ["sphere", "sphere 2", "sphere 3"] {
            let edit = Addition::Refractor(Body::Sphere).edit(&scene, &view, None).unwrap();
            scene = after(&scene, &edit);
            assert_eq!(scene.objects.refractors().last().unwrap().name, expected);
        }
        assert_eq!(unique_name(&scene, "sphere 2"), "sphere 4");
        for (wanted, name) in [("world", "object"), ("  ", "object"), ("7", "7"), ("floor", "floor 2")] {
            assert_eq!(unique_name(&scene, wanted), name);
        }
    }
}
