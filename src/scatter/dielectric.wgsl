// Twin of `dielectric.rs`. Paths are not split, so the choice is always made by comparing the reflectance with a random number.

const TRUSTED_SEGMENTS: u32 = 16u;

struct Scattered {
    direction: vec3f,
    reflectance: f32,
    is_transmitted: bool,
    is_total: bool,
}

/// Scatters unit `direction` where a path's `segment` ends, counted from 1, for `u` uniform in [0, 1).
fn dielectric_scatter(surface: Interface, direction: vec3f, normals: Normals, segment: u32, u: f32) -> Scattered {
    let c = clamp(-dot(direction, normals.face), 0.0, 1.0);
    if is_flat(normals) {
        return scatter_about(surface, direction, normals.face, c, refraction(surface, c), u);
    }
    let shading_c = -dot(direction, normals.shading);
    var bent = Refraction(true, 1.0, 0.0);
    if shading_c > 0.0 {
        bent = refraction(surface, min(shading_c, 1.0));
    }
    if segment > TRUSTED_SEGMENTS && bent.is_total {
        return scatter_about(surface, direction, normals.face, c, refraction(surface, c), u);
    }
    var scattered =
        scatter_about(surface, direction, normals.shading, clamp(shading_c, 0.0, 1.0), bent, u);
    if scattered.is_transmitted {
        let through_face = refraction(surface, c);
        let cosine = select(through_face.b * surface.inverse_eta, -1.0, through_face.is_total);
        scattered.direction = keep_transmitted(normals, scattered.direction, cosine);
    } else {
        scattered.direction = keep_reflected(normals, direction, scattered.direction);
    }
    return scattered;
}

fn scatter_about(
    surface: Interface,
    direction: vec3f,
    normal: vec3f,
    c: f32,
    bent: Refraction,
    u: f32,
) -> Scattered {
    if bent.is_total || u < bent.reflectance {
        return Scattered(reflected(direction, normal, c), bent.reflectance, false, bent.is_total);
    }
    return Scattered(
        transmitted(surface, direction, normal, c, bent.b),
        bent.reflectance,
        true,
        false,
    );
}
