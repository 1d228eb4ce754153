use std::path::Path;

use super::super::mesh::{self, format_of};
use super::*;
use crate::geometry::Mesh;
use crate::scene::LoadNote;

fn read_mesh(bytes: &[u8]) -> Result<(Mesh, Vec<LoadNote>), Fault> {
    let path = Path::new("m.obj");
    let input = crate::formats::files::Input { bytes, path, files: &crate::formats::Memory::default() };
    mesh::read(&input, format_of(path).unwrap())
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn loaded(text: impl AsRef<[u8]>) -> (Mesh, Vec<LoadNote>) {
    read_mesh(text.as_ref()).unwrap()
}

/// Kinds, counts and first lines.
fn passed_over(text: impl AsRef<[u8]>) -> Vec<(&'static str, u64, Option<usize>)> {
    loaded(text).1.iter().map(|note| (note.kind, note.count, note.first_line)).collect()
}

fn fault(text: &str) -> (Option<usize>, String) {
    let fault = read_mesh(text.as_bytes()).unwrap_err();
    (fault.line, fault.message)
}

#[test]
fn faces_in_every_notation() {
    let text = "# a square and a triangle\r\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1e0 0\n\
                vt 0 0\nf 1/1 2/1 3/1 4/1 # quad\nv 5 5 5\nf -1 1 -4\n";
    let (mesh, notes) = loaded(text);
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), notes), (5, 3, vec![]));
    assert_eq!(mesh.triangles[2], [4, 0, 1]);
    assert!(mesh.normals.is_empty());
}

#[test]
fn normals_split_vertices_at_bit_equal_positions() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0.1\nvn 0 0 2\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n";
    let (mesh, _) = loaded(text);
    assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6));
    assert_eq!(mesh.positions[mesh.triangles[0][0] as usize], mesh.positions[mesh.triangles[1][0] as usize]);
    assert_eq!(mesh.normals[0], DVec3::Z);
}

#[test]
fn faults_name_their_line() {
    let square = |rest: &str| fault(&format!("{SQUARE}{rest}"));
    assert_eq!(fault("v 0 0\n"), (Some(1), "a vertex has 2 coordinates, must have 3".into()));
    assert_eq!(fault("v 0 0 x\n").1, "`x` is not a number");
    assert_eq!(square("\nf 1 2 5\n"), (Some(6), "index 5 is out of range: there are 4 vertices".into()));
    assert_eq!(square("f 1 2 -5\n"), (Some(5), "index -5 is out of range: there are 4 vertices so far".into()));
    assert_eq!(square("f 0 1 1\n").0, Some(5));
    assert_eq!(square("f 1 1 9223372036854775808\n").1, "`9223372036854775808` is not an index");
    assert_eq!(square("f 1 1 9223372036854775807\n").0, Some(5));
    assert_eq!(square("f 1 1 -9223372036854775808\n").0, Some(5));
    assert_eq!(square("f 1 2 \x1b[0m\n").1, "`\\u{1b}[0m` is not an index");
    assert_eq!(fault(""), (None, "the mesh has no faces".into()));
    assert_eq!(
        fault("<html>\n<b>\n"),
        (Some(1), "the mesh has no faces, and `<html>` is no OBJ statement that is read (v, vn, f)".into())
    );
    // What would be part of the surface, but is not read.
    for word in ["surf 0 1 0 1 1 2 3 4", "bzp 1 2 3", "call other.obj"] {
        assert_eq!(square(&format!("f 1 2 3\n{word}\n")).0, Some(6), "{word}");
    }
}

#[test]
fn every_way_to_write_lines() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 \\\n 0\nv 0 1 0 # \\\ng a \\\n b\no C:\\parts\\\nf 1 \\\n\\\n 2 3 \\\n4\n";
    let (plain, _) = loaded(format!("{SQUARE}f 1 2 3 4\n"));
    for ends in ["\n", "\r\n", "\r"] {
        let (mesh, notes) = loaded(text.replace('\n', ends));
        assert_eq!((&mesh, notes), (&plain, vec![]), "{ends:?}");
    }
    let mixed: String = text
        .split_inclusive('\n')
        .zip(["\n", "\r", "\r\n"].iter().cycle())
        .map(|(line, end)| line.replace('\n', end))
        .collect();
    assert_eq!(loaded(&mixed).0, plain);
    assert_eq!(loaded(format!("\u{feff}{text}")), (plain.clone(), vec![]));
    let utf16 = |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    assert_eq!(loaded(utf16(u16::to_le_bytes)), (plain.clone(), vec![]));
    assert_eq!(loaded(utf16(u16::to_be_bytes)), (plain, vec![]));
    // At the end of the file there is nothing to join.
    assert_eq!(loaded(format!("{SQUARE}f 1 2 3 \\")).0.triangles, [[0, 1, 2]]);
    // A fault in a line that was joined is at its start.
    assert_eq!(fault(&format!("{SQUARE}\nf 1 \\\n 2 \\\n x\n")).0, Some(6));
}

#[test]
fn what_is_harmless_is_passed_over_and_noted_once() {
    let square = |rest: &str| passed_over(format!("{SQUARE}f 1 2 3 4\n{rest}"));
    assert_eq!(square("vw 1\nf 1 2 3\nxyz\nvw 2\n"), [("unknown_statement", 3, Some(6))]);
    assert_eq!(square("\nf 1 2\nf 9 9\nf\nl 1 2\n"), [("short_faces", 3, Some(7))]);
    assert_eq!(square("f 1 1 2\nf 1 2 2 1\n"), [("degenerate_triangles", 3, Some(6))]);
    assert_eq!(square("v 1 2 3 0.5\nv 1 2 3 1\nv 1 2 3 2\nv 1 2 3 0.1 0.2 0.3\n"), [("vertex_weights", 2, Some(6))]);
    assert_eq!(square("\n\0\0\0\n\0"), [("nul_bytes", 4, Some(7))]);
    assert_eq!(square("surface\x01\u{fffd} 5"), [("unknown_statement", 1, Some(6))]);
    let binary = [format!("{SQUARE}f 1 2 3 4\n").as_bytes(), b"g caf\xe9\n\x9a\xff\x03"].concat();
    assert_eq!(passed_over(binary), [("unknown_statement", 1, Some(7))]);
    assert_eq!(square("cstype bezier\ndeg 3\ncurv 0 1 1 2\nend\np 1\nl 1 2 3\nvt 0\nvt nan\nbevel on\n"), []);
}

#[test]
fn normals_that_are_missing_do_not_matter_to_the_surface() {
    let (plain, _) = loaded(format!("{SQUARE}f 1 2 3\n"));
    let with = |rest: &str| {
        let text = format!("{SQUARE}{rest}");
        assert_eq!(loaded(&text).0, plain, "{rest}");
        passed_over(text)
    };
    assert_eq!(with("f 1/1/1 2/2/2 3/3/3\n"), [("missing_normals", 3, Some(5))]);
    assert_eq!(with("vn 0 0 1\nf 1/1/1 2/2/2 3/3/-3\n"), [("missing_normals", 2, Some(6))]);
    assert_eq!(with("vn 0 0 1\nf 1//0 2//1 3//1\n"), [("missing_normals", 1, Some(6))]);
    assert_eq!(with("vn 0 0 1\nf 1 2//1 3/7\n"), [("partial_normals", 2, Some(6))]);
    assert_eq!(with("f 1/1 2/2/ 3//\n"), []);
    assert_eq!(with("vn 0 0 1\nf 1 2 3\n"), []);
    assert_eq!(with("vn 0 0 0\nvn 0 0 1\nf 1//1 2//2 3//2\n"), [("unusable_normals", 1, Some(7))]);
    assert_eq!(with("vn nan nan -nan(ind)\nvn 0 0 1\nf 1//1 2//2 3//2\n"), [("unusable_normals", 1, Some(7))]);
}

#[test]
fn what_faces_name_may_come_after_them() {
    let text = "f 1//1 2//1 3//2\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 0 1 0\n";
    let (mesh, notes) = loaded(text);
    assert_eq!((mesh.triangles, notes), (vec![[0, 1, 2]], vec![]));
    assert_eq!(mesh.normals, [DVec3::Z, DVec3::Z, DVec3::Y]);
    // Backwards, they count from where they stand.
    let text = format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -5 -4 -3\n");
    assert_eq!(loaded(text).0.triangles, [[0, 1, 2], [0, 1, 2]]);
}

#[test]
fn vertices_that_are_not_finite_matter_where_they_are_used() {
    for (before, after, lines) in [("v nan 0 0\n", "", Some(1)), ("", "v 0 1.#INF 0\nv 1e300 0 0\n", Some(7))] {
        let shift = before.lines().count();
        let face = format!("f {} {} {}\n", 1 + shift, 2 + shift, 3 + shift);
        let text = format!("{before}{SQUARE}\n{face}{after}");
        let (mesh, _) = loaded(&text);
        assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (4, &[[0, 1, 2]][..]));
        let count = (before.len() + after.len()).div_ceil(16) as u64;
        assert_eq!(passed_over(&text), [("unusable_vertices", count, lines)], "{text}");
        // With normals there is one vertex for each corner.
        let (split, _) = loaded(format!(
            "{before}{SQUARE}vn 0 0 1\n{}{after}",
            face.replace(' ', "//1 ").replace("f//1", "f").replace('\n', "//1\n")
        ));
        assert_eq!((split.positions.len(), &split.positions[..]), (3, &mesh.positions[..3]));
    }
    let (line, message) = fault(&format!("{SQUARE}v 0 inf 0\nf 1 2 3\nf 1 2 5\n"));
    assert_eq!(line, Some(5));
    assert!(message.contains("a face uses"), "{message}");
    assert!(fault("v 0 0 nan\nv 0 1 0\nv 1 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n").1.contains("a face uses"));
}

#[test]
fn no_damage_makes_it_panic() {
    let text = "\u{feff}o x\nv 0 0 0\nv 1 0 0 1\nv 1 1 \\\n0\nv 0 1 0 1 1 1\nvn 0 0 1\nvt 0 0\nv nan 0 0\nf 1/1/1 2/1/1 3//1 -2//-1\r\nf 1 2\rzz\0\n".as_bytes();
    let mut meshes = 0;
    for place in 0..text.len() {
        meshes += usize::from(read_mesh(&text[..place]).is_ok());
        for flip in (0..8).map(|bit| 1 << bit).chain([0xff]) {
            let mut damaged = text.to_vec();
            damaged[place] ^= flip;
            // Any answer will do that is not a panic, and that is a mesh if it is one.
            if let Ok((mesh, _)) = read_mesh(&damaged) {
                meshes += 1;
                assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
                assert!(mesh.positions.iter().all(|p| p.is_finite()));
                assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
            }
        }
    }
    assert!(meshes > 100, "{meshes}");
}
