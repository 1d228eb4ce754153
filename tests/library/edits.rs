//! What edits of objects do to the image and to the answers of rectification.

use std::sync::Arc;

use crate::common::{self, add, nest, ready, render};
use glam::DVec3;
use iorect::scene::Description;
use iorect::scene::description::{Environment, Light, Object, Paint, Shape, Solid};
use iorect::tracking::Mode;
use iorect::tracking::{Prepared, prepare};

/// Hidden, and taken out of the file: the same world.
#[test]
fn an_invisible_object_is_as_if_it_were_not_there() {
    let hidden = |mut description: Description, index: usize| {
        description.objects.refractors_mut()[index].visible = false;
        description
    };
    let removed = |mut description: Description, index: usize| {
        description.objects.remove(index);
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
        let before = iorect::formats::open(name).unwrap();
        let known = ready(before.clone());
        for index in 0..before.objects.refractors().len() {
            let mut after = before.clone();
            after.objects.refractors_mut()[index].transform.translate += DVec3::new(0.02, 0.01, -0.03);
            let edited = prepare(Arc::new(after.clone()), Some(&known)).unwrap();
            for mode in [Mode::Rectified, Mode::Reference] {
                let image = |prepared: &Prepared| render(prepared, mode, (32, 18), 2, None).to_rgb();
                assert_eq!(image(&edited), image(&ready(after.clone())), "{name}: object {index}, {mode}");
            }
        }
    }
}

/// Each edit gives the scene one need more, and with it the work that was left out: the image is that of a scene that had it all along.
/// Taking the edit back leaves it out again.
#[test]
fn an_edit_that_adds_a_need_brings_its_work_back() {
    let quad = |y: f64| {
        let [edge_u, edge_v] = [DVec3::Z, DVec3::X];
        Shape::Quad { center: DVec3::new(0.0, y, 0.0), edge_u, edge_v }
    };
    let gradient = Environment::Gradient { zenith: [0.2, 0.4, 1.0], horizon: [1.0; 3], nadir: [0.1; 3] };
    // Two balls side by side, which need next to nothing.
    let mut before = common::empty(1.0);
    before.environment = gradient.clone();
    for (x, ior) in [(-1.2, 1.5), (1.2, 1.6)] {
        add(&mut before, Shape::Sphere { center: DVec3::new(x, 0.0, 0.0), radius: 1.0 }, ior, 0.0);
    }
    let picture = iorect::formats::open("plain-glass").unwrap().environment;
    assert!(matches!(picture, Environment::Image { .. }));
    type Edit<'a> = (&'a str, Box<dyn Fn(&mut Description) + 'a>);
    let with_image = {
        let texels = vec![[255, 0, 0, 255], [0, 0, 255, 255]];
        let image = iorect::scene::texture::TextureImage::new(2, 1, texels);
        let paint = Paint::texture("t.png", Arc::new(image));
        Object::new("painted", quad(-2.0), Solid::of(paint))
    };
    let edits: [Edit<'_>; 8] = [
        ("absorption", Box::new(|d| d.media[1].absorption = [0.5, 0.1, 0.3])),
        ("nesting", Box::new(|d| d.objects.refractors_mut()[1].transform.translate.x = -1.0)),
        ("index_matching", Box::new(|d| d.media[1].ior = iorect::optics::Ior::Constant(1.5))),
        ("smooth_normals", Box::new(|d| d.objects.refractors_mut()[0].refractor_mut().unwrap().smooth = true)),
        ("triangles", Box::new(|d| add(d, Shape::Box { min: DVec3::splat(2.5), max: DVec3::splat(3.0) }, 1.7, 0.0))),
        (
            "emitters",
            Box::new(|d| {
                d.objects.push(Object::new("lamp", quad(3.0), Light::of_radiance([9.0; 3])));
            }),
        ),
        ("image_environment", Box::new(|d| d.environment = picture.clone())),
        ("textures", Box::new(|d| d.objects.push(with_image.clone()))),
    ];
    let known = ready(before.clone());
    let image = |prepared: &Prepared| render(prepared, Mode::Rectified, (32, 18), 4, None).to_rgb();
    for (need, edit) in edits {
        assert!(known.scene.needs.left_out().contains(&need), "{need} is not needed before");
        let mut after = before.clone();
        edit(&mut after);
        let edited = prepare(Arc::new(after.clone()), Some(&known)).unwrap();
        assert!(!edited.scene.needs.left_out().contains(&need), "{need} is needed now");
        assert_eq!(image(&edited), image(&ready(after)), "{need}");
        // The twin: without the work that the edit asks for, it does not show. A smooth ball is as round as it was, equal IORs matter to shadow
        // rays alone, and triangles are always looked for.
        if matches!(need, "absorption" | "nesting" | "emitters" | "image_environment" | "textures") {
            assert_ne!(image(&edited), image(&known), "{need}");
        }
        let undone = prepare(Arc::new(before.clone()), Some(&edited)).unwrap();
        assert_eq!(undone.scene.needs, known.scene.needs, "{need}");
        assert_eq!(image(&undone), image(&known), "{need}");
    }
}
