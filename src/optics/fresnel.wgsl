// Twin of `fresnel.rs`. What cancels was worked out in f64 beforehand: E = η² − 1.

struct Interface {
    /// η = n2/n1, and n1/n2.
    eta: f32,
    inverse_eta: f32,
    /// E = η² − 1; 0: both media have the same index.
    e: f32,
    /// (n1/n2)², the factor on radiance of a transmission seen along a camera path.
    radiance_factor: f32,
}

struct Refraction {
    is_total: bool,
    /// Unpolarised, in [0, 1]; 1 where reflection is total.
    reflectance: f32,
    /// η cos θt.
    b: f32,
}

/// What an interface does at `c` = cos θi in (0, 1].
fn refraction(surface: Interface, c: f32) -> Refraction {
    let q = (1.0 - c) * (1.0 + c);
    let eta_squared = surface.eta * surface.eta;
    let b_squared = select(surface.e + c * c, eta_squared - q, eta_squared < 0.5);
    if b_squared <= 0.0 {
        return Refraction(true, 1.0, 0.0);
    }
    let b = sqrt(b_squared);
    let rs = surface.e / ((c + b) * (c + b));
    let rp_over_rs = (c * b - q) / (c * b + q);
    return Refraction(false, 0.5 * rs * rs * (1.0 + rp_over_rs * rp_over_rs), b);
}

/// Unit direction of the transmitted ray.
fn transmitted(surface: Interface, direction: vec3f, normal: vec3f, c: f32, b: f32) -> vec3f {
    let t = (direction - normal * (surface.e / (c + b))) * surface.inverse_eta;
    return t * (0.5 * (3.0 - dot(t, t)));
}

/// Unit direction of the mirrored ray.
fn reflected(direction: vec3f, normal: vec3f, c: f32) -> vec3f {
    let r = direction + normal * (2.0 * c);
    return r * (0.5 * (3.0 - dot(r, r)));
}
