//! PLY, the Stanford polygon format: ASCII and binary of either byte order. Read are the elements `vertex` (x, y, z and, if present,
//! nx, ny, nz and texture coordinates, under any of their usual names), `face` and `tristrips` (`vertex_indices` or `vertex_index`); everything else is passed over.

mod header;
mod rows;
#[cfg(test)]
mod tests;
mod write;

pub use self::write::{PlyExtra, to_bytes};

use glam::DVec3;

use self::header::{Element, Encoding, Header, Property, Scalar};
use self::rows::{AsciiRows, BinaryRows, Rows};
use super::corners::CornerLists;
use super::polygon::{MAX_CORNERS, too_many_corners};
use super::polygons::{Fault, Polygons};
use crate::geometry::topology::MAX_FACES;

pub(super) fn read(bytes: &[u8]) -> Result<Polygons, Fault> {
    let mut polygons = Polygons::default();
    let (header, body) = Header::read(bytes, &mut polygons.passed_over)?;
    match header.encoding {
        Encoding::Ascii => read_elements(&header, AsciiRows::new(body, header.lines), &mut polygons)?,
        Encoding::Little => read_elements(&header, BinaryRows::<false>::new(body), &mut polygons)?,
        Encoding::Big => read_elements(&header, BinaryRows::<true>::new(body), &mut polygons)?,
    }
    Ok(polygons)
}

/// What a property is to us.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Corners,
    Strips,
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
        ("vertex", "u" | "s" | "texture_u" | "texture_s", None) => Role::Uv(0),
        ("vertex", "v" | "t" | "texture_v" | "texture_t", None) => Role::Uv(1),
        ("face", "vertex_indices" | "vertex_index", Some(_)) => Role::Corners,
        ("tristrips", "vertex_indices" | "vertex_index", Some(_)) => Role::Strips,
        _ => Role::Nothing,
    }
}

fn read_elements(header: &Header, mut rows: impl Rows, polygons: &mut Polygons) -> Result<(), Fault> {
    for element in &header.elements {
        let plan: Vec<(Role, &Property)> = element.properties.iter().map(|p| (role(element, p), p)).collect();
        let has = |wanted: fn(usize) -> Role| (0..3).all(|axis| plan.iter().any(|(role, _)| *role == wanted(axis)));
        let is_vertex = element.name == "vertex";
        if is_vertex && !has(Role::Position) {
            return Err(Fault::new("the element `vertex` lacks x, y or z"));
        }
        let has_normals = is_vertex && has(Role::Normal);
        let has_uvs =
            is_vertex && (0..2).all(|axis| plan.iter().filter(|(role, _)| *role == Role::Uv(axis)).count() == 1);
        let has_corners = plan.iter().any(|(role, _)| matches!(role, Role::Corners | Role::Strips));
        if matches!(element.name.as_str(), "face" | "tristrips") && !has_corners {
            return Err(Fault::new(format!("the element `{}` lacks `vertex_indices`", element.name)));
        }
        // Rows of no properties take no room, and a false count of them would never end.
        if plan.is_empty() {
            continue;
        }
        require_room(element, &rows)?;
        if is_vertex {
            let count = element.count as usize;
            polygons
                .positions
                .try_reserve_exact(count)
                .map_err(|_| Fault::new(format!("there is not enough memory for the {count} vertices of the mesh")))?;
        }
        for row in 0..element.count {
            rows.begin_row()?;
            let (mut position, mut normal, mut uv) = (DVec3::ZERO, DVec3::ZERO, [0.0; 2]);
            for &(role, property) in &plan {
                match (role, property.length) {
                    (Role::Position(axis), _) => position[axis] = rows.next(property.kind)?,
                    (Role::Normal(axis), _) => normal[axis] = rows.next(property.kind)?,
                    (Role::Uv(axis), _) => uv[axis] = rows.next(property.kind)? as f32,
                    (Role::Corners, Some(length)) => {
                        read_face(&mut rows, length, property.kind, row, &mut polygons.faces)?;
                    }
                    (Role::Strips, Some(length)) => {
                        read_strips(&mut rows, length, property.kind, row, &mut polygons.strips)?;
                    }
                    (_, Some(length)) => {
                        let fault = |n| format!("a list of {n} values cannot be: the file is damaged");
                        let length = list_length(&mut rows, length, fault)?;
                        (0..length).try_for_each(|_| rows.skip(property.kind))?;
                    }
                    _ => rows.skip(property.kind)?,
                }
            }
            if is_vertex {
                if has_uvs {
                    polygons.uvs.push_of_position(Some(uv), polygons.positions.len());
                }
                polygons.push_position(position, rows.line());
                if has_normals {
                    // One that has no direction is met again, if it is used.
                    polygons.normals.push(if normal.is_finite() { normal } else { DVec3::ZERO });
                }
            }
        }
    }
    rows.finish(&mut polygons.passed_over);
    let vertices = polygons.positions.len();
    for (name, lists) in [("face", &polygons.faces), ("strip", &polygons.strips)] {
        if let Some((number, vertex, line)) = lists.out_of_range(vertices) {
            let message = format!("{name} {number} names vertex {vertex}, but there are {vertices} (counted from 0)");
            return Err(Fault { line, message });
        }
    }
    Ok(())
}

/// Refuses a count that the file is too short for before anything is read, and one that no mesh may have.
fn require_room(element: &Element, rows: &impl Rows) -> Result<(), Fault> {
    let Element { name, count, properties } = element;
    let least: u64 = properties.iter().map(|property| rows.least_bytes(property)).sum();
    if count.saturating_mul(least) > rows.bytes_left() as u64 {
        return Err(rows.fault(format!("the file is cut off: it promises {count} of `{name}`, more than fit into it")));
    }
    if *count > MAX_FACES as u64 {
        return Err(rows.fault(format!("the file has {count} of `{name}`, at most {MAX_FACES} are read")));
    }
    Ok(())
}

fn read_face(
    rows: &mut impl Rows,
    length: Scalar,
    kind: Scalar,
    row: u64,
    faces: &mut CornerLists,
) -> Result<(), Fault> {
    let fault = |n| format!("face {row} has {n} corners, must have 3 or more (that fit into the file)");
    let length = list_length(rows, length, fault)?;
    if length > MAX_CORNERS {
        return Err(rows.fault(format!("face {row}: {}", too_many_corners(length))));
    }
    for _ in 0..length {
        if length < 3 {
            rows.skip(kind)?;
            continue;
        }
        let number = rows.next(kind)?;
        let out_of_range = || rows.fault(format!("face {row} names vertex {number}, which is out of range"));
        faces.corners.push(vertex(number).ok_or_else(out_of_range)?);
    }
    faces.close(rows.line());
    Ok(())
}

/// Strips in one list, with −1 between them.
fn read_strips(
    rows: &mut impl Rows,
    length: Scalar,
    kind: Scalar,
    row: u64,
    strips: &mut CornerLists,
) -> Result<(), Fault> {
    let fault = |n| format!("the list of strips {row} has {n} corners, which do not fit into the file");
    for _ in 0..list_length(rows, length, fault)? {
        let number = rows.next(kind)?;
        match vertex(number) {
            Some(vertex) => strips.corners.push(vertex),
            None if number == -1.0 => close_strip(strips, rows.line()),
            None => {
                let message = format!("the list of strips {row} names vertex {number}, which is out of range");
                return Err(rows.fault(message));
            }
        }
    }
    close_strip(strips, rows.line());
    Ok(())
}

fn close_strip(strips: &mut CornerLists, line: Option<usize>) {
    if strips.open_corners() > 0 {
        strips.close(line);
    }
}

/// The length of a list, if it is one and so many values can follow.
fn list_length(rows: &mut impl Rows, kind: Scalar, fault: impl Fn(f64) -> String) -> Result<usize, Fault> {
    let number = rows.next(kind)?;
    let is_length = number >= 0.0 && number.fract() == 0.0 && number <= rows.most_values() as f64;
    if is_length { Ok(number as usize) } else { Err(rows.fault(fault(number))) }
}

/// The index of a vertex, if it is one.
fn vertex(number: f64) -> Option<u32> {
    (number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0).then_some(number as u32)
}
