// Twin of `ray.rs`.

struct Ray {
    origin: vec3f,
    /// Unit.
    direction: vec3f,
    /// The primitive that `origin` lies on: never hit again if flat, hit again only across its inside if a sphere.
    leaves: u32,
    /// Only hits behind (`t_min`, `after`) in the order (distance, primitive) count.
    t_min: f32,
    after: u32,
}

struct Hit {
    t: f32,
    /// `NOTHING`: nothing was hit.
    primitive: u32,
    /// Where the triangle or sphere stands in its buffer.
    slot: u32,
    /// Barycentric weights of the second and third corner; unused for spheres.
    weights: vec2f,
    /// Whether the outward side is met.
    is_front: bool,
}

fn ray_leaving(origin: vec3f, direction: vec3f, primitive: u32) -> Ray {
    return Ray(origin, direction, primitive, 0.0, NOTHING);
}

fn ray_beyond(ray: Ray, hit: Hit) -> Ray {
    return Ray(ray.origin, ray.direction, ray.leaves, hit.t, hit.primitive);
}

/// Whether a hit comes after the ray's start in the order (distance, primitive).
fn is_behind_start(ray: Ray, t: f32, primitive: u32) -> bool {
    return t > ray.t_min || (t == ray.t_min && primitive > ray.after);
}

/// Whether a hit comes before another in that order.
fn is_before(t: f32, primitive: u32, other: Hit) -> bool {
    return t < other.t || (t == other.t && primitive < other.primitive);
}
