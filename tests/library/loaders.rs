//! Whole scene files, with the meshes and images that they name, through the library as a program uses it.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use iorect::formats::{self, builtin};
use iorect::geometry::Mesh;
use iorect::optics::Ior;
use iorect::scene::description::{Environment, Paint, Refractor, Shape, Transform};

#[path = "../../assets/make_assets.rs"]
#[allow(dead_code)]
mod make_assets;

const EVERYTHING: &str = r#"
name = "Ice in water in glass"

[camera]
position = [0.0, 1.2, 4]
target = [0.0, 0.5, 0.0]
up = [0.0, 0.0, 1.0]
vertical_fov = 35.0
aperture_radius = 0.02
focus_distance = 3.5

[world]
ior = { cauchy = [1.4, 0.004, 0.0] }
absorption = [0.0, 0.1, 0.2]

[environment]
gradient = { zenith = [0, 0, 1], horizon = [1, 1, 1], nadir = [0.1, 0.1, 0.1] }

[[medium]]
name = "water"
ior = 1.333
absorption = [0.02, 0.01, 0.005]

[[medium]]
name = "flint"
ior = { sellmeier = [[1.73848403, 0.0136068604], [0.311168974, 0.0615960463], [1.17490871, 121.922711]] }

[[medium]]
name = "diamond"
ior = { catalog = "diamond" }

[[refractor]]
name = "ball"
medium = "water"
shape = { sphere = { center = [1, 2, 3], radius = 0.5 } }
priority = -2
roughness = [0.1, 0.2]
thin = true
transform = { scale = 2.0, rotate = [10, 20, 30], translate = [1, 0, 0] }

[[refractor]]
name = "geode"
medium = "flint"
shape = { icosphere = { center = [0, 0, 0], radius = 1, subdivisions = 2 } }
smooth = true
transform = { scale = [1, -2, 3] }

[[refractor]]
name = "stone"
medium = "diamond"
[refractor.shape]
mesh = "models/stone.obj"

[[refractor]]
name = "other stone"
medium = "diamond"
shape.mesh = "models/stone.obj"

[[solid]]
name = "floor"
shape = { quad = { center = [0, 0, 0], edge_u = [0, 0, 4], edge_v = [4, 0, 0] } }
checker = { a = [0.1, 0.2, 0.3], b = [1, 1, 1], size = 0.5 }

[[solid]]
name = "block"
shape = { box = { min = [-1, -1, -1], max = [1, 1, 1] } }
color = [0.5, 0.4, 0.3]
mirror = true
roughness = 0.25

[[solid]]
name = "plain"
shape = { lathe = { profile = [[0, 0], [1, 0], [0, 1]] } }

[[light]]
name = "tube"
shape = { cylinder = { center = [0, 3, 0], radius = 0.1, height = 2 } }
radiance = [10, 10, 10]

[[light]]
name = "ring"
shape = { torus = { center = [0, 3, 0], major = 1, minor = 0.1, segments = 32, rings = 16 } }
radiance = [1, 0, 0]
"#;

const STONE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\nf 1 1 2\n";

#[test]
fn every_key_reaches_the_description() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("models")).unwrap();
    std::fs::write(folder.path().join("models/stone.obj"), STONE).unwrap();
    let path = folder.path().join("all.toml");
    std::fs::write(&path, EVERYTHING).unwrap();
    let scene = formats::file(&path).unwrap();

    assert_eq!(scene.name, "Ice in water in glass");
    assert_eq!((scene.camera.position, scene.camera.up), (DVec3::new(0.0, 1.2, 4.0), DVec3::Z));
    assert_eq!((scene.camera.vertical_fov, scene.camera.aperture_radius), (35.0, 0.02));
    assert_eq!(scene.camera.focus_distance, Some(3.5));
    assert_eq!(scene.world.ior, Ior::Cauchy([1.4, 0.004, 0.0]));
    assert_eq!(scene.world.absorption, [0.0, 0.1, 0.2]);
    let gradient = Environment::Gradient { zenith: [0.0, 0.0, 1.0], horizon: [1.0; 3], nadir: [0.1; 3] };
    assert_eq!(scene.environment, gradient);

    assert_eq!(scene.media.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["water", "flint", "diamond"]);
    assert_eq!(scene.media[0].absorption, [0.02, 0.01, 0.005]);
    // SF11, as its maker prints it.
    assert!((scene.media[1].ior.ior() - 1.784_72).abs() < 5e-6);
    assert!((scene.media[2].ior.ior() - 2.417_485_9).abs() < 5e-8);

    let ball = &scene.objects.refractors()[0];
    assert_eq!(ball.shape, Shape::Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius: 0.5 });
    assert_eq!(
        ball.refractor(),
        Some(&Refractor { priority: -2, roughness: [0.1, 0.2], thin: true, ..Refractor::of("water") })
    );
    let transform = Transform { scale: DVec3::splat(2.0), rotate: DVec3::new(10.0, 20.0, 30.0), translate: DVec3::X };
    assert_eq!(ball.transform, transform);
    assert!(scene.objects.refractors()[1].refractor().unwrap().smooth);
    assert_eq!(scene.objects.refractors()[1].transform.scale, DVec3::new(1.0, -2.0, 3.0));
    let [Shape::Mesh { mesh, notes, .. }, Shape::Mesh { mesh: other, .. }] =
        [&scene.objects.refractors()[2].shape, &scene.objects.refractors()[3].shape]
    else {
        panic!("the stones are not meshes");
    };
    assert_eq!((mesh.triangles.len(), notes.len()), (4, 1));
    assert_eq!((notes[0].kind, notes[0].count, notes[0].first_line), ("degenerate_triangles", 1, Some(9)));
    assert!(Arc::ptr_eq(mesh, other), "one file is read once");

    assert_eq!(
        scene.objects.solids()[0].solid().unwrap().paint,
        Paint::Checker { a: [0.1, 0.2, 0.3], b: [1.0; 3], size: 0.5 }
    );
    assert_eq!(
        (scene.objects.solids()[1].solid().unwrap().paint.clone(), scene.objects.solids()[1].solid().unwrap().mirror),
        (Paint::Color([0.5, 0.4, 0.3]), true)
    );
    assert_eq!(scene.objects.solids()[2].solid().unwrap().paint, Paint::Color([0.8; 3]));
    assert!(matches!(scene.objects.solids()[2].shape, Shape::Lathe { segments: 192, .. }));
    assert!(matches!(scene.objects.lights()[0].shape, Shape::Cylinder { segments: 192, .. }));
    assert!(matches!(scene.objects.lights()[1].shape, Shape::Torus { segments: 32, rings: 16, .. }));
    assert_eq!(scene.objects.lights()[1].light().unwrap().emission.rgb, [1.0, 0.0, 0.0]);
}

#[test]
fn defaults_are_those_of_the_format() {
    let text = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n";
    let scene = formats::parse(text, Path::new("some/where/quiet.toml"), &formats::Disk).unwrap();
    assert_eq!(scene.name, "quiet");
    assert_eq!((scene.camera.up, scene.camera.vertical_fov), (DVec3::Y, 40.0));
    assert_eq!((scene.camera.aperture_radius, scene.camera.focus_distance), (0.0, None));
    assert_eq!((scene.world.ior, scene.world.absorption), (Ior::Constant(1.0), [0.0; 3]));
    assert_eq!(scene.environment, Environment::Color([0.0; 3]));
    assert!(scene.media.is_empty() && scene.objects.is_empty());
}

#[test]
fn inline_arrays_of_tables_do_as_well() {
    let text = "camera = { position = [0, 0, 1], target = [0, 0, 0] }\nmedium = [{ name = \"a\", ior = 2 }, { name = \"b\", ior = 3 }]\n";
    let scene = formats::parse(text, Path::new("s.toml"), &formats::Disk).unwrap();
    assert_eq!(scene.media[1].ior, Ior::Constant(3.0));
}

#[test]
fn an_environment_image_beside_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let image = image::Rgb32FImage::from_fn(4, 2, |x, y| image::Rgb([x as f32, y as f32, -1.0]));
    image.save(folder.path().join("sky.exr")).unwrap();
    let text = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[environment]\nimage = \"sky.exr\"\nrotation = 90\nscale = 2\n";
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let scene = formats::file(&folder.path().join("s.toml")).unwrap();
    let Environment::Image { path, image, rotation, scale } = scene.environment else { panic!("no image") };
    assert_eq!((path.as_path(), rotation, scale), (Path::new("sky.exr"), 90.0, 2.0));
    assert_eq!((image.width, image.height), (4, 2));
    let notes: Vec<_> = image.notes.iter().map(|note| (note.kind, note.count)).collect();
    assert_eq!(notes, [("clipped_pixels", 8)]);
    assert_eq!(image.pixels[7], [3.0, 1.0, 0.0]);
}

#[test]
fn built_in_scenes_open_by_name_and_survive_being_saved() {
    let folder = tempfile::tempdir().unwrap();
    for scene in builtin::all() {
        let original = formats::open(scene.name).unwrap();
        let path = folder.path().join(format!("{}.toml", scene.name));
        formats::save(&original, &path).unwrap();
        let again = formats::open(path.to_str().unwrap()).unwrap();
        assert_eq!(
            (again.media, again.objects.lights(), again.camera),
            (original.media, original.objects.lights(), original.camera)
        );
        assert_eq!(again.objects.refractors().len(), original.objects.refractors().len());
        for (a, b) in again.objects.refractors().iter().zip(original.objects.refractors()) {
            if let (Shape::Mesh { mesh: a, .. }, Shape::Mesh { mesh: b, .. }) = (&a.shape, &b.shape) {
                assert_eq!(a, b);
            } else {
                assert_eq!(a, b);
            }
        }
    }
}

#[test]
fn computed_assets_are_what_their_command_makes() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let read = |path: &str| std::fs::read_to_string(assets.join(path)).unwrap();
    assert_eq!(read("models/brilliant.obj"), make_assets::brilliant());
    assert_eq!(read("models/ice-cube.obj"), make_assets::ice_cube());
    assert_eq!(read("scenes/luneburg.toml"), make_assets::luneburg());
    let image = |name: &str| image::open(assets.join("environments").join(name)).unwrap().to_rgb32f();
    let (sunset, evening) = (image("sunset.exr"), image("evening.exr"));
    assert_eq!(evening.dimensions(), sunset.dimensions());
    for (made, from) in evening.pixels().zip(sunset.pixels()) {
        let expected = make_assets::evening(from.0);
        for (made, expected) in made.0.into_iter().zip(expected) {
            // Stored in half precision.
            assert!((made - expected).abs() <= 1e-3 * expected + 1e-7, "{made} for {expected}");
        }
    }
}

/// In a picture of 2160 lines facets leave the round by less than a tenth of a pixel, and normals are interpolated: edges seen through the
/// glass show no teeth.
#[test]
fn round_things_are_smooth_at_4k() {
    let mut count = 0;
    for scene in builtin::all() {
        let description = formats::open(scene.name).unwrap();
        let camera = &description.camera;
        for object in description.objects.iter() {
            let (radius, segments) = match &object.shape {
                Shape::Cylinder { radius, segments, .. } => (*radius, *segments),
                Shape::Lathe { profile, segments } => (profile.iter().fold(0.0, |most, [r, _]| r.max(most)), *segments),
                Shape::Torus { major, minor, segments, .. } => (major + minor, *segments),
                _ => continue,
            };
            count += 1;
            let (min, max) = object.shape.bounds();
            let middle = object.transform.matrix().transform_point3((min + max) / 2.0);
            let radius = radius * object.transform.scale.abs().max_element();
            let distance = middle.distance(camera.position) - radius;
            let pixels = 1080.0 / ((camera.vertical_fov / 2.0).to_radians().tan() * distance);
            let height = radius * pixels * (1.0 - (std::f64::consts::PI / f64::from(segments)).cos());
            assert!(height < 0.1, "{}: {} leaves the round by {height} pixels", scene.name, object.name);
            assert!(object.is_smooth() || object.light().is_some(), "{}: {} shows facets", scene.name, object.name);
        }
    }
    assert!(count > 5);
}

#[test]
fn the_brilliant_is_convex_and_closed() {
    let scene = formats::open("diamond-in-water").unwrap();
    let shape = &scene.objects.refractors().iter().find(|r| r.name == "wet diamond").unwrap().shape;
    let Shape::Mesh { mesh, notes, .. } = shape else { panic!("no mesh: {shape:?}") };
    assert_eq!(notes, &[]);
    // A closed surface of genus 0: V − E + F = 2, with three half-edges to a face.
    assert_eq!(mesh.positions.len() * 2, mesh.triangles.len() + 4);
    assert!(mesh.signed_volume() > 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        let normal = (b - a).cross(c - a).normalize();
        // Vertices are stored to 7 digits.
        assert!(mesh.positions.iter().all(|p| (*p - a).dot(normal) < 1e-6), "not convex at {t:?}");
    }
}

/// A square of `n` × `n` cells, two triangles each.
fn grid(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for z in 0..=n {
        for x in 0..=n {
            mesh.positions.push(DVec3::new(f64::from(x), f64::from(x ^ z) * 0.125, f64::from(z)));
        }
    }
    for z in 0..n {
        for x in 0..n {
            let a = z * (n + 1) + x;
            mesh.triangles.push([a, a + n + 1, a + 1]);
            mesh.triangles.push([a + 1, a + n + 1, a + n + 2]);
        }
    }
    mesh
}

#[test]
fn a_million_triangles_are_read_quickly() {
    let mesh = grid(708);
    let folder = tempfile::tempdir().unwrap();
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    let mut obj = String::new();
    for p in &mesh.positions {
        p.as_vec3().to_array().iter().for_each(|x| ply.extend(x.to_le_bytes()));
        obj.push_str(&format!("v {} {} {}\n", p.x, p.y, p.z));
    }
    for t in &mesh.triangles {
        ply.push(3);
        t.iter().for_each(|i| ply.extend(i.to_le_bytes()));
        obj.push_str(&format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    }
    std::fs::write(folder.path().join("grid.ply"), ply).unwrap();
    std::fs::write(folder.path().join("grid.obj"), obj).unwrap();
    for name in ["grid.ply", "grid.obj"] {
        let text = format!(
            "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[solid]]\nname = \"grid\"\nshape = {{ mesh = \"{name}\" }}\n"
        );
        let scene = formats::parse(&text, &folder.path().join("s.toml"), &formats::Disk).unwrap();
        let Shape::Mesh { mesh: read, .. } = &scene.objects.solids()[0].shape else { panic!("no mesh") };
        assert_eq!((&read.positions, &read.triangles), (&mesh.positions, &mesh.triangles));
    }
}
