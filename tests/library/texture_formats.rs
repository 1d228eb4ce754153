//! Images on solids in files of other renderers, read and written.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use iorect::export::resolved::{Frame, Target, export};
use iorect::formats::{self, Memory};
use iorect::scene::Description;

use crate::textures::{expected, png, seen, texels};

fn read(path: &str, text: &str, files: &[(&str, &str)]) -> Description {
    let mut all = Memory([("a/texels.png".into(), png())].into());
    all.0.extend(files.iter().map(|(name, text)| (Path::new("a").join(name), text.as_bytes().to_vec())));
    formats::read(text.as_bytes(), &Path::new("a").join(path), &all).unwrap_or_else(|error| panic!("{error}"))
}

fn notes(scene: &Description) -> Vec<&str> {
    scene.source.as_ref().unwrap().import.as_ref().unwrap().notes.iter().map(|note| note.kind).collect()
}

#[track_caller]
fn assert_seen(scene: &Description, eye: DVec3, target: DVec3, color: DVec3, tolerance: f64) {
    let found = seen(scene, eye, target);
    assert!((found - color).abs().max_element() < tolerance, "at {target}: {found}, not {color}");
}

/// A Mitsuba scene of one shape that has the image for its reflectance.
fn mitsuba(shape: &str, inside: &str, to_uv: &str, files: &[(&str, &str)]) -> Description {
    let text = format!(
        "<scene version=\"3.0.0\"><emitter type=\"constant\"/><sensor type=\"perspective\">\
         <transform name=\"to_world\"><lookat origin=\"0,0,9\" target=\"0,0,0\" up=\"0,1,0\"/></transform></sensor>\
         <shape type=\"{shape}\">{inside}<bsdf type=\"twosided\"><bsdf type=\"diffuse\">\
         <texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"texels.png\"/>{to_uv}</texture>\
         </bsdf></bsdf></shape></scene>"
    );
    read("s.xml", &text, files)
}

/// Where Mitsuba 3.9 itself says that texture coordinates are (asked by `ray_intersect`), which count v from the upper row of an image.
#[test]
fn mitsuba_shapes_have_their_own_coordinates() {
    let of_texel = |column: usize, row: usize| [(column as f64 + 0.5) / 3.0, (row as f64 + 0.5) / 2.0];
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
               property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n-1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n\
               -1 1 0 0 1\n3 0 1 2\n3 0 2 3\n";
    let obj = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let file = |name: &str| format!("<string name=\"filename\" value=\"{name}\"/>");
    let unflipped = file("m.obj") + "<boolean name=\"flip_tex_coords\" value=\"false\"/>";
    let moved_right = "<transform name=\"to_uv\"><translate x=\"0.25\"/></transform>";
    let twice = "<transform name=\"to_uv\"><scale x=\"2\" y=\"1\"/></transform>";
    for (column, row) in texels() {
        let [u, v] = of_texel(column, row);
        let flat = |u: f64, v: f64| DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0);
        for (shape, inside, to_uv, target) in [
            ("rectangle", String::new(), "", flat(u, v)),
            ("rectangle", String::new(), moved_right, flat((u + 0.75) % 1.0, v)),
            ("rectangle", String::new(), twice, flat(0.5 * u, v)),
            ("ply", file("m.ply"), "", flat(u, v)),
            ("obj", file("m.obj"), "", flat(u, 1.0 - v)),
            ("obj", unflipped.clone(), "", flat(u, v)),
            // (½, 0.2, 1) has (0.6, 0.75).
            ("cube", String::new(), "", DVec3::new(2.0 * v - 1.0, 2.0 * u - 1.0, 1.0)),
        ] {
            let scene = mitsuba(shape, &inside, to_uv, &[("m.ply", ply), ("m.obj", obj)]);
            assert_seen(&scene, target + DVec3::Z * 5.0, target, expected(column, row), 1e-3);
            assert!(!notes(&scene).iter().any(|kind| kind.contains("texture")), "{shape}: {:?}", notes(&scene));
        }
        // Poles on z, where v is 0; u from x towards y. And the same turned, enlarged and moved.
        let (around, down) = (std::f64::consts::TAU * u, std::f64::consts::PI * v);
        let d = DVec3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos());
        let sphere = "<point name=\"center\" x=\"1\" y=\"0\" z=\"0\"/>";
        let placed = "<transform name=\"to_world\"><scale value=\"2\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"3\"/></transform>";
        let stretched = "<transform name=\"to_world\"><scale x=\"1\" y=\"3\" z=\"2\"/></transform>";
        let turned = DVec3::new(d.x, -d.z, d.y);
        for (inside, target, away, tolerance) in [
            (sphere.to_owned(), d + DVec3::X, d, 1e-3),
            (sphere.to_owned() + placed, DVec3::new(2.0, 3.0, 0.0) + 2.0 * turned, turned, 1e-3),
            (stretched.to_owned(), d * DVec3::new(1.0, 3.0, 2.0), d / DVec3::new(1.0, 3.0, 2.0), 2e-2),
        ] {
            let scene = mitsuba("sphere", &inside, "", &[]);
            assert_seen(&scene, target + away.normalize() * 5.0, target, expected(column, row), tolerance);
        }
    }
}

/// As pbrt-v4's sources have them: v from the lower row of an image.
#[test]
fn pbrt_shapes_have_their_own_coordinates() {
    let scene = |shape: &str, texture: &str| {
        let text = format!(
            "Scale -1 1 1\nLookAt 0 0 9 0 0 0 0 1 0\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n\
             Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"texels.png\" {texture}\n\
             Material \"diffuse\" \"texture reflectance\" \"t\"\n{shape}\n"
        );
        read("s.pbrt", &text, &[])
    };
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ] \
                \"point2 uv\" [ 0 0  1 0  1 1  0 1 ]";
    let patch = "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]";
    for (column, row) in texels() {
        let (u, v) = ((column as f64 + 0.5) / 3.0, 1.0 - (row as f64 + 0.5) / 2.0);
        let flat = |u: f64, v: f64| DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0);
        for (shape, texture, target, tint) in [
            (mesh, "", flat(u, v), 1.0),
            (patch, "", flat(u, v), 1.0),
            (mesh, "\"float uscale\" 2 \"float vdelta\" 0.5 \"float scale\" 0.5", flat(0.5 * u, (v + 0.5) % 1.0), 0.5),
        ] {
            let scene = scene(shape, texture);
            assert_seen(&scene, target + DVec3::Z * 5.0, target, tint * expected(column, row), 1e-3);
        }
        // u from x towards y, v from −z to z.
        let (around, up) = (std::f64::consts::TAU * u, std::f64::consts::PI * (v - 0.5));
        let d = DVec3::new(up.cos() * around.cos(), up.cos() * around.sin(), up.sin());
        assert_seen(&scene("Shape \"sphere\"", ""), d * 5.0, d, expected(column, row), 1e-3);
        let side = DVec3::new(around.cos(), around.sin(), 2.0 * v - 1.0);
        let tube = scene("Shape \"cylinder\"", "");
        assert_seen(&tube, side + side.with_z(0.0) * 5.0, side, expected(column, row), 1e-2);
    }
}

/// What is exported looks as before where it is read again.
#[test]
fn exported_images_look_the_same() {
    let obj = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\nf 4/1 3/2 2/3 1/4\n";
    let text = "[camera]\nposition = [3, 4, 9]\ntarget = [0, 0, 0]\n[environment]\ncolor = [1, 1, 1]\n\
                [[solid]]\nname = \"ball\"\ntexture = \"texels.png\"\nshape = { sphere = { center = [3, 0, 0], radius = 1 } }\n\
                transform = { rotate = [30, 40, 50] }\n\
                [[solid]]\nname = \"can\"\ntexture = \"texels.png\"\ntint = [1, 0.5, 0.25]\nuv = { scale = [2, 1], rotate = 20 }\n\
                shape = { cylinder = { center = [0, 0, 0], radius = 1, height = 2 } }\n\
                [[solid]]\nname = \"plate\"\ntexture = \"texels.png\"\nshape = { mesh = \"m.obj\" }\ntransform = { translate = [-3, 0, 0] }\n";
    let scene = Arc::new(read("s.toml", text, &[("m.obj", obj)]));
    for (target, main) in [(Target::Mitsuba, "scene.xml"), (Target::Pbrt, "scene.pbrt"), (Target::Gltf, "scene.glb")] {
        let bundle = export(&scene, target, Frame { width: 8, height: 8, samples: 1 }).unwrap();
        let images = bundle.paths().filter(|path| path.extension().is_some_and(|ending| ending == "png")).count();
        assert_eq!(images, if target == Target::Gltf { 0 } else { 2 }, "one for each tint");
        let files = Memory(
            bundle.paths().map(|path| (Path::new("b").join(path), bundle.get(path).unwrap().to_vec())).collect(),
        );
        let path = Path::new("b").join(main);
        let mut again = formats::read(&files.0[&path], &path, &files).unwrap_or_else(|error| panic!("{error}"));
        again.environment = scene.environment.clone();
        for index in 0..12 {
            let angle = f64::from(index) * 0.53;
            let d = DVec3::new(angle.cos(), 0.3 * (2.0 * angle).sin(), angle.sin());
            let on_can = d.with_y(0.0).normalize() + DVec3::Y * d.y;
            let on_plate = DVec3::new(-3.0 + 0.9 * d.x, 0.0, 0.9 * d.z);
            for (place, away) in [
                (DVec3::X * 3.0 + d.normalize(), d.normalize()),
                (on_can, on_can.with_y(0.0)),
                (on_plate, DVec3::new(0.01, 1.0, 0.0)),
            ] {
                let before = seen(&scene, place + away, place);
                assert_seen(&again, place + away, place, before, 0.03);
            }
        }
    }
}
