//! The outside of a glTF file: JSON and bytes, in one file or in several.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;

use super::schema::{Asset, BufferView, Mesh, Primitive, Root};
use crate::formats::files::{Input, normal};
use crate::formats::polygons::Fault;

/// How a binary file begins.
const MAGIC: &[u8] = b"glTF";
/// The kinds of chunks that are read.
const JSON: u32 = 0x4e4f_534a;
const BINARY: u32 = 0x004e_4942;
/// Extensions by which geometry is stored in ways that are not read.
const COMPRESSIONS: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Most bytes of the JSON, which may hold buffers, and most tables in it: each takes much more room than the two bytes of an empty one.
const MAX_JSON_BYTES: usize = 1 << 30;
const MAX_TABLES: usize = 1 << 22;

/// What files of all versions have alike.
#[derive(Deserialize)]
struct Versioned {
    asset: Asset,
}

fn other_version(version: &str) -> Option<Fault> {
    let is_read = version.split('.').next() == Some("2");
    (!is_read).then(|| Fault::new(format!("is glTF of version `{version}`; version 2.0 is read")))
}

/// The compression without which there are no meshes: one that the file requires, or uses where it has no other form of its vertices.
fn compression(root: &Root) -> Option<&String> {
    let known = |name: &&String| COMPRESSIONS.contains(&name.as_str());
    let has_no_bytes = |primitive: &Primitive| {
        let accessor = primitive.attributes.get("POSITION").and_then(|index| root.accessors.get(*index));
        accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
    };
    let used = || root.extensions_used.iter().find(known);
    root.extensions_required
        .iter()
        .find(known)
        .or_else(|| used().filter(|_| root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(has_no_bytes)))
}

/// A glTF file with the bytes of its buffers.
#[derive(Debug)]
pub struct Container {
    pub root: Root,
    /// The materials of each mesh, each once, in the order in which its primitives have them.
    materials: Vec<Vec<Option<usize>>>,
    /// The primitives of a mesh by their material.
    primitives: HashMap<(usize, Option<usize>), Vec<usize>>,
    /// Or why they cannot be read, which matters where they are used.
    buffers: Vec<Result<Arc<Vec<u8>>, String>>,
    /// What `uri`s of images and buffers name, by paths.
    files: HashMap<PathBuf, Result<Arc<Vec<u8>>, String>>,
}

impl Container {
    pub fn read(input: &Input<'_>) -> Result<Self, Fault> {
        let (json, binary) = split(input.bytes)?;
        if json.len() > MAX_JSON_BYTES {
            return Err(Fault::new(format!("has {} bytes of JSON; at most {MAX_JSON_BYTES} are read", json.len())));
        }
        if json.iter().filter(|byte| **byte == b'{').count() > MAX_TABLES {
            return Err(Fault::new(format!("has more than the {MAX_TABLES} tables that are read at most")));
        }
        let root: Root = serde_json::from_slice(json).map_err(|error| {
            // Files of version 1 have other tables.
            if let Ok(Versioned { asset }) = serde_json::from_slice(json)
                && let Some(fault) = other_version(&asset.version)
            {
                return fault;
            }
            let message = format!("the JSON cannot be read: {}", without_place(&error.to_string()));
            match binary {
                _ if !input.bytes.starts_with(MAGIC) => {
                    Fault { line: Some(error.line()).filter(|line| *line > 0), message }
                }
                _ => Fault::new(format!("{message} (line {} of the JSON)", error.line())),
            }
        })?;
        if let Some(fault) = other_version(&root.asset.version) {
            return Err(fault);
        }
        if let Some(name) = compression(&root) {
            return Err(Fault::new(format!("needs {name}, which is not read: save it without compression")));
        }
        let (materials, primitives, buffers, files) = (Vec::new(), HashMap::new(), Vec::new(), HashMap::new());
        let mut container = Self { root, materials, primitives, buffers, files };
        container.sort_primitives();
        let mut binary = binary.map(|bytes| Arc::new(bytes.to_vec()));
        for (index, buffer) in std::mem::take(&mut container.root.buffers).into_iter().enumerate() {
            let bytes = match &buffer.uri {
                Some(uri) => container.resource(uri, input),
                None if index == 0 => {
                    binary.take().ok_or_else(|| "has no bytes: the file has no binary chunk".to_owned())
                }
                None => Err("has no `uri`".to_owned()),
            };
            container.buffers.push(bytes.and_then(|bytes| match bytes.len() as u64 {
                length if length < buffer.byte_length => {
                    Err(format!("is cut off: it has {length} of its {} bytes", buffer.byte_length))
                }
                _ => Ok(bytes),
            }));
        }
        let images: Vec<String> = container.root.images.iter().filter_map(|image| image.uri.clone()).collect();
        // What cannot be read is said by those who need it.
        images.iter().for_each(|uri| _ = container.resource(uri, input));
        Ok(container)
    }

    fn sort_primitives(&mut self) {
        for (mesh, Mesh { primitives, .. }) in self.root.meshes.iter().enumerate() {
            let mut materials = Vec::new();
            for (number, primitive) in primitives.iter().enumerate() {
                let of_material = self.primitives.entry((mesh, primitive.material)).or_default();
                if of_material.is_empty() {
                    materials.push(primitive.material);
                }
                of_material.push(number);
            }
            self.materials.push(materials);
        }
    }

    /// The materials of a mesh that is there.
    pub fn materials_of(&self, mesh: usize) -> &[Option<usize>] {
        &self.materials[mesh]
    }

    /// The numbers of the primitives that a mesh has of a material.
    pub fn primitives_of(&self, mesh: usize, material: Option<usize>) -> &[usize] {
        self.primitives.get(&(mesh, material)).map_or(&[], |numbers| numbers)
    }

    /// The bytes of a `uri`, which are read once.
    fn resource(&mut self, uri: &str, input: &Input<'_>) -> Result<Arc<Vec<u8>>, String> {
        if uri.starts_with("data:") {
            return embedded(uri).map(Arc::new);
        }
        let path = path_of(uri)?;
        let read = || {
            let file = input.files.locate(&input.path.parent().unwrap_or(Path::new("")).join(&path));
            let bytes = input.files.read(&file).map_err(|why| format!("{} {why}", file.display()))?;
            Ok(Arc::new(bytes.into_owned()))
        };
        self.files.entry(path.clone()).or_insert_with(read).clone()
    }

    /// The files that were read beside it, or could not be.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = self.files.keys().cloned().collect();
        files.sort();
        files
    }

    /// The path of an image that is a file of its own.
    pub fn image_path(&self, index: usize) -> Option<PathBuf> {
        let uri = self.root.images.get(index)?.uri.as_ref().filter(|uri| !uri.starts_with("data:"))?;
        path_of(uri).ok()
    }

    /// The bytes of an image; an error says why there are none.
    pub fn image(&self, index: usize) -> Result<Arc<Vec<u8>>, String> {
        let image = self.root.images.get(index).ok_or_else(|| format!("there is no image {index}"))?;
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) if uri.starts_with("data:") => embedded(uri).map(Arc::new),
            (Some(uri), _) => {
                let path = path_of(uri)?;
                self.files.get(&path).cloned().unwrap_or_else(|| Err("it was not read".to_owned()))
            }
            (None, Some(view)) => self.view(view).map(|(bytes, _)| Arc::new(bytes.to_vec())),
            (None, None) => Err("it has neither `uri` nor `bufferView`".to_owned()),
        }
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: usize) -> Result<(&[u8], &BufferView), String> {
        let views = &self.root.buffer_views;
        let view =
            views.get(index).ok_or_else(|| format!("there is no bufferView {index}: there are {}", views.len()))?;
        let bytes = match self.buffers.get(view.buffer) {
            Some(Ok(bytes)) => bytes,
            Some(Err(why)) => return Err(format!("buffer {} {why}", view.buffer)),
            None => return Err(format!("bufferView {index} names buffer {}, which is not there", view.buffer)),
        };
        let end = view.byte_offset.checked_add(view.byte_length).filter(|end| *end <= bytes.len() as u64);
        let end = end.ok_or_else(|| {
            format!("bufferView {index} ends beyond buffer {}, which has {} bytes", view.buffer, bytes.len())
        })?;
        Ok((&bytes[view.byte_offset as usize..end as usize], view))
    }
}

/// The JSON, and the binary chunk of a file that has one.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let cut_off = || Fault::new("the file is cut off");
    let version = word(4).ok_or_else(cut_off)?;
    if version != 2 {
        return Err(Fault::new(format!("is binary glTF of version {version}; version 2 is read")));
    }
    let length = word(8).ok_or_else(cut_off)? as usize;
    if length > bytes.len() {
        return Err(Fault::new(format!("the file is cut off: it has {} of its {length} bytes", bytes.len())));
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at + 8 <= length {
        let (size, kind) = (word(at).ok_or_else(cut_off)? as usize, word(at + 4).ok_or_else(cut_off)?);
        at += 8;
        if size > length - at {
            return Err(Fault::new(format!("the chunk at byte {} is cut off", at - 8)));
        }
        let chunk = &bytes[at..at + size];
        match kind {
            JSON => _ = json.get_or_insert(chunk),
            BINARY => _ = binary.get_or_insert(chunk),
            // Chunks of other kinds are to be passed over.
            _ => {}
        }
        at += size;
    }
    Ok((json.ok_or_else(|| Fault::new("the file has no JSON chunk"))?, binary))
}

/// The bytes within a `data:` URI.
fn embedded(uri: &str) -> Result<Vec<u8>, String> {
    let (_, data) = uri.split_once(";base64,").ok_or("is embedded in a way that is not read: only base64 is")?;
    STANDARD.decode(data.trim()).map_err(|error| format!("is embedded as base64 that is none: {error}"))
}

/// The path of a relative URI, in which bytes may be written as `%20`.
fn path_of(uri: &str) -> Result<PathBuf, String> {
    if uri.contains("://") {
        return Err("is on the network, from where nothing is read".to_owned());
    }
    let (mut bytes, mut rest) = (Vec::with_capacity(uri.len()), uri.as_bytes());
    while let [first, after @ ..] = rest {
        let code = after.get(..2).and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok());
        match code {
            Some(code) if *first == b'%' => {
                bytes.push(code);
                rest = &after[2..];
            }
            _ => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    let path = String::from_utf8(bytes).map_err(|_| "has a `uri` that is not UTF-8".to_owned())?;
    if path.is_empty() || path.contains('\0') {
        Err("has a `uri` that names no file".to_owned())
    } else {
        Ok(normal(Path::new(&path)))
    }
}

/// `serde_json` ends its messages with line and column, which are told apart.
fn without_place(message: &str) -> &str {
    message.rfind(" at line ").map_or(message, |end| &message[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_from_uris() {
        assert_eq!(path_of("a%20b/./c%2Ebin"), Ok(PathBuf::from("a b/c.bin")));
        assert_eq!(path_of("100%"), Ok(PathBuf::from("100%")));
        assert_eq!(path_of("ü%zz.bin"), Ok(PathBuf::from("ü%zz.bin")));
        assert!(path_of("http://example.org/a.bin").is_err());
        assert!(path_of("%ff").is_err() && path_of("").is_err() && path_of("a%00").is_err());
    }

    #[test]
    fn embedded_bytes() {
        assert_eq!(embedded("data:application/octet-stream;base64,AAEC"), Ok(vec![0, 1, 2]));
        assert!(embedded("data:,abc").is_err() && embedded("data:x;base64,?").is_err());
    }
}
