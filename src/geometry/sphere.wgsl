// Twin of `sphere.rs`.

struct Sphere {
    center: vec3f,
    radius: f32,
}

struct SphereHits {
    has_enter: bool,
    has_leave: bool,
    enter: f32,
    leave: f32,
}

/// Distances at which the line of a ray enters and leaves. With `starts_here` the origin lies on this sphere, and is not reported.
fn meet_sphere(sphere: Sphere, origin: vec3f, direction: vec3f, starts_here: bool) -> SphereHits {
    let from_center = origin - sphere.center;
    let b = dot(from_center, direction);
    if starts_here {
        return SphereHits(false, b < 0.0, 0.0, -2.0 * b);
    }
    let across = from_center - direction * b;
    let distance = sqrt(dot(across, across));
    let discriminant = (sphere.radius - distance) * (sphere.radius + distance);
    if discriminant < 0.0 {
        return SphereHits(false, false, 0.0, 0.0);
    }
    let root = sqrt(discriminant);
    let distance_to_center = sqrt(dot(from_center, from_center));
    let c = (distance_to_center - sphere.radius) * (distance_to_center + sphere.radius);
    if b > 0.0 {
        let enter = -b - root;
        return SphereHits(true, true, enter, c / enter);
    }
    let leave = -b + root;
    var enter = 0.0;
    if leave != 0.0 {
        enter = c / leave;
    }
    return SphereHits(true, true, enter, leave);
}

/// Unit normal of the sphere where it is nearest to `point`.
fn sphere_normal(sphere: Sphere, point: vec3f) -> vec3f {
    return normalize_or(point - sphere.center, vec3f(0.0, 1.0, 0.0));
}
