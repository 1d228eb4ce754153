use super::*;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::formats::{self, builtin};
use crate::geometry::Mesh;
use crate::optics::Ior;
use crate::scene::LoadNote;
use crate::scene::description::{Description, MeshPart, Refractor, Shape};
use crate::tracking::prepare;

const HEAD: &str = r#"
[camera]
position = [0, 0, 9]
target = [0, 0, 0]
[environment]
color = [1, 1, 1]
[[medium]]
name = "glass"
ior = 1.5
[[medium]]
name = "water"
ior = 1.33
"#;

fn scene(text: &str) -> Description {
    formats::parse(&format!("{HEAD}{text}"), Path::new("test.toml"), &formats::Disk).unwrap()
}

fn object(name: &str, medium: &str, shape: &str) -> String {
    format!("[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\nshape = {{ {shape} }}\n")
}

fn sphere(name: &str, medium: &str, x: f64, radius: f64) -> String {
    object(name, medium, &format!("sphere = {{ center = [{x}, 0, 0], radius = {radius} }}"))
}

fn problems_of(description: Description) -> Vec<Problem> {
    check(&prepare(Arc::new(description), None).unwrap())
}

/// Kinds and places, in order.
fn found(description: Description) -> Vec<(&'static str, String)> {
    problems_of(description).into_iter().map(|p| (p.kind, p.place)).collect()
}

fn pairs(list: &[(&'static str, &str)]) -> Vec<(&'static str, String)> {
    list.iter().map(|(kind, place)| (*kind, (*place).to_owned())).collect()
}

/// A tetrahedron with its faces outward.
fn tetrahedron() -> Mesh {
    Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        normals: Vec::new(),
        triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]],
        uvs: Vec::new(),
    }
}

fn with_mesh(mesh: Mesh, notes: &[LoadNote]) -> Description {
    let mut scene = scene(&(sphere("a", "glass", 0.0, 1.0) + &sphere("b", "water", 5.0, 1.0)));
    scene.objects.refractors_mut()[0].shape =
        Shape::Mesh { path: "m.obj".into(), part: MeshPart::default(), mesh: Arc::new(mesh), notes: notes.to_vec() };
    scene
}

#[test]
fn a_sound_scene_has_no_problems() {
    assert_eq!(found(scene(&(sphere("ball", "glass", 0.0, 1.0) + &sphere("core", "water", 0.1, 0.5)))), []);
    assert_eq!(found(scene(&(sphere("left", "glass", -1.5, 1.0) + &sphere("right", "water", 1.5, 1.0)))), []);
    assert_eq!(found(with_mesh(tetrahedron(), &[])), []);
}

#[test]
fn media_unused_or_dispersive() {
    let mut scene = scene(&sphere("ball", "glass", 0.0, 1.0));
    assert_eq!(found(scene.clone()), pairs(&[("unused_medium", "water")]));
    scene.media.pop();
    scene.media[0].ior = Ior::Cauchy([1.5, 0.01, 0.0]);
    scene.world.ior = Ior::Catalog(crate::optics::catalog::find("air").unwrap());
    assert_eq!(found(scene.clone()), pairs(&[("dispersion", "glass")]));
    let message = &problems_of(scene)[0].message;
    assert!(message.contains("glass 1.5290"), "{message}");
}

/// Once a kind, whatever the number of objects, with their names and values.
#[test]
fn what_is_kept_and_not_rendered() {
    let mut scene = scene(&(sphere("ball", "glass", 0.0, 1.0) + &sphere("core", "water", 0.1, 0.5)));
    scene.objects[0].refractor_mut().unwrap().roughness = [0.25; 2];
    scene.objects[1].refractor_mut().unwrap().roughness = [0.125, 0.5];
    assert_eq!(found(scene.clone()), pairs(&[("roughness", "ball, core")]));
    let message = &unrendered(&scene)[0].message;
    assert!(message.contains("ball 0.25, core 0.125 along u and 0.5 along v"), "{message}");
    let mut walls = scene.clone();
    walls.objects.iter_mut().for_each(|object| {
        *object.refractor_mut().unwrap() = Refractor { thin: true, ..Refractor::of("glass") };
    });
    walls.media.pop();
    walls.objects[1].visible = false;
    assert_eq!(found(walls), pairs(&[("thin_as_body", "ball"), ("thin_hidden", "core")]));
}

#[test]
fn light_and_camera() {
    let mut scene = scene(&(sphere("ball", "glass", 0.0, 1.0) + &sphere("core", "water", 0.0, 0.5)));
    scene.environment = Environment::Color([0.0; 3]);
    scene.camera.position = DVec3::new(0.0, 0.0, 0.8);
    assert_eq!(found(scene.clone()), pairs(&[("no_light", "scene"), ("camera_inside", "camera")]));
    let message = &problems_of(scene)[1].message;
    assert!(message.contains("inside `ball`:"), "{message}");
}

#[test]
fn what_reading_an_image_changed_is_said() {
    let mut scene = formats::open("plain-glass").unwrap();
    assert_eq!(found(scene.clone()), []);
    let Environment::Image { image, .. } = &mut scene.environment else { panic!("no image") };
    let note = |kind| LoadNote { kind, count: 7, first_line: None, message: format!("{kind}, with advice") };
    Arc::make_mut(image).notes = ["unusual_aspect", "clipped_pixels", "replaced_pixels"].map(note).to_vec();
    let problems = problems_of(scene);
    let found: Vec<_> = problems.iter().map(|problem| (problem.kind, problem.severity)).collect();
    let (warning, advice) = (Severity::Warning, Severity::Advice);
    assert_eq!(found, [("clipped_pixels", warning), ("replaced_pixels", warning), ("unusual_aspect", advice)]);
    assert_eq!(problems[0].message, "clipped_pixels, with advice");
    assert!(problems[0].place.ends_with(".exr"), "{}", problems[0].place);
}

#[test]
fn overlaps_by_tie_and_by_priority() {
    let mut spheres = scene(&(sphere("a", "glass", 0.0, 1.0) + &sphere("b", "water", 1.2, 0.5)));
    let problems = problems_of(spheres.clone());
    assert_eq!((problems[0].kind, problems[0].place.as_str()), ("overlap_tie", "a, b"));
    assert!(problems[0].message.contains("overlap with equal priority: the smaller volume wins, here b"));
    spheres.objects.refractors_mut()[0].refractor_mut().unwrap().priority = 1;
    assert_eq!(found(spheres), []);
    let equal = problems_of(scene(&(sphere("a", "glass", 0.0, 1.0) + &sphere("b", "water", 1.2, 1.0))));
    assert!(
        equal[0].message.contains("their volumes are equal, so the later one wins, here b"),
        "{}",
        equal[0].message
    );

    let crossing = object("box", "glass", "box = { min = [-1, -1, -1], max = [1, 1, 1] }");
    let boxes = scene(
        &(crossing.clone() + &object("rod", "water", "cylinder = { center = [0, 0, 0], radius = 0.5, height = 4 }")),
    );
    let kinds = found(boxes);
    assert!(kinds.contains(&("overlap_tie", "box, rod".into())), "{kinds:?}");
    // Boxes around a diagonal neighbour meet, the objects do not.
    let apart = scene(
        &(crossing
            + &object("ball", "water", "icosphere = { center = [1.8, 1.8, 1.8], radius = 1.0, subdivisions = 3 }")),
    );
    assert_eq!(found(apart), []);
}

#[test]
fn copies_of_spheres() {
    let twins = scene(&(sphere("a", "glass", 0.0, 1.0) + &sphere("b", "water", 0.0, 1.0)));
    assert!(found(twins).contains(&("coincident", "a, b".into())));
}

#[test]
fn open_meshes() {
    let mut open = tetrahedron();
    open.triangles.pop();
    let problems = problems_of(with_mesh(open.clone(), &[]));
    assert_eq!((problems[0].kind, problems[0].place.as_str()), ("open_mesh", "a"));
    assert!(problems[0].message.contains("3 of its edges"), "{}", problems[0].message);
    // The place is on the hole's rim, in scene coordinates, and the region shows more than the edge.
    let mut moved = with_mesh(open, &[]);
    moved.objects.refractors_mut()[0].transform.translate = DVec3::new(0.0, 40.0, 0.0);
    moved.objects.refractors_mut()[0].transform.scale = DVec3::splat(2.0);
    let spots = [problems[0].spot, problems_of(moved)[0].spot].map(|spot| spot.expect("it has a place"));
    assert!((spots[1].center - (2.0 * spots[0].center + 40.0 * DVec3::Y)).length() < 1e-12);
    assert!((spots[1].radius - 2.0 * spots[0].radius).abs() < 1e-12 && spots[0].radius > 0.1);
    let json = serde_json::to_value(&problems[0]).unwrap();
    assert_eq!(json["spot"]["center"].as_array().map(Vec::len), Some(3), "{json}");

    let sheet = scene(
        &(object("sheet", "glass", "quad = { center = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [0, 1, 0] }")
            + &sphere("b", "water", 5.0, 1.0)),
    );
    assert!(found(sheet).contains(&("open_mesh", "sheet".into())));
}

#[test]
fn what_was_passed_over_in_a_file_is_said_once_with_its_line() {
    let note = |kind, first_line| LoadNote { kind, count: 2, first_line, message: "2 of something".into() };
    let mut scene = with_mesh(tetrahedron(), &[note("degenerate_triangles", None), note("unknown_statement", Some(7))]);
    let problems = problems_of(scene.clone());
    let facts: Vec<_> = problems.iter().map(|p| (p.severity, p.kind, p.place.as_str(), p.message.as_str())).collect();
    let expected = [
        (Severity::Warning, "unknown_statement", "a", "m.obj:7: 2 of something"),
        (Severity::Advice, "degenerate_triangles", "a", "m.obj: 2 of something"),
    ];
    assert_eq!(facts, expected);
    // Another object of the same file, and one of another.
    let copy = scene.objects.refractors()[0].clone();
    scene.objects.push(crate::scene::description::Object { name: "c".into(), ..copy });
    scene.objects.refractors_mut()[2].transform.translate.x = 20.0;
    assert_eq!(found(scene.clone()), pairs(&[("unknown_statement", "a, c"), ("degenerate_triangles", "a, c")]));
    let Shape::Mesh { path, .. } = &mut scene.objects.refractors_mut()[2].shape else { panic!("no mesh") };
    *path = "n.obj".into();
    assert_eq!(found(scene.clone()).len(), 4);
    // What many files have alike is one problem.
    for number in 0..10 {
        let mut copy = scene.objects.refractors()[2].clone();
        copy.name = format!("d{number}");
        copy.transform.translate.x += 20.0 * f64::from(number + 1);
        let Shape::Mesh { path, .. } = &mut copy.shape else { panic!("no mesh") };
        *path = format!("d{number}.obj").into();
        scene.objects.push(copy);
    }
    let problems = problems_of(scene);
    let places: Vec<_> = problems.iter().map(|problem| (problem.kind, problem.place.as_str())).collect();
    assert_eq!(places, [("unknown_statement", "a and 11 more"), ("degenerate_triangles", "a and 11 more")]);
    assert_eq!(problems[1].message, "m.obj: 2 of something; likewise 11 other files");
}

#[test]
fn built_in_scenes_have_no_warnings() {
    for scene in builtin::all() {
        let problems = problems_of(formats::open(scene.name).unwrap());
        let warnings: Vec<_> = problems.iter().filter(|p| p.severity != Severity::Advice).collect();
        assert!(warnings.is_empty(), "{}: {warnings:?}", scene.name);
        assert!(problems.iter().all(|p| p.kind != "unused_medium"), "{}", scene.name);
    }
}
