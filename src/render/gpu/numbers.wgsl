// Elementary functions with errors of a few units in the last place: WGSL promises much less of its own.

const PI: f32 = 3.14159265358979;
const TAU: f32 = 6.28318530717959;
/// Stands for infinity, which WGSL does not have.
const FAR: f32 = 3.0e38;
/// No primitive, no object, no medium.
const NOTHING: u32 = 0xffffffffu;

/// sin and cos of 2π·`turns`, for turns in [0, 1]. Polynomials of Cephes (Moshier 1989), after an exact reduction.
fn sin_cos_of_turns(turns: f32) -> vec2f {
    let quarters = 4.0 * turns;
    let nearest = floor(quarters + 0.5);
    let x = (quarters - nearest) * (0.25 * TAU);
    let z = x * x;
    let sine = ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * x + x;
    let cosine = ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1.0;
    switch u32(nearest) & 3u {
        case 1u: { return vec2f(cosine, -sine); }
        case 2u: { return vec2f(-sine, -cosine); }
        case 3u: { return vec2f(-cosine, sine); }
        default: { return vec2f(sine, cosine); }
    }
}

/// The angle of (x, y) to the x axis, in [−π, π].
fn angle_of(y: f32, x: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    if larger == 0.0 {
        return 0.0;
    }
    var ratio = min(abs(x), abs(y)) / larger;
    var angle = 0.0;
    // tan(π/8)
    if ratio > 0.414213562 {
        angle = 0.125 * TAU;
        ratio = (ratio - 1.0) / (ratio + 1.0);
    }
    let z = ratio * ratio;
    angle += (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * ratio + ratio;
    if abs(y) > abs(x) {
        angle = 0.25 * TAU - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    return select(angle, -angle, y < 0.0);
}

fn max_component(v: vec3f) -> f32 {
    return max(max(v.x, v.y), v.z);
}

/// Told from the bits, since compilers may take for granted that nothing is infinite.
fn is_finite(v: vec3f) -> bool {
    let bits = bitcast<vec3u>(v) & vec3u(0x7f800000u);
    return all(bits != vec3u(0x7f800000u));
}

/// Unit vector along `v`; `otherwise` where that has no length.
fn normalize_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let squared = dot(v, v);
    if squared > 0.0 {
        return v * (1.0 / sqrt(squared));
    }
    return otherwise;
}

fn normalized(v: vec3f) -> vec3f {
    return v * (1.0 / sqrt(dot(v, v)));
}
