// Twin of `mirror.rs`.

/// Unit direction of the ray that a mirror sends back, above the face.
fn mirror_reflect(direction: vec3f, normals: Normals) -> vec3f {
    let cosine = clamp(-dot(direction, normals.shading), 0.0, 1.0);
    let mirrored = reflected(direction, normals.shading, cosine);
    if is_flat(normals) {
        return mirrored;
    }
    return keep_reflected(normals, direction, mirrored);
}
