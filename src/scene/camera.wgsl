// Twin of `camera.rs`, in coordinates relative to the scene's local origin.

/// The ray through the point `jitter` of a pixel, from the point `lens` of the unit disc.
fn camera_ray(pixel: vec2u, jitter: vec2f, lens: vec2f) -> Ray {
    let at = (vec2f(pixel) - image.half_size) + jitter;
    let through = image.forward + image.right * (at.x * image.scale) - image.up * (at.y * image.scale);
    if image.aperture_radius == 0.0 {
        return ray_leaving(image.position, normalized(through), NOTHING);
    }
    let offset = (image.right * lens.x + image.up * lens.y) * image.aperture_radius;
    return ray_leaving(image.position + offset, normalized(through * image.focus_distance - offset), NOTHING);
}

/// A point of the unit disc, uniform by area (Shirley and Chiu 1997), for `u` uniform in [0, 1)².
fn lens_point(u: vec2f) -> vec2f {
    let p = 2.0 * u - 1.0;
    if all(p == vec2f(0.0)) {
        return p;
    }
    // In turns: an eighth is π/4.
    var r = p.y;
    var turns = 0.25 - 0.125 * p.x / p.y;
    if abs(p.x) > abs(p.y) {
        r = p.x;
        turns = 0.125 * p.y / p.x;
    }
    let sin_cos = sin_cos_of_turns(turns - floor(turns));
    return vec2f(sin_cos.y, sin_cos.x) * r;
}
