//! What the fuzz targets call: each takes any bytes, answers whether they were accepted, and panics where an answer is wrong. Shared by
//! `cargo fuzz` (`fuzz_targets/`) and by the test that runs everywhere (`tests/fuzzing.rs`).
#![allow(dead_code, reason = "each target uses one of these")]

use std::io::Write;
use std::path::Path;

use iorect::export::{read_sums, write_sums};
use iorect::formats::{BuiltIn, Memory, image_from_bytes, mesh_from_bytes, parse, read, to_text};

/// A scene file. Files that it names are looked for among those compiled into the program, never on the disk.
pub fn scene(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let path = Path::new("assets/scenes/fuzz.toml");
    let Ok(scene) = parse(text, path, &BuiltIn) else { return false };
    let saved = to_text(&scene);
    let again =
        parse(&saved, path, &BuiltIn).unwrap_or_else(|error| panic!("what was saved cannot be read: {error}\n{saved}"));
    assert_eq!(again.fingerprint(), scene.fingerprint(), "what was saved is another scene:\n{saved}");
    true
}

pub fn obj(bytes: &[u8]) -> bool {
    // Whether its parts can be shown or not: it is answered.
    let _ = read(
        bytes,
        Path::new("fuzz.obj"),
        &Memory([("a.mtl".into(), b"newmtl glass\nNi 1.5\nTf 0.5\n".to_vec())].into()),
    );
    for part in ["group = \"cube\"", "group = \"sides\", material = \"glass\""] {
        let head = "[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[solid]]\nname = \"s\"\n";
        let text = format!("{head}shape = {{ mesh = \"fuzz.obj\", {part} }}\n");
        let _ = parse(&text, Path::new("fuzz.toml"), &Memory([("fuzz.obj".into(), bytes.to_vec())].into()));
    }
    mesh(bytes, "fuzz.obj")
}

/// A library of materials, for a mesh that uses them.
pub fn mtl(bytes: &[u8]) -> bool {
    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    const FACES: &str = "f 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";
    let parts: String = ["glass", "red wine", "lamp", "wood"].map(|name| format!("usemtl {name}\n{FACES}")).concat();
    let obj = format!("mtllib a.mtl\n{CORNERS}{parts}");
    let scene = read(obj.as_bytes(), Path::new("fuzz.obj"), &Memory([("a.mtl".into(), bytes.to_vec())].into()));
    let scene = scene.expect("a scene, whatever the materials say");
    assert_eq!(scene.objects.len(), 6, "all parts are there");
    scene.objects.refractors().len() > 1 && scene.media.iter().all(|medium| medium.ior.ior() != 1.5)
}

pub fn ply(bytes: &[u8]) -> bool {
    mesh(bytes, "fuzz.ply")
}

/// A scene of another format. What it says in words is the same scene again.
pub fn gltf(bytes: &[u8]) -> bool {
    let files = Memory([("fuzz.glb".into(), bytes.to_vec())].into());
    let Ok(scene) = read(bytes, Path::new("fuzz.glb"), &files) else { return false };
    assert!(!scene.objects.is_empty(), "a scene without objects");
    let saved = to_text(&scene);
    let again = parse(&saved, Path::new("fuzz.toml"), &files)
        .unwrap_or_else(|error| panic!("what was written cannot be read: {error}\n{saved}"));
    assert_eq!(again.fingerprint(), scene.fingerprint(), "what was written is another scene:\n{saved}");
    // Whether there are triangles or not: it is answered.
    let _ = mesh(bytes, "fuzz.glb");
    true
}

fn mesh(bytes: &[u8], name: &str) -> bool {
    let Ok(mesh) = mesh_from_bytes(bytes, Path::new(name)) else { return false };
    assert!(!mesh.triangles.is_empty(), "a mesh without faces");
    assert!(
        mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < mesh.positions.len()),
        "a corner out of range"
    );
    assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len(), "normals without positions");
    let corners = mesh.triangles.iter().flatten().map(|corner| mesh.positions[*corner as usize]);
    assert!(corners.into_iter().all(glam::DVec3::is_finite), "a corner that is not finite");
    true
}

pub fn hdr(bytes: &[u8]) -> bool {
    image(bytes, "fuzz.hdr")
}

pub fn exr(bytes: &[u8]) -> bool {
    image(bytes, "fuzz.exr")
}

pub fn png(bytes: &[u8]) -> bool {
    image(bytes, "fuzz.png")
}

pub fn jpeg(bytes: &[u8]) -> bool {
    image(bytes, "fuzz.jpg")
}

fn image(bytes: &[u8], name: &str) -> bool {
    let Ok(image) = image_from_bytes(bytes, Path::new(name)) else { return false };
    assert_eq!(image.pixels.len(), image.width * image.height, "{}×{}", image.width, image.height);
    assert!(image.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "a pixel that is no radiance");
    true
}

/// A part of an image. It is read from a file, as `iorect merge` reads it.
pub fn sums(bytes: &[u8]) -> bool {
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.write_all(bytes).expect("room for a small file");
    let Ok(part) = read_sums(file.path()) else { return false };
    let again = file.path().with_extension("again.exr");
    write_sums(&again, &part).expect("what was read can be written");
    let same = read_sums(&again).expect("what was written can be read") == part;
    std::fs::remove_file(&again).expect("it was just written");
    assert!(same, "what was written is another part");
    true
}
