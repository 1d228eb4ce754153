//! A sphere of nearly equal triangles: an icosahedron whose faces are split in four, again and again.

use std::collections::HashMap;

use glam::DVec3;

use crate::geometry::Mesh;

/// Vertices lie on the sphere; normals are the sphere's.
pub(super) fn icosphere(center: DVec3, radius: f64, subdivisions: u32) -> Mesh {
    let (mut directions, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::with_capacity(triangles.len() * 3 / 2);
        let mut middle_of = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle_of(a, b), middle_of(b, c), middle_of(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh {
        positions: directions.iter().map(|d| center + *d * radius).collect(),
        normals: directions,
        triangles,
        uvs: Vec::new(),
    }
}

/// Twelve vertices, cyclic permutations of (0, ±1, ±φ), and twenty faces.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let vertices: Vec<DVec3> = (0..3)
        .flat_map(|turn| {
            [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(short, long)| {
                let mut p = DVec3::ZERO;
                p[(turn + 1) % 3] = short;
                p[(turn + 2) % 3] = long * golden;
                p.normalize()
            })
        })
        .collect();
    // Faces join vertices that are all an edge apart; an edge subtends 63.4°, the next distance 116.6°.
    let is_edge = |a: usize, b: usize| vertices[a].dot(vertices[b]) > 0.0;
    let mut faces = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let is_outward = vertices[a].dot(vertices[b].cross(vertices[c])) > 0.0;
                    let (b, c) = if is_outward { (b, c) } else { (c, b) };
                    faces.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    (vertices, faces)
}
