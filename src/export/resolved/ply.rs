//! Meshes as PLY files with what other renderers read of them: binary, little endian.

use crate::geometry::Mesh;

/// What a file holds besides positions, faces, and normals where the mesh has some.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extra<'a> {
    /// Texture coordinates by vertex, as `u` and `v`.
    pub uv: &'a [[f64; 2]],
    /// Names and values of whole numbers by face.
    pub of_faces: &'a [(&'a str, Vec<i32>)],
}

/// The bytes of a PLY file. Coordinates are `float`, as all of these renderers compute.
pub fn to_bytes(mesh: &Mesh, extra: Extra<'_>) -> Vec<u8> {
    let Mesh { positions, normals, triangles } = mesh;
    let has_normals = normals.len() == positions.len() && !normals.is_empty();
    let has_uv = extra.uv.len() == positions.len() && !positions.is_empty();
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", positions.len());
    let vertex = [(true, &["x", "y", "z"][..]), (has_normals, &["nx", "ny", "nz"]), (has_uv, &["u", "v"])];
    for name in vertex.iter().filter(|(is_there, _)| *is_there).flat_map(|(_, names)| *names) {
        header += &format!("property float {name}\n");
    }
    header += &format!("element face {}\nproperty list uchar int vertex_indices\n", triangles.len());
    extra.of_faces.iter().for_each(|(name, _)| header += &format!("property int {name}\n"));
    header += "end_header\n";
    let mut bytes = header.into_bytes();
    let mut push = |value: f64| bytes.extend((value as f32).to_le_bytes());
    for (index, position) in positions.iter().enumerate() {
        position.to_array().into_iter().for_each(&mut push);
        if has_normals {
            normals[index].to_array().into_iter().for_each(&mut push);
        }
        if has_uv {
            extra.uv[index].into_iter().for_each(&mut push);
        }
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
    use crate::formats;

    #[test]
    fn what_is_written_is_read_again() {
        let positions = vec![DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 3.0, DVec3::splat(-2.25)];
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
        let (uv, of_faces) = ([[0.0, 1.0]; 4], [("outside", vec![0, 1, 2, 3]), ("inside", vec![4; 4])]);
        for normals in [Vec::new(), vec![DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::X]] {
            for extra in [Extra::default(), Extra { uv: &uv, of_faces: &of_faces }] {
                let mesh =
                    Mesh { positions: positions.clone(), normals: normals.clone(), triangles: triangles.clone() };
                let read = formats::mesh_from_bytes(&to_bytes(&mesh, extra), "a.ply".as_ref()).unwrap();
                assert_eq!(read, mesh);
            }
        }
    }
}
