//! Makes glTF files for tests.

use serde_json::{Value, json};

/// A file that is being made: its JSON, and one buffer.
pub struct Maker {
    pub root: Value,
    pub bytes: Vec<u8>,
}

/// A cube from −1 to 1, its faces counter-clockwise seen from outside.
pub const CUBE: [[f32; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
pub const CUBE_FACES: [u16; 36] =
    [0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5];

impl Maker {
    /// With nothing in it.
    pub fn new() -> Self {
        let root = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": [], "buffers": [],
        });
        Self { root, bytes: Vec::new() }
    }

    /// A cube as mesh 0, of material 0 if `material`, and no nodes.
    pub fn cube(material: Option<Value>) -> Self {
        let mut maker = Self::new();
        let position = maker.floats(&CUBE);
        let indices = maker.shorts(&CUBE_FACES);
        let mut primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        if let Some(material) = material {
            primitive["material"] = json!(0);
            maker.push("materials", material);
        }
        maker.push("meshes", json!({"name": "Cube", "primitives": [primitive]}));
        maker
    }

    /// Adds to a list, and answers where it is there.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.root.get(list).is_none() {
            self.root[list] = json!([]);
        }
        let list = self.root[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// A node of the scene.
    pub fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.root["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    /// A buffer view of new bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn floats(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let accessor = json!({"bufferView": view, "componentType": 5126, "count": vectors.len(), "type": "VEC3"});
        self.push("accessors", accessor)
    }

    pub fn shorts(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let accessor = json!({"bufferView": view, "componentType": 5123, "count": indices.len(), "type": "SCALAR"});
        self.push("accessors", accessor)
    }

    /// As a text file with its buffer in a file of that name.
    pub fn text(&self, uri: &str) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{"uri": uri, "byteLength": self.bytes.len()}]);
        serde_json::to_vec_pretty(&root).unwrap()
    }

    /// As one binary file.
    pub fn binary(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        let mut json = serde_json::to_vec(&root).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + binary.len();
        let word = |x: usize| (x as u32).to_le_bytes();
        let head = [b"glTF".to_owned(), word(2), word(length), word(json.len()), *b"JSON"].concat();
        [head, json, word(binary.len()).to_vec(), b"BIN\0".to_vec(), binary].concat()
    }
}
