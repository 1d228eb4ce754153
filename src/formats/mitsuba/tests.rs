use std::path::Path;

use glam::DVec3;

use crate::formats::{Memory, read, to_text};
use crate::scene::description::{Description, Environment, Shape};

fn scene_with(text: &str, files: &[(&str, &str)]) -> Result<Description, String> {
    let files = files.iter().map(|(name, text)| ((*name).into(), text.as_bytes().to_vec())).collect();
    read(text.as_bytes(), Path::new("s.xml"), &Memory(files)).map_err(|error| error.to_string())
}

fn scene(inner: &str) -> Description {
    scene_with(&format!("<scene version=\"3.0.0\">{inner}</scene>"), &[]).unwrap()
}

fn kinds(description: &Description) -> Vec<&'static str> {
    let import = description.source.as_ref().unwrap().import.as_ref().unwrap();
    import.notes.iter().map(|note| note.kind).collect()
}

fn declared(description: &Description, object: &str) -> (String, f64, String) {
    let object = description.objects.find(object).unwrap_or_else(|| panic!("no {object}: {:?}", description.objects));
    let refractor = object.refractor().expect("a refractor");
    let ior = description.medium(&refractor.medium).unwrap().ior.ior();
    (refractor.medium.clone(), ior, refractor.outside.clone().unwrap_or_default())
}

const SENSOR: &str = r#"<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0, 0, 9" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>"#;

fn glass(id: &str, inside: &str, outside: &str) -> String {
    format!(r#"<bsdf type="dielectric" id="{id}"><float name="int_ior" value="{inside}"/>{outside}</bsdf>"#)
}

fn cube(id: &str, half: f64, inner: &str) -> String {
    format!(
        r#"<shape type="cube" id="{id}"><transform name="to_world"><scale value="{half}"/></transform>{inner}</shape>"#
    )
}

#[test]
fn the_camera_looks_along_z_with_x_to_the_left() {
    let described = scene(SENSOR);
    let camera = described.camera;
    assert!((camera.position - DVec3::new(0.0, 0.0, 9.0)).length() < 1e-12);
    assert!(((camera.target - camera.position).normalize() - DVec3::NEG_Z).length() < 1e-12);
    assert!((camera.up - DVec3::Y).length() < 1e-12);
    // 40° over the width of 768 by 576 pixels.
    let expected = 2.0 * (20.0_f64.to_radians().tan() * 0.75).atan().to_degrees();
    assert!((camera.vertical_fov - expected).abs() < 1e-9);
    let over_height = SENSOR.replace("<float", r#"<string name="fov_axis" value="y"/><float"#);
    assert!((scene(&over_height).camera.vertical_fov - 40.0).abs() < 1e-9);
}

#[test]
fn variables_includes_and_references() {
    let main = r#"<scene version="3.0.0">
<default name="size" value="2"/><default name="sizes" value="3"/>
<include filename="parts/glass.xml"/>
<shape type="sphere" id="ball"><float name="radius" value="$size"/><ref id="clear"/></shape>
<shape type="sphere" id="other"><float name="radius" value="$sizes"/><ref id="clear"/></shape></scene>"#;
    let part = r#"<scene version="3.0.0"><bsdf type="twosided"><bsdf type="dielectric" id="clear"/></bsdf></scene>"#;
    let read = scene_with(main, &[("parts/glass.xml", part)]).unwrap();
    assert_eq!(declared(&read, "ball"), ("clear".into(), 1.5046, "world".into()));
    let radii: Vec<f64> = (read.objects.iter())
        .filter_map(|o| if let Shape::Sphere { radius, .. } = o.shape { Some(radius) } else { None })
        .collect();
    assert_eq!(radii, [2.0, 3.0]);
    let import = read.source.as_ref().unwrap().import.as_ref().unwrap();
    assert_eq!(import.files, [Path::new("parts/glass.xml")]);
    // What is missing is told with its place.
    let missing = scene_with(main, &[]).unwrap_err();
    assert!(missing.starts_with("s.xml:3:1: parts/glass.xml cannot be read"), "{missing}");
    let unknown = scene_with("<scene>\n<shape type=\"sphere\"><ref id=\"x\"/></shape></scene>", &[]).unwrap_err();
    assert!(unknown.starts_with("s.xml:2:22: there is no element with the id `x`"), "{unknown}");
    let broken = scene_with("<scene>\n<shape></scene>", &[]).unwrap_err();
    assert!(broken.starts_with("s.xml:2:"), "{broken}");
}

const TRIANGLES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";

/// Which side of a mesh is inside follows from its normals, as Mitsuba takes them.
#[test]
fn flipped_and_mirrored_meshes_exchange_their_sides() {
    let read = |inner: &str| {
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/>{}{inner}</shape></scene>",
            glass("", "1.5", r#"<float name="ext_ior" value="1.33"/>"#)
        );
        let scene = scene_with(&text, &[("m.obj", TRIANGLES)]).unwrap();
        (declared(&scene, "m").1, scene)
    };
    let flip = r#"<boolean name="flip_normals" value="true"/>"#;
    let mirror = r#"<transform name="to_world"><scale x="-1"/></transform>"#;
    assert_eq!(read("").0, 1.5);
    assert_eq!(read(flip).0, 1.33);
    assert_eq!(read(mirror).0, 1.33);
    assert_eq!(read(&(flip.to_owned() + mirror)).0, 1.5);
    let shear = r#"<transform name="to_world"><matrix value="1 0.5 0 0  0 1 0 0  0 0 1 0  0 0 0 1"/></transform>"#;
    let (ior, sheared) = read(shear);
    assert_eq!(ior, 1.5);
    let Shape::Mesh { mesh, path, .. } = &sheared.objects[0].shape else { panic!("a mesh") };
    assert_eq!((mesh.positions[2], path.as_path()), (DVec3::new(0.5, 1.0, 0.0), Path::new("s.xml")));
}

#[test]
fn instances_stand_where_their_transforms_say() {
    let group = format!(
        r#"<shape type="shapegroup" id="g"><shape type="sphere"><float name="radius" value="0.5"/>{}</shape></shape>"#,
        glass("", "1.5", "")
    );
    let instance = |x: f64| {
        format!(
            r#"<shape type="instance"><ref id="g"/><transform name="to_world"><translate x="{x}"/></transform></shape>"#
        )
    };
    let read = scene(&(group + &instance(1.0) + &instance(-2.0)));
    let centers: Vec<f64> = (read.objects.iter())
        .filter_map(|o| if let Shape::Sphere { center, .. } = o.shape { Some(center.x) } else { None })
        .collect();
    assert_eq!(centers, [1.0, -2.0]);
}

#[test]
fn what_has_no_counterpart_is_said_once_a_kind() {
    let rough = r#"<bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf>"#;
    let read = scene(
        &(SENSOR.to_owned()
            + &cube("a", 1.0, rough)
            + &cube("b", 2.0, rough)
            + &cube("c", 3.0, r#"<bsdf type="hair"/>"#)
            + r#"<shape type="sdfgrid"/>"#
            + r#"<emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>"#
            + r#"<emitter type="sunsky"/>"#),
    );
    assert_eq!(kinds(&read), ["distribution", "bsdf", "shape", "emitter"]);
    let import = read.source.as_ref().unwrap().import.as_ref().unwrap();
    assert_eq!((import.notes[0].count, import.notes[0].first_line), (2, Some(2)));
    assert_eq!(read.environment, Environment::Color([0.5; 3]));
    assert!(read.objects.find("c").is_some_and(|object| object.solid().is_some()));
}

/// Nothing about rendering stands in the way of reading the scene.
#[test]
fn how_to_render_is_passed_over() {
    let read = scene(
        r#"<integrator type="$kind"/><sampler type="$kind" id="many"><integer name="sample_count" value="$spp"/></sampler>
        <sensor type="perspective"><ref id="many"/><sampler type="independent"><integer name="sample_count" value="$spp"/></sampler></sensor>
        <emitter type="area" id="glow"><rgb name="radiance" value="2"/></emitter><shape type="sphere"><ref id="glow"/></shape>"#,
    );
    assert_eq!(kinds(&read), [""; 0]);
    assert!(read.objects[0].light().is_some());
}

/// Files are looked for where `<path>` says too, as seen from the file that says it.
#[test]
fn files_are_looked_for_in_other_folders() {
    let text = r#"<scene version="3.0.0"><path value="../common"/><shape type="obj"><string name="filename" value="meshes/a.obj"/></shape></scene>"#;
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let files = Memory([("common/meshes/a.obj".into(), mesh.as_bytes().to_vec())].into());
    let read = crate::formats::read(text.as_bytes(), Path::new("scenes/s.xml"), &files).unwrap();
    let Shape::Mesh { path, .. } = &read.objects[0].shape else { panic!("a mesh") };
    assert_eq!(path, Path::new("../common/meshes/a.obj"), "from the scene's folder");
}

/// As a scene of the program's own format it says the same.
#[test]
fn it_is_written_as_the_own_format() {
    let read = scene(
        &(SENSOR.to_owned()
            + &cube("tank", 3.0, &glass("", "1.333", ""))
            + &cube("ice", 1.0, &glass("", "1.31", r#"<float name="ext_ior" value="1.333"/>"#))
            + r#"<shape type="rectangle" id="lamp"><emitter type="area"><rgb name="radiance" value="3"/></emitter></shape>"#),
    );
    let text = to_text(&read);
    let again = crate::formats::parse(&text, Path::new("s.toml"), &Memory::default()).unwrap();
    assert_eq!((&again.objects, &again.media, &again.world), (&read.objects, &read.media, &read.world), "{text}");
    assert_eq!(again.fingerprint(), read.fingerprint());
}

/// Whatever is changed about a file, it is read or refused, and never more than that.
#[test]
fn mutated_files_are_read_or_refused() {
    let whole = format!(
        "<scene version=\"3.0.0\"><default name=\"r\" value=\"0.5\"/>{SENSOR}{}{}<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>\
         <shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/></shape></scene>",
        cube("tank", 3.0, &glass("", "1.333", "")),
        r#"<emitter type="spot"><rgb name="intensity" value="1, 2, 3"/></emitter>"#
    );
    crate::formats::importing::mutations(whole.as_bytes(), |bytes| {
        let files = [("m.obj".into(), TRIANGLES.as_bytes().to_vec())].into();
        if let Ok(description) = read(bytes, Path::new("s.xml"), &Memory(files)) {
            // It may still be impossible, as a sphere that is too small for its place is.
            _ = crate::scene::compile::compile(&description, None);
        }
    });
    // Elements in each other to no end.
    let deep = "<scene>".to_owned() + &"<shape>".repeat(20_000) + &"</shape>".repeat(20_000) + "</scene>";
    assert!(scene_with(&deep, &[]).is_err());
}

/// What could go on for ever, or double with every line.
#[test]
fn circles_and_doublings_end() {
    let doubling: String =
        (1..64).map(|k| format!("<default name=\"v{k}x\" value=\"$v{}x$v{}x\"/>", k - 1, k - 1)).collect();
    let doubling = format!("<scene><default name=\"v0x\" value=\"1\"/>{doubling}</scene>");
    assert!(scene_with(&doubling, &[]).unwrap_err().contains("more than"));
    let texture = r#"<scene><texture type="checkerboard" id="t"><ref id="t" name="color0"/></texture><shape type="sphere"><bsdf type="diffuse">
<ref id="t" name="reflectance"/></bsdf></shape></scene>"#;
    assert!(scene_with(texture, &[]).unwrap_err().contains("deep in each other"));
    let group = r#"<scene><shape type="shapegroup" id="g"><shape type="instance"><ref id="g"/></shape></shape><shape type="instance"><ref id="g"/></shape></scene>"#;
    assert!(scene_with(group, &[]).unwrap_err().contains("too many shapes"));
    let mesh = r#"<scene><shape type="obj"><string name="filename" value="s.xml"/></shape></scene>"#;
    assert!(scene_with(mesh, &[("s.xml", mesh)]).unwrap_err().contains("s.xml is no mesh that is read"));
    let itself = "<scene><include filename=\"s.xml\"/></scene>";
    assert!(scene_with(itself, &[("s.xml", itself)]).unwrap_err().contains("include each other"));
}

/// Meshes that are in no file of their own are named as parts of the scene's, until it is saved.
#[test]
fn a_scene_in_words_is_the_same_scene() {
    let sheared = r#"<transform name="to_world"><matrix value="1 0.5 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform>"#;
    let text = format!(
        "<scene version=\"3.0.0\">{SENSOR}<shape type=\"cube\" id=\"block\">{sheared}{}</shape></scene>",
        glass("", "1.5", "")
    );
    let scene = scene_with(&text, &[]).unwrap();
    let Shape::Mesh { part, .. } = &scene.objects[0].shape else { panic!("a mesh: {:?}", scene.objects[0]) };
    assert_eq!(part.group.as_deref(), Some("block"));
    let files = Memory([("s.xml".into(), text.into_bytes())].into());
    let saved = crate::formats::to_text(&scene);
    let again = crate::formats::parse(&saved, Path::new("s.toml"), &files).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint(), "{saved}");
    let missing =
        crate::formats::parse(&saved.replace("group = \"block\"", "group = \"rock\""), Path::new("s.toml"), &files);
    assert!(missing.unwrap_err().to_string().contains("s.xml has no mesh of its own for an object `rock`"));
}
