//! From what a file declares on both sides of each of its surfaces to the media of a scene.
//!
//! Two declarations are one medium if their index and what they absorb are equal. An outer side whose absorption is not declared is the world or the
//! medium of the same index, if there is one. The world is what is declared outside of most things and inside of none, air before others.

use crate::formats::names::Names;
use crate::optics::{Ior, Medium, medium};
use crate::scene::description::{Object, Role, WorldMedium};

use super::Matter;

/// What a file says of one side of a surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Side {
    /// `None`: that of the world, as inside of a surface that bends nothing.
    pub ior: Option<f64>,
    /// The index at all wavelengths, where the file says it.
    pub formula: Option<Ior>,
    /// σ per scene unit; `None` where the file says nothing.
    pub absorption: Option<[f64; 3]>,
    /// The file's name for it, or the empty text.
    pub name: String,
}

impl Side {
    /// Whether nothing is different on two sides of a surface that bends nothing.
    pub fn absorbs_as(&self, other: &Self) -> bool {
        self.absorption.unwrap_or_default() == other.absorption.unwrap_or_default()
    }

    /// It absorbs nothing, and has no name.
    pub fn clear() -> Self {
        Self { absorption: Some([0.0; 3]), ..Self::default() }
    }
}

/// Indices as near as this are one: files give them in single precision.
const SAME: f64 = 1e-6;
/// Air and vacuum, which nothing tells apart.
const NEAR_WORLD: f64 = 5e-4;

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// Names the media in the objects, and gives back the world, the media and what the camera is declared to be in.
pub fn resolve(objects: &mut [(Object, Matter)], camera: Option<&Side>) -> (WorldMedium, Vec<Medium>, Option<String>) {
    let world = world(objects);
    let mut media = Media { world, list: Vec::new(), names: Names::default() };
    // Insides first: what lies outside of something is mostly inside something else.
    for (object, matter) in &mut *objects {
        if let (Matter::Refractor { inside, .. }, Role::Refractor(refractor)) = (&*matter, &mut object.role)
            && inside.ior.is_some()
        {
            refractor.medium = media.inside(inside, &object.name);
        }
    }
    // What bends nothing has the index of what is outside.
    for (object, matter) in &mut *objects {
        if let (Matter::Refractor { inside, outside, .. }, Role::Refractor(refractor)) = (&*matter, &mut object.role)
            && inside.ior.is_none()
        {
            let ior = media.index_of(outside);
            refractor.medium = media.inside(&Side { ior: Some(ior), ..inside.clone() }, &object.name);
        }
    }
    for (object, matter) in objects {
        let outside = match matter {
            Matter::Refractor { outside, .. } => Some(&*outside),
            Matter::Light { around, .. } => around.as_ref(),
            Matter::Solid(_) => None,
        };
        if let (Some(outside), Some(declared)) = (outside, object.outside_mut()) {
            *declared = Some(media.outside(outside));
        }
    }
    let camera = camera.map(|camera| media.outside(camera));
    let Media { world: (ior, absorption), list, .. } = media;
    (WorldMedium { ior: Ior::Constant(ior), absorption }, list, camera)
}

/// Index and absorption of what is declared outside of everything.
fn world(objects: &[(Object, Matter)]) -> (f64, [f64; 3]) {
    let sides = || {
        objects.iter().filter_map(|(_, matter)| match matter {
            Matter::Refractor { inside, outside, .. } => Some((inside, outside)),
            _ => None,
        })
    };
    let is_inside = |ior: f64| sides().any(|(inside, _)| inside.ior.is_some_and(|known| is_same(known, ior)));
    // (index, absorption, how often)
    let mut candidates: Vec<(f64, [f64; 3], usize)> = Vec::new();
    for (_, outside) in sides() {
        let Some(ior) = outside.ior else { continue };
        let absorption = outside.absorption.unwrap_or_default();
        match candidates.iter_mut().find(|(known, of, _)| is_same(*known, ior) && *of == absorption) {
            Some((.., count)) => *count += 1,
            None => candidates.push((ior, absorption, 1)),
        }
    }
    let is_air = |ior: f64| (ior - 1.0).abs() < NEAR_WORLD;
    let most = |candidates: &mut dyn Iterator<Item = &(f64, [f64; 3], usize)>| {
        candidates.fold(None, |best: Option<(f64, [f64; 3], usize)>, &next| match best {
            Some(best) if best.2 >= next.2 => Some(best),
            _ => Some(next),
        })
    };
    let found = most(&mut candidates.iter().filter(|(ior, ..)| is_air(*ior)))
        .or_else(|| most(&mut candidates.iter().filter(|(ior, ..)| !is_inside(*ior))));
    found.map_or((1.0, [0.0; 3]), |(ior, absorption, _)| (ior, absorption))
}

struct Media {
    world: (f64, [f64; 3]),
    list: Vec<Medium>,
    names: Names,
}

impl Media {
    fn find(&self, ior: f64, absorption: [f64; 3]) -> Option<String> {
        let is_it = |medium: &&Medium| is_same(medium.ior.ior(), ior) && medium.absorption == absorption;
        self.list.iter().find(is_it).map(|medium| medium.name.clone())
    }

    fn add(&mut self, ior: f64, side: &Side, otherwise: &str) -> String {
        let name = match side.name.as_str() {
            "" => super::indices::name_of(ior).unwrap_or(otherwise),
            name => name,
        };
        let name = self.names.give(name, "medium");
        let absorption = side.absorption.unwrap_or_default();
        let ior = side.formula.clone().unwrap_or(Ior::Constant(ior));
        self.list.push(Medium { name: name.clone(), ior, absorption });
        name
    }

    /// The medium inside `object`, which is never the world by name.
    fn inside(&mut self, side: &Side, object: &str) -> String {
        let (ior, absorption) = (side.ior.unwrap_or(self.world.0), side.absorption.unwrap_or_default());
        self.find(ior, absorption).unwrap_or_else(|| self.add(ior, side, object))
    }

    fn outside(&mut self, side: &Side) -> String {
        let Some(ior) = side.ior else { return self.by_absorption(side) };
        let is_world = (ior - self.world.0).abs() < NEAR_WORLD;
        let found = match side.absorption {
            Some(absorption) if is_world && absorption == self.world.1 => Some(medium::WORLD.to_owned()),
            Some(absorption) => self.find(ior, absorption),
            None if is_world => Some(medium::WORLD.to_owned()),
            // Of several of one index, one that absorbs nothing.
            None => self.find(ior, [0.0; 3]).or_else(|| {
                let of_index = self.list.iter().find(|medium| is_same(medium.ior.ior(), ior));
                of_index.map(|medium| medium.name.clone())
            }),
        };
        found.unwrap_or_else(|| self.add(ior, side, &format!("IOR {ior}")))
    }

    /// Around cameras and lights, and where nothing bends, files declare what absorbs and not the index.
    fn by_absorption(&mut self, side: &Side) -> String {
        match self.known(side) {
            Some(name) => name,
            None => self.add(self.world.0, side, "medium"),
        }
    }

    /// The medium of that name, or else of that absorption.
    fn known(&self, side: &Side) -> Option<String> {
        let absorption = side.absorption.unwrap_or_default();
        let by_name = self.list.iter().find(|medium| !side.name.is_empty() && medium.name == side.name);
        match by_name {
            Some(medium) => Some(medium.name.clone()),
            None if absorption == self.world.1 => Some(medium::WORLD.to_owned()),
            None => self.list.iter().find(|medium| medium.absorption == absorption).map(|medium| medium.name.clone()),
        }
    }

    /// The index of a side; of one that does not say it, that of the medium that it is taken for.
    fn index_of(&self, side: &Side) -> f64 {
        let known = || {
            let name = self.known(side)?;
            self.list.iter().find(|medium| medium.name == name).map(|medium| medium.ior.ior())
        };
        side.ior.or_else(known).unwrap_or(self.world.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::{Light, Refractor, Shape};
    use glam::DVec3;

    fn side(ior: Option<f64>, absorption: Option<f64>, name: &str) -> Side {
        Side { ior, absorption: absorption.map(|sigma| [sigma; 3]), name: name.to_owned(), ..Side::default() }
    }

    fn ball(name: &str, inside: Side, outside: Side) -> (Object, Matter) {
        let shape = Shape::Sphere { center: DVec3::ZERO, radius: 1.0 };
        (
            Object::new(name, shape, Refractor::of("")),
            Matter::Refractor { refractor: Refractor::of(""), inside, outside },
        )
    }

    /// Medium, index and what is declared outside, by object.
    fn resolved(objects: &mut [(Object, Matter)]) -> Vec<(String, f64, String)> {
        let (_, media, _) = resolve(objects, None);
        let ior = |name: &str| media.iter().find(|medium| medium.name == name).map_or(f64::NAN, |m| m.ior.ior());
        (objects.iter())
            .map(|(object, _)| {
                let medium = object.refractor().map(|refractor| refractor.medium.clone()).unwrap_or_default();
                (medium.clone(), ior(&medium), object.outside().unwrap_or_default().to_owned())
            })
            .collect()
    }

    fn row(medium: &str, ior: f64, outside: &str) -> (String, f64, String) {
        (medium.to_owned(), ior, outside.to_owned())
    }

    #[test]
    fn equal_declarations_are_one_medium() {
        let mut objects = [
            ball("tank", side(Some(1.333), Some(0.1), "sea"), side(Some(1.000_277), None, "air")),
            // Whose outside is not said to absorb.
            ball("ice", side(Some(1.31), None, ""), side(Some(1.333), None, "")),
            ball("bubble", side(Some(1.0), None, ""), side(Some(1.333), Some(0.1), "sea")),
            ball("stone", side(Some(1.7), None, ""), side(Some(1.2), None, "")),
        ];
        assert_eq!(
            resolved(&mut objects),
            [
                row("sea", 1.333, "world"),
                row("ice", 1.31, "sea"),
                row("bubble", 1.0, "sea"),
                // Nothing is of that index but what is declared here.
                row("stone", 1.7, "IOR 1.2")
            ]
        );
    }

    #[test]
    fn the_world_is_what_is_outside_of_most_and_inside_of_none() {
        let mut objects = [
            ball("a", side(Some(1.5), None, ""), side(Some(1.33), None, "water")),
            ball("b", side(Some(1.0), None, ""), side(Some(1.5), None, "")),
        ];
        let (world, ..) = resolve(&mut objects, None);
        assert_eq!(world.ior.ior(), 1.33);
        assert_eq!(objects[0].0.outside(), Some("world"));
        assert_eq!(resolve(&mut [], None).0.ior.ior(), 1.0);
    }

    #[test]
    fn what_bends_nothing_has_the_index_around_it() {
        let shape = Shape::Point { position: DVec3::ZERO };
        let light = Light::of_radiance([1.0; 3]);
        let lamp = Object::new("lamp", shape, light.clone());
        let mut objects = [
            ball("ink", side(None, Some(2.0), "ink"), side(None, Some(0.1), "sea")),
            ball("tank", side(Some(1.333), Some(0.1), "sea"), side(Some(1.0), None, "")),
            ball("smoke", side(None, Some(0.5), "smoke"), side(None, None, "")),
            (lamp, Matter::Light { light, around: Some(side(None, Some(0.1), "sea")) }),
        ];
        let expected = [row("ink", 1.333, "sea"), row("sea", 1.333, "world"), row("smoke", 1.0, "world")];
        let found = resolved(&mut objects);
        assert_eq!(found[..3], expected);
        assert_eq!(found[3].2, "sea");
    }
}
