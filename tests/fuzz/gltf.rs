//! Small glTF files in the ways in which programs write them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// A glass with wine in it, a mirrored twin of it, a table, a lamp and a camera; numbers apart and with indices of 16 bits.
pub fn table() -> (Value, Vec<u8>) {
    let (mut bytes, mut accessors, mut views) = (Vec::new(), Vec::new(), Vec::new());
    let cube: Vec<[f32; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
    let faces: [u16; 36] =
        [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5];
    let mut add = |data: Vec<u8>, component: u32, count: usize, kind: &str| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        accessors
            .push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
        bytes.extend(data);
    };
    let floats: Vec<u8> = cube.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    add(floats.clone(), 5126, 8, "VEC3");
    add(faces.iter().flat_map(|x| x.to_le_bytes()).collect(), 5123, 36, "SCALAR");
    add(floats, 5126, 8, "VEC3");
    add((0..32).map(|i| 8 * i).collect(), 5121, 8, "VEC4");
    add((0..16).flat_map(|i| (0.1_f32 * i as f32).to_le_bytes()).collect(), 5126, 8, "VEC2");
    let primitive =
        |material: usize| json!({"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 1, "material": material});
    let root = json!({
        "asset": {"version": "2.0", "generator": "Khronos glTF Blender I/O v4.2.70"},
        "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior", "KHR_lights_punctual"],
        "scene": 0,
        "scenes": [{"name": "Scene", "nodes": [0, 3, 4, 5]}],
        "nodes": [
            {"name": "Glass", "mesh": 0, "children": [1, 2], "rotation": [0, 0.6, 0, 0.8]},
            {"name": "Wine", "mesh": 1, "scale": [0.9, 0.9, 0.9]},
            {"name": "Twin", "mesh": 0, "scale": [-1, 1, 1], "translation": [0, 0, 5]},
            {"name": "Table", "mesh": 2, "matrix": [9, 0, 0, 0, 0.5, 0.1, 0, 0, 0, 0, 9, 0, 0, -2, 0, 1]},
            {"name": "Camera", "camera": 0, "translation": [0, 1, 9]},
            {"name": "Lamp", "translation": [0, 5, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 500, "color": [1, 0.9, 0.8], "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.5}},
        ]}},
        "meshes": [
            {"name": "Glass", "primitives": [primitive(0)]},
            {"name": "Wine", "primitives": [primitive(1)]},
            {"name": "Table", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 2, "COLOR_0": 3, "TEXCOORD_0": 4},
                "indices": 1, "material": 2}]},
        ],
        "materials": [
            {"name": "Glass", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 0.1},
                "KHR_materials_ior": {"ior": 1.46}}},
            {"name": "Wine", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_dispersion": {"dispersion": 0.2},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.01, 0.02]}}},
            {"name": "Wood", "pbrMetallicRoughness": {"baseColorFactor": [0.4, 0.2, 0.1, 1], "metallicFactor": 0}},
        ],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": bytes.len()}],
    });
    (root, bytes)
}

/// In one binary file.
pub fn binary() -> Vec<u8> {
    let (root, bytes) = table();
    wrapped(serde_json::to_vec(&root).unwrap(), bytes)
}

fn wrapped(mut json: Vec<u8>, mut bytes: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let word = |x: usize| (x as u32).to_le_bytes().to_vec();
    let length = word(28 + json.len() + bytes.len());
    let json_head = [word(json.len()), b"JSON".to_vec()].concat();
    let head = [b"glTF".to_vec(), word(2), length, json_head].concat();
    [head, json, word(bytes.len()), b"BIN\0".to_vec(), bytes].concat()
}

/// As text, with everything in it: an image too.
pub fn embedded(png: &[u8]) -> Vec<u8> {
    let (mut root, bytes) = table();
    let uri = |kind: &str, bytes: &[u8]| format!("data:{kind};base64,{}", STANDARD.encode(bytes));
    root["buffers"][0]["uri"] = json!(uri("application/octet-stream", &bytes));
    root["images"] = json!([{"uri": uri("image/png", png)}]);
    root["textures"] = json!([{"source": 0}]);
    root["materials"][2]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0, "extensions": {
        "KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.5, "scale": [2, -1]}}});
    root["samplers"] = json!([{"wrapS": 33071, "wrapT": 10497}]);
    root["textures"][0]["sampler"] = json!(0);
    serde_json::to_vec_pretty(&root).unwrap()
}

/// Positions among other numbers, others sparse and in bytes, a strip and a fan, and no scene.
pub fn packed() -> Vec<u8> {
    let square = [[0_i8, 0, 0, 0], [127, 0, 0, 0], [0, 127, 0, 0], [127, 127, 0, 0]];
    let mut bytes: Vec<u8> = square.iter().flatten().map(|x| *x as u8).collect();
    bytes.extend([0, 1, 2, 3, 3, 0, 0, 1]);
    for corner in [[0.0_f32, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]] {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 8]);
    }
    let root = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [2, 0, 0]}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}, {"attributes": {"POSITION": 2}}]},
            {"primitives": [{"attributes": {"POSITION": 3}, "mode": 6}, {"attributes": {"POSITION": 2}, "mode": 1}]},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 8, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
                "count": 3, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 3}}},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 16, "byteStride": 4},
            {"buffer": 0, "byteOffset": 16, "byteLength": 8},
            {"buffer": 0, "byteOffset": 24, "byteLength": 52, "byteStride": 20},
            {"buffer": 0, "byteOffset": 24, "byteLength": 60},
        ],
        "buffers": [{"byteLength": bytes.len()}],
    });
    wrapped(serde_json::to_vec(&root).unwrap(), bytes)
}

/// Where the numbers of a file are, as JSON pointers.
pub fn numbers(value: &Value) -> Vec<String> {
    let below = |key: &str, value: &Value| numbers(value).into_iter().map(|rest| format!("/{key}{rest}")).collect();
    let all: Vec<Vec<String>> = match value {
        Value::Number(_) => return vec![String::new()],
        Value::Array(list) => list.iter().enumerate().map(|(i, value)| below(&i.to_string(), value)).collect(),
        Value::Object(table) => table.iter().map(|(key, value)| below(key, value)).collect(),
        _ => Vec::new(),
    };
    all.concat()
}

/// The same file with another number in one place.
pub fn with_number(pointer: &str, number: &Value) -> Vec<u8> {
    let (mut root, bytes) = table();
    *root.pointer_mut(pointer).expect("there is one") = number.clone();
    wrapped(serde_json::to_vec(&root).unwrap(), bytes)
}
