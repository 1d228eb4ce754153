// Twin of `interaction.rs`: what is worked out about a hit. The walk itself is in `path.wgsl`.

/// Roundings, of the numbers that a hit is computed from, that two hits of one place differ by at the most; as a share of those numbers. In f64
/// it is 64 of them; in f32 that would be as much as thin shells are thick.
const SAME_PLACE: f32 = 16.0 * 1.1920929e-7;

fn crossing_of(ray: Ray, hit: Hit) -> Crossing {
    let refractor = faces[hit.primitive].object;
    let point = surface_at(ray, hit);
    return Crossing(
        refractor,
        objects[refractor].medium,
        hit.is_front,
        hit.primitive,
        hit.weights,
        point.position,
        point.normal,
    );
}

/// How far apart two hits of one place may be found, near a hit of `ray`.
fn same_place(ray: Ray, hit: Hit) -> f32 {
    let reach = objects[faces[hit.primitive].object].reach;
    return SAME_PLACE * (max_component(abs(ray.origin)) + hit.t + reach);
}

/// Whether the ray has just met the same object in the place of the hit.
fn has_just_met(ray: Ray, hit: Hit) -> bool {
    let last = select(ray.after, ray.leaves, ray.after == NOTHING);
    if last == NOTHING || hit.t - ray.t_min > same_place(ray, hit) {
        return false;
    }
    return faces[last].object == faces[hit.primitive].object;
}

/// The normals at a hit that scattering uses, on the side that the ray comes from.
fn normals_at(hit: Hit, normal: vec3f) -> Normals {
    let outward = select(-1.0, 1.0, hit.is_front);
    let face = normal * outward;
    if SMOOTH_NORMALS && objects[faces[hit.primitive].object].is_smooth != 0u {
        return Normals(face, shading_normal(hit, normal) * outward);
    }
    return Normals(face, face);
}
