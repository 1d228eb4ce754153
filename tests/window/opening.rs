//! Files of every kind, dropped on the window or opened by name.

use std::path::Path;

use egui_kittest::Harness;
use iorect::app::{App, Command};
use iorect::scene::Description;
use iorect::scene::description::Environment;

use crate::harness::{apply, drop_files, has_notice, until, window};

fn scene(harness: &Harness<'_, App>) -> Description {
    Description::clone(harness.state().state().document.description())
}

fn write(path: &Path, contents: impl AsRef<[u8]>) {
    std::fs::write(path, contents).expect("the folder is writable");
}

/// A tetrahedron of glass, with its buffer in another file.
pub fn write_gltf(path: &Path, ior: f64) {
    let corners: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces: [u8; 12] = [0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).chain(faces).collect();
    write(&path.with_file_name("stone.bin"), bytes);
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0, "name": "stone"}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}],
        "materials": [{{"name": "crystal", "pbrMetallicRoughness": {{"metallicFactor": 0, "roughnessFactor": 0}}, "extensions": {{
            "KHR_materials_transmission": {{"transmissionFactor": 1}}, "KHR_materials_volume": {{"thicknessFactor": 1}},
            "KHR_materials_ior": {{"ior": {ior}}}}}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 12}}],
        "buffers": [{{"byteLength": 60, "uri": "stone.bin"}}]}}"#
    );
    write(path, text);
}

#[test]
fn a_gltf_file_opens_is_watched_and_becomes_a_scene_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [gltf, saved] = ["stone.gltf", "mine.toml"].map(|name| folder.path().join(name));
    write_gltf(&gltf, 1.7);
    let mut harness = window("nested-spheres");
    // The buffer that was dragged along does not matter.
    drop_files(&mut harness, &[&folder.path().join("stone.bin"), &gltf]);
    until(&mut harness, "it is open", |app| app.state().document.description().name == "stone");
    let ior = |app: &App| app.state().document.description().medium("crystal").map(|medium| medium.ior.ior());
    assert_eq!(ior(harness.state()), Some(1.7));
    assert!(harness.state().state().document.path.is_none(), "the file itself is never written to");
    // Another program writes it anew.
    harness.run_steps(2);
    std::thread::sleep(std::time::Duration::from_millis(1000));
    write_gltf(&gltf, 1.625);
    until(&mut harness, "the change is shown", |app| ior(app) == Some(1.625));
    let before = std::fs::read(&gltf).expect("it is there");
    apply(&mut harness, Command::SaveAs(saved.clone()));
    until(&mut harness, "it is saved", |app| app.state().document.path.is_some());
    let again = iorect::formats::open(&saved).expect("a scene file");
    assert_eq!(again.fingerprint(), scene(&harness).fingerprint());
    assert!(folder.path().join("mine-meshes/stone.ply").is_file());
    assert_eq!(std::fs::read(&gltf).expect("it is there"), before);
}

#[test]
fn a_mesh_is_added_and_an_image_surrounds_the_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [mesh, library, image] = ["stone.obj", "stone.mtl", "sky.hdr"].map(|name| folder.path().join(name));
    write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    write(&library, "newmtl a\n");
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    (0..8).for_each(|_| sky.extend([128, 128, 128, 129]));
    write(&image, sky);
    let mut harness = window("nested-spheres");
    let count = scene(&harness).objects.len();
    drop_files(&mut harness, &[&library, &mesh]);
    until(&mut harness, "it is added", move |app| app.state().document.description().objects.len() == count + 1);
    assert!(scene(&harness).objects.find("stone").is_some());
    drop_files(&mut harness, &[&image]);
    until(&mut harness, "it surrounds the scene", |app| {
        matches!(app.state().document.description().environment, Environment::Image { .. })
    });
}

/// Scenes are opened, meshes added, and images put around the scene, by a drop or by the dialog, which ask for the same.
#[test]
fn every_kind_of_file_can_be_dropped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    write(
        &path("mitsuba.xml"),
        r#"<scene version="3.0.0"><emitter type="constant"/><shape type="sphere"><bsdf type="dielectric"/></shape></scene>"#,
    );
    write(
        &path("book.pbrt"),
        "WorldBegin\nLightSource \"infinite\"\nMaterial \"dielectric\" \"float eta\" 1.4\nShape \"sphere\"\n",
    );
    iorect::formats::save(&iorect::formats::open("camera-in-water").expect("a built-in scene"), &path("own.toml"))
        .expect("the folder is writable");
    write_gltf(&path("other.gltf"), 1.5);
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    write(&path("pebble.ply"), format!("{header}{corners}3 0 2 1\n3 0 3 2\n3 0 1 3\n3 1 2 3\n"));
    let facet = |corners: [&str; 3]| {
        let corners = corners.map(|corner| format!("vertex {corner}\n")).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let [o, x, y, z] = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let facets = [facet([o, y, x]), facet([o, z, y]), facet([o, x, z]), facet([x, y, z])].concat();
    write(&path("shard.stl"), format!("solid shard\n{facets}endsolid shard\n"));
    let picture = iorect::export::Picture { width: 4, height: 2, rgb: vec![[0.5; 3]; 8] };
    iorect::export::exr(&path("sky.exr"), &picture, &[]).expect("the folder is writable");

    let mut harness = window("nested-spheres");
    for (file, name) in
        [("mitsuba.xml", "mitsuba"), ("book.pbrt", "book"), ("other.gltf", "other"), ("own.toml", "Camera in water")]
    {
        drop_files(&mut harness, &[&path(file)]);
        until(&mut harness, file, move |app| app.state().document.description().name == name);
        assert!(!scene(&harness).objects.refractors().is_empty(), "{file}");
    }
    for (file, name) in [("pebble.ply", "pebble"), ("shard.stl", "shard")] {
        drop_files(&mut harness, &[&path(file)]);
        until(&mut harness, file, move |app| app.state().document.description().objects.find(name).is_some());
        assert_eq!(scene(&harness).name, "Camera in water", "{file} is added");
    }
    drop_files(&mut harness, &[&path("sky.exr")]);
    until(&mut harness, "the sky is there", |app| {
        matches!(app.state().document.description().environment, Environment::Image { .. })
    });
}

/// A box for each material of a library: two of glass, one opaque, one that shines.
#[test]
fn a_mesh_of_several_materials_is_added_as_several_objects_that_stay_together() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [mesh, library] = ["set.obj", "set.mtl"].map(|name| folder.path().join(name));
    let mut text = "mtllib set.mtl\n".to_owned();
    for (number, material) in ["wine", "crystal", "coaster", "lamp"].into_iter().enumerate() {
        let x = 2000 * number;
        text += &format!("usemtl {material}\nv {x} 0 0\nv {} 0 0\nv {x} 1000 0\nv {x} 0 1000\n", x + 1000);
        text += "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
    }
    write(&mesh, text);
    write(
        &library,
        "newmtl wine\nNi 1.36\nd 0.1\nnewmtl crystal\nNi 1.6\nd 0.1\nnewmtl coaster\nKd 0.2 0.1 0\nnewmtl lamp\nKe 4 4 4\n",
    );
    let mut harness = window("nested-spheres");
    let before = scene(&harness);
    for round in 1..=2 {
        drop_files(&mut harness, &[&mesh]);
        let count = before.objects.len() + 4 * round;
        until(&mut harness, "they are added", move |app| app.state().document.description().objects.len() == count);
    }
    let after = scene(&harness);
    let refractor = |name: &str| after.objects.find(name).and_then(|object| object.refractor()).expect("a refractor");
    for (name, ior) in [("wine", 1.36), ("crystal", 1.6), ("wine 2", 1.36), ("crystal 2", 1.6)] {
        let medium = after.medium(&refractor(name).medium).expect("it comes along");
        assert_eq!((medium.name.as_str(), medium.ior.ior()), (name, ior));
    }
    assert!(after.objects.find("coaster 2").is_some_and(|object| object.solid().is_some()));
    assert!(after.objects.find("lamp 2").is_some_and(|object| object.light().is_some()));
    // One size and one place for all, so that they stand to each other as in the file.
    let transform = |name: &str| after.objects.find(name).map(|object| object.transform);
    assert!(["crystal", "coaster", "lamp"].iter().all(|name| transform(name) == transform("wine")));
    assert_ne!(transform("wine"), transform("wine 2"));
    assert!(transform("wine").is_some_and(|transform| transform.scale.x < 0.01), "a mesh in millimetres");
    // They came together and go together.
    apply(&mut harness, Command::Undo);
    assert_eq!(scene(&harness).objects.len(), before.objects.len() + 4);
    apply(&mut harness, Command::Undo);
    assert_eq!(scene(&harness), before);
}

#[test]
fn a_damaged_gltf_file_is_a_notice() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let gltf = folder.path().join("stone.gltf");
    write_gltf(&gltf, 1.7);
    write(&folder.path().join("stone.bin"), [0; 9]);
    let mut harness = window("nested-spheres");
    let name = scene(&harness).name;
    drop_files(&mut harness, &[&gltf]);
    until(&mut harness, "the notice is there", |app| !app.state().notices.is_empty());
    assert!(has_notice(&harness, "buffer 0 is cut off: it has 9 of its 60 bytes"));
    assert_eq!(scene(&harness).name, name);
}
