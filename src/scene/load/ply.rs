//! PLY, the Stanford polygon format: ASCII and binary of either byte order. Read are the elements `vertex` (x, y, z and, if present,
//! nx, ny, nz) and `face` (`vertex_indices` or `vertex_index`); everything else is passed over.

use glam::DVec3;

use super::mesh::{Builder, Fault};
use super::polygon::{MAX_CORNERS, too_many_corners};

pub(super) fn read(bytes: &[u8]) -> Result<Builder, Fault> {
    let (header, body) = Header::read(bytes)?;
    let mut builder = Builder::default();
    match header.encoding {
        Encoding::Ascii => read_elements(&header, AsciiRows::new(body, header.lines), &mut builder)?,
        Encoding::Little => read_elements(&header, BinaryRows::<false> { rest: body }, &mut builder)?,
        Encoding::Big => read_elements(&header, BinaryRows::<true> { rest: body }, &mut builder)?,
    }
    Ok(builder)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

#[derive(Debug)]
struct Property {
    name: String,
    kind: Scalar,
    /// The type of a list's length.
    length: Option<Scalar>,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

#[derive(Debug)]
struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// How many lines it has.
    lines: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), Fault> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut rest = bytes;
        for number in 1.. {
            let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
                return Err(Fault::at(number, "the header is cut off: there is no `end_header`"));
            };
            let line = String::from_utf8_lossy(rest[..end].trim_ascii()).into_owned();
            rest = &rest[end + 1..];
            let bad = |message: String| Err(Fault::at(number, message));
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            if number == 1 {
                if words != ["ply"] {
                    return bad("is no PLY file: it does not begin with `ply`".into());
                }
                continue;
            }
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, "1.0"] => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return bad(format!("the format `{name}` is unknown")),
                    });
                }
                ["element", name, count] => {
                    let Ok(count) = count.parse() else { return bad(format!("`{count}` is not a count")) };
                    elements.push(Element { name: name.into(), count, properties: Vec::new() });
                }
                ["property", .., name] if words.len() == 3 || (words.len() == 5 && words[1] == "list") => {
                    let types: Option<Vec<Scalar>> = words[if words.len() == 5 { 2 } else { 1 }..words.len() - 1]
                        .iter()
                        .map(|w| Scalar::named(w))
                        .collect();
                    let (Some(types), Some(element)) = (types, elements.last_mut()) else {
                        return bad(format!("`{line}` has an unknown type or stands before any element"));
                    };
                    let (length, kind) = if types.len() == 2 { (Some(types[0]), types[1]) } else { (None, types[0]) };
                    if length.is_some_and(Scalar::is_float) {
                        return bad("the length of a list must be a whole number".into());
                    }
                    element.properties.push(Property { name: name.into(), kind, length });
                }
                ["end_header"] => {
                    let Some(encoding) = encoding else { return bad("the header names no `format`".into()) };
                    return Ok((Self { encoding, elements, lines: number }, rest));
                }
                _ => return bad(format!("`{line}` is no header line that is known")),
            }
        }
        unreachable!("the loop ends by returning")
    }
}

/// The rows of the body, one property after the other.
trait Rows {
    fn begin_row(&mut self) -> Result<(), Fault>;
    /// Numbers of every type fit f64 exactly.
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault>;
    fn fault(&self, message: String) -> Fault;
    /// At most so many more values can follow: a bound on what a count may promise.
    fn most_values(&self) -> usize;
}

struct AsciiRows<'a> {
    lines: std::slice::Split<'a, u8, fn(&u8) -> bool>,
    words: std::str::SplitAsciiWhitespace<'a>,
    line: usize,
    bytes: usize,
}

impl<'a> AsciiRows<'a> {
    fn new(body: &'a [u8], line: usize) -> Self {
        let is_newline: fn(&u8) -> bool = |&byte| byte == b'\n';
        Self { lines: body.split(is_newline), words: "".split_ascii_whitespace(), line, bytes: body.len() }
    }
}

impl Rows for AsciiRows<'_> {
    fn begin_row(&mut self) -> Result<(), Fault> {
        loop {
            self.line += 1;
            let line = self.lines.next().ok_or_else(|| self.fault("the file ends before its last element".into()))?;
            let text = std::str::from_utf8(line).map_err(|_| self.fault("is not text".into()))?;
            if !text.trim().is_empty() {
                self.words = text.split_ascii_whitespace();
                return Ok(());
            }
        }
    }

    fn next(&mut self, kind: Scalar) -> Result<f64, Fault> {
        let word = self.words.next().ok_or_else(|| self.fault("the line has too few values".into()))?;
        let number: f64 = word.parse().map_err(|_| self.fault(format!("`{word}` is not a number")))?;
        if !kind.is_float() && number.fract() != 0.0 {
            return Err(self.fault(format!("`{word}` is not a whole number")));
        }
        Ok(number)
    }

    fn fault(&self, message: String) -> Fault {
        Fault::at(self.line, message)
    }

    fn most_values(&self) -> usize {
        self.bytes
    }
}

struct BinaryRows<'a, const IS_BIG: bool> {
    rest: &'a [u8],
}

impl<const IS_BIG: bool> BinaryRows<'_, IS_BIG> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (taken, rest) = self
            .rest
            .split_first_chunk::<N>()
            .ok_or_else(|| Fault::new("the file is cut off: it ends before its last element"))?;
        self.rest = rest;
        let mut taken = *taken;
        if IS_BIG {
            taken.reverse();
        }
        Ok(taken)
    }
}

impl<const IS_BIG: bool> Rows for BinaryRows<'_, IS_BIG> {
    fn begin_row(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    #[inline]
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault> {
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn fault(&self, message: String) -> Fault {
        Fault::new(message)
    }

    fn most_values(&self) -> usize {
        self.rest.len()
    }
}

/// What a property is to us.
#[derive(Clone, Copy)]
enum Role {
    Position(usize),
    Normal(usize),
    Corners,
    Nothing,
}

fn role(element: &Element, property: &Property) -> Role {
    match (element.name.as_str(), property.name.as_str(), property.length) {
        ("vertex", "x", None) => Role::Position(0),
        ("vertex", "y", None) => Role::Position(1),
        ("vertex", "z", None) => Role::Position(2),
        ("vertex", "nx", None) => Role::Normal(0),
        ("vertex", "ny", None) => Role::Normal(1),
        ("vertex", "nz", None) => Role::Normal(2),
        ("face", "vertex_indices" | "vertex_index", Some(_)) => Role::Corners,
        _ => Role::Nothing,
    }
}

fn read_elements(header: &Header, mut rows: impl Rows, builder: &mut Builder) -> Result<(), Fault> {
    let mut faces = Faces::default();
    for element in &header.elements {
        let plan: Vec<(Role, &Property)> = element.properties.iter().map(|p| (role(element, p), p)).collect();
        let has = |wanted: fn(&Role) -> Option<usize>| {
            (0..3).all(|axis| plan.iter().any(|(role, _)| wanted(role) == Some(axis)))
        };
        let is_vertex = element.name == "vertex";
        if is_vertex && !has(|role| if let Role::Position(axis) = role { Some(*axis) } else { None }) {
            return Err(Fault::new("the element `vertex` lacks x, y or z"));
        }
        let has_normals = is_vertex && has(|role| if let Role::Normal(axis) = role { Some(*axis) } else { None });
        if element.name == "face" && !plan.iter().any(|(role, _)| matches!(role, Role::Corners)) {
            return Err(Fault::new("the element `face` lacks `vertex_indices`"));
        }
        // Rows of no properties take no room, and a false count of them would never end.
        if plan.is_empty() {
            continue;
        }
        // A row takes at least one byte, so a count beyond the file's size is false: fail before reading, reserve no more.
        if element.count > rows.most_values() as u64 {
            return Err(rows.fault(format!(
                "the file is cut off: it promises {} of `{}`, more than fit into it",
                element.count, element.name
            )));
        }
        for row in 0..element.count {
            rows.begin_row()?;
            let (mut position, mut normal) = (DVec3::ZERO, DVec3::ZERO);
            for &(role, property) in &plan {
                match (role, property.length) {
                    (Role::Position(axis), _) => position[axis] = rows.next(property.kind)?,
                    (Role::Normal(axis), _) => normal[axis] = rows.next(property.kind)?,
                    (Role::Corners, Some(length)) => faces.read(&mut rows, length, property.kind, row)?,
                    (Role::Nothing, Some(length)) => {
                        let values = rows.next(length)?;
                        for _ in 0..whole(values, rows.most_values()).unwrap_or_default() {
                            rows.next(property.kind)?;
                        }
                    }
                    _ => {
                        rows.next(property.kind)?;
                    }
                }
            }
            if is_vertex {
                if !(position.is_finite() && normal.is_finite()) {
                    return Err(rows.fault(format!("vertex {row} has a coordinate that is not finite: {position}")));
                }
                builder.positions.push(position);
                if has_normals {
                    builder.normals.push(normal);
                }
            }
        }
    }
    faces.check(builder.positions.len())?;
    // Faces may come before the vertices that they name.
    let mut start = 0;
    for end in faces.ends {
        builder.push_face(&faces.corners[start..end]);
        start = end;
    }
    Ok(())
}

/// Faces one after the other, with the end of each.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    ends: Vec<usize>,
    /// The highest index, and the face and line that it stands in.
    highest: Option<(u32, u64, Option<usize>)>,
}

impl Faces {
    fn read(&mut self, rows: &mut impl Rows, length: Scalar, kind: Scalar, row: u64) -> Result<(), Fault> {
        let length = rows.next(length)?;
        let Some(length @ 3..) = whole(length, rows.most_values()) else {
            return Err(
                rows.fault(format!("face {row} has {length} corners, must have 3 or more (that fit into the file)"))
            );
        };
        if length > MAX_CORNERS {
            return Err(rows.fault(format!("face {row}: {}", too_many_corners(length))));
        }
        for _ in 0..length {
            let number = rows.next(kind)?;
            if !(number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0) {
                return Err(rows.fault(format!("face {row} names vertex {number}, which is out of range")));
            }
            let index = number as u32;
            if self.highest.is_none_or(|(highest, ..)| index > highest) {
                self.highest = Some((index, row, rows.fault(String::new()).line));
            }
            self.corners.push(index);
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    fn check(&self, vertices: usize) -> Result<(), Fault> {
        match self.highest {
            Some((index, face, line)) if index as usize >= vertices => Err(Fault {
                line,
                message: format!("face {face} names vertex {index}, but there are {vertices} (counted from 0)"),
            }),
            _ => Ok(()),
        }
    }
}

/// A count, if it is one and not beyond `most`.
fn whole(number: f64, most: usize) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number <= most as f64).then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use super::super::mesh::{Format, read};
    use super::*;
    use crate::geometry::Mesh;

    const ASCII: &str = "ply\r\nformat ascii 1.0\ncomment a pyramid\nelement vertex 4\nproperty float x\nproperty double y\n\
        property float z\nproperty uchar red\nelement edge 1\nproperty list uchar int ends\nelement face 3\n\
        property list uchar int vertex_indices\nproperty float weight\nend_header\n0 0 0 255\n1 0 0 255\n1 1 0 255\n\n0 1 0.5 0\n\
        2 0 1\n3 0 1 2 0.5\n3 0 2 3 0.5\n4 0 1 2 3 1\n";

    /// The same mesh in either byte order.
    fn binary(is_big: bool) -> Vec<u8> {
        let name = if is_big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = format!(
            "ply\nformat {name} 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
             element face 3\nproperty list uchar ushort vertex_index\nend_header\n"
        )
        .into_bytes();
        let mut put = |raw: &[u8]| {
            if is_big { bytes.extend(raw.iter().rev()) } else { bytes.extend(raw) }
        };
        for (x, y, z) in [(0.0_f32, 0.0_f64, 0.0_f32), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.5)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&z.to_le_bytes());
        }
        for face in [&[0_u16, 1, 2][..], &[0, 2, 3], &[0, 1, 2, 3]] {
            put(&[face.len() as u8]);
            face.iter().for_each(|i| put(&i.to_le_bytes()));
        }
        bytes
    }

    fn mesh(bytes: &[u8]) -> Mesh {
        read(bytes, Format::Ply).unwrap().0
    }

    fn fault(text: &str) -> (Option<usize>, String) {
        let fault = read(text.as_bytes(), Format::Ply).unwrap_err();
        (fault.line, fault.message)
    }

    #[test]
    fn three_encodings_of_one_mesh() {
        let ascii = mesh(ASCII.as_bytes());
        assert_eq!((ascii.positions.len(), ascii.triangles.len()), (4, 4));
        assert_eq!(ascii.positions[3], DVec3::new(0.0, 1.0, 0.5));
        assert_eq!(ascii.triangles[1], [0, 2, 3]);
        assert_eq!(mesh(&binary(false)), ascii);
        assert_eq!(mesh(&binary(true)), ascii);
    }

    #[test]
    fn normals_are_read() {
        let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list int int vertex_index\nelement vertex 3\nproperty float x\n\
                    property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n\
                    3 0 1 2\n0 0 0 0 0 2\n1 0 0 0 0 1\n0 1 0 0 1 1\n";
        let mesh = mesh(text.as_bytes());
        assert_eq!(mesh.normals[..2], [DVec3::Z; 2]);
        assert!((mesh.normals[2].length() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn faults_in_ascii_name_their_line() {
        assert_eq!(
            fault(&ASCII.replace("3 0 2 3 0.5", "3 0 2 4 0.5")),
            (Some(22), "face 1 names vertex 4, but there are 4 (counted from 0)".into())
        );
        assert_eq!(fault(&ASCII.replace("3 0 2 3 0.5", "3 0 -2 3 0.5")).0, Some(22));
        assert_eq!(fault(&ASCII.replace("1 1 0 255", "1 NaN 0 255")).0, Some(17));
        assert_eq!(fault(&ASCII.replace("1 1 0 255", "1 1 zero 255")), (Some(17), "`zero` is not a number".into()));
        assert_eq!(fault(&ASCII.replace("3 0 1 2 0.5", "2 0 1 0.5")).0, Some(21));
        assert_eq!(fault(&ASCII.replace("3 0 1 2 0.5", "3 0 1 2")).1, "the line has too few values");
        assert!(fault(&ASCII.replace("4 0 1 2 3 1\n", "")).1.contains("ends before"));
        assert!(fault(&ASCII.replace("end_header", "end")).1.contains("no header line"));
        assert!(fault(&ASCII.replace("vertex 4", "vertex 4000000000000")).1.contains("more than fit"));
        assert!(fault(&ASCII.replace("float x", "float w")).1.contains("lacks x"));
        assert!(fault("solid cube\n").1.contains("no PLY file"));
        assert!(fault("ply").1.contains("cut off"));
    }

    #[test]
    fn no_damage_makes_it_panic() {
        for bytes in [ASCII.as_bytes().to_vec(), binary(false), binary(true)] {
            for length in 0..bytes.len() - 2 {
                assert!(read(&bytes[..length], Format::Ply).is_err(), "cut at {length}");
            }
            for place in 0..bytes.len() {
                for flip in [0x01, 0x10, 0x80, 0xff] {
                    let mut damaged = bytes.clone();
                    damaged[place] ^= flip;
                    // Any answer will do that is not a panic, and that is a mesh if it is one.
                    if let Ok((mesh, _)) = read(&damaged, Format::Ply) {
                        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
                        assert!(mesh.positions.iter().all(|p| p.is_finite()));
                    }
                }
            }
        }
    }
}
