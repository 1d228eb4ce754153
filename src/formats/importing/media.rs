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
    /// σ per scene unit; `None` where the file says nothing.
    pub absorption: Option<[f64; 3]>,
    /// The file's name for it, or the empty text.
    pub name: String,
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
        if let (Matter::Refractor { inside, .. }, Role::Refractor(refractor)) = (&*matter, &mut object.role) {
            refractor.medium = media.inside(inside, &object.name);
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
    let camera = camera.map(|camera| media.around_camera(camera));
    let Media { world: (ior, absorption), list, .. } = media;
    (WorldMedium { ior: Ior::Constant(ior), absorption }, list, camera)
}

/// Index and absorption of what is declared outside of everything.
fn world(objects: &[(Object, Matter)]) -> (f64, [f64; 3]) {
    let sides = || {
        objects.iter().filter_map(|(_, matter)| match matter {
            Matter::Refractor { inside, outside } => Some((inside, outside)),
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

    fn add(&mut self, ior: f64, absorption: [f64; 3], name: &str, otherwise: &str) -> String {
        let name = if name.is_empty() { super::indices::name_of(ior).unwrap_or(otherwise) } else { name };
        let name = self.names.give(name, "medium");
        self.list.push(Medium { name: name.clone(), ior: Ior::Constant(ior), absorption });
        name
    }

    /// The medium inside `object`, which is never the world by name.
    fn inside(&mut self, side: &Side, object: &str) -> String {
        let (ior, absorption) = (side.ior.unwrap_or(self.world.0), side.absorption.unwrap_or_default());
        self.find(ior, absorption).unwrap_or_else(|| self.add(ior, absorption, &side.name, object))
    }

    fn outside(&mut self, side: &Side) -> String {
        let ior = side.ior.unwrap_or(self.world.0);
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
        found.unwrap_or_else(|| self.add(ior, side.absorption.unwrap_or_default(), &side.name, &format!("IOR {ior}")))
    }

    /// Around a camera files declare what absorbs, and not the index.
    fn around_camera(&mut self, side: &Side) -> String {
        if side.ior.is_some() {
            return self.outside(side);
        }
        let absorption = side.absorption.unwrap_or_default();
        let by_name = self.list.iter().find(|medium| !side.name.is_empty() && medium.name == side.name);
        let found = by_name.or_else(|| self.list.iter().find(|medium| medium.absorption == absorption));
        match found {
            _ if absorption == self.world.1 && by_name.is_none() => medium::WORLD.to_owned(),
            Some(medium) => medium.name.clone(),
            None => self.add(self.world.0, absorption, &side.name, "camera"),
        }
    }
}
