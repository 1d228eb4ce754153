//! Wavefront OBJ: positions, normals and faces. Materials, texture coordinates, groups and lines are passed over.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::str::SplitAsciiWhitespace;

use glam::DVec3;

use super::mesh::{Builder, Fault};
use super::polygon::{MAX_CORNERS, too_many_corners};

/// Statements that say nothing about the surface.
const PASSED_OVER: [&str; 15] =
    ["vt", "vp", "g", "o", "s", "mg", "l", "p", "usemtl", "mtllib", "usemap", "maplib", "bevel", "lod", "shadow_obj"];

pub(super) fn read(bytes: &[u8]) -> Result<Builder, Fault> {
    let mut reader = Reader::default();
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        reader.line(line).map_err(|message| Fault::at(number + 1, message))?;
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Faces one after the other, with the end of each; a corner is a position and perhaps a normal.
    corners: Vec<(u32, Option<u32>)>,
    ends: Vec<usize>,
}

impl Reader {
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let line = line.split(|&byte| byte == b'#').next().unwrap_or_default().trim_ascii();
        if line.is_empty() {
            return Ok(());
        }
        let Ok(line) = std::str::from_utf8(line) else {
            // Names of groups and materials may be in any encoding.
            return match line.first() {
                Some(b'g' | b'o' | b'u' | b'm') => Ok(()),
                _ => Err("is not text".into()),
            };
        };
        let mut words = line.split_ascii_whitespace();
        match words.next().unwrap_or_default() {
            "v" => self.positions.push(vector(&mut words, "a vertex")?),
            "vn" => self.normals.push(vector(&mut words, "a normal")?),
            "f" => self.face(words)?,
            word if PASSED_OVER.contains(&word) => {}
            word => return Err(format!("`{word}` is no OBJ statement that is read (v, vn, f)")),
        }
        Ok(())
    }

    fn face(&mut self, words: SplitAsciiWhitespace<'_>) -> Result<(), String> {
        let start = self.corners.len();
        for word in words {
            let mut parts = word.split('/');
            let position = index(parts.next().unwrap_or_default(), self.positions.len(), "vertices")?;
            let normal = match parts.nth(1) {
                None | Some("") => None,
                Some(text) => Some(index(text, self.normals.len(), "normals")?),
            };
            self.corners.push((position, normal));
        }
        match self.corners.len() - start {
            0..=2 => Err(format!("a face has {} corners, must have 3 or more", self.corners.len() - start)),
            corners if corners > MAX_CORNERS => Err(too_many_corners(corners)),
            _ => {
                self.ends.push(self.corners.len());
                Ok(())
            }
        }
    }

    /// One vertex for each pair of a position and a normal, if every corner has a normal; else one for each position.
    fn finish(self) -> Result<Builder, Fault> {
        let has_normals = self.corners.iter().all(|(_, normal)| normal.is_some());
        let mut builder = Builder::default();
        let mut indices = Vec::with_capacity(self.corners.len());
        if has_normals {
            let mut made: HashMap<(u32, u32), u32> = HashMap::with_capacity(self.positions.len());
            for (position, normal) in self.corners {
                let normal = normal.unwrap_or_default();
                let next = builder.positions.len();
                indices.push(match made.entry((position, normal)) {
                    Entry::Occupied(found) => *found.get(),
                    Entry::Vacant(free) => {
                        builder.positions.push(self.positions[position as usize]);
                        builder.normals.push(self.normals[normal as usize]);
                        let index = u32::try_from(next).map_err(|_| Fault::new("the mesh has too many vertices"))?;
                        *free.insert(index)
                    }
                });
            }
        } else {
            builder.positions = self.positions;
            indices.extend(self.corners.iter().map(|(position, _)| *position));
        }
        let mut start = 0;
        for end in self.ends {
            builder.push_face(&indices[start..end]);
            start = end;
        }
        Ok(builder)
    }
}

/// Three finite numbers; what may follow, a weight or a colour, is passed over.
fn vector(words: &mut SplitAsciiWhitespace<'_>, what: &str) -> Result<DVec3, String> {
    let mut v = DVec3::ZERO;
    for axis in 0..3 {
        let word = words.next().ok_or_else(|| format!("{what} has {axis} coordinates, must have 3"))?;
        let number: f64 = word.parse().map_err(|_| format!("`{word}` is not a number"))?;
        if !number.is_finite() {
            return Err(format!("a coordinate of {what} is {number}, must be finite"));
        }
        v[axis] = number;
    }
    Ok(v)
}

/// OBJ counts from 1, and from the latest backwards with −1.
fn index(text: &str, count: usize, what: &str) -> Result<u32, String> {
    let number: i64 = text.parse().map_err(|_| format!("`{text}` is not an index"))?;
    let zero_based = if number < 0 { number + count as i64 } else { number - 1 };
    match u32::try_from(zero_based) {
        Ok(index) if (index as usize) < count => Ok(index),
        _ => Err(format!("index {number} is out of range: there are {count} {what} so far")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::{Format, read};
    use super::*;

    fn fault(text: &str) -> (Option<usize>, String) {
        let fault = read(text.as_bytes(), Format::Obj).unwrap_err();
        (fault.line, fault.message)
    }

    #[test]
    fn faces_in_every_notation() {
        let text = "# a square and a triangle\r\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1e0 0\n\
                    vt 0 0\nf 1/1 2/1 3/1 4/1 # quad\nv 5 5 5\nf -1 1 -4\n";
        let (mesh, dropped) = read(text.as_bytes(), Format::Obj).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), dropped), (5, 3, 0));
        assert_eq!(mesh.triangles[2], [4, 0, 1]);
        assert!(mesh.normals.is_empty());
    }

    #[test]
    fn normals_split_vertices_at_bit_equal_positions() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0.1\nvn 0 0 2\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n";
        let (mesh, _) = read(text.as_bytes(), Format::Obj).unwrap();
        assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6));
        assert_eq!(mesh.positions[mesh.triangles[0][0] as usize], mesh.positions[mesh.triangles[1][0] as usize]);
        assert_eq!(mesh.normals[0], DVec3::Z);
    }

    #[test]
    fn faults_name_their_line() {
        assert_eq!(fault("v 0 0 0\nv 1 nan 0\n"), (Some(2), "a coordinate of a vertex is NaN, must be finite".into()));
        assert_eq!(fault("v 0 0\n"), (Some(1), "a vertex has 2 coordinates, must have 3".into()));
        assert_eq!(fault("v 0 0 x\n").1, "`x` is not a number");
        assert_eq!(
            fault("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n"),
            (Some(5), "index 4 is out of range: there are 3 vertices so far".into())
        );
        assert_eq!(fault("v 0 0 0\nf 0 1 1\n").0, Some(2));
        assert_eq!(fault("v 0 0 0\nf 1 1\n").1, "a face has 2 corners, must have 3 or more");
        assert_eq!(fault("v 0 0 0\nf 1 1 9223372036854775808\n").1, "`9223372036854775808` is not an index");
        assert_eq!(fault("<html>\n").0, Some(1));
        assert_eq!(fault(""), (None, "the mesh has no faces".into()));
    }
}
