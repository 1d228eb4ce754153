mod make;
mod materials;

use std::path::Path;

use glam::DVec3;
use serde_json::json;

use self::make::{CUBE, CUBE_FACES, Maker};
use crate::formats::{Memory, parse, read, to_text};
use crate::geometry::Mesh;
use crate::scene::compile::compile;
use crate::scene::description::{Description, Environment, MeshPart, Object, Quantity, Shape, Transform};

fn files(named: &[(&str, Vec<u8>)]) -> Memory {
    Memory(named.iter().map(|(name, bytes)| (name.into(), bytes.clone())).collect())
}

fn opened(maker: &Maker) -> Description {
    read(&maker.binary(), Path::new("a/set.glb"), &Memory::default()).unwrap()
}

fn error(bytes: &[u8]) -> String {
    read(bytes, Path::new("a/set.gltf"), &Memory::default()).unwrap_err().to_string()
}

fn error_of(maker: &Maker) -> String {
    error(&maker.binary())
}

fn mesh(object: &Object) -> &std::sync::Arc<Mesh> {
    let Shape::Mesh { mesh, .. } = &object.shape else { panic!("no mesh: {object:?}") };
    mesh
}

fn part(object: &Object) -> &MeshPart {
    let Shape::Mesh { part, .. } = &object.shape else { panic!("no mesh: {object:?}") };
    part
}

fn notes(scene: &Description) -> Vec<&'static str> {
    scene.source.as_ref().unwrap().import.as_ref().unwrap().notes.iter().map(|note| note.kind).collect()
}

/// The volume of an object in the world: negative where it is inside out.
fn volume(object: &Object) -> f64 {
    mesh(object).signed_volume() * object.transform.matrix().matrix3.determinant().abs()
}

#[test]
fn a_cube_in_every_wrapping() {
    let mut maker = Maker::cube(None);
    maker.node(json!({"mesh": 0, "name": "Cube"}));
    let scene = opened(&maker);
    assert_eq!((scene.name.as_str(), scene.objects.len()), ("set", 1));
    let cube = &scene.objects[0];
    assert_eq!((cube.name.as_str(), mesh(cube).positions.len(), mesh(cube).triangles.len()), ("Cube", 8, 12));
    assert!((volume(cube) - 8.0).abs() < 1e-12);
    assert_eq!(notes(&scene), ["no_camera", "no_light"]);
    assert!(scene.source.as_ref().is_some_and(|source| !source.is_own_file()));
    let others = files(&[("a/my buffer.bin", maker.bytes.clone())]);
    let outside = read(&maker.text("my%20buffer.bin"), Path::new("a/set.gltf"), &others).unwrap();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&maker.bytes);
    let uri = format!("data:application/octet-stream;base64,{data}");
    let embedded = read(&maker.text(&uri), Path::new("a/set.gltf"), &Memory::default()).unwrap();
    for other in [&outside, &embedded] {
        assert_eq!(other.fingerprint(), scene.fingerprint());
    }
    let import = outside.source.as_ref().unwrap().import.clone().unwrap();
    assert_eq!((import.format, import.files), ("glTF", vec!["my buffer.bin".into()]));
    // It is in the middle of the picture.
    assert_eq!(scene.camera.target, DVec3::ZERO);
    assert_eq!(compile(&scene, None).unwrap().objects.len(), 1);
}

#[test]
fn nodes_move_meshes_and_share_them() {
    let mut maker = Maker::cube(None);
    maker.push("nodes", json!({"mesh": 0, "name": "child", "translation": [0, 3, 0]}));
    // A quaternion of another length than 1 is the rotation that it would be.
    maker.node(json!({"name": "parent", "children": [0], "scale": [2, 2, 2], "rotation": [0, 0, 1, 1]}));
    maker.node(json!({"mesh": 0, "name": "mirrored", "scale": [-1, 1, 1], "translation": [9, 0, 0]}));
    maker.node(json!({"mesh": 0, "name": "child", "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 7, 1]}));
    let scene = opened(&maker);
    let objects = scene.objects.solids();
    let names: Vec<&str> = objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["child", "mirrored", "child 2"]);
    assert!(std::sync::Arc::ptr_eq(mesh(&objects[0]), mesh(&objects[1])), "one mesh");
    // A quarter turn to the left, and twice as large.
    let Transform { scale, rotate, translate } = objects[0].transform;
    assert!((translate - DVec3::new(-6.0, 0.0, 0.0)).length() < 1e-6, "{translate}");
    assert!((scale - 2.0).length() < 1e-6 && (rotate - DVec3::new(0.0, 0.0, 90.0)).length() < 1e-5, "{scale} {rotate}");
    assert_eq!(objects[1].transform.scale, DVec3::new(-1.0, 1.0, 1.0));
    // What is sheared has the shear in its mesh.
    assert_eq!(objects[2].transform, Transform::IDENTITY);
    assert_eq!(mesh(&objects[2]).positions[1], DVec3::new(1.5, 1.0, 6.0));
    assert_eq!(part(&objects[2]).group.as_deref(), Some("/nodes/3/mesh"));
    for (object, expected) in objects.iter().zip([64.0, 8.0, 8.0]) {
        assert!((volume(object) - expected).abs() < 1e-4, "{}: {}", object.name, volume(object));
    }
    assert!(notes(&scene).contains(&"sheared"));
    assert_eq!(compile(&scene, None).unwrap().objects.len(), 3);
}

/// A mirroring shear turns faces about, so that the outside stays outside.
#[test]
fn a_sheared_mirror_image_keeps_its_outside() {
    let mut maker = Maker::cube(None);
    let normals: Vec<[f32; 3]> = CUBE.to_vec();
    let accessor = maker.floats(&normals);
    maker.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(accessor);
    maker.node(json!({"mesh": 0, "matrix": [-1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 7, 1]}));
    let scene = opened(&maker);
    let cube = &scene.objects[0];
    assert!((volume(cube) - 8.0).abs() < 1e-9);
    let mesh = mesh(cube);
    let middle = DVec3::new(0.0, 0.0, 7.0);
    assert!(mesh.positions.iter().zip(&mesh.normals).all(|(p, n)| (*p - middle).dot(*n) > 0.0));
}

#[test]
fn every_layout_of_numbers() {
    let mut expected = Maker::cube(None);
    expected.node(json!({"mesh": 0}));
    let expected = mesh(&opened(&expected).objects[0]).clone();
    let check = |change: &dyn Fn(&mut Maker) -> (usize, usize)| {
        let mut maker = Maker::new();
        let (position, indices) = change(&mut maker);
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        maker.push("meshes", json!({"primitives": [primitive]}));
        maker.node(json!({"mesh": 0}));
        assert_eq!(*mesh(&opened(&maker).objects[0]), expected);
    };
    // Positions among other numbers, each 20 bytes.
    check(&|maker| {
        let bytes: Vec<u8> =
            CUBE.iter().flat_map(|p| [&[9_u8; 4][..], &p.map(f32::to_le_bytes).concat(), &[7; 4]].concat()).collect();
        let view = maker.view(&bytes);
        maker.root["bufferViews"][view]["byteStride"] = json!(20);
        let accessor = json!({"bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 8, "type": "VEC3"});
        (maker.push("accessors", accessor), maker.shorts(&CUBE_FACES))
    });
    // Zeros, in whose place stand others; bytes as indices.
    check(&|maker| {
        let values = maker.view(&CUBE.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        let places = maker.view(&[0, 1, 2, 3, 4, 5, 6, 7]);
        let sparse = json!({"count": 8, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values}});
        let accessor = json!({"componentType": 5126, "count": 8, "type": "VEC3", "sparse": sparse});
        let position = maker.push("accessors", accessor);
        let view = maker.view(&CUBE_FACES.map(|index| index as u8));
        let indices = json!({"bufferView": view, "componentType": 5121, "count": 36, "type": "SCALAR"});
        (position, maker.push("accessors", indices))
    });
    // Bytes of which −127 and 127 are −1 and 1, padded to words; long indices.
    check(&|maker| {
        let bytes: Vec<u8> =
            CUBE.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0.0].map(|x| (127.0 * x) as i8 as u8)).collect();
        let view = maker.view(&bytes);
        maker.root["bufferViews"][view]["byteStride"] = json!(4);
        let accessor =
            json!({"bufferView": view, "componentType": 5120, "normalized": true, "count": 8, "type": "VEC3"});
        let position = maker.push("accessors", accessor);
        let view = maker.view(&CUBE_FACES.iter().flat_map(|x| u32::from(*x).to_le_bytes()).collect::<Vec<u8>>());
        let indices = json!({"bufferView": view, "componentType": 5125, "count": 36, "type": "SCALAR"});
        (position, maker.push("accessors", indices))
    });
}

#[test]
fn strips_fans_and_triangles_without_indices() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let triangles = |vertices: &[[f32; 3]], mode: u32, indices: Option<&[u16]>| {
        let mut maker = Maker::new();
        let position = maker.floats(vertices);
        let mut primitive = json!({"attributes": {"POSITION": position}, "mode": mode});
        if let Some(indices) = indices {
            primitive["indices"] = json!(maker.shorts(indices));
        }
        maker.push("meshes", json!({"primitives": [primitive]}));
        maker.node(json!({"mesh": 0}));
        let scene = opened(&maker);
        let mesh = mesh(&scene.objects[0]).clone();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
            assert_eq!((b - a).cross(c - a), DVec3::Z, "all look up");
        }
        (mesh.triangles.len(), mesh.positions.len(), notes(&scene).contains(&"incomplete_triangles"))
    };
    assert_eq!(triangles(&square, 5, None), (2, 4, false));
    assert_eq!(triangles(&square, 5, Some(&[0, 1, 2, 3, 3, 0, 0, 1, 2])), (3, 4, false));
    assert_eq!(triangles(&square, 6, Some(&[0, 1, 3, 2])), (2, 4, false));
    // Vertices that no face uses are left out, and so are corners that make none.
    assert_eq!(triangles(&square, 4, None), (1, 3, true));
}

#[test]
fn lines_and_points_are_left_out() {
    let mut maker = Maker::cube(None);
    let lines = json!({"attributes": {"POSITION": 0}, "mode": 1});
    maker.root["meshes"][0]["primitives"].as_array_mut().unwrap().push(lines.clone());
    maker.node(json!({"mesh": 0}));
    assert_eq!(notes(&opened(&maker))[0], "lines_and_points");
    maker.root["meshes"][0]["primitives"] = json!([lines]);
    assert!(error_of(&maker).ends_with("the scene has no triangles"));
}

#[test]
fn primitives_of_one_material_are_one_object() {
    let mut maker = Maker::cube(Some(json!({"name": "Glass"})));
    maker.push("materials", json!({"name": "Label"}));
    let half = |maker: &mut Maker, faces: &[u16], material: serde_json::Value| {
        let indices = maker.shorts(faces);
        json!({"attributes": {"POSITION": 0}, "indices": indices, "material": material})
    };
    let primitives = [
        half(&mut maker, &CUBE_FACES[..12], json!(0)),
        half(&mut maker, &CUBE_FACES[12..18], json!(1)),
        half(&mut maker, &CUBE_FACES[18..30], json!(0)),
        half(&mut maker, &CUBE_FACES[30..], serde_json::Value::Null),
    ];
    maker.root["meshes"][0]["primitives"] = json!(primitives);
    maker.node(json!({"mesh": 0, "name": "Bottle"}));
    let scene = opened(&maker);
    let found: Vec<(&str, usize)> = scene.objects.iter().map(|o| (o.name.as_str(), mesh(o).triangles.len())).collect();
    assert_eq!(found, [("Bottle Glass", 8), ("Bottle Label", 2), ("Bottle", 2)]);
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_do() {
    let mut maker = Maker::cube(None);
    maker.node(json!({"mesh": 0}));
    maker.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 1}}),
    );
    maker.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}));
    maker.node(json!({"camera": 0}));
    maker.node(json!({"camera": 1, "translation": [0, 0, 9], "scale": [2, 2, 2]}));
    maker.node(json!({"camera": 1, "translation": [5, 0, 9]}));
    maker.root["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 6.83, "color": [1, 0.5, 0], "range": 4},
        {"type": "spot", "name": "beam", "intensity": 683, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        {"type": "directional"},
        {"type": "area"},
    ]}});
    for light in 0..4 {
        let reference = json!({"KHR_lights_punctual": {"light": light}});
        maker.node(json!({"extensions": reference, "translation": [1, 5, 0], "rotation": [-1, 0, 0, 1]}));
    }
    let scene = opened(&maker);
    let camera = &scene.camera;
    assert_eq!((camera.position, camera.target, camera.up), (DVec3::Z * 9.0, DVec3::ZERO, DVec3::Y));
    assert!((camera.vertical_fov - 0.5_f64.to_degrees()).abs() < 1e-12);
    assert_eq!(scene.environment, Environment::Color([0.0; 3]));
    let lights = scene.objects.lights();
    assert_eq!(lights.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["light", "beam", "light 2"]);
    let emission = |index: usize| lights[index].light().unwrap().emission;
    assert_eq!((emission(0).quantity, emission(0).rgb), (Quantity::Intensity, [6.83, 3.415, 0.0]));
    assert_eq!(lights[0].shape, Shape::Point { position: DVec3::new(1.0, 5.0, 0.0) });
    let Shape::Spot { position, target, inner_angle, outer_angle } = lights[1].shape else { panic!("a spot") };
    assert!((target - position).normalize().distance(DVec3::NEG_Y) < 1e-6, "it looks down");
    assert!((inner_angle - 0.2_f64.to_degrees()).abs() < 1e-12 && (outer_angle - 0.4_f64.to_degrees()).abs() < 1e-12);
    let Shape::Directional { direction, angle: 0.0 } = lights[2].shape else { panic!("from afar") };
    assert!(direction.distance(DVec3::NEG_Y) < 1e-6);
    assert_eq!((emission(2).quantity, emission(2).rgb), (Quantity::Irradiance, [1.0; 3]));
    let kinds = notes(&scene);
    for kind in ["orthographic_camera", "more_cameras", "light", "light_range", "light_units"] {
        assert_eq!(kinds.iter().filter(|known| **known == kind).count(), 1, "{kind}: {kinds:?}");
    }
    // Blender writes so many lumens for a watt.
    maker.root["asset"]["generator"] = json!("Khronos glTF Blender I/O v4.2.70");
    let rgb = opened(&maker).objects.lights()[1].light().unwrap().emission.rgb;
    assert!((rgb[0] - 1.0).abs() < 1e-12, "{rgb:?}");
}

/// The names in a scene's own text lead to the same meshes.
#[test]
fn a_scene_in_words_is_the_same_scene() {
    let mut maker = Maker::cube(Some(json!({"name": "Glass"})));
    maker.node(json!({"mesh": 0, "name": "a", "scale": [1, 2, 3], "rotation": [0.5, 0.5, 0.5, 0.5]}));
    maker.node(json!({"mesh": 0, "name": "b", "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 7, 1]}));
    let bytes = maker.binary();
    let scene = read(&bytes, Path::new("a/set.glb"), &Memory::default()).unwrap();
    let again = parse(&to_text(&scene), Path::new("a/set.toml"), &files(&[("a/set.glb", bytes.clone())])).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint(), "{}", to_text(&scene));
    assert_eq!(again.objects, scene.objects);
    // By the names of nodes, meshes and materials, where they stand.
    let named = |shape: &str| {
        let text = format!(
            "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[solid]]\nname = \"s\"\nshape = {{ mesh = \"set.glb\"{shape} }}\n"
        );
        parse(&text, Path::new("a/s.toml"), &files(&[("a/set.glb", bytes.clone())]))
    };
    let triangles = |shape: &str| mesh(&named(shape).unwrap().objects[0]).triangles.len();
    assert_eq!([triangles(""), triangles(", group = \"Cube\""), triangles(", group = \"b\"")], [24, 24, 12]);
    assert_eq!(triangles(", group = \"a\", material = \"Glass\""), 12);
    let b = named(", group = \"b\"").unwrap();
    assert_eq!(mesh(&b.objects[0]).positions, mesh(&scene.objects[1]).positions);
    let message = |shape: &str| named(shape).unwrap_err().to_string();
    assert!(
        message(", group = \"Cub\"").contains("has no group `Cub`; did you mean `Cube`?; groups: "),
        "{}",
        message(", group = \"Cub\"")
    );
    assert!(message(", group = \"/meshes/7\"").contains("there is no mesh 7"));
}

#[test]
fn damage_is_told_with_its_place() {
    let whole = || {
        let mut maker = Maker::cube(None);
        maker.node(json!({"mesh": 0, "name": "Box"}));
        maker
    };
    let changed = |change: &dyn Fn(&mut Maker)| {
        let mut maker = whole();
        change(&mut maker);
        error_of(&maker)
    };
    type Change = fn(&mut Maker);
    let cases: [(Change, &str); 22] = [
        (
            |m| m.root["accessors"][0]["count"] = json!(9),
            "mesh 0 (`Cube`), primitive 0: accessor 0 ends beyond bufferView 0",
        ),
        (|m| m.root["accessors"][0]["count"] = json!(u64::MAX), "accessor 0 ends beyond bufferView 0"),
        (|m| m.root["accessors"][0]["type"] = json!("VEC2"), "accessor 0 has the type `VEC2`, must be VEC3"),
        (|m| m.root["accessors"][0]["componentType"] = json!(1), "componentType 1"),
        (|m| m.root["accessors"][0]["bufferView"] = json!(70), "there is no bufferView 70"),
        (|m| _ = m.root["accessors"][0].as_object_mut().unwrap().remove("type"), "has the type ``"),
        (|m| m.root["accessors"][1]["byteOffset"] = json!(2), "accessor 1 ends beyond bufferView 1"),
        (|m| m.root["accessors"][1]["componentType"] = json!(5126), "accessor 1"),
        (|m| m.root["bufferViews"][0]["byteLength"] = json!(1_u64 << 40), "bufferView 0 ends beyond buffer 0"),
        (
            |m| m.root["bufferViews"][0]["byteStride"] = json!(4),
            "elements of 12 bytes, but bufferView 0 has them every 4",
        ),
        (|m| m.root["bufferViews"][0]["buffer"] = json!(3), "names buffer 3, which is not there"),
        (|m| m.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(5), "accessor 5 is not there"),
        (|m| m.root["meshes"][0]["primitives"][0]["mode"] = json!(7), "the mode 7"),
        (|m| m.root["meshes"][0]["primitives"][0]["material"] = json!(7), "there is no material 7"),
        (|m| m.root["nodes"][0]["mesh"] = json!(7), "node 0 (`Box`): there is no mesh 7"),
        (|m| m.root["nodes"][0]["children"] = json!([0]), "node 0 (`Box`) is reached in two ways"),
        (|m| m.root["asset"]["version"] = json!("1.0"), "glTF of version `1.0`"),
        (|m| m.root["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]), "without compression"),
        (
            |m| {
                m.root["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
                m.root["accessors"][0] = json!({"componentType": 5126, "count": 8, "type": "VEC3"});
            },
            "needs KHR_draco_mesh_compression",
        ),
        (|m| (m.root["asset"]["version"], m.root["nodes"]) = (json!("1.1"), json!({"a": {}})), "glTF of version `1.1`"),
        (
            |m| m.root["accessors"][0] = json!({"componentType": 5126, "count": 1_u64 << 40, "type": "VEC3"}),
            "no bufferView",
        ),
        (
            |m| m.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes()),
            "mesh 0 (`Cube`): vertex 0: a face uses this vertex",
        ),
    ];
    for (change, expected) in cases {
        let message = changed(&change);
        assert!(message.starts_with("a/set.gltf: ") && message.contains(expected), "{expected}: {message}");
    }
    let few = changed(&|m| m.bytes[96..98].copy_from_slice(&500_u16.to_le_bytes()));
    assert!(few.contains("primitive 0: names vertex 500, but there are 8"), "{few}");
    // The wrapping.
    let bytes = whole().binary();
    assert!(error(&bytes[..bytes.len() - 1]).contains("cut off"));
    assert!(error(&bytes[..10]).contains("cut off"));
    assert!(error(b"glTF\x01\0\0\0\x0c\0\0\0").contains("version 1"));
    assert!(error(b"{\n\"asset\": {\"version\": 2}}").starts_with("a/set.gltf:2:1: the JSON cannot be read"));
    assert!(error(b"").contains("the JSON cannot be read"));
    assert!(error(b"{}").contains("version"));
    assert!(error(&whole().text("no.bin")).contains("buffer 0 a/no.bin cannot be read: there is no such file"));
    assert!(error(&whole().text("https://example.org/x.bin")).contains("on the network"));
    assert!(error(&whole().text("data:x;base64,AAAA")).contains("buffer 0 is cut off: it has 3 of its"));
}

/// A few bytes cannot ask for all memory.
#[test]
fn numbers_that_are_used_very_often_are_refused() {
    let mut maker = Maker::new();
    maker.push("accessors", json!({"componentType": 5126, "count": 1 << 22, "type": "VEC3"}));
    let primitive = json!({"attributes": {"POSITION": 0}});
    maker.push("meshes", json!({"primitives": vec![primitive; 100]}));
    maker.node(json!({"mesh": 0}));
    // All of its faces are flat.
    maker.root["accessors"][0]["count"] = json!(1 << 10);
    assert!(error_of(&maker).contains("no triangles"));
    maker.root["accessors"][0]["count"] = json!(1 << 22);
    assert!(error_of(&maker).contains("more than"));
    // As many objects as nodes times materials.
    let mut maker = Maker::cube(None);
    let primitive = |material: usize| json!({"attributes": {"POSITION": 0}, "indices": 1, "material": material});
    maker.root["meshes"][0]["primitives"] = (0..2000).map(primitive).collect();
    (0..2000).for_each(|_| _ = maker.push("materials", json!({})));
    (0..2000).for_each(|_| _ = maker.node(json!({"mesh": 0})));
    assert!(error_of(&maker).contains("more than"));
    let many = [b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{}".to_vec(), b",{}".repeat(1 << 22), b"]}".to_vec()]
        .concat();
    assert!(error(&many).contains("more than the 4194304 tables"));
}
