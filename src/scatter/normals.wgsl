// Twin of `normals.rs`.

/// Whether some surface has interpolated normals.
override SMOOTH_NORMALS: bool = true;

const LEAST_COSINE: f32 = 1e-3;

struct Normals {
    face: vec3f,
    shading: vec3f,
}

fn is_flat(normals: Normals) -> bool {
    return !SMOOTH_NORMALS || all(normals.face == normals.shading);
}

fn keep_reflected(normals: Normals, direction: vec3f, reflected_: vec3f) -> vec3f {
    let height = dot(reflected_, normals.face);
    if height >= LEAST_COSINE {
        return reflected_;
    }
    let mirrored = max(-dot(direction, normals.face), 0.0);
    return raised(reflected_, normals.face, height, min(LEAST_COSINE, 0.9 * mirrored));
}

/// `cosine_through_face` is that, behind the face, of the ray refracted about the face's own normal; negative if there is none.
fn keep_transmitted(normals: Normals, transmitted_: vec3f, cosine_through_face: f32) -> vec3f {
    let depth = -dot(transmitted_, normals.face);
    if depth >= LEAST_COSINE {
        return transmitted_;
    }
    let least = select(LEAST_COSINE, min(LEAST_COSINE, 0.9 * cosine_through_face), cosine_through_face >= 0.0);
    return raised(transmitted_, -normals.face, depth, least);
}

fn raised(direction: vec3f, normal: vec3f, height: f32, least: f32) -> vec3f {
    if height >= least {
        return direction;
    }
    return normalized(direction + normal * (least - height));
}
