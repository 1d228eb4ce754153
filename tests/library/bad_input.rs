//! Bad scenes: each is one clear error that names file and place, and nothing panics.

use std::path::Path;
use std::sync::Arc;

use crate::common::{Numbers, add, empty, ready, render, sphere};
use glam::DVec3;
use iorect::check::check;
use iorect::formats::{self, builtin};
use iorect::geometry::Mesh;
use iorect::rectify::PatchKind;
use iorect::scene::description::{Description, Object, Paint, Shape, Solid};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

const CAMERA: &str = "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n";
const GLASS: &str = "[[medium]]\nname = \"glass\"\nior = 1.5\n";

/// The error for a scene's text.
fn fault(text: &str) -> String {
    match formats::parse(text, Path::new("bad.toml"), &formats::Disk) {
        Ok(_) => panic!("this was read without complaint:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Asserts that a scene is refused at a place, with all of some words.
fn refused(text: &str, line: usize, column: usize, words: &[&str]) {
    let message = fault(text);
    assert!(message.starts_with(&format!("bad.toml:{line}:{column}: ")), "{message}\n{text}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

/// A scene with one refractor of a shape, which begins on line 10.
fn with_shape(shape: &str) -> String {
    format!("{CAMERA}{GLASS}[[refractor]]\nname = \"a\"\nmedium = \"glass\"\nshape = {shape}\n")
}

#[test]
fn text_that_is_no_toml() {
    refused("[camera\n", 1, 8, &[]);
    refused("name = \"a\"\nname = \"b\"\n", 2, 1, &["duplicate key"]);
    refused(&format!("{CAMERA}vertical_fov = 3O\n"), 4, 16, &[]);
}

#[test]
fn unknown_and_missing_keys() {
    refused(&format!("colour = 1\n{CAMERA}"), 1, 1, &["unknown key `colour`", "camera, world, environment"]);
    refused(
        &format!("{CAMERA}verticalfov = 30\n"),
        4,
        1,
        &["unknown key `verticalfov` in [camera]", "did you mean `vertical_fov`?", "valid keys: position, target, up"],
    );
    refused(
        &format!("{CAMERA}[[medium]]\nname = \"a\"\nior = 1.5\ncolor = [1, 1, 1]\n"),
        7,
        1,
        &["[[medium]]", "absorption"],
    );
    refused(&with_shape("{ sphere = { center = [0, 0, 0], raduis = 1 } }"), 10, 42, &["did you mean `radius`?"]);
    refused(&with_shape("{ sphere = { center = [0, 0, 0] } }"), 10, 20, &["lacks `radius`"]);
    refused(&with_shape("{ spere = {} }"), 10, 11, &["did you mean `sphere`?", "cylinder, torus, lathe"]);
    assert!(fault("").contains("the scene lacks `camera`"));
    refused("[camera]\nposition = [0, 0, 0]\n", 1, 1, &["[camera] lacks `target`"]);
}

#[test]
fn wrong_types() {
    refused(
        "[camera]\nposition = \"here\"\ntarget = [0, 0, 1]\n",
        2,
        12,
        &["`position` must be an array of 3 numbers, found a string"],
    );
    refused("[camera]\nposition = [0, 1]\ntarget = [0, 0, 1]\n", 2, 12, &["must be an array of 3 numbers, found 2"]);
    refused(
        "[camera]\nposition = [0, 1, true]\ntarget = [0, 0, 1]\n",
        2,
        19,
        &["element 3 of `position` must be a number, found a boolean"],
    );
    refused("camera = 3\n", 1, 10, &["`camera` must be a table, found an integer"]);
    refused(&format!("{CAMERA}[medium]\nname = \"a\"\n"), 4, 1, &["[[medium]]"]);
    refused(&format!("{CAMERA}[[medium]]\nname = \"a\"\nior = \"1.5\"\n"), 6, 7, &["must be a number", "catalog"]);
    refused(
        &with_shape("{ icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 2.5 } }"),
        10,
        72,
        &["whole number"],
    );
    refused(
        &(with_shape("{ sphere = { center = [0, 0, 0], radius = 1 } }") + "smooth = 1\n"),
        11,
        10,
        &["true or false"],
    );
}

#[test]
fn impossible_cameras() {
    refused("[camera]\nposition = [1, 2, 3]\ntarget = [1, 2, 3]\n", 3, 10, &["no direction"]);
    refused(&format!("{CAMERA}up = [0, 0, 0]\n"), 4, 6, &["`up`"]);
    refused(&format!("{CAMERA}up = [0, 0, -2]\n"), 4, 6, &["`up`"]);
    refused(&format!("{CAMERA}vertical_fov = 180\n"), 4, 16, &["180"]);
    refused(&format!("{CAMERA}vertical_fov = 0\n"), 4, 16, &["greater than 0"]);
    refused(&format!("{CAMERA}aperture_radius = -1\n"), 4, 19, &["0 or more"]);
    refused(&format!("{CAMERA}focus_distance = 0\n"), 4, 18, &["greater than 0"]);
    refused("[camera]\nposition = [nan, 0, 0]\ntarget = [0, 0, 0]\n", 2, 13, &["NaN, must be finite"]);
    refused("[camera]\nposition = [0, inf, 0]\ntarget = [0, 0, 0]\n", 2, 16, &["inf, must be finite"]);
}

#[test]
fn impossible_media() {
    let medium = |ior: &str| format!("{CAMERA}[[medium]]\nname = \"m\"\nior = {ior}\n");
    for ior in ["0", "0.0", "-1.5", "nan", "inf", "-inf"] {
        refused(&medium(ior), 6, 7, &["`ior` is"]);
        refused(&format!("{CAMERA}[world]\nior = {ior}\n"), 5, 7, &["`ior` is"]);
    }
    refused(&medium("{ catalog = \"watr\" }"), 6, 19, &["no `watr`", "did you mean `water`?", "diamond"]);
    refused(&medium("{ cauchy = [1.5, 0.01] }"), 6, 18, &["3 numbers"]);
    refused(&medium("{ cauchy = [-3, 0, 0] }"), 6, 7, &["gives an IOR of -3"]);
    refused(&medium("{ sellmeier = [] }"), 6, 21, &["pairs [B, C]"]);
    refused(&medium("{ sellmeier = [[-5, 0.01]] }"), 6, 7, &["NaN"]);
    refused(&medium("{ catalog = \"water\", cauchy = [1, 0, 0] }"), 6, 7, &["exactly one of"]);
    refused(&medium("{}"), 6, 7, &["exactly one of"]);
    refused(&format!("{}absorption = [0, -1, 0]\n", medium("1.5")), 7, 14, &["element 2", "-1", "0 or more"]);
    refused(&format!("{CAMERA}[world]\nabsorption = [0, 0, inf]\n"), 5, 21, &["finite"]);
    refused(&format!("{CAMERA}[[medium]]\nname = \"world\"\nior = 1.5\n"), 5, 8, &["reserved"]);
    refused(&format!("{CAMERA}[[medium]]\nname = \"vacuum\"\nior = 1.5\n"), 5, 8, &["reserved"]);
    refused(&format!("{CAMERA}{GLASS}{GLASS}"), 8, 8, &["two media called `glass`"]);
    refused(&format!("{CAMERA}[[medium]]\nname = \" \"\nior = 1.5\n"), 5, 8, &["empty"]);
}

#[test]
fn impossible_objects() {
    let ball = "shape = { sphere = { center = [0, 0, 0], radius = 1 } }\n";
    let object = |medium: &str| format!("{CAMERA}{GLASS}[[refractor]]\nname = \"a\"\nmedium = \"{medium}\"\n{ball}");
    refused(&object("glas"), 9, 10, &["no medium `glas`", "did you mean `glass`?", "media: glass"]);
    refused(&object("water"), 9, 10, &["the catalogue has it", "media: glass"]);
    refused(&object("world"), 9, 10, &["reserved"]);
    let whole = object("glass");
    refused(&format!("{whole}[[solid]]\nname = \"a\"\n{ball}"), 12, 8, &["already a refractor called `a`"]);
    refused(&format!("{CAMERA}[[light]]\nname = \"vacuum\"\n{ball}radiance = [1, 1, 1]\n"), 5, 8, &["reserved"]);
    refused(&format!("{whole}priority = 3000000000\n"), 11, 12, &["-2147483648 to 2147483647"]);
    refused(&format!("{whole}roughness = 2\n"), 11, 13, &["between 0 and 1"]);
    refused(&format!("{whole}roughness = [0.5, -1]\n"), 11, 13, &["element 2", "between 0 and 1"]);
    refused(&format!("{whole}roughness = [0.5, 0.1, 0.1]\n"), 11, 13, &["2 numbers"]);
    refused(&format!("{CAMERA}[[solid]]\nname = \"s\"\n{ball}roughness = 0.1\n"), 7, 13, &["belongs to a mirror"]);
    refused(&format!("{whole}transform = {{ scale = 0 }}\n"), 11, 23, &["must not be 0"]);
    refused(&format!("{whole}transform = {{ scale = [1, 0, 1] }}\n"), 11, 23, &["must not be 0"]);
    refused(&format!("{whole}transform = {{ scale = [1, 2, 1] }}\n"), 11, 13, &["use an `icosphere`"]);
    refused(&format!("{whole}transform = {{ rotate = [0, 0] }}\n"), 11, 24, &["3 numbers"]);
    refused(
        &format!("{CAMERA}[[solid]]\nname = \"s\"\n{ball}color = [0.5, 1.5, 0.5]\n"),
        7,
        9,
        &["element 2", "between 0 and 1"],
    );
    refused(
        &format!(
            "{CAMERA}[[solid]]\nname = \"s\"\n{ball}color = [0, 0, 0]\nchecker = {{ a = [0, 0, 0], b = [1, 1, 1], size = 1 }}\n"
        ),
        8,
        11,
        &["both `color` and `checker`"],
    );
    refused(
        &format!("{CAMERA}[[solid]]\nname = \"s\"\n{ball}checker = {{ a = [0, 0, 0], b = [1, 1, 1], size = 0 }}\n"),
        7,
        50,
        &["greater than 0"],
    );
    refused(&format!("{CAMERA}[[light]]\nname = \"l\"\n{ball}radiance = [-1, 0, 0]\n"), 7, 12, &["0 or more"]);
    refused(&format!("{CAMERA}[[light]]\nname = \"l\"\n{ball}"), 4, 1, &["light `l` lacks `radiance`"]);
    assert!(
        fault(&format!("{CAMERA}[[light]]\nname = \"l\"\n{ball}mirror = true\nradiance = [1, 1, 1]\n"))
            .contains("unknown key `mirror`")
    );
}

#[test]
fn impossible_shapes() {
    for (shape, column, words) in [
        ("{ sphere = { center = [0, 0, 0], radius = 0 } }", 51, &["radius is 0, must be greater than 0"][..]),
        ("{ sphere = { center = [0, 0, 0], radius = -1 } }", 51, &["radius is -1"]),
        ("{ box = { min = [0, 0, 0], max = [1, 0, 1] } }", 42, &["along y"]),
        ("{ cylinder = { center = [0, 0, 0], radius = 1, height = 1, segments = 2 } }", 79, &["3 to"]),
        ("{ cylinder = { center = [0, 0, 0], radius = 1, height = 1, segments = 4294967295 } }", 79, &["3 to"]),
        ("{ cylinder = { center = [0, 0, 0], radius = 1, height = 1, segments = -1 } }", 79, &["`segments` is -1"]),
        ("{ icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 20 } }", 72, &["0 to 8"]),
        ("{ torus = { center = [0, 0, 0], major = 1, minor = 2 } }", 60, &["less than major"]),
        ("{ lathe = { profile = [[0, 0], [1, 0]] } }", 31, &["3 or more"]),
        ("{ lathe = { profile = [[1, 0], [2, 1], [2, 0], [1, 1]] } }", 31, &["crosses"]),
        ("{ quad = { center = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [2, 0, 0] } }", 69, &["parallel"]),
        ("{}", 9, &["exactly one of sphere"]),
        ("{ mesh = \"stone.glb\" }", 18, &["stone.glb", "no such file"]),
        ("{ mesh = \"stone.3ds\" }", 18, &["use .obj, .ply, .stl"]),
        ("{ mesh = \"no-such.obj\" }", 18, &["no-such.obj", "no such file"]),
        ("{ mesh = \"\" }", 18, &["empty"]),
    ] {
        refused(&with_shape(shape), 10, column, words);
    }
}

#[test]
fn impossible_environments() {
    let environment = |text: &str| format!("{CAMERA}[environment]\n{text}\n");
    refused(&environment(""), 4, 1, &["exactly one of color, gradient, image"]);
    refused(&environment("color = [0, 0, 0]\nimage = \"a.exr\""), 4, 1, &["exactly one of"]);
    refused(&environment("color = [0, -1, 0]"), 5, 9, &["0 or more"]);
    refused(&environment("color = [1, 1, 1]\nscale = 2"), 6, 9, &["belongs to an `image`"]);
    refused(&environment("gradient = { zenith = [1, 1, 1], horizon = [1, 1, 1] }"), 5, 12, &["lacks `nadir`"]);
    refused(&environment("image = \"no-such.exr\""), 5, 9, &["no-such.exr", "no such file"]);
    refused(&environment("image = \"sky.bmp\""), 5, 9, &["use .exr, .hdr"]);
}

#[test]
fn faults_in_named_files_are_placed_in_those() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let fault_with = |name: &str, bytes: &[u8], text: &str| {
        std::fs::write(at(name), bytes).unwrap();
        let error = formats::parse(text, &at("s.toml"), &formats::Disk).unwrap_err();
        let place = error.place.clone().unwrap();
        assert_eq!(place.file, at(name), "{error}");
        (place.line_column.map(|(line, _)| line), error.message)
    };
    let mesh = |name: &str| with_shape(&format!("{{ mesh = \"{name}\" }}"));
    let (line, message) = fault_with("m.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n", &mesh("m.obj"));
    assert_eq!((line, message.contains("out of range")), (Some(3), true), "{message}");
    let (_, message) = fault_with("m.obj", b"", &mesh("m.obj"));
    assert!(message.contains("no faces"), "{message}");
    let (_, message) = fault_with("m.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n0123456789", &mesh("m.ply"));
    assert!(message.contains("cut off"), "{message}");
    let image = format!("{CAMERA}[environment]\nimage = \"e.exr\"\n");
    let (_, message) = fault_with("e.exr", b"not an image", &image);
    assert!(message.contains("cannot be decoded"), "{message}");
}

#[test]
fn files_that_cannot_be_read() {
    let message = |name: &str| formats::open(name).unwrap_err().to_string();
    assert!(message("no/such/scene.toml").contains("scene.toml: cannot be read: there is no such file"));
    assert!(message("camera-in-watr").contains("did you mean `camera-in-water`?"));
    let folder = tempfile::tempdir().unwrap();
    assert!(message(folder.path().to_str().unwrap()).contains("is a folder"));
    let path = folder.path().join("latin.toml");
    std::fs::write(&path, b"# ok\nname = \"caf\xe9\"\n").unwrap();
    assert!(message(path.to_str().unwrap()).contains("latin.toml:2:12: is not text"));
}

/// Sizes at the ends of what is accepted can be compiled, and those beyond are refused.
#[test]
fn huge_and_tiny() {
    for size in ["1e18", "1e-18", "1e6", "1e-90"] {
        let ball = format!("{{ icosphere = {{ center = [0, 0, 0], radius = {size}, subdivisions = 1 }} }}");
        let scene = formats::parse(&with_shape(&ball), Path::new("s.toml"), &formats::Disk).unwrap();
        iorect::tracking::prepare(std::sync::Arc::new(scene), None).unwrap();
    }
    refused(&with_shape("{ sphere = { center = [0, 0, 0], radius = 1e19 } }"), 10, 51, &["at most 1e18"]);
    refused(&with_shape("{ sphere = { center = [0, 1e300, 0], radius = 1 } }"), 10, 31, &["too large"]);
    let ball = with_shape("{ sphere = { center = [0, 0, 0], radius = 1 } }");
    refused(&format!("{ball}transform = {{ scale = 1e30 }}\n"), 11, 23, &["1e18"]);
    refused(&format!("{ball}transform = {{ translate = [0, 0, -1e30] }}\n"), 11, 27, &["1e18"]);
}

/// Cuts and flips of a scene that has every section: an error or a scene, never a panic; and what is read can be saved.
#[test]
fn no_damage_makes_it_panic() {
    let text = builtin::find("iced-water").unwrap().text;
    let path = Path::new("built-in/scenes/iced-water.toml");
    let mut read = 0;
    for cut in (0..text.len()).step_by(7).filter(|&cut| text.is_char_boundary(cut)) {
        read += usize::from(formats::parse(&text[..cut], path, &formats::BuiltIn).is_ok());
    }
    let mut random = 1_u64;
    for _ in 0..600 {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..2 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let place = (random >> 33) as usize % bytes.len();
            bytes[place] = b"0123456789-.e[]{}\"'=,#\n xnai"[(random >> 20) as usize % 28];
        }
        let Ok(damaged) = String::from_utf8(bytes) else { continue };
        if let Ok(scene) = formats::parse(&damaged, path, &formats::BuiltIn) {
            read += 1;
            assert_eq!(formats::to_text(&scene), damaged);
        }
    }
    assert!(read > 0, "some damage, as in a comment or a digit, leaves a scene");
}

/// Every mode renders it, and `rectified` sees what `reference` does, but for paths that graze.
fn renders(scene: &Prepared, size: u32) {
    let [rectified, reference] =
        [Mode::Rectified, Mode::Reference].map(|mode| render(scene, mode, (size, size), 1, Some(32)));
    let differing = rectified.sums.iter().zip(&reference.sums).filter(|(a, b)| a != b).count();
    assert!(100 * differing <= rectified.sums.len(), "{differing} pixels differ");
    for mode in Mode::ALL {
        let film = render(scene, mode, (size, size), 1, Some(32));
        assert!(film.sums.iter().all(|sum| sum.is_finite()), "{mode}");
        assert_eq!(film.events.non_finite, 0, "{mode}");
    }
}

fn kinds(scene: &Prepared) -> Vec<&'static str> {
    check(scene).into_iter().map(|problem| problem.kind).collect()
}

/// Objects of scenes that have many: 100,000 by hand, with `IORECT_TEST_OBJECTS`.
fn many() -> u32 {
    std::env::var("IORECT_TEST_OBJECTS").ok().and_then(|text| text.parse().ok()).unwrap_or(4000)
}

/// As near to a cube of `count` places as can be, 2 units apart, about the origin.
fn lattice(count: u32) -> impl Iterator<Item = DVec3> {
    let side = f64::from(count).cbrt().ceil() as u32;
    let at = move |k: u32| 2.0 * f64::from(k) - f64::from(side - 1);
    (0..count).map(move |k| DVec3::new(at(k % side), at(k / side % side), at(k / side / side)))
}

fn before_all(mut description: Description, count: u32) -> Description {
    description.camera.position = DVec3::new(0.3, 0.4, 4.0 * f64::from(count).cbrt());
    description
}

#[test]
fn many_objects_that_are_apart() {
    let count = many();
    let mut description = before_all(empty(1.0), count);
    lattice(count).for_each(|center| add(&mut description, sphere(center, 0.9), 1.5, 0.0));
    let scene = ready(description);
    assert_eq!(scene.table.patches.len() as u32, count);
    assert!(scene.table.patches.iter().all(|p| p.kind == PatchKind::Clear && p.outside_refractor.is_none()));
    assert_eq!(check(&scene), []);
    renders(&scene, 12);
}

#[test]
fn many_pairs_in_one_medium() {
    let count = many();
    let mut description = before_all(empty(1.0), count);
    add(&mut description, sphere(DVec3::ZERO, 4.0 * f64::from(count).cbrt()), 1.1, 0.0);
    for center in lattice(count / 2) {
        add(&mut description, sphere(center, 0.9), 1.3, 0.0);
        add(&mut description, sphere(center + 0.1, 0.5), 1.5, 0.0);
    }
    let scene = ready(description);
    for pair in scene.table.patches[1..].chunks(2) {
        assert_eq!(pair[0].outside_refractor, Some(scene.table.patches[0].refractor));
        assert_eq!(pair[1].outside_refractor, Some(pair[0].refractor));
    }
    assert!(kinds(&scene).iter().all(|kind| *kind == "camera_inside"));
    renders(&scene, 12);
}

/// Each reaches into its six neighbours.
#[test]
fn many_objects_that_overlap() {
    let count = many() / 4;
    let mut description = before_all(empty(1.0), count);
    lattice(count).for_each(|center| add(&mut description, sphere(center, 1.2), 1.5, 0.0));
    let scene = ready(description);
    // One line says how many pairs there are.
    let problems = check(&scene);
    let ties: Vec<_> = problems.iter().filter(|problem| problem.kind == "overlap_tie").collect();
    assert_eq!(ties.len(), 1, "{ties:?}");
    let before = ties[0].message.split(" pairs").next().unwrap_or_default();
    let ties: f64 = before.rsplit(' ').next().and_then(|count| count.parse().ok()).expect("a number of pairs");
    let side = f64::from(count).cbrt();
    assert!(ties <= 3.0 * f64::from(count) && ties > 3.0 * (f64::from(count) - 3.0 * side * side), "{ties}");
    renders(&scene, 8);
}

/// Forty spheres through one circle: where they meet there are 2⁴⁰ ways in which a point may lie in them or not.
#[test]
fn many_surfaces_through_one_curve() {
    let mut description = empty(1.0);
    description.camera.position = DVec3::new(0.0, 3.0, 6.0);
    for k in -20..20 {
        let height = 0.05 * f64::from(k) + 0.025;
        add(&mut description, sphere(DVec3::Y * height, (1.0 + height * height).sqrt()), 1.3, 0.0);
    }
    let scene = ready(description);
    assert!(kinds(&scene).contains(&"overlap_tie"));
    renders(&scene, 16);
}

/// Sheets, bowls and boxes without a lid, here and there.
#[test]
fn only_open_meshes() {
    let mut random = Numbers(5);
    let mut description = empty(1.0);
    description.camera.position = DVec3::new(0.0, 0.0, 12.0);
    for k in 0..120 {
        let center = random.point(DVec3::splat(-3.0), DVec3::splat(3.0));
        let shape = if k % 2 == 0 {
            Shape::Quad { center, edge_u: random.direction(), edge_v: random.direction() }
        } else {
            let mut corners: Vec<DVec3> = (0..4).map(|_| center + random.direction()).collect();
            corners.push(center);
            let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4]];
            Shape::mesh(
                "fan.obj",
                Arc::new(Mesh { positions: corners, normals: Vec::new(), triangles, uvs: Vec::new() }),
            )
        };
        add(&mut description, shape, 1.2 + 0.002 * f64::from(k), 0.0);
    }
    let scene = ready(description);
    let open = kinds(&scene).iter().filter(|kind| **kind == "open_mesh").count();
    assert_eq!(open, 120);
    for mode in Mode::ALL {
        let film = render(&scene, mode, (8, 8), 1, Some(16));
        assert!(film.sums.iter().all(|sum| sum.is_finite()), "{mode}");
    }
}

/// Faces that lie back to back, which is said, and a ball pressed flat, all in one ball.
#[test]
fn objects_without_volume() {
    let mut description = empty(1.0);
    description.camera.position = DVec3::new(0.0, 2.0, 6.0);
    let positions = [DVec3::ZERO, DVec3::X, DVec3::Z].map(|p| p + DVec3::Y * 1.2).to_vec();
    let mesh = Mesh { positions, normals: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 1]], uvs: Vec::new() };
    add(&mut description, Shape::mesh("flat.obj", Arc::new(mesh)), 1.5, 0.0);
    add(&mut description, Shape::Icosphere { center: DVec3::ZERO, radius: 1.0, subdivisions: 3 }, 1.4, 0.0);
    description.objects.refractors_mut()[1].transform.scale.y = 1e-12;
    add(&mut description, sphere(DVec3::ZERO, 2.0), 1.33, 0.0);
    let scene = ready(description);
    assert!(kinds(&scene).contains(&"double_faces"), "{:?}", check(&scene));
    // What is thinner than rounding is not the same to every mode.
    for mode in Mode::ALL {
        let film = render(&scene, mode, (16, 16), 1, Some(32));
        assert!(film.sums.iter().all(|sum| sum.is_finite()), "{mode}");
    }
}

/// The later one fills both, and the picture is that of one.
#[test]
fn two_identical_objects() {
    let shapes = [
        sphere(DVec3::ZERO, 1.0),
        Shape::Icosphere { center: DVec3::new(0.1, 0.0, 0.0), radius: 1.0, subdivisions: 3 },
    ];
    for shape in shapes {
        let [mut twins, mut one] = [(); 2].map(|()| empty(1.1));
        add(&mut twins, shape.clone(), 1.4, 0.2);
        add(&mut twins, shape.clone(), 1.5, 0.1);
        add(&mut one, shape, 1.5, 0.1);
        let [twins, one] = [twins, one].map(ready);
        assert_eq!(kinds(&twins), ["coincident"]);
        let [twins, one] = [twins, one].map(|scene| {
            renders(&scene, 16);
            render(&scene, Mode::Rectified, (16, 16), 4, None)
        });
        assert_eq!(twins.events.total(), 0);
        assert_eq!(twins.sums, one.sums);
    }
}

/// What lies in a stone is not seen, and changes nothing.
#[test]
fn an_object_inside_an_opaque_one() {
    let stone = |with_ball: bool| {
        let mut description = empty(1.0);
        add(&mut description, sphere(DVec3::X * 2.0, 1.0), 1.5, 0.0);
        description.objects.push(Object::new("stone", sphere(DVec3::ZERO, 1.0), Solid::of(Paint::Color([0.5; 3]))));
        if with_ball {
            add(&mut description, sphere(DVec3::new(0.1, 0.0, 0.0), 0.5), 1.3, 0.0);
        }
        ready(description)
    };
    let [with, without] = [true, false].map(|with_ball| {
        let scene = stone(with_ball);
        let said: &[&str] = if with_ball { &["inside_solid"] } else { &[] };
        assert_eq!(kinds(&scene), said);
        renders(&scene, 16);
        render(&scene, Mode::Rectified, (32, 32), 4, None)
    });
    // The local origin is another one, and with it rounding.
    let most = with.sums.iter().zip(&without.sums).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
    assert!(most < 1e-6, "{most}");
    assert_eq!(with.events.total(), 0);
}
