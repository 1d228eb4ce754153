//! Random scenes of spheres and meshes that nest, overlap and stand half out of each other, and of such
//! whose faces coincide: on every well-conditioned
//! ray `rectified`, `reference` and a truth worked out apart agree.
//!
//! `IORECT_TEST_CASES=N` sets how many scenes of each kind are tried; the seeds go on from those of the default run.

use std::sync::Arc;

use crate::common::truth::{Truth, is_above, survey};
use crate::common::{Numbers, add, empty, ready, render, sphere};
use glam::DVec3;
use iorect::geometry::Mesh;
use iorect::render::Film;
use iorect::scene::description::{Description, Object, Paint, Shape, Solid, Transform};
use iorect::scene::shapes::tessellate;
use iorect::tracking::Mode;
use rayon::prelude::*;

/// Scenes of each kind in the default run.
const CASES: usize = 600;
/// Rays for each scene.
const RAYS: usize = 8;
/// Scenes in which faults are planted, to see that they would be found: one in so many.
const PLANTED_ONE_IN: usize = 4;

fn cases() -> usize {
    match std::env::var("IORECT_TEST_CASES") {
        Ok(text) => text.parse().expect("IORECT_TEST_CASES is a number"),
        Err(_) => CASES,
    }
}

/// One of each shape, about as large as a sphere of `radius`, at the origin.
fn shape(numbers: &mut Numbers, radius: f64) -> Shape {
    let r = radius;
    match numbers.index(6) {
        0 => sphere(DVec3::ZERO, r),
        1 => Shape::Icosphere { center: DVec3::ZERO, radius: r, subdivisions: 1 + numbers.index(2) as u32 },
        2 => {
            let half = DVec3::new(numbers.between(0.3, 1.0), numbers.between(0.3, 1.0), numbers.between(0.3, 1.0)) * r;
            Shape::Box { min: -half, max: half }
        }
        3 => Shape::Cylinder {
            center: DVec3::ZERO,
            radius: r * numbers.between(0.3, 0.8),
            height: r * numbers.between(0.5, 1.8),
            segments: 5 + numbers.index(20) as u32,
        },
        4 => {
            let minor = numbers.between(0.15, 0.4) * r;
            Shape::Torus {
                center: DVec3::ZERO,
                major: r - minor,
                minor,
                segments: 9 + numbers.index(9) as u32,
                rings: 7,
            }
        }
        // A tumbler.
        _ => {
            let (wall, bottom) = (numbers.between(0.5, 0.9) * r, numbers.between(-0.8, 0.0) * r);
            let profile = vec![[0.0, -r], [r, -r], [r, r], [wall, r], [wall, bottom], [0.0, bottom]];
            Shape::Lathe { profile, segments: 6 + numbers.index(12) as u32 }
        }
    }
}

fn turn(numbers: &mut Numbers) -> DVec3 {
    DVec3::new(numbers.between(-180.0, 180.0), numbers.between(-90.0, 90.0), numbers.between(-180.0, 180.0))
}

fn index_of_refraction(numbers: &mut Numbers) -> f64 {
    match numbers.index(8) {
        0 => 1.0,
        1 => 0.8,
        2 => 2.4,
        _ => numbers.between(1.2, 1.8),
    }
}

/// Adds an object at a place and in a turn of its own, sometimes with a priority, sometimes mirrored, sometimes of a medium that is there.
fn place(numbers: &mut Numbers, description: &mut Description, shape: Shape, translate: DVec3) {
    let ior = index_of_refraction(numbers);
    let is_sphere = matches!(shape, Shape::Sphere { .. });
    add(description, shape, ior, 0.0);
    let scale = match (is_sphere, numbers.index(5)) {
        (false, 0) => DVec3::new(-1.0, numbers.between(0.7, 1.2), 1.0),
        _ => DVec3::ONE,
    };
    let rotate = if numbers.index(4) == 0 { DVec3::ZERO } else { turn(numbers) };
    let priority = if numbers.index(3) == 0 { numbers.index(5) as i32 - 2 } else { 0 };
    let shared = (numbers.index(8) == 0).then(|| numbers.index(description.media.len()));
    let refractor = description.objects.refractors_mut().last_mut().unwrap();
    refractor.transform = Transform { scale, rotate, translate };
    let refractor = refractor.refractor_mut().unwrap();
    refractor.priority = priority;
    if let Some(medium) = shared {
        refractor.medium = description.media[medium].name.clone();
    }
}

/// Each object somewhere in the one before, nearly always wholly.
fn eccentric_nest(numbers: &mut Numbers) -> Description {
    let mut description = empty(index_of_refraction(numbers));
    let (mut center, mut radius) = (numbers.direction(), 1.5);
    for _ in 0..2 + numbers.index(5) {
        let shape = shape(numbers, radius);
        place(numbers, &mut description, shape, center);
        let next = radius * numbers.between(0.3, 0.75);
        center += numbers.direction() * (numbers.next() * (0.6 * radius - 0.5 * next).max(0.0));
        radius = next;
    }
    // The order of the file must not matter.
    for k in (1..description.objects.refractors().len()).rev() {
        let other = numbers.index(k + 1);
        description.objects.refractors_mut().swap(k, other);
    }
    description
}

/// Objects of about one size, anyhow.
fn overlaps(numbers: &mut Numbers) -> Description {
    let mut description = empty(index_of_refraction(numbers));
    for _ in 0..2 + numbers.index(4) {
        let radius = numbers.between(0.3, 1.2);
        let shape = shape(numbers, radius);
        let at = numbers.direction() * numbers.between(0.0, 1.0);
        place(numbers, &mut description, shape, at);
    }
    description
}

/// A pool, objects across its surface, and some on its walls.
fn half_submerged(numbers: &mut Numbers) -> Description {
    let mut description = empty(1.0);
    let level = numbers.between(-0.2, 0.3);
    let max = DVec3::new(2.0, level, 2.0);
    add(&mut description, Shape::Box { min: DVec3::splat(-2.0), max }, 1.333, 0.0);
    if numbers.index(2) == 0 {
        description.objects.refractors_mut()[0].transform.rotate = turn(numbers);
    }
    let matrix = description.objects.refractors()[0].transform.matrix();
    for _ in 0..1 + numbers.index(4) {
        // Some are so small that no vertex of theirs meets an edge of the pool.
        let radius = if numbers.index(3) == 0 { 0.05 } else { numbers.between(0.2, 0.8) };
        let at = DVec3::new(
            numbers.between(-2.0, 2.0),
            level + numbers.between(-0.6, 0.6) * radius,
            numbers.between(-2.0, 2.0),
        );
        let shape = shape(numbers, radius);
        place(numbers, &mut description, shape, matrix.transform_point3(at));
    }
    description
}

/// Boxes and cylinders on a coarse grid, so that faces coincide: the same way and opposed, wholly and in part, of other tessellation; in a third
/// of the scenes all turned by one rotation, so that they coincide but for rounding.
fn touching(numbers: &mut Numbers) -> Description {
    let mut description = empty(index_of_refraction(numbers));
    let rotate = if numbers.index(3) == 0 { turn(numbers) } else { DVec3::ZERO };
    for _ in 0..2 + numbers.index(4) {
        let mut on_grid = |low: usize, high: usize| (low + numbers.index(high - low)) as f64 * 0.5 - 1.0;
        let shape = if on_grid(0, 4) < 0.5 {
            let min = DVec3::new(on_grid(0, 4), on_grid(0, 4), on_grid(0, 4));
            let size = DVec3::new(on_grid(3, 6), on_grid(3, 6), on_grid(3, 6));
            Shape::Box { min, max: min + size }
        } else {
            let center = DVec3::new(on_grid(0, 5), on_grid(0, 5), on_grid(0, 5));
            let segments = 4 * (1 + numbers.index(4) as u32);
            Shape::Cylinder { center, radius: 0.5 + 0.5 * numbers.index(2) as f64, height: 1.0, segments }
        };
        place(numbers, &mut description, shape, DVec3::ZERO);
        description.objects.refractors_mut().last_mut().unwrap().transform =
            Transform { rotate, ..Transform::IDENTITY };
    }
    description
}

/// The same with opaque boxes among them.
fn touching_solids(numbers: &mut Numbers) -> Description {
    let mut description = touching(numbers);
    let transform = description.objects.refractors()[0].transform;
    for k in 0..1 + numbers.index(2) {
        let mut on_grid = |low: usize, high: usize| (low + numbers.index(high - low)) as f64 * 0.5 - 1.0;
        let min = DVec3::new(on_grid(0, 4), on_grid(0, 4), on_grid(0, 4));
        let max = min + DVec3::new(on_grid(3, 5), on_grid(3, 5), on_grid(3, 5));
        description.objects.push(Object {
            transform,
            ..Object::new(format!("solid {k}"), Shape::Box { min, max }, Solid::of(Paint::Color([0.5; 3])))
        });
    }
    description
}

/// Objects of two parts each, in one mesh: parts that cross, nest or stand apart make one body. Some reach into each other.
fn unions(numbers: &mut Numbers) -> Description {
    let mut description = empty(index_of_refraction(numbers));
    for _ in 0..1 + numbers.index(3) {
        let mut all = Mesh::default();
        for _ in 0..2 {
            let radius = numbers.between(0.3, 0.9);
            let part = loop {
                if let Some(mesh) = tessellate(&shape(numbers, radius)).unwrap() {
                    break mesh;
                }
            };
            let rotate =
                Transform { rotate: turn(numbers), translate: numbers.direction() * 0.5, ..Transform::IDENTITY };
            let first = all.positions.len() as u32;
            all.positions.extend(part.positions.iter().map(|p| rotate.matrix().transform_point3(*p)));
            all.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + first)));
        }
        let shape = Shape::mesh("made.ply", Arc::new(all));
        let at = numbers.direction() * numbers.between(0.0, 1.0);
        place(numbers, &mut description, shape, at);
    }
    description
}

/// What came of many scenes.
#[derive(Default)]
struct Total {
    checked: usize,
    coincident: usize,
    faults: Vec<String>,
    /// Faults that were planted, and found: another rule for overlaps, and one exterior for each object.
    of_wrong_rule: usize,
    of_wrong_mode: usize,
}

/// Returns how many of the surfaces that were met coincided with another.
fn check(make: fn(&mut Numbers) -> Description) -> usize {
    let try_seed = |seed: u64| {
        let description = make(&mut Numbers(seed * 7919 + 1));
        let truth = Truth::new(&description);
        let scene = ready(description);
        let rays = truth.rays(RAYS, seed);
        let mut total = Total::default();
        for mode in [Mode::Reference, Mode::Rectified] {
            let found = survey(&scene, &truth, mode, &rays);
            total.checked += found.checked;
            total.coincident += found.coincident;
            total.faults.extend(found.faults.into_iter().map(|fault| format!("seed {seed}: {fault}")));
        }
        if seed.is_multiple_of(PLANTED_ONE_IN as u64) {
            total.of_wrong_mode = survey(&scene, &truth, Mode::RectifiedObject, &rays).faults.len();
            let truth = truth.with_top(|a, b| !is_above(a, b));
            total.of_wrong_rule = survey(&scene, &truth, Mode::Rectified, &rays).faults.len();
        }
        total
    };
    let total = (0..cases() as u64).into_par_iter().map(try_seed).reduce(Total::default, |mut a, b| {
        a.checked += b.checked;
        a.coincident += b.coincident;
        a.faults.extend(b.faults);
        a.of_wrong_rule += b.of_wrong_rule;
        a.of_wrong_mode += b.of_wrong_mode;
        a
    });
    let (faults, checked) = (total.faults, total.checked);
    assert!(
        faults.is_empty(),
        "{} faults among {checked} vertices: {:#?}",
        faults.len(),
        &faults[..faults.len().min(6)]
    );
    assert!(checked > 16 * cases(), "too little was compared: {checked}");
    let planted = cases() / PLANTED_ONE_IN;
    assert!(total.of_wrong_rule > planted / 4, "a wrong rule is seen by {} rays", total.of_wrong_rule);
    assert!(total.of_wrong_mode > planted / 10, "a wrong mode is seen by {} rays", total.of_wrong_mode);
    total.coincident
}

#[test]
fn eccentric_nests() {
    assert_eq!(check(eccentric_nest), 0);
}

#[test]
fn overlapping_objects() {
    assert_eq!(check(overlaps), 0);
}

#[test]
fn half_submerged_objects() {
    assert_eq!(check(half_submerged), 0);
}

#[test]
fn touching_objects() {
    let coincident = check(touching);
    assert!(coincident > cases(), "{coincident}");
}

#[test]
fn touching_objects_and_solids() {
    let coincident = check(touching_solids);
    assert!(coincident > cases(), "{coincident}");
}

#[test]
fn meshes_of_several_parts() {
    check(unions);
}

/// Whatever the scene, the three ways to ask agree about points in space.
#[test]
fn points_in_space() {
    let wrong: usize = (0..cases() as u64)
        .into_par_iter()
        .map(|seed| {
            let mut numbers = Numbers(seed * 104_729 + 3);
            let description = match seed % 3 {
                0 => eccentric_nest(&mut numbers),
                1 => overlaps(&mut numbers),
                _ => half_submerged(&mut numbers),
            };
            let truth = Truth::new(&description);
            let other = Truth::new(&description).with_top(|a, b| !is_above(a, b));
            let scene = ready(description).scene;
            let mut differs = 0;
            for _ in 0..20 {
                let point = numbers.point(DVec3::splat(-1.5), DVec3::splat(1.5));
                let (medium, is_ambiguous) =
                    iorect::rectify::containment::medium_at(&scene, point - scene.geometry.origin);
                let name = &scene.medium(medium).name;
                assert_eq!(name, truth.medium_at(point), "seed {seed} at {point}");
                assert!(!is_ambiguous, "seed {seed} at {point}");
                differs += usize::from(name != other.medium_at(point));
            }
            differs
        })
        .sum();
    assert!(wrong > cases() / 4, "the other rule gives another answer at {wrong} points");
}

/// Every built-in scene: whole images of the two modes from the same random numbers are the same but for rounding, and neither counts
/// anything. One exterior per object does not do that everywhere.
#[test]
fn built_in_scenes() {
    let mut object_differs = Vec::new();
    for builtin in iorect::formats::builtin::all() {
        let scene = ready(iorect::formats::open(builtin.name).unwrap());
        let size = (40, 30);
        let [reference, rectified, object] =
            [Mode::Reference, Mode::Rectified, Mode::RectifiedObject].map(|mode| render(&scene, mode, size, 2, None));
        assert_eq!((reference.events.total(), rectified.events.total()), (0, 0), "{}", builtin.name);
        let differing = |film: &Film| {
            let is_far =
                |i: &usize| film.mean(*i).distance(reference.mean(*i)) > 1e-6 * (1.0 + reference.mean(*i).length());
            (0..film.sums.len()).filter(is_far).count()
        };
        assert_eq!(differing(&rectified), 0, "{}: pixels of {}", builtin.name, reference.sums.len());
        if differing(&object) > 0 {
            object_differs.push(builtin.name);
        }
    }
    assert!(object_differs.contains(&"half-submerged"), "{object_differs:?}");
}
