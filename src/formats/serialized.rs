//! Mitsuba's `serialized` meshes: compressed arrays, of several shapes in one file, each a group `0`, `1` and so on.
//!
//! A file ends with a directory: where each shape begins, and how many there are. Each begins with a format number and a version, and all that
//! follows is one deflated stream.

use std::io::Read;

use flate2::read::ZlibDecoder;
use glam::DVec3;

use super::polygons::{Fault, Polygons};
use crate::geometry::topology::MAX_FACES;

/// The number that each shape begins with.
const MAGIC: u16 = 0x041c;
const VERSIONS: std::ops::RangeInclusive<u16> = 3..=4;
/// Most shapes of one file.
const MOST_SHAPES: u32 = 1 << 16;

/// Bits of what a shape's stream begins with.
mod flag {
    pub const NORMALS: u32 = 0x1;
    pub const TEXTURE_COORDINATES: u32 = 0x2;
    pub const COLORS: u32 = 0x8;
    pub const FACE_NORMALS: u32 = 0x10;
    pub const DOUBLE: u32 = 0x2000;
}

pub(super) fn read(bytes: &[u8]) -> Result<Polygons, Fault> {
    let damaged = || Fault::new("this is no serialized mesh, or it is cut off");
    if bytes.get(..2) != Some(&MAGIC.to_le_bytes()) {
        return Err(Fault::new("this is no serialized mesh: it does not begin with its number"));
    }
    let version = version_at(bytes, 0).ok_or_else(damaged)?;
    if !VERSIONS.contains(&version) {
        return Err(Fault::new(format!("serialized meshes of version {version} are not read: 3 and 4 are")));
    }
    let (body, count) = bytes.split_last_chunk::<4>().ok_or_else(damaged)?;
    let count = u32::from_le_bytes(*count);
    let width = if version == 3 { 4 } else { 8 };
    let directory = (count > 0 && count <= MOST_SHAPES).then(|| width * count as usize);
    let begin = directory.and_then(|length| body.len().checked_sub(length)).ok_or_else(damaged)?;
    let mut polygons = Polygons::default();
    let mut least = 0;
    for (index, entry) in body[begin..].chunks_exact(width).enumerate() {
        let mut wide = [0; 8];
        wide[..width].copy_from_slice(entry);
        let start = usize::try_from(u64::from_le_bytes(wide)).ok();
        // One behind the other: none is read twice.
        let start = start.filter(|start| (least..begin).contains(start));
        let start = start.filter(|start| version_at(bytes, *start) == Some(version)).ok_or_else(damaged)?;
        least = start + 4;
        shape(&bytes[least..begin.max(least)], version, index, &mut polygons)
            .map_err(|message| Fault::new(format!("shape {index}: {message}")))?;
    }
    Ok(polygons)
}

fn version_at(bytes: &[u8], start: usize) -> Option<u16> {
    let word = |at: usize| bytes.get(at..at + 2).map(|word| u16::from_le_bytes([word[0], word[1]]));
    word(start).filter(|magic| *magic == MAGIC).and_then(|_| word(start + 2))
}

/// Adds a shape, whose stream `deflated` begins with.
fn shape(deflated: &[u8], version: u16, index: usize, polygons: &mut Polygons) -> Result<(), String> {
    let mut stream = Stream(ZlibDecoder::new(deflated));
    let flags = u32::from_le_bytes(stream.bytes()?);
    if version == 4 {
        while stream.bytes::<1>()? != [0] {}
    }
    let [vertices, faces] = [u64::from_le_bytes(stream.bytes()?), u64::from_le_bytes(stream.bytes()?)];
    let is_double = flags & flag::DOUBLE != 0;
    let before = polygons.positions.len();
    let is_too_much = |before: usize, more: u64| more.saturating_add(before as u64) > MAX_FACES as u64;
    if is_too_much(before, vertices) || is_too_much(polygons.faces.len(), faces) {
        return Err(format!(
            "with it the file has more than {MAX_FACES} vertices or faces, which is the most that are read"
        ));
    }
    for _ in 0..vertices {
        let position = stream.vector(is_double)?;
        polygons.push_position(position, None);
    }
    let has_normals = flags & flag::NORMALS != 0;
    let mut normals = Vec::new();
    for _ in 0..if has_normals { vertices } else { 0 } {
        let normal = stream.vector(is_double)?;
        normals.push(if normal.is_finite() { normal } else { DVec3::ZERO });
    }
    // Of shapes without normals of their own none are kept.
    let is_smooth = has_normals && flags & flag::FACE_NORMALS == 0 && polygons.normals.len() == before;
    if is_smooth {
        polygons.normals.append(&mut normals)
    } else {
        polygons.normals.clear()
    }
    let has_uvs = flags & flag::TEXTURE_COORDINATES != 0;
    for vertex in before..before + vertices as usize {
        let uv =
            if has_uvs { Some([stream.number(is_double)? as f32, stream.number(is_double)? as f32]) } else { None };
        polygons.uvs.push_of_position(uv, vertex);
    }
    let colors = if flags & flag::COLORS != 0 { 3 } else { 0 };
    for _ in 0..vertices * colors {
        stream.number(is_double)?;
    }
    polygons.parts.begin(polygons.faces.len(), std::iter::once(index.to_string().as_str()), None);
    for face in 0..faces {
        for _ in 0..3 {
            let corner = u32::from_le_bytes(stream.bytes()?);
            if u64::from(corner) >= vertices {
                return Err(format!("face {face} names vertex {corner}, but there are {vertices} (counted from 0)"));
            }
            polygons.faces.corners.push(before as u32 + corner);
        }
        polygons.faces.close(None);
    }
    Ok(())
}

/// Reads what is deflated.
struct Stream<'a>(ZlibDecoder<&'a [u8]>);

impl Stream<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes).map_err(|_| "its data are cut off or damaged".to_owned())?;
        Ok(bytes)
    }

    fn number(&mut self, is_double: bool) -> Result<f64, String> {
        match is_double {
            true => self.bytes().map(f64::from_le_bytes),
            false => self.bytes().map(|bytes| f64::from(f32::from_le_bytes(bytes))),
        }
    }

    fn vector(&mut self, is_double: bool) -> Result<DVec3, String> {
        Ok(DVec3::new(self.number(is_double)?, self.number(is_double)?, self.number(is_double)?))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;
    use crate::scene::description::MeshPart;

    /// Shapes of one triangle each, at that height, with normals and texture coordinates or without.
    fn file(version: u16, is_double: bool, shapes: &[(f64, bool)]) -> Vec<u8> {
        let (mut bytes, mut starts) = (Vec::new(), Vec::new());
        for &(height, has_normals) in shapes {
            starts.push(bytes.len() as u64);
            bytes.extend(MAGIC.to_le_bytes());
            bytes.extend(version.to_le_bytes());
            let mut data = Vec::new();
            let own = if has_normals { flag::NORMALS | flag::TEXTURE_COORDINATES } else { 0 };
            let flags = own | if is_double { flag::DOUBLE } else { 0x1000 } | flag::COLORS;
            data.extend(flags.to_le_bytes());
            if version == 4 {
                data.extend(b"a name\0");
            }
            data.extend(3_u64.to_le_bytes());
            data.extend(1_u64.to_le_bytes());
            let mut number = |x: f64| match is_double {
                true => data.extend(x.to_le_bytes()),
                false => data.extend((x as f32).to_le_bytes()),
            };
            [0.0, 0.0, height, 1.0, 0.0, height, 0.0, 1.0, height].into_iter().for_each(&mut number);
            if has_normals {
                (0..3).for_each(|_| [0.0, 0.0, 1.0].into_iter().for_each(&mut number));
                [0.0, 0.0, 1.0, 0.0, 0.0, 1.0].into_iter().for_each(&mut number);
            }
            (0..9).for_each(|_| number(0.5));
            [0_u32, 1, 2].iter().for_each(|corner| data.extend(corner.to_le_bytes()));
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(&data).unwrap();
            bytes.extend(encoder.finish().unwrap());
        }
        for start in &starts {
            match version {
                3 => bytes.extend((*start as u32).to_le_bytes()),
                _ => bytes.extend(start.to_le_bytes()),
            }
        }
        bytes.extend((starts.len() as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn shapes_are_groups() {
        for (version, is_double) in [(3, false), (4, false), (4, true)] {
            let read = read(&file(version, is_double, &[(1.0, true), (2.0, true)])).unwrap();
            assert_eq!((read.positions.len(), read.normals.len(), read.faces.len()), (6, 6, 2));
            let (second, _) = read.part(&MeshPart::of_group("1")).unwrap().finish().unwrap();
            assert_eq!((second.positions.len(), second.positions[0].z, second.normals[0]), (3, 2.0, DVec3::Z));
            assert_eq!(second.uvs, [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]);
        }
        let mixed = read(&file(4, false, &[(1.0, true), (2.0, false)])).unwrap();
        assert!(mixed.normals.is_empty());
    }

    /// Whatever is damaged, nothing but an error comes of it.
    #[test]
    fn damaged_files_are_refused() {
        let whole = file(4, false, &[(1.0, true), (2.0, false)]);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
        crate::formats::importing::mutations(&whole, |bytes| _ = read(bytes));
        assert!(read(&file(5, false, &[(1.0, true)])).unwrap_err().message.contains("version 5"));
    }
}
