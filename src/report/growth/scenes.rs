//! Scenes of any size.

use glam::DVec3;

use super::Quantity;
use crate::formats::{self, builtin};
use crate::optics::{Ior, Medium};
use crate::report::stability::scenes;
use crate::scene::SceneError;
use crate::scene::description::{CameraDescription, Description, Environment, Object, Refractor, Shape};

const WATER: f64 = 1.333;
const GLASS: f64 = 1.5;

/// A scene in which there is `size` of `quantity`, and the size that it really has.
pub fn of(quantity: Quantity, size: u64) -> Result<(Description, u64), SceneError> {
    Ok(match quantity {
        Quantity::Triangles => tori(size),
        Quantity::Nesting => (lens(size), size),
        Quantity::Objects => (balls(size), size),
        Quantity::Threads => (formats::open(builtin::DEFAULT)?, size),
    })
}

/// Four tori, one in the other. A torus has 2 · segments · rings triangles.
fn tori(triangles: u64) -> (Description, u64) {
    let mut description = empty("tori", DVec3::new(0.0, 2.2, 2.6));
    // Segments along are twice those around.
    let rings = ((triangles as f64 / 16.0).sqrt().round() as u32).max(3);
    for (index, minor) in [0.4, 0.3, 0.2, 0.1].into_iter().enumerate() {
        let shape = Shape::Torus { center: DVec3::ZERO, major: 1.0, minor, segments: 2 * rings, rings };
        add(&mut description, shape, if index % 2 == 0 { GLASS } else { WATER });
    }
    (description, 16 * u64::from(rings).pow(2))
}

/// A Luneburg lens, n = √(2 − r²), of so many shells of equal thickness.
fn lens(shells: u64) -> Description {
    let mut description = empty("lens", DVec3::new(0.0, 0.0, 3.5));
    let count = shells as f64;
    for shell in 0..shells {
        let radius = (shells - shell) as f64 / count;
        let middle = radius - 0.5 / count;
        add(&mut description, Shape::Sphere { center: DVec3::ZERO, radius }, (2.0 - middle * middle).sqrt());
    }
    description
}

/// Balls on a grid in a block.
fn balls(count: u64) -> Description {
    let mut description = empty("balls", DVec3::new(1.4, 1.1, 2.6));
    add(&mut description, Shape::Box { min: DVec3::splat(-0.75), max: DVec3::splat(0.75) }, WATER);
    let side = (1..).find(|side: &u64| side.pow(3) >= count).unwrap_or(1);
    let step = 1.4 / side as f64;
    for k in 0..count {
        let cell = DVec3::new((k % side) as f64, (k / side % side) as f64, (k / side / side) as f64);
        let center = (cell + 0.5) * step - 0.7;
        let medium = description.media.last().map_or(String::new(), |medium| medium.name.clone());
        let shape = Shape::Sphere { center, radius: 0.35 * step };
        // One medium for all balls.
        if k == 0 {
            add(&mut description, shape, GLASS);
        } else {
            description.objects.push(refractor(k as usize + 1, medium, shape));
        }
    }
    description
}

fn empty(name: &str, position: DVec3) -> Description {
    let blank = scenes::empty(1.0);
    Description {
        name: name.to_owned(),
        camera: CameraDescription { position, ..blank.camera },
        environment: Environment::Gradient { zenith: [0.3, 0.5, 0.9], horizon: [1.0; 3], nadir: [0.2, 0.18, 0.15] },
        ..blank
    }
}

/// Adds a refractor with a medium of its own.
fn add(description: &mut Description, shape: Shape, ior: f64) {
    let index = description.objects.refractors().len();
    let name = format!("medium {index}");
    description.media.push(Medium { name: name.clone(), ior: Ior::Constant(ior), absorption: [0.0; 3] });
    description.objects.push(refractor(index, name, shape));
}

fn refractor(index: usize, medium: String, shape: Shape) -> Object {
    Object::new(format!("object {index}"), shape, Refractor::of(medium))
}
