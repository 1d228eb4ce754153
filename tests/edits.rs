//! What edits of objects do to the image and to the answers of rectification.

mod common;

use std::sync::Arc;

use common::{add, nest, ready, render};
use glam::DVec3;
use iorect::render::{Prepared, prepare};
use iorect::scene::Description;
use iorect::scene::description::Shape;
use iorect::tracking::Mode;

/// Hidden, and taken out of the file: the same world.
#[test]
fn an_invisible_object_is_as_if_it_were_not_there() {
    let hidden = |mut description: Description, index: usize| {
        description.refractors[index].visible = false;
        description
    };
    let removed = |mut description: Description, index: usize| {
        description.refractors.remove(index);
        description
    };
    let nested = || nest(1.0, &[(3.0, 1.5), (2.0, 1.33), (1.0, 1.0)]);
    // Meshes that cross each other, beside what the nest has.
    let crossing = || {
        let mut description = nest(1.1, &[(2.0, 1.5)]);
        let (min, max) = (DVec3::new(-3.0, -3.0, -3.0), DVec3::new(3.0, 0.25, 3.0));
        add(&mut description, Shape::Box { min, max }, 1.33, 0.05);
        let center = DVec3::new(1.5, 0.5, 1.0);
        add(&mut description, Shape::Icosphere { center, radius: 1.0, subdivisions: 2 }, 1.7, 0.0);
        description
    };
    for (name, description) in [("nested", nested()), ("crossing", crossing())] {
        for index in 0..3 {
            for mode in Mode::ALL {
                let image = |description| render(&ready(description), mode, (24, 24), 4, None).to_rgb();
                let (a, b) = (hidden(description.clone(), index), removed(description.clone(), index));
                assert_eq!(image(a), image(b), "{name}: object {index}, {mode}");
            }
        }
    }
}

/// Whatever is kept of the scene before an edit: the image is that of the scene as it is now.
#[test]
fn an_edited_scene_is_the_scene_opened_so() {
    for name in ["lamp-in-ice", "half-submerged"] {
        let before = iorect::scene::load::open(name).unwrap();
        let known = ready(before.clone());
        for index in 0..before.refractors.len() {
            let mut after = before.clone();
            after.refractors[index].transform.translate += DVec3::new(0.02, 0.01, -0.03);
            let edited = prepare(Arc::new(after.clone()), Some(&known)).unwrap();
            for mode in [Mode::Rectified, Mode::Reference] {
                let image = |prepared: &Prepared| render(prepared, mode, (32, 18), 2, None).to_rgb();
                assert_eq!(image(&edited), image(&ready(after.clone())), "{name}: object {index}, {mode}");
            }
        }
    }
}
