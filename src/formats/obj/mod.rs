//! Wavefront OBJ: positions, normals, texture coordinates and faces, and the names of their groups, objects and materials. Lines and points
//! are passed over.

pub(super) mod mtl;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::str::SplitAsciiWhitespace;

use glam::DVec3;

use super::lines::{Lines, number, shown};
use super::passed_over::Kind;
use super::polygons::{Fault, Polygons, Uvs};

/// Statements that end in a name, which may end in a backslash.
const NAMES: [&str; 9] = ["g", "o", "s", "usemtl", "mtllib", "usemap", "maplib", "shadow_obj", "trace_obj"];

/// Other statements that say nothing about the surface. Those of free-form curves and surfaces need a `surf` to make one.
const PASSED_OVER: [&str; 28] = [
    "vp", "mg", "l", "p", "bevel", "lod", "c_interp", "d_interp", "cstype", "deg", "bmat", "step", "curv", "curv2",
    "parm", "trim", "hole", "scrv", "sp", "end", "con", "ctech", "stech", "scmp", "csh", "res", "cdc", "usemat",
];

/// Statements by which there is more surface than the faces.
const FREE_FORM: [&str; 4] = ["surf", "bsp", "bzp", "cdp"];

/// Marks of a corner that names no normal, and of one whose normal is not there.
const NO_NORMAL: u32 = u32::MAX;
const LOST_NORMAL: u32 = u32::MAX - 1;
/// Mark of a corner that names no texture coordinates.
const NO_UV: u32 = u32::MAX;

pub(super) fn read(bytes: &[u8]) -> Result<Polygons, Fault> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(bytes);
    let mut joined = Vec::new();
    while let Some(line) = lines.next() {
        let number = lines.number;
        let mut statement = without_comment(line);
        if is_continued(statement) {
            join(statement, &mut lines, &mut joined);
            statement = &joined;
        }
        // Names of groups and materials may be in any encoding.
        let text = String::from_utf8_lossy(statement);
        reader.statement(&text, number).map_err(|message| Fault::at(number, message))?;
    }
    let padding = lines.padding;
    reader.polygons.passed_over.add_many(Kind::NulBytes, padding.bytes, Some(padding.first_line));
    reader.finish()
}

fn without_comment(line: &[u8]) -> &[u8] {
    // `1.#INF` and its like are how some programs write what is no number.
    let is_start = |&at: &usize| line[at] == b'#' && !line[..at].ends_with(b".");
    match (0..line.len()).find(is_start) {
        Some(start) => line[..start].trim_ascii_end(),
        None => line,
    }
}

/// Whether the statement goes on in the next line. A backslash right after a name is taken for part of it, as in `mtllib C:\parts\`:
/// to join lines there would swallow one.
fn is_continued(statement: &[u8]) -> bool {
    let [before @ .., b'\\'] = statement else { return false };
    let is_apart = before.last().is_none_or(u8::is_ascii_whitespace);
    let word = before.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    is_apart || !NAMES.iter().any(|name| name.as_bytes() == word)
}

/// Puts a statement that is continued into one line.
fn join(first: &[u8], lines: &mut Lines<'_>, joined: &mut Vec<u8>) {
    joined.clear();
    let mut part = first;
    while let Some(start) = part.strip_suffix(b"\\") {
        joined.extend(start);
        joined.push(b' ');
        part = without_comment(lines.next().unwrap_or_default());
    }
    joined.extend(part);
}

#[derive(Default)]
struct Reader {
    /// Their faces name positions, which may come after them.
    polygons: Polygons,
    /// Of length 1, or 0 where they have no direction.
    normals: Vec<DVec3>,
    /// The normal of each corner of the faces.
    corner_normals: Vec<u32>,
    names_normals: bool,
    uvs: Vec<[f32; 2]>,
    /// The texture coordinates of corners of the faces, up to the last that names some.
    corner_uvs: Vec<u32>,
    /// What the next faces belong to.
    object: Option<String>,
    groups: Vec<String>,
    material: Option<String>,
}

impl Reader {
    fn statement(&mut self, text: &str, line: usize) -> Result<(), String> {
        let mut words = text.split_ascii_whitespace();
        let Some(word) = words.next() else { return Ok(()) };
        match word {
            "v" => {
                let position = vector(&mut words, "a vertex")?;
                self.polygons.push_position(position, Some(line));
                if let (Some(weight), None) = (words.next(), words.next())
                    && number(weight)? != 1.0
                {
                    self.polygons.passed_over.add(Kind::VertexWeights, Some(line));
                }
            }
            "vn" => {
                let normal = vector(&mut words, "a normal")?;
                self.normals.push(if normal.is_finite() { normal.normalize_or_zero() } else { DVec3::ZERO });
            }
            // What is no number is 0: few ask for them.
            "vt" => {
                let mut coordinate = || words.next().and_then(|word| number(word).ok()).unwrap_or_default() as f32;
                self.uvs.push([coordinate(), coordinate()]);
            }
            // `fo` is how the first versions of the format wrote it.
            "f" | "fo" => self.face(words, line)?,
            "g" => {
                let name = rest_of(text, word);
                self.groups = words.map(str::to_owned).collect();
                // Several groups; some programs mean one, whose name has spaces.
                self.groups.extend((self.groups.len() > 1).then(|| name.to_owned()));
                self.begin_part();
            }
            "o" => {
                self.object = Some(rest_of(text, word).to_owned()).filter(|name| !name.is_empty());
                self.begin_part();
            }
            "usemtl" => {
                self.material = Some(rest_of(text, word).to_owned()).filter(|name| !name.is_empty());
                self.begin_part();
            }
            "mtllib" => self.polygons.libraries.push(rest_of(text, word).to_owned()),
            word if NAMES.contains(&word) || PASSED_OVER.contains(&word) => {}
            word if FREE_FORM.contains(&word) => {
                return Err(format!("`{word}` is a free-form surface, which is not read: convert it to faces"));
            }
            "call" => return Err("`call` names another file, which is not read: put what it holds here".into()),
            word => self.polygons.passed_over.add_named(Kind::UnknownStatement, word, line),
        }
        Ok(())
    }

    fn begin_part(&mut self) {
        let Polygons { parts, faces, .. } = &mut self.polygons;
        let groups = self.groups.iter().chain(&self.object).map(String::as_str);
        parts.begin(faces.len(), groups, self.material.as_deref());
    }

    fn face(&mut self, words: SplitAsciiWhitespace<'_>, line: usize) -> Result<(), String> {
        let faces = &mut self.polygons.faces;
        let (start, count) = (faces.corners.len(), self.polygons.positions.len());
        for word in words {
            let mut parts = word.split('/');
            let position = index(parts.next().unwrap_or_default())?;
            let out_of_range = || format!("index {position} is out of range: there are {count} vertices so far");
            faces.corners.push(zero_based(position, count).ok_or_else(out_of_range)?);
            if let Some(uv) = parts.next().and_then(|text| zero_based(index(text).ok()?, self.uvs.len())) {
                self.corner_uvs.resize(faces.corners.len() - 1, NO_UV);
                self.corner_uvs.push(uv);
            }
            self.corner_normals.push(match parts.next() {
                None | Some("") => NO_NORMAL,
                Some(text) => {
                    self.names_normals = true;
                    zero_based(index(text)?, self.normals.len()).unwrap_or(LOST_NORMAL)
                }
            });
        }
        if faces.open_corners() < 3 {
            faces.discard();
            self.corner_normals.truncate(start);
            self.corner_uvs.truncate(start);
            self.polygons.passed_over.add(Kind::ShortFaces, Some(line));
            return Ok(());
        }
        faces.close_polygon(Some(line))
    }

    /// One vertex for each pair of a position and a normal, if every corner has a normal; else one for each position.
    fn finish(mut self) -> Result<Polygons, Fault> {
        let count = self.polygons.positions.len();
        if let Some((_, vertex, line)) = self.polygons.faces.out_of_range(count) {
            let index = u64::from(vertex) + 1;
            return Err(Fault { line, message: format!("index {index} is out of range: there are {count} vertices") });
        }
        if !self.corner_uvs.is_empty() {
            self.corner_uvs.resize(self.polygons.faces.corners.len(), NO_UV);
            let uv = |index: &u32| self.uvs.get(*index as usize).copied().unwrap_or([f32::NAN; 2]);
            self.polygons.uvs = Uvs::OfCorners(self.corner_uvs.iter().map(uv).collect());
        }
        if !self.has_all_normals() {
            return Ok(self.polygons);
        }
        self.polygons.drop_unusable()?;
        let positions = std::mem::take(&mut self.polygons.positions);
        let mut made: HashMap<(u32, u32), u32> = HashMap::with_capacity(positions.len());
        for (corner, normal) in self.polygons.faces.corners.iter_mut().zip(self.corner_normals) {
            let next = self.polygons.positions.len();
            *corner = match made.entry((*corner, normal)) {
                Entry::Occupied(found) => *found.get(),
                Entry::Vacant(free) => {
                    self.polygons.positions.push(positions[*corner as usize]);
                    self.polygons.normals.push(self.normals[normal as usize]);
                    let index = u32::try_from(next).map_err(|_| Fault::new("the mesh has too many vertices"))?;
                    *free.insert(index)
                }
            }
        }
        Ok(self.polygons)
    }

    /// Whether every corner has a normal; notes those that lack one.
    fn has_all_normals(&mut self) -> bool {
        if !self.names_normals {
            return self.corner_normals.is_empty();
        }
        let (mut missing, mut unusable, mut without) = ((0, None), (0, None), (0, None));
        let mut normals = self.corner_normals.iter();
        for face in self.polygons.faces.iter() {
            for &normal in normals.by_ref().take(face.corners.len()) {
                let tally = match self.normals.get(normal as usize) {
                    Some(&DVec3::ZERO) => &mut unusable,
                    Some(_) => continue,
                    None if normal == NO_NORMAL => &mut without,
                    None => &mut missing,
                };
                tally.0 += 1;
                tally.1 = tally.1.or(face.line);
            }
        }
        let passed_over = &mut self.polygons.passed_over;
        passed_over.add_many(Kind::MissingNormals, missing.0, missing.1);
        passed_over.add_many(Kind::UnusableNormals, unusable.0, unusable.1);
        if missing.0 + unusable.0 == 0 && without.0 < self.corner_normals.len() as u64 {
            passed_over.add_many(Kind::PartialNormals, without.0, without.1);
        }
        missing.0 + unusable.0 + without.0 == 0
    }
}

/// What follows a statement's first word.
fn rest_of<'t>(text: &'t str, word: &str) -> &'t str {
    text.trim_ascii_start()[word.len()..].trim_ascii()
}

/// Three numbers. What may follow is a weight, or a colour.
fn vector(words: &mut SplitAsciiWhitespace<'_>, what: &str) -> Result<DVec3, String> {
    let mut v = DVec3::ZERO;
    for axis in 0..3 {
        let word = words.next().ok_or_else(|| format!("{what} has {axis} coordinates, must have 3"))?;
        v[axis] = number(word)?;
    }
    Ok(v)
}

fn index(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| format!("{} is not an index", shown(text.as_bytes())))
}

/// OBJ counts from 1, and from the latest of the `count` so far backwards with −1. `None`: before the first.
fn zero_based(number: i64, count: usize) -> Option<u32> {
    let index = if number < 0 { number.checked_add(count as i64)? } else { number - 1 };
    // The highest are marks.
    u32::try_from(index).ok().filter(|&index| index < LOST_NORMAL)
}

#[cfg(test)]
mod tests;
