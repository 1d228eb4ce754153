use std::path::Path;

use glam::DVec3;

use crate::formats::{Memory, read};
use crate::scene::camera::Camera;
use crate::scene::description::{Description, Environment, Shape};

fn scene_with(text: &str, files: &[(&str, &str)]) -> Result<Description, String> {
    let files = files.iter().map(|(name, text)| ((*name).into(), text.as_bytes().to_vec())).collect();
    read(text.as_bytes(), Path::new("s.pbrt"), &Memory(files)).map_err(|error| error.to_string())
}

fn scene(text: &str) -> Description {
    scene_with(text, &[]).unwrap()
}

fn declared(description: &Description, object: &str) -> (String, f64, String) {
    let object = description.objects.find(object).unwrap_or_else(|| panic!("no {object}: {:?}", description.objects));
    let refractor = object.refractor().expect("a refractor");
    let ior = description.medium(&refractor.medium).unwrap().ior.ior();
    (refractor.medium.clone(), ior, refractor.outside.clone().unwrap_or_default())
}

const CAMERA: &str = "LookAt 0 0 -9  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n";
const MEDIA: &str = "MakeNamedMedium \"sea\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.2 0.1 0] \"rgb sigma_s\" [0 0 0]\n\
                     MakeNamedMedium \"frost\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.01 0 0] \"rgb sigma_s\" [0 0 0]\n";

fn ball(radius: f64, eta: f64, media: [&str; 2]) -> String {
    let [inside, outside] = media;
    format!(
        "AttributeBegin\nMediumInterface \"{inside}\" \"{outside}\"\nMaterial \"dielectric\" \"float eta\" {eta}\n\
         Shape \"sphere\" \"float radius\" {radius}\nAttributeEnd\n"
    )
}

/// pbrt's coordinates are left-handed: what is at +x is at the right of a camera that looks along +z.
#[test]
fn the_picture_is_that_of_pbrt() {
    let place = |before: &str| {
        let read = scene(&format!("{before}{CAMERA}WorldBegin\nTranslate 1 0 0\nShape \"sphere\""));
        let Shape::Sphere { center, .. } = read.objects[0].shape else { panic!("a sphere") };
        let camera = Camera::new(&read.camera).unwrap();
        (center - camera.position).dot(camera.right)
    };
    assert!((place("") - 1.0).abs() < 1e-9);
    // With the usual turn of files that come from right-handed programs.
    assert!((place("Scale -1 1 1\n") + 1.0).abs() < 1e-9);
    let read =
        scene(&format!("Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" [ 800 ]\n{CAMERA}WorldBegin"));
    let expected = 2.0 * (20.0_f64.to_radians().tan() * 2.0).atan().to_degrees();
    assert!((read.camera.vertical_fov - expected).abs() < 1e-9, "over the shorter side");
}

#[test]
fn transforms_attributes_objects_and_includes() {
    let main = "WorldBegin\nInclude \"parts/ball.pbrt\"\nAttributeBegin\nTranslate 0 2 0\nScale 2 2 2\nObjectInstance \"ball\"\nAttributeEnd\n\
                Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1 ]\nObjectInstance \"ball\"\n";
    let part = "ObjectBegin \"ball\"\nTranslate 1 0 0\nMaterial \"diffuse\" \"rgb reflectance\" [.1 .2 .3]\nShape \"sphere\"\nObjectEnd\n";
    let read = scene_with(main, &[("parts/ball.pbrt", part)]).unwrap();
    let spheres: Vec<(DVec3, f64)> = (read.objects.iter())
        .filter_map(|o| if let Shape::Sphere { center, radius } = o.shape { Some((center, radius)) } else { None })
        .collect();
    assert_eq!(spheres, [(DVec3::new(2.0, 2.0, 0.0), 2.0), (DVec3::new(6.0, 6.0, 7.0), 1.0)]);
    for (text, start) in [
        ("WorldBegin\n  Shpae \"sphere\"", "s.pbrt:2:3: there is no directive `Shpae`"),
        ("AttributeEnd", "s.pbrt:1:1: `AttributeEnd` ends nothing"),
        ("WorldBegin Shape \"sphere\" \"float radius\" [ 1 x ]", "s.pbrt:1:46: `x` is no number"),
        ("Include \"no.pbrt\"", "s.pbrt:1:1: no.pbrt cannot be read"),
        ("ObjectInstance \"x\"", "s.pbrt:1:1: there is no object `x`"),
        ("Translate 1 2", "s.pbrt:1:14: a number is needed"),
    ] {
        let error = scene_with(text, &[]).unwrap_err();
        assert!(error.starts_with(start), "{error}");
    }
}

/// As in a public scene, whose translation stands in the wrong place.
#[test]
fn the_last_row_of_a_matrix_is_left_out() {
    let read = scene("WorldBegin\nConcatTransform [ 1 0 0 0  0 1 0 0  0 0 1 8.5  1 2 3 1 ]\nShape \"sphere\"");
    let Shape::Sphere { center, .. } = read.objects[0].shape else { panic!("a sphere") };
    assert_eq!(center, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(read.source.as_ref().unwrap().import.as_ref().unwrap().notes[0].kind, "projective");
}

/// Which side of a mesh is inside follows from its orientation.
#[test]
fn reversed_meshes_exchange_their_sides() {
    let mesh =
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 2 1 0 3 2 0 1 3 1 2 3]";
    let inside = |before: &str| {
        let read = scene(&format!("WorldBegin\nMaterial \"dielectric\" \"float eta\" 1.5\n{before}\n{mesh}"));
        declared(&read, "mesh").1
    };
    assert_eq!(inside(""), 1.5);
    assert_eq!(inside("ReverseOrientation"), 1.0);
    // pbrt keeps the outside of a mirrored mesh outside.
    assert_eq!(inside("Scale -1 1 1"), 1.5);
}

#[test]
fn what_has_no_counterpart_is_said_once_a_kind() {
    let read = scene(
        "WorldBegin\nMaterial \"subsurface\"\nShape \"sphere\"\nMaterial \"subsurface\"\nShape \"sphere\"\n\
         Shape \"curve\" \"point3 P\" []\nLightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2\nTexture \"t\" \"spectrum\" \"marble\"\n",
    );
    let import = read.source.as_ref().unwrap().import.as_ref().unwrap();
    let kinds: Vec<&str> = import.notes.iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["bsdf", "shape", "texture_unread", "no_camera"]);
    assert_eq!((import.notes[0].count, import.notes[0].first_line), (2, Some(2)));
    assert_eq!(read.environment, Environment::Color([2.0, 4.0, 6.0]));
}

/// Meshes that stand in the file itself are written beside the scene.
#[test]
fn it_is_saved_with_its_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let read = scene(
        "WorldBegin\nMaterial \"dielectric\"\nRotate 30 0 1 0\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \
         \"normal N\" [-1 -1 -1 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 2 1 0 3 2 0 1 3 1 2 3]",
    );
    let path = folder.path().join("saved.toml");
    crate::formats::save(&read, &path).unwrap();
    let again = crate::formats::open(&path).unwrap();
    let mesh = |description: &Description| match &description.objects[0].shape {
        Shape::Mesh { mesh, .. } => mesh.clone(),
        other => panic!("no mesh: {other:?}"),
    };
    let (saved, own) = (mesh(&again), mesh(&read));
    assert_eq!((&saved.positions, &saved.triangles), (&own.positions, &own.triangles));
    assert!(saved.normals.iter().zip(&own.normals).all(|(a, b)| (*a - *b).length() < 1e-6) && saved.normals.len() == 4);
    assert_eq!(again.objects[0].transform, read.objects[0].transform);
}

/// Whatever is changed about a file, it is read or refused, and never more than that.
#[test]
fn mutated_files_are_read_or_refused() {
    let whole = format!(
        "{MEDIA}{CAMERA}WorldBegin\n{}AttributeBegin\nTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\nAreaLightSource \"diffuse\" \"rgb L\" [1 2 3]\n\
         Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\nAttributeEnd\nObjectBegin \"o\"\nShape \"disk\" \"float innerradius\" 0.5\n\
         ObjectEnd\nScale 1 2 3\nObjectInstance \"o\"\nShape \"cylinder\"\nLightSource \"spot\" \"point3 from\" [0 1 0]\n",
        ball(3.0, 1.333, ["sea", ""])
    );
    crate::formats::importing::mutations(whole.as_bytes(), |bytes| {
        if let Ok(description) = read(bytes, Path::new("s.pbrt"), &Memory::default()) {
            // It may still be impossible, as a sphere that is too small for its place is.
            _ = crate::scene::compile::compile(&description, None);
        }
    });
}
