//! Images on solids, held against colours and places worked out by hand.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;
use iorect::formats::{self, Memory};
use iorect::scene::Description;
use iorect::scene::description::{Paint, Shape};
use iorect::tracking::Mode;

use crate::common;

/// Three columns and two rows of sRGB, no two alike: the upper row first.
const TEXELS: [[[u8; 3]; 3]; 2] =
    [[[255, 0, 0], [0, 255, 0], [0, 0, 255]], [[255, 255, 255], [188, 188, 188], [255, 188, 0]]];

/// 188 in linear light (IEC 61966-2-1).
const HALF: f64 = 0.502_886;

/// What the texels are in linear light.
pub fn expected(column: usize, row: usize) -> DVec3 {
    let light = |byte: u8| match byte {
        188 => HALF,
        byte => f64::from(byte) / 255.0,
    };
    DVec3::from(TEXELS[row][column].map(light))
}

pub fn png() -> Vec<u8> {
    let image = image::RgbImage::from_fn(3, 2, |x, y| image::Rgb(TEXELS[y as usize][x as usize]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A scene of one solid in white surroundings, which reads `texels.png` and these files.
fn read(solid: &str, files: &[(&str, &str)]) -> Result<Description, String> {
    let text = format!(
        "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nvertical_fov = 0.0001\n[environment]\ncolor = [1, 1, 1]\n\
         [[solid]]\nname = \"s\"\n{solid}\n"
    );
    let mut all: Memory = Memory([("a/texels.png".into(), png())].into());
    all.0.extend(files.iter().map(|(name, text)| (Path::new("a").join(name), text.as_bytes().to_vec())));
    formats::read(text.as_bytes(), Path::new("a/s.toml"), &all).map_err(|error| error.to_string())
}

/// What is seen from `eye` at `target`: a convex diffuse surface in white surroundings has the radiance of its albedo.
pub fn seen(scene: &Description, eye: DVec3, target: DVec3) -> DVec3 {
    let mut scene = scene.clone();
    (scene.camera.position, scene.camera.target, scene.camera.vertical_fov) = (eye, target, 1e-4);
    scene.camera.up = if (eye - target).normalize().y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    common::render(&common::ready(scene), Mode::Rectified, (1, 1), 4, None).mean(0)
}

#[track_caller]
fn assert_seen(scene: &Description, eye: DVec3, target: DVec3, color: DVec3) {
    let found = seen(scene, eye, target);
    assert!((found - color).abs().max_element() < 2e-4, "at {target}: {found}, not {color}");
}

/// The middle of a texel on a surface of 3 by 2 about the origin, x to the right and y upwards.
fn middle(column: usize, row: usize) -> DVec3 {
    DVec3::new(column as f64 - 1.0, 0.5 - row as f64, 0.0)
}

pub fn texels() -> impl Iterator<Item = (usize, usize)> {
    (0..6).map(|k| (k % 3, k / 3))
}

const QUAD: &str = "shape = { quad = { center = [0, 0, 0], edge_u = [3, 0, 0], edge_v = [0, 2, 0] } }\n";

#[test]
fn a_quad_shows_each_texel_in_its_place() {
    let scene = read(&format!("texture = \"texels.png\"\n{QUAD}"), &[]).unwrap();
    for (column, row) in texels() {
        let target = middle(column, row);
        assert_seen(&scene, target + DVec3::Z * 5.0, target, expected(column, row));
        // Solids have the same colour on both sides.
        assert_seen(&scene, target - DVec3::Z * 5.0, target, expected(column, row));
    }
    // Half way between two texels is half of each; beyond the edge the image begins again.
    let half = DVec3::new(-0.5, 0.5, 0.0);
    assert_seen(&scene, half + DVec3::Z, half, DVec3::new(0.5, 0.5, 0.0));
    let edge = DVec3::new(1.499_9, 0.5, 0.0);
    assert_seen(&scene, edge + DVec3::Z, edge, DVec3::new(0.5, 0.0, 0.5));
    // Two by one repetitions, the second of which begins in the middle; turned, moved and mirrored.
    let twice = read(&format!("texture = \"texels.png\"\nuv = {{ scale = [2, 1] }}\n{QUAD}"), &[]).unwrap();
    let first = DVec3::new(0.25, 0.5, 0.0);
    assert_seen(&twice, first + DVec3::Z, first, expected(0, 0));
    let moved = "uv = { scale = [-1, 1], offset = [0, 0.5] }";
    let moved = read(&format!("texture = \"texels.png\"\n{moved}\n{QUAD}"), &[]).unwrap();
    assert_seen(&moved, middle(0, 1) + DVec3::Z, middle(0, 1), expected(2, 0));
    // Counter-clockwise about the lower left corner: up becomes left, and with that the last column.
    let turned = read(&format!("texture = \"texels.png\"\nuv = {{ rotate = 90 }}\n{QUAD}"), &[]).unwrap();
    let place = DVec3::new(-1.5 + 3.0 * 0.75, -1.0 + 2.0 / 6.0, 0.0);
    assert_seen(&turned, place + DVec3::Z, place, expected(2, 0));
    let tinted = read(&format!("texture = \"texels.png\"\ntint = [0.5, 1, 0]\n{QUAD}"), &[]).unwrap();
    assert_seen(&tinted, middle(0, 1) + DVec3::Z, middle(0, 1), DVec3::new(0.5, 1.0, 0.0));
}

/// A rectangle of 3 by 2 with texture coordinates at its corners, counter-clockwise from the lower left, as OBJ and PLY.
fn rectangles(uv: [[f64; 2]; 4]) -> [(&'static str, String); 2] {
    let corners = [[-1.5, -1.0], [1.5, -1.0], [1.5, 1.0], [-1.5, 1.0]];
    let mut obj = String::new();
    corners.iter().for_each(|[x, y]| obj += &format!("v {x} {y} 0\n"));
    uv.iter().for_each(|[u, v]| obj += &format!("vt {u} {v}\n"));
    obj += "f 1/1 2/2 3/3 4/4\n";
    let mut ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned();
    corners.iter().zip(uv).for_each(|([x, y], [u, v])| ply += &format!("{x} {y} 0 {u} {v}\n"));
    ply += "4 0 1 2 3\n";
    [("m.obj", obj), ("m.ply", ply)]
}

#[test]
fn meshes_have_their_own_coordinates() {
    let upright = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mirrored = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    // Three times across and twice up, from the left of the second and the bottom of the third repetition on.
    let repeated = [[1.0, 2.0], [4.0, 2.0], [4.0, 4.0], [1.0, 4.0]];
    let texture = "texture = \"texels.png\"";
    for (index, uv) in [upright, mirrored, repeated].into_iter().enumerate() {
        for (name, text) in rectangles(uv) {
            let solid = format!("{texture}\nshape = {{ mesh = \"{name}\" }}\n");
            let scene = read(&solid, &[(name, &text)]).unwrap();
            for (column, row) in texels() {
                let target = match index {
                    0 => middle(column, row),
                    1 => middle(2 - column, row),
                    // The repetition in the middle of the first row, a third as wide and half as high.
                    _ => DVec3::new((column as f64 - 1.0) / 3.0, 0.75 - 0.5 * row as f64, 0.0),
                };
                assert_seen(&scene, target + DVec3::Z * 5.0, target, expected(column, row));
            }
            // Where the object is mirrored, so is its image.
            let scene = read(&format!("{solid}transform = {{ scale = [-1, 1, 1] }}\n"), &[(name, &text)]).unwrap();
            let (from, to) = if index == 1 { (2, 2) } else { (0, 2) };
            if index < 2 {
                assert_seen(&scene, middle(to, 0) + DVec3::Z, middle(to, 0), expected(from, 0));
                assert_seen(&scene, middle(1, 1) + DVec3::Z, middle(1, 1), expected(1, 1));
            }
        }
    }
}

#[test]
fn round_and_square_shapes_show_the_image_upright_from_outside() {
    let forms = [
        ("box = { min = [-1.5, -1, -1], max = [1.5, 1, 1] }", 3.0),
        ("sphere = { center = [0, 0, 0], radius = 1 }", 0.0),
        ("icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 6 }", 0.0),
        ("cylinder = { center = [0, 0, 0], radius = 1, height = 2 }", 0.0),
    ];
    for (form, width) in forms {
        let scene = read(&format!("texture = \"texels.png\"\nshape = {{ {form} }}\n"), &[]).unwrap();
        for (column, row) in texels() {
            let direction = match width {
                // The front of the box.
                3.0 => {
                    let target = middle(column, row).with_z(1.0);
                    assert_seen(&scene, target + DVec3::Z * 5.0, target, expected(column, row));
                    continue;
                }
                // u is ½ in front and grows to the right of one who stands there; rows are half of the height.
                _ => {
                    let angle = ((column as f64 + 0.5) / 3.0 - 0.5) * std::f64::consts::TAU;
                    DVec3::new(angle.sin(), 0.0, angle.cos())
                }
            };
            let up = if row == 0 { 1.0 } else { -1.0 };
            let target = match form.starts_with("cylinder") {
                true => direction + DVec3::Y * 0.5 * up,
                false => (direction + DVec3::Y * up).normalize(),
            };
            let found = seen(&scene, target + direction * 5.0, target);
            // Facets bend what is seen by less than this.
            assert!((found - expected(column, row)).abs().max_element() < 5e-3, "{form} {column} {row}: {found}");
        }
    }
}

#[test]
fn a_turned_sphere_turns_its_image() {
    let sphere = "texture = \"texels.png\"\nshape = { sphere = { center = [0, 0, 0], radius = 1 } }\n";
    let scene =
        read(&format!("{sphere}transform = {{ rotate = [0, 90, 0], scale = 2, translate = [1, 0, 0] }}\n"), &[]);
    // What was in front is on the right: above the equator the middle of the green texel.
    let target = DVec3::new(1.0, 0.0, 0.0) + DVec3::new(1.0, 1.0, 0.0).normalize() * 2.0;
    assert_seen(&scene.unwrap(), target + DVec3::X * 5.0, target, expected(1, 0));
}

#[test]
fn what_makes_no_texture_is_told_with_its_place() {
    let bare = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let mesh = "texture = \"texels.png\"\nshape = { mesh = \"m.obj\" }\n";
    for (solid, place, words) in [
        (mesh.to_owned(), "a/s.toml:9:11", "the mesh m.obj has no texture coordinates"),
        (format!("texture = \"gone.png\"\n{QUAD}"), "a/s.toml:9:11", "the texture a/gone.png cannot be read"),
        (format!("texture = \"m.obj\"\n{QUAD}"), "a/s.toml:9:11", "the texture a/m.obj is no image"),
        (format!("texture = 1\n{QUAD}"), "a/s.toml:9:11", "string"),
        (format!("texture = \"texels.png\"\ntint = [2, 1, 1]\n{QUAD}"), "a/s.toml:10:8", "between 0 and 1"),
        (format!("color = [1, 1, 1]\ntint = [1, 1, 1]\n{QUAD}"), "a/s.toml:10:8", "multiplies a `texture`"),
        (format!("color = [1, 1, 1]\nuv = {{ scale = [1, 1] }}\n{QUAD}"), "a/s.toml:10:6", "a `texture`"),
        (format!("texture = \"texels.png\"\nuv = {{ scale = [1e9, 1] }}\n{QUAD}"), "a/s.toml:10:", "1e6"),
        (
            format!("color = [1, 1, 1]\ntexture = \"texels.png\"\n{QUAD}"),
            "a/s.toml:10:11",
            "both `color` and `texture`",
        ),
    ] {
        let error = read(&solid, &[("m.obj", bare)]).unwrap_err();
        assert!(error.starts_with(place) && error.contains(words), "{solid}: {error}");
    }
    // In memory the same is refused.
    let mut scene = read(&format!("texture = \"texels.png\"\n{QUAD}"), &[]).unwrap();
    let mesh = common::mesh_of(&scene.objects[0].shape);
    scene.objects[0].shape = Shape::mesh("m.obj", mesh);
    let error = iorect::scene::compile::compile(&scene, None).unwrap_err().to_string();
    assert!(error.contains("`s`") && error.contains("texture coordinates"), "{error}");
}

#[test]
fn a_saved_scene_has_its_textures_again() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    };
    write("in/oak.png", &png());
    let text = format!(
        "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n[[solid]]\nname = \"a\" # of oak\ntexture = \"oak.png\"\n{QUAD}\
         [[solid]]\nname = \"b\"\ntexture = \"oak.png\"\ntint = [0.5, 0.25, 1.0]\nuv = {{ scale = [2.0, -3.0] }}\n{QUAD}"
    );
    let path = write("in/s.toml", text.as_bytes());
    let scene = formats::file(&path).unwrap();
    let image = |object: &str| match &scene.objects.find(object).unwrap().solid().unwrap().paint {
        Paint::Texture { image, .. } => std::sync::Arc::clone(image),
        other => panic!("{other:?}"),
    };
    assert!(std::sync::Arc::ptr_eq(&image("a"), &image("b")), "a file is read once");
    let target = folder.path().join("elsewhere/s.toml");
    std::fs::create_dir_all(target.parent().unwrap()).unwrap();
    formats::save(&scene, &target).unwrap();
    let written = std::fs::read_to_string(&target).unwrap();
    assert_eq!(written, text.replace("oak.png", "../in/oak.png"));
    let again = formats::file(&target).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint());
    // What is edited is written, and another image is another scene.
    let mut edited = again.clone();
    edited.objects.find_mut("b").unwrap().solid_mut().unwrap().paint = Paint::Color([0.5; 3]);
    formats::save(&edited, &target).unwrap();
    let written = std::fs::read_to_string(&target).unwrap();
    assert!(
        written.contains("color = [0.5, 0.5, 0.5]") && !written.contains("tint") && !written.contains("uv"),
        "{written}"
    );
    assert_eq!(formats::file(&target).unwrap().fingerprint(), edited.fingerprint());
    let mut other = png();
    assert_ne!(edited.fingerprint(), again.fingerprint());
    other.clear();
    image::RgbImage::from_pixel(3, 2, image::Rgb([1, 2, 3]))
        .write_to(&mut Cursor::new(&mut other), image::ImageFormat::Png)
        .unwrap();
    write("in/oak.png", &other);
    assert_ne!(formats::file(&path).unwrap().fingerprint(), scene.fingerprint());
}
