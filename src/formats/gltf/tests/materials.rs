use std::io::Cursor;
use std::path::Path;

use serde_json::{Value, json};

use super::make::{CUBE_FACES, Maker};
use super::{notes, opened};
use crate::formats::{parse, to_text};
use crate::optics::Ior;
use crate::scene::description::{Description, Paint, Solid};

fn of(material: Value) -> Description {
    let mut maker = Maker::cube(Some(material));
    maker.node(json!({"mesh": 0}));
    opened(&maker)
}

fn solid(material: Value) -> ([f64; 3], bool) {
    let scene = of(material);
    let solid = scene.objects[0].solid().expect("a solid");
    let Paint::Color(color) = solid.paint else { panic!("one colour") };
    (color, solid.mirror)
}

fn glass(extensions: &Value) -> Value {
    let mut material = json!({
        "name": "Wine",
        "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
    });
    for (name, extension) in extensions.as_object().unwrap() {
        material["extensions"][name] = extension.clone();
    }
    material
}

#[test]
fn what_transmits_with_a_volume_is_a_refractor() {
    let volume = json!({"thicknessFactor": 0.5, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 0]});
    let scene = of(glass(&json!({"KHR_materials_volume": volume, "KHR_materials_ior": {"ior": 1.36}})));
    let [wine] = &scene.media[..] else { panic!("one medium: {:?}", scene.media) };
    assert_eq!((wine.name.as_str(), &wine.ior), ("Wine", &Ior::Constant(1.36)));
    assert!((wine.absorption[0] - 2_f64.ln() / 2.0).abs() < 1e-12 && wine.absorption[1] == 0.0);
    assert!((wine.absorption[2] - 1e4_f64.ln() / 2.0).abs() < 1e-12);
    assert_eq!(scene.objects.refractors()[0].refractor().unwrap().medium, "Wine");
    // A renderer of glTF takes the world to be around everything.
    let declared = (scene.objects[0].outside(), scene.camera_medium.as_deref());
    assert_eq!(declared, (Some("world"), Some("world")));
    assert_eq!(notes(&scene), ["black_volume", "no_camera", "no_light"]);
}

#[test]
fn a_thin_wall_is_taken_for_a_body_and_kept_as_such() {
    let scene = of(glass(&json!({})));
    let refractor = scene.objects[0].refractor().unwrap();
    assert!(refractor.thin && scene.objects[0].visible && refractor.roughness == [0.0; 2]);
    assert_eq!((&scene.media[0].ior, scene.media[0].absorption), (&Ior::Constant(1.5), [0.0; 3]));
    assert_eq!(notes(&scene), ["no_camera", "no_light"]);
}

#[test]
fn what_glass_has_no_place_for_is_told_once_a_kind() {
    let mut material = glass(&json!({
        "KHR_materials_volume": {"thicknessFactor": 1},
        "KHR_materials_dispersion": {"dispersion": 0.3},
        "KHR_materials_specular": {"specularFactor": 0.5},
        "KHR_materials_clearcoat": {"clearcoatFactor": 1},
        "KHR_materials_iridescence": {},
    }));
    material["pbrMetallicRoughness"] =
        json!({"metallicFactor": 0, "roughnessFactor": 0.4, "baseColorFactor": [0.5, 1, 1, 1]});
    material["normalTexture"] = json!({"index": 0});
    let scene = of(material);
    let medium = &scene.media[0];
    assert!((medium.ior.ior() - 1.5).abs() < 1e-12 && (medium.ior.abbe_number().unwrap() - 20.0 / 0.3).abs() < 1e-6);
    assert!((medium.absorption[0] - 2.0 * 2_f64.ln()).abs() < 1e-12);
    let refractor = scene.objects[0].refractor().unwrap();
    assert!(!refractor.thin && refractor.roughness.iter().all(|alpha| (alpha - 0.16).abs() < 1e-12));
    let kinds = ["normal_texture", "material_extension", "specular", "surface_tint"];
    assert_eq!(notes(&scene)[..4], kinds);
}

#[test]
fn media_of_equal_values_stay_two_and_one_material_is_one() {
    let mut maker = Maker::cube(Some(glass(&json!({"KHR_materials_volume": {"thicknessFactor": 1}}))));
    let twin = maker.root["materials"][0].clone();
    maker.push("materials", twin);
    let mut second = maker.root["meshes"][0].clone();
    second["primitives"][0]["material"] = json!(1);
    maker.push("meshes", second);
    for (mesh, x) in [(0, 0), (1, 5), (0, 10)] {
        maker.node(json!({"mesh": mesh, "translation": [x, 0, 0]}));
    }
    let scene = opened(&maker);
    assert_eq!(scene.media.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["Wine", "Wine 2"]);
    let media: Vec<&str> = scene.objects.refractor_roles().map(|refractor| refractor.medium.as_str()).collect();
    assert_eq!(media, ["Wine", "Wine 2", "Wine"]);
}

#[test]
fn solids_are_diffuse_or_mirrors() {
    let pbr = |metallic: f64, roughness: f64| json!({"pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness, "baseColorFactor": [0.9, 0.6, 2, 1]}});
    assert_eq!(solid(pbr(0.0, 1.0)), ([0.9, 0.6, 1.0], false));
    assert_eq!(solid(pbr(1.0, 0.0)), ([0.9, 0.6, 1.0], true));
    assert_eq!(solid(pbr(1.0, 0.9)), ([0.9, 0.6, 1.0], false));
    // Of metal nothing passes.
    let mut metal = glass(&json!({}));
    metal["pbrMetallicRoughness"]["metallicFactor"] = json!(1);
    assert!(solid(metal).1);
    let weak = json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.2}}, "pbrMetallicRoughness": {"metallicFactor": 0}});
    assert_eq!(notes(&of(weak))[0], "part_transmission");
    let old = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.3, 1]}}});
    assert_eq!(solid(old), ([0.1, 0.2, 0.3], false));
    let mut maker = Maker::cube(None);
    maker.node(json!({"mesh": 0}));
    let scene = opened(&maker);
    assert_eq!(scene.objects[0].solid().map(|solid| &solid.paint), Some(&Paint::Color([0.8; 3])));
}

/// Colours of vertices multiply that of the material (section 3.9.2 of the specification); a mesh without them stays as it is.
#[test]
fn colors_of_vertices_stand_for_their_average() {
    let mut maker = Maker::cube(Some(
        json!({"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1, "baseColorFactor": [0.5, 1, 1, 1]}}),
    ));
    let colors: Vec<[f32; 3]> = (0..8).map(|i| if i < 2 { [1.0, 0.0, 0.4] } else { [0.2, 0.0, 0.8] }).collect();
    let accessor = maker.floats(&colors);
    let plain = maker.root["meshes"][0].clone();
    maker.root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
    maker.push("meshes", plain);
    (0..2).for_each(|mesh| _ = maker.node(json!({"mesh": mesh})));
    let scene = opened(&maker);
    let Some(Solid { paint: Paint::Color(color), .. }) = scene.objects[0].solid() else { panic!("one colour") };
    assert!(color.iter().zip([0.2, 0.0, 0.7]).all(|(a, b)| (a - b).abs() < 1e-6), "{color:?}");
    assert_eq!(scene.objects[1].solid().map(|solid| &solid.paint), Some(&Paint::Color([0.5, 1.0, 1.0])));
    assert!(notes(&scene).contains(&"vertex_colors"));
    // With opacity, as whole numbers.
    let view = maker.view(&[255, 51, 0, 7].repeat(8));
    maker.root["accessors"][accessor] =
        json!({"bufferView": view, "componentType": 5121, "normalized": true, "count": 8, "type": "VEC4"});
    let scene = opened(&maker);
    let Some(Solid { paint: Paint::Color(color), .. }) = scene.objects[0].solid() else { panic!("one colour") };
    assert!(color.iter().zip([0.5, 0.2, 0.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{color:?}");
}

#[test]
fn what_emits_is_a_light() {
    let lamp = |factor: f64| json!({"emissiveFactor": [factor, 0, 0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}});
    let scene = of(lamp(0.5));
    assert_eq!(scene.objects.lights()[0].light().unwrap().emission.rgb, [5.0, 0.0, 0.0]);
    assert!(!notes(&scene).contains(&"no_light"));
    assert_eq!(notes(&of(lamp(0.001)))[0], "weak_emission");
    // Sheets of it may shine from both sides; the inside of a cube shines for nobody.
    let two_sided = |faces: &[u16]| {
        let mut material = lamp(1.0);
        material["doubleSided"] = json!(true);
        let mut maker = Maker::cube(Some(material));
        let indices = maker.shorts(faces);
        maker.root["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        maker.node(json!({"mesh": 0}));
        opened(&maker).objects.lights()[0].light().unwrap().two_sided
    };
    assert!(two_sided(&CUBE_FACES[..6]) && !two_sided(&CUBE_FACES));
}

#[test]
fn images_stand_for_their_average() {
    // A quarter black, the rest white.
    let image = image::RgbImage::from_fn(4, 4, |x, _| image::Rgb([if x < 1 { 0 } else { 255 }; 3]));
    let mut png = Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let material = json!({"pbrMetallicRoughness": {
        "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}},
        "baseColorFactor": [0.8, 0.4, 0, 1], "metallicFactor": 1, "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.2,
    }});
    let mut maker = Maker::cube(Some(material));
    let view = maker.view(&png.into_inner());
    maker.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    maker.push("textures", json!({"source": 0}));
    maker.node(json!({"mesh": 0}));
    let scene = opened(&maker);
    let solid = scene.objects[0].solid().unwrap();
    let Paint::Color(color) = solid.paint else { panic!("one colour") };
    assert!(color.iter().zip([0.6, 0.3, 0.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{color:?}");
    // More of it is metal than not. The cube has no texture coordinates.
    assert!(solid.mirror);
    // α is the square of the roughness, here of 0.2 times the mean of the image's green.
    assert!(solid.roughness.iter().all(|alpha| (alpha - 0.0225).abs() < 1e-9), "{:?}", solid.roughness);
    assert_eq!(notes(&scene)[..2], ["texture", "no_texture_coordinates"]);
    // One that cannot be read, or is not there, leaves the factor alone.
    for image in [
        json!({"uri": "data:image/ktx2;base64,AAAA"}),
        json!({"uri": "gone.png"}),
        json!({"bufferView": 99}),
        json!({}),
    ] {
        maker.root["images"][0] = image;
        let scene = opened(&maker);
        assert_eq!(notes(&scene)[0], "image");
        assert_eq!(scene.objects[0].solid().map(|solid| &solid.paint), Some(&Paint::Color([0.8, 0.4, 0.0])));
    }
}

/// A square in two triangles with the coordinates of a whole image, v downwards as glTF has them, of a material with an image of two by two.
fn square(texture: Value, sets: &[[[f32; 2]; 4]]) -> Maker {
    let image = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([255 * x as u8, 255 * y as u8, 0]));
    let mut png = Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mut maker = Maker::cube(Some(json!({
        "name": "Oak",
        "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [1, 0.5, 1, 1], "baseColorTexture": texture},
    })));
    let position = maker.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = maker.shorts(&[0, 1, 2, 0, 2, 3]);
    let mut attributes = json!({"POSITION": position});
    for (set, uv) in sets.iter().enumerate() {
        let view = maker.view(&uv.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        let accessor = json!({"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC2"});
        let accessor = maker.push("accessors", accessor);
        attributes[format!("TEXCOORD_{set}")] = json!(accessor);
    }
    maker.root["meshes"][0]["primitives"][0]["attributes"] = attributes;
    maker.root["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let view = maker.view(&png.into_inner());
    maker.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    maker.push("textures", json!({"source": 0, "sampler": 0}));
    maker.push("samplers", json!({}));
    maker.node(json!({"mesh": 0, "name": "plate"}));
    maker
}

const WHOLE: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

/// The texture coordinates at the lower left, the lower right and the upper right corner.
fn uvs(scene: &Description) -> [[f32; 2]; 3] {
    super::mesh(&scene.objects[0]).uvs[0]
}

#[test]
fn base_colours_with_images_are_textures() {
    let scene = opened(&square(json!({"index": 0}), &[WHOLE]));
    let Paint::Texture { path, image, tint, .. } = &scene.objects[0].solid().unwrap().paint else {
        panic!("no texture")
    };
    assert_eq!((path.to_str(), *tint), (Some("set.glb#/images/0"), [1.0, 0.5, 1.0]));
    // The upper row first: black and red, then green and yellow.
    let rgb = |texel: &[u8; 4]| [texel[0], texel[1], texel[2]];
    let texels: Vec<[u8; 3]> = image.texels().iter().map(rgb).collect();
    assert_eq!(texels, [[0, 0, 0], [255, 0, 0], [0, 255, 0], [255, 255, 0]]);
    // v goes up.
    assert_eq!(uvs(&scene), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!(notes(&scene), ["no_camera", "no_light"]);
}

/// In the words of a scene file, which name the image within the file; and saved, with files of its own.
#[test]
fn embedded_images_survive() {
    let maker = square(json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 1]}}}), &[WHOLE]);
    let scene = opened(&maker);
    let files = super::files(&[("a/set.glb", maker.binary())]);
    let again = parse(&to_text(&scene), Path::new("a/set.toml"), &files).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plates.toml");
    crate::formats::save(&scene, &path).unwrap();
    let saved = crate::formats::file(&path).unwrap();
    let Paint::Texture { path, image, tint, .. } = &saved.objects[0].solid().unwrap().paint else {
        panic!("no texture")
    };
    assert_eq!((path.to_str(), *tint), (Some("plates-textures/plate.png"), [1.0, 0.5, 1.0]));
    let Paint::Texture { image: before, .. } = &scene.objects[0].solid().unwrap().paint else { panic!("no texture") };
    assert_eq!((image, uvs(&saved)), (before, uvs(&scene)));
}

#[test]
fn textures_are_moved_turned_and_scaled() {
    let with = |transform: Value, tex_coord: usize| {
        let texture = json!({"index": 0, "texCoord": tex_coord, "extensions": {"KHR_texture_transform": transform}});
        let other = WHOLE.map(|[u, v]| [u * 0.5, v * 0.5]);
        uvs(&opened(&square(texture, &[WHOLE, other])))
    };
    // With v downwards: (u, v) at the lower left is (0, 1), becomes (0.25, 2.5) and is (0.25, −1.5) with v upwards.
    assert_eq!(with(json!({"scale": [2, 2], "offset": [0.25, 0.5]}), 0), [[0.25, -1.5], [2.25, -1.5], [2.25, 0.5]]);
    assert_eq!(with(json!({}), 1), [[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]]);
    assert_eq!(with(json!({"texCoord": 1}), 0), [[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]]);
    // Coordinates are turned counter-clockwise about the upper left corner, (0, 1) with v upwards: what was below it is now to its right.
    let turned = with(json!({"rotation": std::f64::consts::FRAC_PI_2}), 0);
    for (found, expected) in turned.iter().zip([[1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]) {
        assert!((found[0] - expected[0]).abs() + (found[1] - expected[1]).abs() < 1e-6, "{turned:?}");
    }
}

#[test]
fn what_is_approximated_of_textures_is_told() {
    let twice = WHOLE.map(|uv| uv.map(|x| 2.0 * x));
    for (uv, sampler, expected) in [
        (twice, json!({"wrapS": 33071}), Some("wrap")),
        (twice, json!({"wrapT": 33648}), Some("wrap")),
        (twice, json!({"wrapS": 10497}), None),
        (WHOLE, json!({"wrapS": 33071}), None),
    ] {
        let mut maker = square(json!({"index": 0}), &[uv]);
        maker.root["samplers"][0] = sampler;
        let found = notes(&opened(&maker)).into_iter().find(|kind| *kind == "wrap");
        assert_eq!(found, expected);
    }
    let mut maker = square(json!({"index": 0}), &[WHOLE]);
    maker.root["materials"][0]["alphaMode"] = json!("MASK");
    assert_eq!(notes(&opened(&maker))[0], "cutout");
}
