// Twin of `lambert.rs`.

/// Normals that agree better than this span no plane that rounding leaves alone.
const LEAST_TILT: f32 = 1e-12;

struct LambertSample {
    direction: vec3f,
    pdf: f32,
}

/// A direction above the face, for `u` uniform in [0, 1)², and its probability per steradian.
fn lambert_sample(normals: Normals, u: vec2f) -> LambertSample {
    let sin_cos = sin_cos_of_turns(u.y);
    let r = sqrt(u.x);
    let across = r * sin_cos.y;
    var along = r * sin_cos.x;
    let below = share_below(normals);
    let share = 1.0 - below;
    if below < LEAST_TILT {
        let basis = frame(normals.shading);
        let cosine = sqrt(max(1.0 - u.x, 0.0));
        let direction = normalized(basis.tangent * across + basis.bitangent * along + normals.shading * cosine);
        return LambertSample(direction, cosine / PI);
    }
    let axis = normalized(cross(normals.face, normals.shading));
    let towards = cross(normals.shading, axis);
    let reach = sqrt(max(1.0 - across * across, 0.0));
    along = below * reach + share * along;
    let cosine = sqrt(max(1.0 - across * across - along * along, 0.0));
    let direction = normalized(axis * across + towards * along + normals.shading * cosine);
    return LambertSample(direction, cosine / (PI * share));
}

/// Probability per steradian of unit `direction`.
fn lambert_pdf(normals: Normals, direction: vec3f) -> f32 {
    if dot(direction, normals.face) <= 0.0 {
        return 0.0;
    }
    return max(dot(direction, normals.shading), 0.0) / (PI * (1.0 - share_below(normals)));
}

/// Share of the cosine lobe about the interpolated normal s that is below the face, whose normal is g, in [0, ½): (1 − s·g)/2 without
/// cancellation.
fn share_below(normals: Normals) -> f32 {
    if is_flat(normals) {
        return 0.0;
    }
    let difference = normals.shading - normals.face;
    return 0.25 * dot(difference, difference);
}
