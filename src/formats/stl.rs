//! STL, the format of 3D printers: facets of three corners, in binary or as text. The facets' normals are passed over, as their corners say the
//! same; corners at one place are one vertex.

use std::collections::HashMap;

use glam::DVec3;

use super::lines::{Lines, number, shown};
use super::passed_over::Kind;
use super::polygons::{Fault, Polygons};
use crate::geometry::topology::MAX_FACES;

/// Bytes before the facets of a binary file: a header without meaning and their number.
const HEADER: usize = 84;
/// Bytes of a facet: a normal, three corners, two bytes without meaning.
const FACET: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Polygons, Fault> {
    let count = bytes.get(HEADER - 4..HEADER).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let promised = count.map(|count| HEADER as u64 + u64::from(count) * FACET as u64);
    let is_exact = promised == Some(bytes.len() as u64);
    // Headers of binary files may begin with `solid` too.
    if !is_exact && bytes.trim_ascii_start().starts_with(b"solid") {
        return read_text(bytes);
    }
    let (Some(count), Some(promised)) = (count, promised) else {
        return Err(Fault::new(
            "this is no STL file: it neither begins with `solid` nor is long enough for a binary one",
        ));
    };
    if promised > bytes.len() as u64 {
        let message = format!("the file is cut off: it promises {count} facets, which is more than fit into it");
        return Err(Fault::new(message));
    }
    if count as usize > MAX_FACES {
        return Err(Fault::new(format!("the file has {count} facets, at most {MAX_FACES} are read")));
    }
    let mut facets = Facets::default();
    let body = &bytes[HEADER..promised as usize];
    for facet in body.chunks_exact(FACET) {
        for corner in facet[12..48].chunks_exact(12) {
            let coordinate = |axis: usize| {
                let at = 4 * axis;
                f32::from_le_bytes([corner[at], corner[at + 1], corner[at + 2], corner[at + 3]])
            };
            facets.push(DVec3::from([0, 1, 2].map(|axis| f64::from(coordinate(axis)))), None);
        }
        facets.polygons.faces.close(None);
    }
    let rest = bytes.len() as u64 - promised;
    facets.polygons.passed_over.add_many(Kind::TrailingBytes, rest, None);
    Ok(facets.polygons)
}

/// Several solids in one file are one surface, each a group of it.
fn read_text(bytes: &[u8]) -> Result<Polygons, Fault> {
    let mut facets = Facets::default();
    let mut lines = Lines::new(bytes);
    let mut in_facet = None;
    while let Some(line) = lines.next() {
        let at = lines.number;
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace();
        let Some(first) = words.next() else { continue };
        match first.to_ascii_lowercase().as_str() {
            "vertex" => {
                let mut coordinate =
                    || -> Result<f64, String> { number(words.next().ok_or("a vertex has three coordinates")?) };
                let position = (|| Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?)))();
                if in_facet.is_none() {
                    return Err(Fault::at(at, "a vertex outside of any facet"));
                }
                facets.push(position.map_err(|message: String| Fault::at(at, message))?, Some(at));
            }
            "facet" => {
                if in_facet.replace(at).is_some() {
                    return Err(Fault::at(at, "a facet in a facet: `endfacet` is missing"));
                }
            }
            "endfacet" => {
                let Some(begun) = in_facet.take() else {
                    return Err(Fault::at(at, "`endfacet` ends no facet"));
                };
                let corners = facets.polygons.faces.open_corners();
                if corners != 3 {
                    return Err(Fault::at(begun, format!("this facet has {corners} corners, must have 3")));
                }
                facets.polygons.faces.close(Some(begun));
            }
            "solid" => {
                let name = text[first.len()..].trim();
                let Polygons { parts, faces, .. } = &mut facets.polygons;
                parts.begin(faces.len(), Some(name).filter(|name| !name.is_empty()).into_iter(), None);
            }
            "endsolid" | "outer" | "endloop" => {}
            _ => {
                let message = format!("{} is no statement of an STL file", shown(first.as_bytes()));
                return Err(Fault::at(at, message));
            }
        }
    }
    if let Some(begun) = in_facet {
        return Err(Fault::at(begun, "the file is cut off: this facet is not ended"));
    }
    facets.polygons.passed_over.add_many(Kind::NulBytes, lines.padding.bytes, Some(lines.padding.first_line));
    Ok(facets.polygons)
}

#[derive(Default)]
struct Facets {
    polygons: Polygons,
    /// Vertices by the bits of their coordinates.
    known: HashMap<[u64; 3], u32>,
}

impl Facets {
    fn push(&mut self, position: DVec3, line: Option<usize>) {
        // −0 and 0 are one place.
        let place = (position + 0.0).to_array().map(f64::to_bits);
        let polygons = &mut self.polygons;
        let vertex = *self.known.entry(place).or_insert_with(|| {
            polygons.push_position(position, line);
            polygons.positions.len() as u32 - 1
        });
        polygons.faces.corners.push(vertex);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Mesh;

    const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn binary(header: &str) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, b' ');
        bytes.extend((FACES.len() as u32).to_le_bytes());
        for face in FACES {
            bytes.extend([0; 12]);
            face.iter().flat_map(|&corner| CORNERS[corner]).for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    fn text() -> String {
        let facet = |face: [usize; 3]| {
            let vertex = |&corner: &usize| {
                let [x, y, z] = CORNERS[corner];
                format!("   vertex {x:e} {y} -{z}\n")
            };
            let vertices: String = face.iter().map(vertex).collect();
            format!(" facet normal 0 0 0\n  outer loop\n{vertices}  endloop\n endfacet\n")
        };
        format!("solid thing of parts\n{}endsolid thing\n", FACES.map(facet).concat())
    }

    fn mesh(bytes: &[u8]) -> Mesh {
        read(bytes).unwrap().finish().unwrap().0
    }

    #[test]
    fn both_kinds_have_the_same_faces() {
        for header in ["made by hand", "solid but binary"] {
            let mesh = mesh(&binary(header));
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 4));
            assert_eq!(mesh.triangles[0], [0, 1, 2]);
        }
        let as_text = mesh(text().as_bytes());
        assert_eq!(as_text.triangles, mesh(&binary("")).triangles);
        // `-0` is where `0` is.
        assert_eq!(as_text.positions.len(), 4);
    }

    #[test]
    fn what_follows_is_passed_over_and_told() {
        let mut bytes = binary("x");
        bytes.extend(*b"extra");
        let (mesh, notes) = read(&bytes).unwrap().finish().unwrap();
        assert_eq!((mesh.triangles.len(), notes.len(), notes[0].count), (4, 1, 5));
    }

    #[test]
    fn damage_is_told_with_its_place() {
        let fault = |bytes: &[u8]| read(bytes).and_then(|polygons| polygons.finish().map(|_| ())).unwrap_err();
        assert!(fault(b"").message.contains("no STL file"));
        assert!(fault(&binary("x")[..200]).message.contains("promises 4 facets"));
        let text = text();
        let changed = |from: &str, to: &str| fault(text.replacen(from, to, 1).as_bytes());
        assert_eq!(changed("vertex 0e0 0 -0\n", "vertex 0 0\n"), Fault::at(4, "a vertex has three coordinates"));
        assert_eq!(changed("vertex 0e0 0 -0\n", "vertex 0 b 0\n"), Fault::at(4, "`b` is not a number"));
        assert_eq!(changed("vertex 0e0 0 -0\n", "\n"), Fault::at(2, "this facet has 2 corners, must have 3"));
        assert!(changed("endfacet", "end").message.contains("no statement"));
        assert_eq!(changed(" endfacet\n", "\n").line, Some(9));
        let cut = fault(&text.as_bytes()[..text.find("endloop").unwrap()]);
        assert_eq!((cut.line, cut.message.contains("cut off")), (Some(2), true));
        assert!(changed("vertex 0e0 0 -0\n", "vertex nan 0 0\n").message.contains("finite"));
    }
}
