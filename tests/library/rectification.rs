//! What lies on the other side: nests, neighbours, opaque things in between, rings, mirrored instances, deep nests, and overlaps that one
//! exterior per object cannot get right.

use std::sync::Arc;

use crate::common::{add, empty, nest, ready, render, sphere};
use glam::DVec3;
use iorect::geometry::Ray;
use iorect::rectify::containment::{containment, medium_at, top};
use iorect::scene::description::{Description, Object, Paint, Shape, Solid, Transform};
use iorect::scene::{MediumId, ObjectId};
use iorect::tracking::Mode;
use iorect::tracking::{Prepared, prepare};
use iorect::transport::inspect::{Follow, trace};

/// Name of what was found outside each patch.
fn outsides(prepared: &Prepared) -> Vec<&str> {
    prepared
        .table
        .patches
        .iter()
        .map(|p| p.outside.map_or("mixed", |id| prepared.scene.medium(id).name.as_str()))
        .collect()
}

fn icosphere(center: DVec3, radius: f64) -> Shape {
    Shape::Icosphere { center, radius, subdivisions: 2 }
}

fn ring(center: DVec3) -> Shape {
    Shape::Torus { center, major: 2.0, minor: 0.8, segments: 48, rings: 24 }
}

#[test]
fn each_shell_of_a_nest_lies_in_the_next() {
    let shells: Vec<_> = (0..9).map(|k| (1.0 - 0.1 * f64::from(k), 1.1 + 0.1 * f64::from(k))).collect();
    let scene = ready(nest(1.333, &shells));
    let mut expected = vec!["world".to_owned()];
    expected.extend((0..8).map(|k| format!("object {k}")));
    assert_eq!(outsides(&scene), expected);
    assert!(scene.table.patches.iter().all(|p| p.confidence == 1.0 && p.rays >= 16));
}

#[test]
fn meshes_and_spheres_nest_in_each_other() {
    let mut description = empty(1.0);
    // Listed inside out: the order of the file does not matter.
    add(&mut description, sphere(DVec3::new(0.1, 0.0, 0.0), 0.3), 1.2, 0.0);
    add(&mut description, icosphere(DVec3::ZERO, 0.6), 1.4, 0.0);
    add(&mut description, sphere(DVec3::ZERO, 0.9), 1.3, 0.0);
    add(&mut description, Shape::Box { min: DVec3::splat(-1.5), max: DVec3::splat(1.5) }, 1.5, 0.0);
    assert_eq!(outsides(&ready(description)), ["object 1", "object 2", "object 3", "world"]);
}

#[test]
fn neighbours_are_no_containers() {
    let mut description = empty(1.0);
    add(&mut description, Shape::Box { min: DVec3::splat(-4.0), max: DVec3::splat(4.0) }, 1.5, 0.0);
    for x in [-2.4, -0.8, 0.8, 2.4] {
        add(&mut description, sphere(DVec3::new(x, 0.0, 0.0), 0.7), 1.2, 0.0);
    }
    assert_eq!(outsides(&ready(description)), ["world", "object 0", "object 0", "object 0", "object 0"]);
}

/// A solid shell all around the inner ball, inside the outer one.
#[test]
fn opaque_things_are_looked_through() {
    let mut description = nest(1.0, &[(1.0, 1.5), (0.3, 1.333)]);
    description.objects.push(Object::new("shell", icosphere(DVec3::ZERO, 0.6), Solid::of(Paint::Color([0.5; 3]))));
    assert_eq!(outsides(&ready(description)), ["world", "object 0"]);
}

/// Rays may leave a ring and enter it again; only the first hit counts.
#[test]
fn a_ring_contains_what_is_in_its_tube_and_not_what_is_in_its_hole() {
    let mut description = empty(1.0);
    add(&mut description, ring(DVec3::ZERO), 1.5, 0.0);
    add(&mut description, sphere(DVec3::new(2.0, 0.0, 0.0), 0.5), 1.2, 0.0);
    add(&mut description, sphere(DVec3::ZERO, 0.5), 1.2, 0.0);
    let scene = ready(description);
    assert_eq!(outsides(&scene), ["world", "object 0", "world"]);
    assert!(scene.table.patches.iter().all(|p| p.confidence == 1.0));
}

#[test]
fn instances_may_be_mirrored_turned_and_moved() {
    let mut description = empty(1.0);
    for (x, scale) in [(-3.0, DVec3::new(-1.0, 1.0, 1.0)), (3.0, DVec3::splat(-1.5))] {
        add(&mut description, ring(DVec3::ZERO), 1.5, 0.0);
        add(&mut description, icosphere(DVec3::new(2.0, 0.0, 0.0), 0.4), 1.3, 0.0);
        for refractor in description.objects.refractors_mut().iter_mut().rev().take(2) {
            let translate = DVec3::new(x * 3.0, 1.0, -2.0);
            refractor.transform = Transform { scale, rotate: DVec3::new(20.0, -70.0, 130.0), translate };
        }
    }
    assert_eq!(outsides(&ready(description)), ["world", "object 0", "world", "object 2"]);
}

#[test]
fn nothing_nested_needs_no_rays() {
    let mut description = empty(1.0);
    add(&mut description, sphere(DVec3::X * 2.0, 1.0), 1.5, 0.0);
    add(&mut description, sphere(DVec3::NEG_X * 2.0, 1.0), 1.5, 0.0);
    let prepared = ready(description);
    assert!(!prepared.scene.needs.nesting);
    assert!(
        prepared.table.patches.iter().all(|p| p.rays == 0 && p.confidence == 1.0 && p.outside == Some(MediumId::WORLD))
    );
}

/// An edit that adds a need brings the pre-trace back.
#[test]
fn an_object_that_moves_into_another_is_found_there() {
    let mut description = empty(1.0);
    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.5, 0.0);
    add(&mut description, sphere(DVec3::X * 3.0, 0.5), 1.3, 0.0);
    let apart = ready(description.clone());
    assert_eq!(outsides(&apart), ["world", "world"]);
    description.objects.refractors_mut()[1].transform.translate = DVec3::NEG_X * 2.8;
    let inside = prepare(Arc::new(description), Some(&apart)).unwrap();
    assert_eq!(outsides(&inside), ["world", "object 0"]);
}

#[test]
fn two_hundred_and_fifty_six_deep() {
    let shells: Vec<_> = (0..256).map(|k| (1.0 - f64::from(k) / 300.0, if k % 2 == 0 { 1.5 } else { 1.4 })).collect();
    let mut description = nest(1.0, &shells);
    description.camera.vertical_fov = 10.0;
    let scene = ready(description);
    assert!(scene.table.patches.windows(2).all(|p| p[1].outside_refractor == Some(p[0].refractor)));
    for mode in [Mode::Rectified, Mode::Stack, Mode::Reference] {
        let film = render(&scene, mode, (4, 4), 1, None);
        assert_eq!(film.events.total(), 0, "{mode}");
        assert!((0..16).all(|i| film.mean(i).is_finite()));
    }
}

#[test]
fn the_camera_knows_its_medium() {
    let prepared = ready(nest(1.0, &[(1.0, 1.5), (0.8, 1.3), (0.6, 1.0), (0.4, 2.4)]));
    for (x, expected) in [(1.1, "world"), (0.9, "object 0"), (0.7, "object 1"), (0.5, "object 2"), (0.1, "object 3")] {
        let (medium, is_ambiguous) = medium_at(&prepared.scene, DVec3::new(x, 0.01, 0.02));
        assert_eq!(prepared.scene.medium(medium).name, expected);
        assert!(!is_ambiguous);
        let ray = Ray::new(DVec3::new(x, 0.01, 0.02), DVec3::X);
        // Mode `declared` does not ask about the place.
        for mode in Mode::ALL.into_iter().filter(|mode| *mode != Mode::Declared) {
            assert_eq!(trace(&prepared, mode, ray, Follow::Transmit, 0, None).camera_medium, expected);
        }
    }
}

/// A lens half in the water: each of its points knows its own medium, and a wide white room is scaled accordingly.
#[test]
fn a_lens_across_a_waterline() {
    let mut description = empty(1.0);
    add(
        &mut description,
        Shape::Box { min: DVec3::new(-50.0, -50.0, -50.0), max: DVec3::new(50.0, 0.0, 50.0) },
        1.5,
        2.0,
    );
    description.camera.position = DVec3::new(0.0, 0.0, 0.0);
    description.camera.target = DVec3::new(0.0, 0.0, -1.0);
    description.camera.aperture_radius = 0.1;
    let scene = ready(description);
    let film = render(&scene, Mode::Rectified, (16, 16), 64, None);
    // Half of the lens is in water, and half of the rays from above look up or down into it: none may be counted as inconsistent.
    assert_eq!(film.events.inconsistent, 0);
}

#[test]
fn the_innermost_of_several_containers() {
    let scene = |edit: &dyn Fn(&mut Description)| {
        let mut description = nest(1.0, &[(1.0, 1.5), (0.9, 1.3), (0.9, 1.2)]);
        edit(&mut description);
        ready(description).scene
    };
    let all = [ObjectId(0), ObjectId(1), ObjectId(2)];
    // The smaller volume wins, and of two equal ones the later.
    assert_eq!(top(&scene(&|_| {}), all), Some(ObjectId(2)));
    assert_eq!(
        top(&scene(&|d| d.objects.refractors_mut()[2].transform.scale = DVec3::splat(1.05)), all),
        Some(ObjectId(1))
    );
    // Priority goes before volume, and may be negative.
    assert_eq!(
        top(&scene(&|d| d.objects.refractors_mut()[0].refractor_mut().unwrap().priority = 1), all),
        Some(ObjectId(0))
    );
    assert_eq!(
        top(&scene(&|d| d.objects.refractors_mut()[2].refractor_mut().unwrap().priority = -1), all),
        Some(ObjectId(1))
    );
    assert_eq!(top(&scene(&|_| {}), []), None);
}

#[test]
fn containment_asks_every_refractor() {
    let mut description = nest(1.0, &[(1.0, 1.5), (0.5, 1.3)]);
    add(&mut description, icosphere(DVec3::new(1.0, 0.0, 0.0), 0.9), 1.2, 0.0);
    let scene = ready(description).scene;
    let found = |x: f64| {
        containment(&scene, DVec3::new(x, 0.001, 0.002), None).refractors.iter().map(|o| o.0).collect::<Vec<_>>()
    };
    assert_eq!(found(0.0), [0, 1]);
    assert_eq!(found(0.3), [0, 1, 2]);
    assert_eq!(found(0.8), [0, 2]);
    assert_eq!(found(1.5), [2]);
    assert_eq!(found(-1.5), [0u32; 0]);
}

/// Half in, half out. One exterior for the whole ball cannot be right: the votes say so, more rays are shot, and the paths count what is
/// wrong. Patch by patch it is right, and the same as the reference, bit for bit.
#[test]
fn half_submerged() {
    let mut description = empty(1.0);
    add(&mut description, Shape::Box { min: DVec3::new(-3.0, -3.0, -3.0), max: DVec3::new(3.0, 0.0, 3.0) }, 1.333, 0.1);
    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.5, 0.0);
    add(&mut description, icosphere(DVec3::new(1.9, 0.1, 0.0), 0.7), 1.4, 0.0);
    description.camera.position = DVec3::new(0.0, 3.0, 8.0);
    let prepared = ready(description);
    let ball = &prepared.table.object_table(&prepared.scene).answers[1];
    assert!(ball.confidence() < 0.9 && ball.rays() > 100, "{ball:?}");
    assert!(render(&prepared, Mode::RectifiedObject, (24, 24), 4, None).events.inconsistent > 0);
    let rectified = render(&prepared, Mode::Rectified, (24, 24), 8, None);
    assert_eq!(rectified.events.total(), 0);
    assert_eq!(rectified.sums, render(&prepared, Mode::Reference, (24, 24), 8, None).sums);
}
