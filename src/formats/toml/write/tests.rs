use glam::DVec3;

use super::*;
use crate::formats::{self, builtin};
use crate::optics::{Ior, Medium};
use crate::scene::description::{
    Environment, Kind, Light, MeshPart, Object, Paint, Quantity, Refractor, Shape, Source, Transform, WorldMedium,
};

const TEXT: &str = r#"# A scene with remarks.
name = "Remarked"   # called so

[camera]
position = [0, 1, 4]   # standing
target = [0.0, 0.0, 0.0]

[[medium]]
name = "glass"
ior = 1.50   # typed with two digits

# The thing itself.
[[refractor]]
name = "ball"
medium = "glass"
shape = { sphere = { center = [0, 0, 0], radius = 1 } }

[[medium]]
name = "water"
ior = { catalog = "water" }

[[solid]]
name = "floor"
color = [0.5, 0.5, 0.5]
[solid.shape.quad]
center = [0, -1, 0]
edge_u = [0, 0, 4]
edge_v = [4, 0, 0]
"#;

fn read(text: &str) -> Description {
    formats::parse(text, Path::new("remarked.toml"), &formats::Disk).unwrap()
}

/// Reads what was written: it must say the same.
fn assert_faithful(description: &Description) -> String {
    let text = to_text(description);
    let mut again = read(&text);
    again.source.clone_from(&description.source);
    assert_eq!(&again, description, "{text}");
    text
}

#[test]
fn what_was_not_edited_is_not_touched() {
    assert_eq!(to_text(&read(TEXT)), TEXT);
    for scene in builtin::all() {
        assert_eq!(to_text(&formats::open(scene.name).unwrap()), scene.text, "{}", scene.name);
    }
}

#[test]
fn an_edit_changes_its_line_only() {
    let mut scene = read(TEXT);
    scene.media[0].ior = Ior::Constant(1.7);
    let text = assert_faithful(&scene);
    assert_eq!(text, TEXT.replace("1.50   #", "1.7   #"));
    scene.camera.position.x = 0.1;
    let text = assert_faithful(&scene);
    assert!(text.contains("position = [0.1, 1, 4]   # standing"), "{text}");
}

#[test]
fn every_kind_of_edit_is_read_back() {
    let mut scene = read(TEXT);
    scene.name = "Other \"name\"".into();
    scene.camera.up = DVec3::Z;
    scene.camera.vertical_fov = 35.5;
    scene.camera.aperture_radius = 0.01;
    scene.camera.focus_distance = Some(3.25);
    scene.world = WorldMedium { ior: Ior::Cauchy([1.4, 0.01, 0.0]), absorption: [0.1, 0.2, 1e-7] };
    scene.environment = Environment::Gradient { zenith: [0.1; 3], horizon: [1.0; 3], nadir: [1e9, 0.0, 0.0] };
    scene.media[1].absorption = [0.0, 0.5, 1.0];
    scene.media[0].ior = Ior::Sellmeier(vec![[1.0, 0.01], [0.1, 100.0]].into());
    let [ball, floor] = &mut scene.objects[..] else { panic!("two objects") };
    *ball.refractor_mut().unwrap() = Refractor {
        priority: -3,
        smooth: true,
        roughness: [0.1; 2],
        thin: true,
        outside: Some("world".into()),
        ..Refractor::of("water")
    };
    scene.camera_medium = Some("water".into());
    ball.transform = Transform { scale: DVec3::splat(2.0), rotate: DVec3::X, translate: -DVec3::Y };
    floor.solid_mut().unwrap().paint = Paint::Checker { a: [0.0; 3], b: [1.0; 3], size: 0.25 };
    floor.solid_mut().unwrap().mirror = true;
    floor.solid_mut().unwrap().roughness = [0.25, 0.5];
    floor.visible = false;
    floor.shape = Shape::Torus { center: DVec3::ZERO, major: 2.0, minor: 0.5, segments: 12, rings: 8 };
    let shape = Shape::Lathe { profile: vec![[0.0, 0.0], [1.0, 0.5], [0.0, 1.0]], segments: 128 };
    scene.objects.push(Object {
        visible: false,
        transform: Transform { scale: DVec3::new(1.0, -2.0, 3.0), ..Transform::IDENTITY },
        ..Object::new("lamp", shape, Light::of_radiance([3.0, 2.0, 1.0]))
    });
    let text = assert_faithful(&scene);
    assert!(text.contains("# The thing itself.") && text.contains("# called so"), "{text}");
}

#[test]
fn hidden_is_said_of_what_is_hidden_only() {
    let mut scene = read(TEXT);
    assert!(scene.objects.iter().all(|object| object.visible));
    scene.objects[0].visible = false;
    let text = assert_faithful(&scene);
    assert_eq!(text.matches("visible").count(), 1, "{text}");
    let mut hidden = read(&text);
    hidden.objects[0].visible = true;
    assert!(!to_text(&hidden).contains("visible"), "{}", to_text(&hidden));
    // What says the default says it still.
    let plain = TEXT.replace("name = \"ball\"", "name = \"ball\"\nvisible = true");
    assert_eq!(to_text(&read(&plain)), plain);
}

#[test]
fn objects_come_go_move_and_are_renamed() {
    let mut scene = read(TEXT);
    let ball = scene.objects.refractors()[0].clone();
    scene.objects.push(Object { name: "first".into(), ..ball.clone() });
    scene.objects.refractors_mut().swap(0, 1);
    scene.objects.push(Object { name: "last".into(), ..ball });
    assert_faithful(&scene);
    scene.objects.remove(1);
    scene.media.swap(0, 1);
    scene.objects.solids_mut()[0].name = "ground".into();
    let text = assert_faithful(&scene);
    assert!(!text.contains("\"ball\"") && !text.contains("\"floor\""), "{text}");
    // New ones around one with a subtable, and then in another order.
    let ground = scene.objects.solids()[0].clone();
    let quad = |center| Shape::Quad { center, edge_u: DVec3::Z, edge_v: DVec3::X };
    scene.objects.push(Object { name: "before".into(), shape: quad(DVec3::Y), ..ground.clone() });
    scene.objects.solids_mut().swap(0, 1);
    scene.objects.push(Object { name: "after".into(), shape: quad(DVec3::X), ..ground });
    assert_faithful(&scene);
    let source = Source { path: "remarked.toml".into(), text: to_text(&scene), is_builtin: false, import: None };
    scene.source = Some(std::sync::Arc::new(source));
    scene.objects.solids_mut().rotate_left(1);
    assert_faithful(&scene);
    scene.objects.clear(Kind::Solid);
    scene.objects.clear(Kind::Refractor);
    let text = assert_faithful(&scene);
    assert!(!text.contains("[[refractor]]") && !text.contains("[solid.shape"), "{text}");
}

#[test]
fn a_scene_without_source_is_written_whole() {
    for scene in builtin::all() {
        let mut description = formats::open(scene.name).unwrap();
        description.source = None;
        let text = to_text(&description);
        let again = parse_text_only(&text, Path::new("scene.toml")).unwrap();
        assert_eq!(again.media, description.media, "{text}");
        assert_eq!((again.camera, &again.world), (description.camera, &description.world));
        assert!(again.objects.iter().map(|o| &o.name).eq(description.objects.iter().map(|o| &o.name)), "{text}");
    }
}

#[test]
fn saved_elsewhere_it_still_finds_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |path: &str| folder.path().join(path);
    for sub in ["a/meshes", "b"] {
        std::fs::create_dir_all(at(sub)).unwrap();
    }
    std::fs::write(at("a/meshes/m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(
        at("a/s.toml"),
        TEXT.replace("sphere = { center = [0, 0, 0], radius = 1 }", "mesh = \"meshes/m.obj\""),
    )
    .unwrap();
    let scene = formats::file(&at("a/s.toml")).unwrap();
    save(&scene, &at("b/s.toml")).unwrap();
    let again = formats::file(&at("b/s.toml")).unwrap();
    let Shape::Mesh { path, mesh, .. } = &again.objects.refractors()[0].shape else { panic!("no mesh") };
    assert_eq!((path.as_path(), mesh.triangles.len()), (Path::new("../a/meshes/m.obj"), 1));
    // Back again, over itself.
    save(&again, &at("a/s.toml")).unwrap();
    assert_eq!(formats::file(&at("a/s.toml")).unwrap().objects[0].shape, scene.objects.refractors()[0].shape);
}

/// Whatever the scene was before, what was added goes by a path within the scene's folder where it lies there.
#[test]
fn what_is_added_goes_with_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let at = |path: &str| folder.path().join(path);
    for sub in ["a/meshes", "b"] {
        std::fs::create_dir_all(at(sub)).unwrap();
    }
    let file = at("a/meshes/m.obj");
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let named = |path: &str| {
        let scene = formats::file(&at(path)).unwrap();
        let Shape::Mesh { path, .. } = &scene.objects.find("ball").unwrap().shape else { panic!("no mesh") };
        path.clone()
    };
    let fresh = Description { source: None, ..read(TEXT) };
    std::fs::write(at("a/mine.toml"), TEXT).unwrap();
    let saved = formats::file(&at("a/mine.toml")).unwrap();
    let built_in = Description { source: formats::open("siblings").unwrap().source, ..read(TEXT) };
    for mut scene in [fresh, saved, built_in] {
        let (mesh, notes) = formats::mesh_from_file(&file).unwrap();
        let ball = scene.objects.iter_mut().find(|object| object.name == "ball").unwrap();
        ball.shape = Shape::Mesh { path: file.clone(), part: MeshPart::default(), mesh: mesh.into(), notes };
        for (target, expected) in
            [("a/s.toml", Path::new("meshes/m.obj")), ("a/meshes/s.toml", Path::new("m.obj")), ("b/s.toml", &*file)]
        {
            save(&scene, &at(target)).unwrap();
            assert_eq!(named(target), expected, "{target}");
        }
    }
    // A path that the file itself has is not touched.
    let text = TEXT.replace("sphere = { center = [0, 0, 0], radius = 1 }", &format!("mesh = '{}'", file.display()));
    std::fs::write(at("a/own.toml"), &text).unwrap();
    save(&formats::file(&at("a/own.toml")).unwrap(), &at("a/own.toml")).unwrap();
    assert_eq!(std::fs::read_to_string(at("a/own.toml")).unwrap(), text);
}

#[test]
fn a_saved_built_in_scene_brings_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let scene = formats::open("plain-glass").unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(folder.path().join("evening.exr"), "another file of that name").unwrap();
    save(&scene, &path).unwrap();
    save(&scene, &path).unwrap();
    let again = formats::file(&path).unwrap();
    let Environment::Image { path: image, .. } = &again.environment else { panic!("no image") };
    assert_eq!(image, Path::new("evening-2.exr"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn a_place_that_cannot_be_written_is_an_error() {
    let scene = read(TEXT);
    let folder = tempfile::tempdir().unwrap();
    let error = save(&scene, &folder.path().join("no/such/folder/s.toml")).unwrap_err();
    assert!(error.to_string().contains("there is no folder"), "{error}");
    assert!(save(&scene, folder.path()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

/// Notations that the editor of TOML would not write itself.
const ODD: [&str; 5] = [
    // Inline tables, in arrays and of their own; a table of dotted keys; odd spaces; numbers in every form.
    "name   =   'odd'\ncamera={position=[ 0,1 , +4.0 ],target=[0e0,0.0_0,-0.0], }\n\
     medium = [ { name = \"glass\",   ior=1.50 } , # clear\n   { name=\"water\" , ior = {catalog=\"water\"} },\n]\n\
     [[refractor]]\n  name=\"ball\"\n  medium = \"glass\"\n  shape.sphere.center = [0,0,0]\n  shape.sphere.radius = 1\n\
     \n  transform.translate = [ 0 , 1e0, 0]  # up\n  transform.scale = 2\n",
    // Sections in any order, of several kinds in turn, with their parts in tables of their own.
    "[[solid]]\nname = \"floor\"\n[solid.shape.quad]\nedge_u = [0, 0, 4] # long\nedge_v = [4, 0, 0]\ncenter = [0, -1, 0]\n[solid.transform]\nscale = 1\nrotate = [0, 0, 0]\n\
     [[light]]\nname = \"lamp\"\nradiance = [\n  1, # red\n  2,\n  3,\n]\nshape = { sphere = { center = [0, 3, 0], radius = 0.1 } }\n\
     [camera]\ntarget = [0, 0, 0]\n\n\nposition = [0, 0, 5]\n[[solid]]\nname = \"wall\"\nvisible = true\nshape = { quad = { center = [0, 0, -2], edge_u = [1, 0, 0], edge_v = [0, 1, 0] } }\n# the end",
    // No end of the last line, tabs, a string of several lines, a quoted key.
    "\"name\" = \"\"\"\nof two\nlines\"\"\"\n[camera]\n\tposition\t=\t[0,0,1]\n\ttarget\t=\t[0,0,0]\n\n\n",
    // A profile of several lines.
    "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[medium]]\nname = \"glass\"\nior = 1.5\n[[refractor]]\nname = \"vase\"\nmedium = \"glass\"\n\
     shape = { lathe = { profile = [\n  [0.0, 0.00],  # foot\n  [0.5, 0.50],\n  [0.0, 1.00],\n], segments = 16 } }\n",
    // Dotted keys that take turns.
    "camera.position = [0, 0, 1]\nworld.ior = 1.1\ncamera.target = [0, 0, 0]\nworld.absorption = [0, 0, 0]\n",
];

/// The same with other ends of lines and with a byte-order mark.
fn variants(text: &str) -> Vec<String> {
    let crlf = text.replace('\n', "\r\n");
    let mixed = text.replacen('\n', "\r\n", text.matches('\n').count() / 2);
    let mut all = vec![text.to_owned(), crlf, mixed];
    // Those that can be read.
    let marked: Vec<String> = all.iter().map(|text| format!("\u{feff}{text}")).collect();
    all.extend(marked.into_iter().filter(|text| formats::parse(text, Path::new("odd.toml"), &formats::Disk).is_ok()));
    all
}

#[test]
fn odd_notations_are_not_touched() {
    for text in ODD.iter().flat_map(|text| variants(text)) {
        assert_eq!(to_text(&read(&text)), text);
    }
    for scene in builtin::all() {
        let text = scene.text.replace('\n', "\r\n");
        let description =
            formats::parse(&text, Path::new(&format!("built-in/scenes/{}.toml", scene.name)), &formats::BuiltIn)
                .unwrap();
        assert_eq!(to_text(&description), text, "{}", scene.name);
    }
}

/// Lines that differ, ends of lines included.
fn differing(a: &str, b: &str) -> Vec<(String, String)> {
    let (a, b): (Vec<&str>, Vec<&str>) = (a.split_inclusive('\n').collect(), b.split_inclusive('\n').collect());
    assert_eq!(a.len(), b.len(), "{b:?}");
    a.iter().zip(b).filter(|(a, b)| **a != *b).map(|(a, b)| ((*a).to_owned(), b.to_owned())).collect()
}

#[test]
fn an_edit_of_an_odd_notation_changes_its_line_only() {
    type Edit = fn(&mut Description);
    const HALF: Shape = Shape::Sphere { center: DVec3::ZERO, radius: 0.5 };
    let edits: [(usize, Edit, &str, &str); 11] = [
        (0, |s| s.camera.position.z = 3.5, "+4.0 ]", "3.5 ]"),
        (0, |s| s.media[0].ior = Ior::Constant(1.6), "ior=1.50 }", "ior=1.6 }"),
        (0, |s| s.media[1].name = "ice".into(), "name=\"water\"", "name=\"ice\""),
        (0, |s| s.objects[0].transform.translate.y = 2.0, "[ 0 , 1e0, 0]  # up", "[ 0 , 2.0, 0]  # up"),
        (0, |s| s.objects[0].transform.scale = DVec3::splat(3.0), "scale = 2", "scale = 3.0"),
        (0, |s| s.objects[0].shape = HALF, "radius = 1", "radius = 0.5"),
        (1, |s| s.objects[2].light_mut().unwrap().emission.rgb[1] = 7.0, "  2,", "  7.0,"),
        (1, |s| s.objects[0].transform.scale = DVec3::splat(2.0), "scale = 1", "scale = 2.0"),
        (1, |s| s.objects[1].visible = false, "visible = true", "visible = false"),
        (2, |s| s.camera.position.x = 1.0, "[0,0,1]", "[1.0,0,1]"),
        (
            3,
            |s| {
                let Shape::Lathe { profile, .. } = &mut s.objects[0].shape else { panic!("no lathe") };
                profile[1][0] = 0.25;
            },
            "[0.5, 0.50]",
            "[0.25, 0.50]",
        ),
    ];
    for (which, edit, from, to) in edits {
        for text in variants(ODD[which]) {
            let mut scene = read(&text);
            edit(&mut scene);
            let saved = assert_faithful(&scene);
            assert_eq!(saved, text.replacen(from, to, 1), "{from} → {to}");
            assert_eq!(differing(&text, &saved).len(), 1, "{from} → {to}");
        }
    }
}

#[test]
fn inline_lists_come_go_and_move() {
    let mut scene = read(ODD[0]);
    let glass = scene.media[0].clone();
    scene.media.push(Medium { name: "ice".into(), absorption: [0.1; 3], ..glass });
    let text = assert_faithful(&scene);
    assert!(text.contains("{ name = \"glass\",   ior=1.50 }") && !text.contains("[[medium]]"), "{text}");
    assert_eq!(text.matches("# clear").count(), 1, "{text}");
    scene.media.rotate_left(1);
    assert_faithful(&scene);
    scene.objects.clear(Kind::Refractor);
    scene.media.clear();
    let text = assert_faithful(&scene);
    assert!(!text.contains("medium"), "{text}");
}

#[test]
fn many_media_are_saved_in_time_that_grows_with_their_number() {
    let scene = |count: u32| {
        let media = (0..count).map(|i| format!("[[medium]]\nname = \"medium{i}\"\nior = 1.5\n"));
        let objects = (0..count).map(|i| {
            format!(
                "[[refractor]]\nname = \"ball{i}\"\nmedium = \"medium{i}\"\nshape = {{ sphere = {{ center = [{}, 0, 0], radius = 1 }} }}\n",
                3 * i
            )
        });
        let camera = "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n".to_owned();
        std::iter::once(camera).chain(media).chain(objects).collect::<String>()
    };
    let seconds = |count: u32| {
        let text = scene(count);
        let start = std::time::Instant::now();
        let mut description = read(&text);
        description.media[0].ior = Ior::Constant(1.25);
        assert_eq!(to_text(&description), text.replacen("ior = 1.5", "ior = 1.25", 1));
        start.elapsed().as_secs_f64()
    };
    // Of several, the least disturbed.
    let least = |count| (0..3).map(|_| seconds(count)).fold(f64::INFINITY, f64::min);
    let (few, many) = (least(1000), least(16_000));
    assert!(many < 64.0 * few, "16 times the media take {:.1} times as long", many / few);
}

const LIGHTS: &str = r#"[camera]
position = [0, 1, 4]
target = [0, 0, 0]

[[light]]
name = "bulb"
point = { position = [0, 3, 0] }   # above the table
power = [60, 50, 40]

[[light]]
name = "spot"
spot = { position = [0, 3, 0], target = [0, 0, 0], inner_angle = 20, outer_angle = 30.5 }
intensity = [10, 10, 10]
transform = { translate = [1, 0, 0] }

[[light]]
name = "sun"
directional = { direction = [1, -1, 0], angle = 0.53 }
irradiance = [3, 3, 2.5]

[[light]]
name = "moon"
irradiance = [0.1, 0.1, 0.2]
[light.directional]
direction = [-1, -1, 0]

[[light]]
name = "panel"
shape = { quad = { center = [0, 2, 0], edge_u = [1, 0, 0], edge_v = [0, 0, 1] } }
power = [5, 5, 5]
two_sided = true
"#;

#[test]
fn lights_of_every_kind_are_read_and_written() {
    let scene = read(LIGHTS);
    assert_eq!(assert_faithful(&scene), LIGHTS);
    let lights: Vec<(Shape, Light)> =
        scene.objects.lights().iter().map(|object| (object.shape.clone(), object.light().unwrap().clone())).collect();
    let at = DVec3::Y * 3.0;
    let sun = Shape::Directional { direction: DVec3::new(1.0, -1.0, 0.0), angle: 0.53 };
    let expected = [
        (Shape::Point { position: at }, Light::of(Quantity::Power, [60.0, 50.0, 40.0])),
        (
            Shape::Spot { position: at, target: DVec3::ZERO, inner_angle: 20.0, outer_angle: 30.5 },
            Light::of(Quantity::Intensity, [10.0; 3]),
        ),
        (sun, Light::of(Quantity::Irradiance, [3.0, 3.0, 2.5])),
        (
            Shape::Directional { direction: DVec3::new(-1.0, -1.0, 0.0), angle: 0.0 },
            Light::of(Quantity::Irradiance, [0.1, 0.1, 0.2]),
        ),
        (
            Shape::Quad { center: DVec3::Y * 2.0, edge_u: DVec3::X, edge_v: DVec3::Z },
            Light { two_sided: true, ..Light::of(Quantity::Power, [5.0; 3]) },
        ),
    ];
    assert_eq!(lights, expected);
    // Written from nothing.
    let again = assert_faithful(&Description { source: None, ..scene.clone() });
    assert!(again.contains("irradiance") && !again.contains("angle = 0.0\n"), "{again}");

    // Each edit changes its line.
    fn light<'a>(scene: &'a mut Description, name: &str) -> &'a mut Object {
        scene.objects.find_mut(name).unwrap()
    }
    type Edit = fn(&mut Description);
    let edits: [(Edit, &str, &str); 6] = [
        (|s| light(s, "bulb").light_mut().unwrap().emission.rgb[0] = 61.0, "[60, 50", "[61.0, 50"),
        (|s| light(s, "bulb").shape = Shape::Point { position: DVec3::Y }, "[0, 3, 0] }   #", "[0, 1.0, 0] }   #"),
        (|s| light(s, "panel").light_mut().unwrap().two_sided = false, "two_sided = true\n", ""),
        (
            |s| light(s, "panel").light_mut().unwrap().emission.quantity = Quantity::Radiance,
            "power = [5, 5, 5]\ntwo_sided = true\n",
            "two_sided = true\nradiance = [5.0, 5.0, 5.0]\n",
        ),
        (|s| light(s, "spot").transform.translate.x = 2.0, "[1, 0, 0] }\n\n", "[2.0, 0, 0] }\n\n"),
        (
            |s| light(s, "sun").shape = Shape::Directional { direction: DVec3::new(1.0, -1.0, 0.0), angle: 1.0 },
            "0.53",
            "1.0",
        ),
    ];
    for (edit, from, to) in edits {
        let mut edited = scene.clone();
        edit(&mut edited);
        assert_eq!(assert_faithful(&edited), LIGHTS.replacen(from, to, 1), "{from}");
    }
    // Another kind in its place.
    let mut other = scene;
    light(&mut other, "bulb").shape = Shape::Sphere { center: at, radius: 0.25 };
    let text = assert_faithful(&other);
    assert!(text.contains("sphere") && !text.contains("point ="), "{text}");
}

const WINE: &str = "o glass\nusemtl clear\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no drink\nusemtl red\nv 0 0 1\nv 5 0 1\nv 0 5 1\nf 4 5 6\nf 6 5 4\n";

fn wine(shapes: &[&str]) -> Result<Description, SceneError> {
    let mut text = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n".to_owned();
    for (number, shape) in shapes.iter().enumerate() {
        text += &format!("[[solid]]\nname = \"s{number}\"\nshape = {{ {shape} }}\n");
    }
    let files = formats::Memory([("wine.obj".into(), WINE.into())].into());
    formats::parse(&text, Path::new("s.toml"), &files)
}

#[test]
fn parts_of_a_file_are_objects_of_their_own() {
    let whole = r#"mesh = "wine.obj""#;
    let glass = r#"mesh = "wine.obj", group = "glass""#;
    let red = r#"mesh = "wine.obj", material = "red""#;
    let both = r#"mesh = "wine.obj", group = "drink", material = "red""#;
    let scene = wine(&[whole, glass, red, both, glass]).unwrap();
    let mesh = |index: usize| match &scene.objects[index].shape {
        Shape::Mesh { mesh, .. } => mesh,
        other => panic!("no mesh: {other:?}"),
    };
    let sizes = [0, 1, 2, 3].map(|index| (mesh(index).triangles.len(), mesh(index).positions.len()));
    assert_eq!(sizes, [(3, 6), (1, 3), (2, 3), (2, 3)]);
    assert_eq!(mesh(2).positions[1], DVec3::new(5.0, 0.0, 1.0));
    assert!(std::sync::Arc::ptr_eq(mesh(1), mesh(4)), "one part is read once");
    // The text says the same again, and so does one that is written anew.
    assert_eq!(to_text(&scene), scene.source.as_ref().unwrap().text);
    let anew = to_text(&Description { source: None, ..scene.clone() });
    for shape in [glass, red, both] {
        assert!(anew.contains(&format!("shape = {{ {shape} }}")), "{anew}");
    }
    // What is in the file counts, not by which name it was taken.
    let as_one = |shape| wine(&[shape]).unwrap().fingerprint();
    assert_eq!(as_one(red), as_one(both));
    assert_ne!(as_one(red), as_one(glass));
    // Another part takes the place of one.
    let mut edited = scene.clone();
    edited.objects[1].shape = scene.objects[2].shape.clone();
    assert!(to_text(&edited).contains(&format!("name = \"s1\"\nshape = {{ {red} }}")), "{}", to_text(&edited));
}

#[test]
fn a_part_that_is_not_there_is_told_where_it_is_named() {
    let message = |shape| wine(&[shape]).unwrap_err().to_string();
    assert_eq!(
        message(r#"mesh = "wine.obj", group = "drnik""#),
        "s.toml:6:38: the mesh wine.obj has no group `drnik`; did you mean `drink`?; groups: glass, drink"
    );
    assert!(message(r#"mesh = "wine.obj", material = """#).starts_with("s.toml:6:41: `material` is empty"));
    assert!(message(r#"mesh = "wine.obj", groop = "glass""#).contains("did you mean `group`?"));
    assert!(message(r#"sphere = { center = [0, 0, 0], radius = 1 }, group = "glass""#).contains("unknown key `group`"));
}

/// Two nodes with one mesh, a third with another whose node has the first one's name, and one that is sheared.
fn gltf() -> Vec<u8> {
    use base64::Engine;
    let corners: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces: [u8; 12] = [0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3];
    let bytes = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).chain(faces).collect::<Vec<u8>>();
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{"asset": {{"version": "2.0"}},
        "nodes": [{{"mesh": 0, "name": "a/b"}}, {{"mesh": 0, "name": "c", "translation": [3, 0, 0]}}, {{"mesh": 1, "name": "a/b"}},
            {{"mesh": 0, "name": "leaning", "matrix": [1, 0, 0, 0, 0.1, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}},
            {{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 2}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}},
            {{"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 12}}],
        "buffers": [{{"byteLength": 60, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
    )
    .into_bytes()
}

/// Its meshes go beside the scene file, each once, and no file of somebody else's is lost.
#[test]
fn a_scene_of_another_format_is_saved_with_its_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |path: &str| folder.path().join(path);
    std::fs::write(at("set.gltf"), gltf()).unwrap();
    std::fs::create_dir_all(at("out/mine-meshes")).unwrap();
    std::fs::write(at("out/mine-meshes/a-b.ply"), "another file of that name").unwrap();
    let scene = formats::open(at("set.gltf")).unwrap();
    save(&scene, &at("out/mine.toml")).unwrap();
    let files = || {
        let entries = std::fs::read_dir(at("out/mine-meshes")).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(files(), ["a-b 2.ply", "a-b-2.ply", "a-b.ply", "leaning.ply"]);
    assert_eq!(std::fs::read(at("out/mine-meshes/a-b.ply")).unwrap(), b"another file of that name");
    let again = formats::open(at("out/mine.toml")).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint());
    let path = |index: usize| match &again.objects[index].shape {
        Shape::Mesh { path, .. } => path.clone(),
        other => panic!("no mesh: {other:?}"),
    };
    assert_eq!((path(0), path(1)), (path(1), "mine-meshes/a-b-2.ply".into()));
    // Saving once more changes nothing.
    let text = std::fs::read_to_string(at("out/mine.toml")).unwrap();
    save(&scene, &at("out/mine.toml")).unwrap();
    assert_eq!((files().len(), std::fs::read_to_string(at("out/mine.toml")).unwrap()), (4, text));
    // Nothing is written over the file itself.
    let refused = save(&scene, &at("set.gltf")).unwrap_err().to_string();
    assert!(refused.contains(".toml") && std::fs::read(at("set.gltf")).unwrap() == gltf(), "{refused}");
    // What was added from elsewhere stays where it is.
    let mut added = scene.clone();
    std::fs::write(at("wine.obj"), WINE).unwrap();
    added.objects[0].shape = Shape::mesh("wine.obj", formats::mesh_from_file(&at("wine.obj")).unwrap().0);
    save(&added, &at("out/mine.toml")).unwrap();
    assert!(std::fs::read_to_string(at("out/mine.toml")).unwrap().contains("mesh = \"../wine.obj\""));
}
