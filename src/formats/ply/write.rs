//! Meshes as PLY files: binary, little endian.

use crate::geometry::Mesh;

/// A mesh as the bytes of a PLY file. Coordinates are `float` where that loses nothing of any, else `double`; normals are `float`.
pub fn to_bytes(mesh: &Mesh) -> Vec<u8> {
    let Mesh { positions, normals, triangles } = mesh;
    let is_single = positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
    let has_normals = !normals.is_empty() && normals.len() == positions.len();
    let kind = if is_single { "float" } else { "double" };
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", positions.len());
    ["x", "y", "z"].iter().for_each(|axis| header += &format!("property {kind} {axis}\n"));
    if has_normals {
        ["nx", "ny", "nz"].iter().for_each(|axis| header += &format!("property float {axis}\n"));
    }
    header += &format!("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", triangles.len());
    let mut bytes = header.into_bytes();
    bytes.reserve(positions.len() * if is_single { 24 } else { 36 } + triangles.len() * 13);
    for (index, position) in positions.iter().enumerate() {
        for coordinate in position.to_array() {
            match is_single {
                true => bytes.extend((coordinate as f32).to_le_bytes()),
                false => bytes.extend(coordinate.to_le_bytes()),
            }
        }
        if has_normals {
            normals[index].to_array().iter().for_each(|component| bytes.extend((*component as f32).to_le_bytes()));
        }
    }
    for triangle in triangles {
        bytes.push(3);
        triangle.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
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
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
        for positions in [single, double] {
            for normals in [Vec::new(), vec![DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::X]] {
                let mesh = Mesh { positions: positions.to_vec(), normals, triangles: triangles.clone() };
                let read = super::super::read(&to_bytes(&mesh)).unwrap().finish().unwrap();
                assert_eq!(read, (mesh, Vec::new()));
            }
        }
    }
}
