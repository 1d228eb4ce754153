//! Meshes as PLY files: binary, little endian.

use crate::geometry::Mesh;

/// What a file holds besides positions, faces, and normals where the mesh has some.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlyExtra<'a> {
    /// Texture coordinates by vertex, as `u` and `v`; none, or one for each. Those of the mesh itself take their place.
    pub uv: &'a [[f64; 2]],
    /// Names and values of whole numbers by face, one for each.
    pub of_faces: &'a [(&'a str, Vec<i32>)],
}

/// A mesh as the bytes of a PLY file. Coordinates are `float` where that loses nothing of any, else `double`; all other fractions are `float`.
/// Positions are split where texture coordinates of the mesh differ.
pub fn to_bytes(mesh: &Mesh, extra: PlyExtra<'_>) -> Vec<u8> {
    if mesh.has_uvs() {
        let (split, uv) = mesh.with_uv_of_positions();
        let uv: Vec<[f64; 2]> = uv.into_iter().map(|pair| pair.map(f64::from)).collect();
        return to_bytes(&split, PlyExtra { uv: &uv, ..extra });
    }
    let Mesh { positions, normals, triangles, uvs: _ } = mesh;
    let is_single = positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
    let has_normals = !normals.is_empty() && normals.len() == positions.len();
    let has_uv = !extra.uv.is_empty() && extra.uv.len() == positions.len();
    let kind = if is_single { "float" } else { "double" };
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", positions.len());
    ["x", "y", "z"].iter().for_each(|axis| header += &format!("property {kind} {axis}\n"));
    let more = [(has_normals, &["nx", "ny", "nz"][..]), (has_uv, &["u", "v"])];
    for name in more.iter().filter(|(is_there, _)| *is_there).flat_map(|(_, names)| *names) {
        header += &format!("property float {name}\n");
    }
    // Some readers know no other kind of corners than `int`.
    header += &format!("element face {}\nproperty list uchar int vertex_indices\n", triangles.len());
    extra.of_faces.iter().for_each(|(name, _)| header += &format!("property int {name}\n"));
    header += "end_header\n";
    let mut bytes = header.into_bytes();
    bytes
        .reserve(positions.len() * if is_single { 32 } else { 44 } + triangles.len() * (13 + 4 * extra.of_faces.len()));
    for (index, position) in positions.iter().enumerate() {
        for coordinate in position.to_array() {
            match is_single {
                true => bytes.extend((coordinate as f32).to_le_bytes()),
                false => bytes.extend(coordinate.to_le_bytes()),
            }
        }
        let normal = if has_normals { &normals[index].to_array()[..] } else { &[] };
        let uv = if has_uv { &extra.uv[index][..] } else { &[] };
        normal.iter().chain(uv).for_each(|fraction| bytes.extend((*fraction as f32).to_le_bytes()));
    }
    for (index, triangle) in triangles.iter().enumerate() {
        bytes.push(3);
        triangle.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
        extra.of_faces.iter().for_each(|(_, values)| bytes.extend(values[index].to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let single = [DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 3.0, DVec3::splat(-2.25)];
        let double = single.map(|p| p + DVec3::splat(0.1));
        let (uv, of_faces) = ([[0.0, 1.0]; 4], [("outside", vec![0, 1, 2, 3]), ("inside", vec![4; 4])]);
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
        for positions in [single, double] {
            for normals in [Vec::new(), vec![DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::X]] {
                let uvs = Vec::new();
                let mesh = Mesh { positions: positions.to_vec(), normals, triangles: triangles.clone(), uvs };
                for extra in [PlyExtra::default(), PlyExtra { uv: &uv, of_faces: &of_faces }] {
                    let (read, _) = super::super::read(&to_bytes(&mesh, extra)).unwrap().finish().unwrap();
                    assert_eq!(read.uvs.len(), if extra.uv.is_empty() { 0 } else { mesh.triangles.len() });
                    assert!(read.uvs.iter().flatten().all(|uv| *uv == [0.0, 1.0]));
                    assert_eq!(read.without_uvs(), mesh);
                }
                let (_, notes) = super::super::read(&to_bytes(&mesh, PlyExtra::default())).unwrap().finish().unwrap();
                assert_eq!(notes, Vec::new());
                // Of its own it has other coordinates at each corner.
                let corner = |t: usize, k: usize| [t as f32, 0.25 * k as f32];
                let uvs = (0..4).map(|t| [0, 1, 2].map(|k| corner(t, k))).collect();
                let mesh = Mesh { uvs, ..mesh };
                let (read, _) = super::super::read(&to_bytes(&mesh, PlyExtra::default())).unwrap().finish().unwrap();
                assert_eq!((&read.uvs, read.positions.len()), (&mesh.uvs, 12));
                let places = |mesh: &Mesh| -> Vec<[DVec3; 3]> {
                    mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
                };
                assert_eq!(places(&read), places(&mesh));
            }
        }
    }
}
