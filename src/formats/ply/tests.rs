use std::path::Path;

use super::super::mesh::{self, format_of};
use super::*;
use crate::geometry::Mesh;
use crate::scene::LoadNote;

fn read_mesh(bytes: &[u8]) -> Result<(Mesh, Vec<LoadNote>), Fault> {
    let path = Path::new("m.ply");
    let input = crate::formats::files::Input { bytes, path, files: &crate::formats::Memory::default() };
    mesh::read(&input, format_of(path).unwrap())
}

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

fn loaded(bytes: impl AsRef<[u8]>) -> (Mesh, Vec<LoadNote>) {
    read_mesh(bytes.as_ref()).unwrap()
}

fn mesh(bytes: &[u8]) -> Mesh {
    loaded(bytes).0
}

/// Kinds, counts and first lines.
fn passed_over(bytes: impl AsRef<[u8]>) -> Vec<(&'static str, u64, Option<usize>)> {
    loaded(bytes).1.iter().map(|note| (note.kind, note.count, note.first_line)).collect()
}

fn fault(text: &str) -> (Option<usize>, String) {
    let fault = read_mesh(text.as_bytes()).unwrap_err();
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
    assert!(fault(&ASCII.replace("1 1 0 255", "1 1e300 0 255")).1.contains("a face uses"));
    assert_eq!(fault(&ASCII.replace("1 1 0 255", "1 1 zero 255")), (Some(17), "`zero` is not a number".into()));
    assert_eq!(fault(&ASCII.replace("3 0 1 2 0.5", "-3 0 1 2 0.5")).0, Some(21));
    assert_eq!(fault(&ASCII.replace("3 0 1 2 0.5", "3.5 0 1 2 0.5")), (Some(21), "`3.5` is not a whole number".into()));
    assert_eq!(fault(&ASCII.replace("3 0 1 2 0.5", "3 0 1 2")).1, "the line has too few values");
    assert!(fault(&ASCII.replace("4 0 1 2 3 1\n", "")).1.contains("ends before"));
    assert!(fault(&ASCII.replace("end_header", "end")).1.contains("no header line"));
    assert_eq!(fault(&ASCII.replace("property float x", "property float")).0, Some(5));
    assert_eq!(fault(&ASCII.replace("element vertex 4\n", "")).1, "`property float x` stands before any element");
    assert!(fault(&ASCII.replace("vertex 4", "vertex 4000000000000")).1.contains("more than fit"));
    assert!(fault(&ASCII.replace("vertex 4", "vertex 20000000000000000000")).1.contains("is not a count"));
    assert!(fault(&ASCII.replace("float x", "float w")).1.contains("lacks x"));
    assert!(fault("solid cube\n").1.contains("no PLY file"));
    assert!(fault("ply").1.contains("cut off"));
}

#[test]
fn every_way_to_write_lines() {
    let plain = mesh(ASCII.as_bytes());
    let text = ASCII.replace("\r\n", "\n");
    for ends in ["\n", "\r\n", "\r"] {
        assert_eq!(loaded(text.replace('\n', ends)), (plain.clone(), vec![]), "{ends:?}");
    }
    assert_eq!(loaded(format!("\u{feff}{text}")), (plain.clone(), vec![]));
    let utf16 = |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    assert_eq!(loaded(utf16(u16::to_le_bytes)), (plain.clone(), vec![]));
    assert_eq!(loaded(utf16(u16::to_be_bytes)), (plain, vec![]));
}

/// The body begins right after the header's last line end, whatever byte comes then.
#[test]
fn headers_of_binary_files_end_as_their_lines_do() {
    for is_big in [false, true] {
        let bytes = binary(is_big);
        let start = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..start]).unwrap();
        for first in [0, b'\n', b'\r'] {
            // The first byte is one of the first coordinate, x of the vertex 0.
            let mut body = bytes[start..].to_vec();
            body[if is_big { 3 } else { 0 }] = first;
            if is_big {
                body[0] = first;
            }
            let expected = mesh(&[header.as_bytes(), &body].concat());
            for ends in ["\r\n", "\r"] {
                let file = [header.replace('\n', ends).as_bytes(), &body].concat();
                assert_eq!(loaded(&file), (expected.clone(), vec![]), "{ends:?} before {first}");
            }
        }
        assert_eq!(mesh(&[b"\xef\xbb\xbf", &bytes[..]].concat()), mesh(&bytes));
    }
}

#[test]
fn what_is_harmless_is_passed_over_and_noted_once() {
    let with = |from: &str, to: &str| passed_over(ASCII.replace(from, to));
    assert_eq!(with("comment a pyramid", "comment\nobj_info\nobj_info x 1\n\ncomment caf\u{e9}"), []);
    assert_eq!(with("comment a", "texture a.png\ncomments a"), [("unknown_header_line", 2, Some(3))]);
    assert_eq!(with("4 0 1 2 3 1", "2 0 1 1"), [("short_faces", 1, Some(23))]);
    assert_eq!(with("3 0 1 2 0.5\n3 0 2 3 0.5", "0 1\n2 77 -5 1"), [("short_faces", 2, Some(21))]);
    assert_eq!(with("1 1 0 255", "1 1 0 255 9 9"), [("extra_values", 1, Some(17))]);
    assert_eq!(
        with("4 0 1 2 3 1", "4 0 1 2 3 1 7\n\nmore\nx\n\0\0"),
        [("extra_values", 1, Some(23)), ("trailing_bytes", 5, Some(25)), ("nul_bytes", 2, Some(27))]
    );
    assert_eq!(with("property uchar red", "property text red"), [], "a type that is unknown, in a text");
    assert_eq!(with("0 0 0 255", "0 0 0 none"), []);
    let mut trailing = binary(false);
    trailing.extend([1, 2, 3]);
    assert_eq!(passed_over(&trailing), [("trailing_bytes", 3, None)]);
    assert_eq!(mesh(&trailing), mesh(&binary(false)));
}

#[test]
fn vertices_that_no_face_uses_may_be_anything() {
    let (mesh, notes) =
        loaded(ASCII.replace("vertex 4", "vertex 6").replace("0 0 0 255", "nan 0 0 255\n0 0 0 255").replace(
            "2 0 1\n3 0 1 2 0.5\n3 0 2 3 0.5\n4 0 1 2 3 1",
            "1 1e39 0 0\n2 0 1\n3 1 2 3 0.5\n3 1 3 4 0.5\n4 1 2 3 4 1",
        ));
    assert_eq!(mesh, self::mesh(ASCII.as_bytes()));
    assert_eq!(
        (notes.len(), notes[0].kind, notes[0].count, notes[0].first_line),
        (1, "unusable_vertices", 2, Some(15))
    );
}

/// A header for a square with other elements, whose rows are `rows` after the vertices'.
fn square(elements: &str, rows: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{elements}\
         end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n{rows}"
    )
}

#[test]
fn strips_with_restarts() {
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let (mesh, notes) = loaded(square(strips, "10 0 1 2 3 -1 -1 2 0 1 -1\n"));
    assert_eq!((mesh.triangles, notes), (vec![[0, 1, 2], [2, 1, 3], [2, 0, 1]], vec![]));
    assert_eq!(passed_over(square(strips, "8 0 1 2 -1 0 -1 1 2\n")), [("short_faces", 2, Some(14))]);
    assert_eq!(fault(&square(strips, "3 0 1 -2\n")).0, Some(14));
    assert_eq!(
        fault(&square(strips, "7 0 1 2 -1 0 1 4\n")).1,
        "strip 1 names vertex 4, but there are 4 (counted from 0)"
    );
    assert!(fault(&square(strips, "-1\n")).1.contains("do not fit"));
    let both = format!("{strips}element face 1\nproperty list uchar int vertex_index\n");
    assert_eq!(loaded(square(&both, "3 0 1 2\n3 1 3 2\n")).0.triangles, [[1, 3, 2], [0, 1, 2]]);
    assert!(fault(&square("element tristrips 1\nproperty int x\n", "1\n")).1.contains("`tristrips` lacks"));
}

#[test]
fn lists_of_every_type() {
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let types = [
        "char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint16", "int64", "uint64",
        "float32",
    ];
    for length in types {
        for kind in types {
            let elements = format!(
                "element face 1\nproperty list {length} {kind} texcoord\nproperty list {length} {kind} vertex_indices\n\
                 element material 2\nproperty list {length} {kind} of\nproperty {kind} b\n"
            );
            let text = square(&elements, "2 7 7 3 0 1 2\n0 1\n3 1 2 3 4\n");
            assert_eq!(loaded(&text).0.triangles, [[0, 1, 2]], "{length} {kind}");
            for is_big in [false, true] {
                assert_eq!(mesh(&as_binary(&text, is_big)).triangles, [[0, 1, 2]], "{length} {kind}");
            }
        }
    }
    let unknown = square(
        &face.replace("vertex_indices", "a\nproperty list uchar int vertex_indices").replacen("int", "half", 1),
        "1 x 3 0 1 2\n",
    );
    assert_eq!(loaded(&unknown).0.triangles, [[0, 1, 2]]);
    let binary = unknown.replace("ascii", "binary_big_endian");
    assert_eq!(fault(&binary), (Some(8), "`half` is no type of PLY, so that the body cannot be read".into()));
}

/// The binary twin of a text whose header and rows are plain.
fn as_binary(text: &str, is_big: bool) -> Vec<u8> {
    let name = if is_big { "binary_big_endian" } else { "binary_little_endian" };
    let (header, body) = text.split_once("end_header\n").unwrap();
    let header = format!("{}end_header\n", header.replace("ascii", name));
    let (parsed, _) = Header::read(header.as_bytes(), &mut Default::default()).unwrap();
    let mut words = body.split_ascii_whitespace();
    let mut bytes = header.into_bytes();
    let mut put = |kind: Scalar| {
        let number: f64 = words.next().unwrap().parse().unwrap();
        let mut raw = match kind {
            Scalar::F32 => (number as f32).to_le_bytes().to_vec(),
            Scalar::F64 => number.to_le_bytes().to_vec(),
            _ => (number as i64).to_le_bytes()[..kind.bytes()].to_vec(),
        };
        if is_big {
            raw.reverse();
        }
        bytes.extend(raw);
        number as usize
    };
    for element in &parsed.elements {
        for property in (0..element.count).flat_map(|_| &element.properties) {
            let count = property.length.map_or(1, &mut put);
            (0..count).for_each(|_| _ = put(property.kind));
        }
    }
    bytes
}

/// Promises of more than a short file can hold fail before anything is reserved.
#[test]
fn false_counts_fail_at_once() {
    let face = "element face 1\nproperty list uint int vertex_indices\n";
    assert!(fault(&square(face, "4000000000 0 1 2\n")).1.contains("that fit into the file"));
    let other = "element other 1\nproperty list uint double x\n";
    assert!(fault(&square(other, "4000000000 0 1 2\n")).1.contains("cannot be"));
    assert!(fault(&square(other, "-1 0\n")).1.contains("cannot be"));
    for count in ["5", "4000000000", "18446744073709551615"] {
        let text = as_binary(&square("", ""), false);
        let end = text.windows(11).position(|window| window == b"end_header\n").unwrap();
        let header = std::str::from_utf8(&text[..end]).unwrap().replace("vertex 4", &format!("vertex {count}"));
        let error = read_mesh(&[header.as_bytes(), &text[end..]].concat()).unwrap_err();
        assert!(error.message.contains("more than fit into it"), "{}", error.message);
    }
    // Rows without values take no room, however many there are said to be.
    assert_eq!(
        loaded(square(&format!("element nothing 18446744073709551615\n{face}"), "3 0 1 2\n")).0.triangles.len(),
        1
    );
}

#[test]
fn no_damage_makes_it_panic() {
    for bytes in [ASCII.as_bytes().to_vec(), binary(false), binary(true)] {
        for length in 0..bytes.len() - 2 {
            assert!(read_mesh(&bytes[..length]).is_err(), "cut at {length}");
        }
        for place in 0..bytes.len() {
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[place] ^= flip;
                // Any answer will do that is not a panic, and that is a mesh if it is one.
                if let Ok((mesh, _)) = read_mesh(&damaged) {
                    assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
                    assert!(mesh.positions.iter().all(|p| p.is_finite()));
                }
            }
        }
    }
}
