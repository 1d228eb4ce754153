use crate::geometry::Ray;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::*;
use crate::formats;
use crate::scene::camera::Camera;
use crate::tracking::prepare;

fn prepared(text: &str) -> Prepared {
    let description = formats::parse(text, Path::new("test.toml"), &formats::Disk).unwrap();
    prepare(Arc::new(description), None).unwrap()
}

/// Media of IOR 1.3, 1.5 and 1.7 called `water`, `glass` and `sapphire`, and what `rest` adds to them.
fn scene(rest: &str) -> Prepared {
    let head = "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n\
        [[medium]]\nname = \"water\"\nior = 1.3\n[[medium]]\nname = \"glass\"\nior = 1.5\n[[medium]]\nname = \"sapphire\"\nior = 1.7\n";
    prepared(&format!("{head}{rest}"))
}

fn refractor(name: &str, medium: &str, shape: &str, priority: i32) -> String {
    format!("[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\nshape = {{ {shape} }}\npriority = {priority}\n")
}

fn ball(x: f64, radius: f64) -> String {
    format!("sphere = {{ center = [{x}, 0, 0], radius = {radius} }}")
}

fn slab(from: f64, to: f64) -> String {
    format!("box = {{ min = [{from}, -5, -5], max = [{to}, 5, 5] }}")
}

/// Along the x axis, slightly aslant.
fn along_x(prepared: &Prepared, start: f64, modes: [Mode; 2]) -> Option<Parting> {
    let ray = Ray::new(DVec3::new(start, 0.1, 0.05), DVec3::new(1.0, 0.02, 0.01));
    compare(prepared, modes, ray, Follow::Transmit, 0, Some(30)).parting
}

/// Index of the vertex, the mode's mistake, and its cause, against the reference.
fn fault(prepared: &Prepared, start: f64, mode: Mode) -> Option<(usize, Fault)> {
    let parting = along_x(prepared, start, [mode, Mode::Reference])?;
    assert_eq!(parting.faults[1], None, "the reference is the truth");
    // The other way around it is the same.
    let turned = along_x(prepared, start, [Mode::Reference, mode]).unwrap();
    assert_eq!((turned.vertex, &turned.faults[1]), (parting.vertex, &parting.faults[0]));
    let [fault, _] = parting.faults;
    Some((parting.vertex, fault.expect("what parts from the truth is wrong")))
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn a_nest_seen_from_outside_misleads_naive_alone() {
    let scene =
        scene(&(refractor("outer", "glass", &ball(0.0, 1.0), 0) + &refractor("inner", "water", &ball(0.0, 0.5), 0)));
    for mode in [Mode::Stack, Mode::Priority, Mode::RectifiedObject, Mode::Rectified, Mode::Reference] {
        assert_eq!(along_x(&scene, -3.0, [mode, Mode::Reference]), None, "{mode}");
    }
    let (vertex, found) = fault(&scene, -3.0, Mode::Naive).unwrap();
    assert_eq!((vertex, &found.cause), (1, &Cause::VacuumOutside));
    assert_eq!(
        found.sentence(),
        "naive took vacuum (IOR 1) outside inner; it is glass (IOR 1.5). naive takes the outside of everything for vacuum."
    );
}

#[test]
fn a_path_that_starts_inside_misleads_what_has_state() {
    let scene =
        scene(&(refractor("pool", "water", &ball(0.0, 4.0), 0) + &refractor("ball", "glass", &ball(0.0, 1.0), 0)));
    for mode in [Mode::Stack, Mode::Priority] {
        let (vertex, found) = fault(&scene, -3.0, mode).unwrap();
        assert_eq!((vertex, &found.cause), (0, &Cause::StartsInside { within: names(&["pool"]) }));
        let text = found.sentence();
        assert!(text.contains("took the world (IOR 1) outside ball; it is water (IOR 1.3)."), "{text}");
        assert!(text.ends_with(&format!("The path starts inside pool, which {mode} does not know.")), "{text}");
        // Naive is wrong in the same way there, so the two do not part: only where the pool ends.
        assert_eq!(along_x(&scene, -3.0, [mode, Mode::Naive]), None);
    }
    // Inside both, the innermost is named first; the ball is left into the world instead of into the water.
    let (vertex, found) = fault(&scene, 0.0, Mode::Stack).unwrap();
    assert_eq!((vertex, &found.cause), (0, &Cause::StartsInside { within: names(&["ball", "pool"]) }));
    assert!(matches!(&found.mistake, Mistake::Outside { took, is } if took.name == "world" && is.name == "water"));
    for mode in [Mode::RectifiedObject, Mode::Rectified] {
        assert_eq!(fault(&scene, -3.0, mode), None);
    }
}

#[test]
fn overlaps_mislead_the_stack_and_what_has_one_interior() {
    let scene =
        scene(&(refractor("wall", "glass", &slab(0.0, 2.0), 2) + &refractor("drink", "water", &slab(1.0, 4.0), 1)));
    let (vertex, found) = fault(&scene, -3.0, Mode::Stack).unwrap();
    assert_eq!((vertex, &found.cause), (1, &Cause::Overlap { hidden: "drink".into(), filler: "wall".into() }));
    assert!(matches!(&found.mistake, Mistake::Invented { to, is, .. } if to.name == "water" && is.name == "glass"));
    for mode in [Mode::Priority, Mode::Rectified] {
        assert_eq!(fault(&scene, -3.0, mode), None);
    }
    assert_eq!(fault(&scene, -3.0, Mode::Naive).unwrap().1.cause.name(), "overlap");
    assert_eq!(fault(&scene, -3.0, Mode::RectifiedObject).unwrap().1.cause.name(), "overlap");
}

#[test]
fn equal_priorities_mislead_the_list() {
    // The truth gives the overlap to the smaller volume; the list to what was entered last.
    let scene =
        scene(&(refractor("small", "glass", &slab(0.0, 2.0), 0) + &refractor("large", "water", &slab(1.0, 6.0), 0)));
    let (_, found) = fault(&scene, -3.0, Mode::Priority).unwrap();
    assert_eq!(found.cause, Cause::EqualPriorities { a: "large".into(), b: "small".into() });
}

#[test]
fn one_answer_for_an_object_that_juts_out() {
    let water = refractor("water", "water", &slab(0.0, 4.0), 0);
    let scene = scene(&(water + &refractor("ball", "glass", &ball(0.0, 1.0), 1)));
    // One end of the ball lies in the world, the other in water; its one answer is wrong for one of them.
    let (_, found) = fault(&scene, -3.0, Mode::RectifiedObject).unwrap();
    let Cause::OneAnswerPerObject { refractor, outsides } = &found.cause else { panic!("{found:?}") };
    assert_eq!((&refractor[..], outsides), ("ball", &names(&["water", "world"])));
    assert_eq!(fault(&scene, -3.0, Mode::Rectified), None);
}

#[test]
fn surfaces_that_coincide() {
    let scene =
        scene(&(refractor("first", "glass", &slab(0.0, 2.0), 0) + &refractor("second", "water", &slab(2.0, 4.0), 0)));
    assert_eq!(fault(&scene, -3.0, Mode::Rectified), None);
    let found: Vec<Cause> =
        [Mode::Stack, Mode::Priority].into_iter().filter_map(|mode| Some(fault(&scene, -3.0, mode)?.1.cause)).collect();
    for cause in &found {
        assert!(matches!(cause, Cause::SurfacesCoincide { .. }), "{cause:?}");
    }
}

/// A world of oil: naive alone takes it for vacuum.
#[test]
fn the_world_may_be_no_vacuum() {
    let scene = scene(&("[world]\nior = 1.4\n".to_owned() + &refractor("ball", "glass", &ball(0.0, 1.0), 0)));
    let (vertex, found) = fault(&scene, -3.0, Mode::Naive).unwrap();
    assert_eq!((vertex, found.cause), (0, Cause::VacuumOutside));
    assert_eq!(fault(&scene, -3.0, Mode::Stack), None);
}

/// Media that light cannot tell from each other make no difference, whatever they are called.
#[test]
fn names_alone_part_nothing() {
    let air = "[[medium]]\nname = \"air\"\nior = 1\n";
    let scene = scene(
        &(air.to_owned()
            + &refractor("room", "air", &ball(0.0, 4.0), 0)
            + &refractor("ball", "glass", &ball(0.0, 1.0), 0)),
    );
    for a in Mode::ALL {
        for b in Mode::ALL {
            assert_eq!(along_x(&scene, -3.0, [a, b]), None, "{a} {b}");
        }
    }
}

/// Kinds of causes of each mode against the reference, over a grid of pixels of a built-in scene.
fn causes_in(name: &str) -> BTreeMap<(Mode, &'static str), u32> {
    let prepared = prepare(Arc::new(formats::open(Path::new(name)).unwrap()), None).unwrap();
    let camera = Camera::new(&prepared.description.camera).unwrap();
    const SIDE: u32 = 14;
    let mut found = BTreeMap::new();
    for index in 0..SIDE * SIDE {
        let film = DVec2::new(f64::from(index % SIDE), f64::from(index / SIDE)) + 0.5;
        let ray = camera.ray(film, DVec2::splat(f64::from(SIDE)), DVec2::ZERO);
        let paths = Mode::ALL.map(|mode| trace(&prepared, mode, ray, Follow::Transmit, 0, Some(40)));
        for a in &paths {
            for b in &paths {
                let Some(parting) = parting(&prepared, [a, b]) else { continue };
                assert_ne!(a.mode, b.mode);
                // Up to the place the paths are one.
                let up_to = |path: &TracedPath| -> Vec<[f64; 3]> {
                    path.vertices.iter().take(parting.vertex + 1).map(|vertex| vertex.position).collect()
                };
                assert_eq!(up_to(a), up_to(b));
                assert!(parting.faults.iter().any(Option::is_some), "{name}: {parting:?}");
                for fault in parting.faults.iter().flatten() {
                    assert!(!parting.sentence().is_empty());
                    assert_ne!(fault.cause, Cause::Unexplained, "{name}: {parting:#?}");
                    if b.mode == Mode::Reference {
                        *found.entry((fault.mode, fault.cause.name())).or_default() += 1;
                    }
                }
            }
        }
    }
    found
}

#[test]
fn built_in_scenes_have_the_causes_that_they_are_made_for() {
    use Mode::{Naive, Priority, RectifiedObject, Stack};
    type Expected = &'static [(Mode, &'static str)];
    let expected: [(&str, Expected); 12] = [
        ("plain-glass", &[]),
        ("nested-spheres", &[(Naive, "vacuum_outside")]),
        ("bubble-in-glass", &[(Naive, "vacuum_outside")]),
        ("three-shells", &[(Naive, "vacuum_outside")]),
        ("siblings", &[(Naive, "vacuum_outside")]),
        ("diamond-in-water", &[(Naive, "vacuum_outside")]),
        ("world-oil", &[(Naive, "vacuum_outside")]),
        ("lamp-in-ice", &[(Naive, "vacuum_outside")]),
        ("luneburg", &[(Naive, "vacuum_outside")]),
        ("camera-in-water", &[(Naive, "vacuum_outside"), (Stack, "starts_inside"), (Priority, "starts_inside")]),
        (
            "half-submerged",
            &[(Naive, "vacuum_outside"), (Stack, "overlap"), (RectifiedObject, "one_answer_per_object")],
        ),
        ("iced-water", &[(Naive, "overlap"), (Stack, "overlap"), (RectifiedObject, "overlap")]),
    ];
    for (name, expected) in expected {
        let found = causes_in(name);
        println!("{name}: {found:?}");
        for key in expected {
            assert!(found.contains_key(key), "{name}: {key:?} not in {found:?}");
        }
        // They declare nothing: what misleads naive misleads declared, but for what is in a world of another index.
        let of_others = found.keys().filter(|(mode, _)| *mode != Mode::Declared).count();
        assert!(found.keys().all(|(mode, cause)| *mode != Mode::Declared || *cause != "vacuum_outside"), "{found:?}");
        if let [] | [(Naive, _)] = expected {
            assert_eq!(of_others, expected.len(), "{name}: {found:?}");
        }
    }
}
