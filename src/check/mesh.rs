//! Meshes from files: what is not closed, looks inward, or lost triangles. Shapes made from numbers are closed by construction.

use std::collections::HashMap;

use glam::DVec3;

use super::Problem;
use crate::geometry::Mesh;
use crate::scene::description::{Description, Shape, Transform};

pub(super) fn problems(description: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    for refractor in &description.refractors {
        match &refractor.shape {
            Shape::Quad { .. } => problems.push(Problem::warning(
                &refractor.name,
                "open_mesh",
                "a quad encloses nothing, so a refractor of that shape has no inside",
            )),
            Shape::Mesh { mesh, .. } => problems.extend(surface(&refractor.name, mesh, &refractor.transform)),
            _ => {}
        }
    }
    let solids = description.solids.iter().map(|s| (&s.name, &s.shape));
    let lights = description.lights.iter().map(|l| (&l.name, &l.shape));
    for (name, shape) in description.refractors.iter().map(|r| (&r.name, &r.shape)).chain(solids).chain(lights) {
        if let Shape::Mesh { path, dropped: dropped @ 1.., .. } = shape {
            problems.push(Problem::advice(
                name,
                "degenerate_triangles",
                format!("{dropped} triangles of {} have no area and were left out", path.display()),
            ));
        }
    }
    problems
}

/// What is wrong with the surface of a refractor.
fn surface(name: &str, mesh: &Mesh, transform: &Transform) -> Option<Problem> {
    let edges = unmatched_edges(mesh);
    if let Some(&[a, b]) = edges.first() {
        let middle = transform.matrix().transform_point3((a + b) / 2.0);
        let length = transform.matrix().transform_vector3(b - a).length();
        let problem = Problem::warning(
            name,
            "open_mesh",
            format!(
                "the mesh is not closed: {} of its edges are not shared by exactly two faces that look the same way, the first near \
                 [{:.4}, {:.4}, {:.4}]. Close it, or its inside is a guess",
                edges.len(),
                middle.x,
                middle.y,
                middle.z
            ),
        );
        // Two edges' length shows the surroundings of the gap.
        return Some(if length > 0.0 { problem.at(middle, 2.0 * length) } else { problem });
    }
    (mesh.signed_volume() < 0.0).then(|| {
        Problem::warning(
            name,
            "inside_out",
            "the faces of the mesh look inward, so that inside and outside are exchanged: turn its faces over",
        )
    })
}

/// Edges, by bit-equal positions, that are not run along once in each direction; each once, in the order of the faces.
fn unmatched_edges(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    // One number for each position; −0 is 0.
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let ids: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = numbers.len() as u32;
            *numbers.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let mut counts: HashMap<(u32, u32), (u32, u32)> = HashMap::with_capacity(mesh.triangles.len() * 3 / 2);
    let corners = || mesh.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    for (a, b) in corners() {
        let (a, b) = (ids[a as usize], ids[b as usize]);
        let count = counts.entry((a.min(b), a.max(b))).or_default();
        if a < b { count.0 += 1 } else { count.1 += 1 }
    }
    corners()
        .filter(|&(a, b)| {
            let (a, b) = (ids[a as usize], ids[b as usize]);
            counts.remove(&(a.min(b), a.max(b))).is_some_and(|count| count != (1, 1))
        })
        .map(|(a, b)| [mesh.positions[a as usize], mesh.positions[b as usize]])
        .collect()
}
