// Twin of the questions that `geometry.rs` answers about points of surfaces.

/// Of each primitive, triangles first.
struct Face {
    /// Unit, outward; unused for spheres.
    normal: vec3f,
    object: u32,
}

/// Interpolated normals at the corners of a triangle, by its slot; all zero: the face's own.
struct CornerNormals {
    a: vec3f,
    pad0: u32,
    b: vec3f,
    pad1: u32,
    c: vec3f,
    pad2: u32,
}

struct SurfacePoint {
    position: vec3f,
    /// Unit, outward.
    normal: vec3f,
}

fn is_sphere(primitive: u32) -> bool {
    return SPHERES && (!TRIANGLES || primitive >= scene.triangle_count);
}

/// The surface at a hit of `ray`. The position is taken from the primitive, not from the ray.
fn surface_at(ray: Ray, hit: Hit) -> SurfacePoint {
    if is_sphere(hit.primitive) {
        let sphere = spheres[hit.slot];
        let normal = sphere_normal(sphere, ray.origin + ray.direction * hit.t);
        return SurfacePoint(sphere.center + normal * sphere.radius, normal);
    }
    let a = triangles[hit.slot].a;
    let position = a + (triangles[hit.slot].b - a) * hit.weights.x + (triangles[hit.slot].c - a) * hit.weights.y;
    return SurfacePoint(position, faces[hit.primitive].normal);
}

/// The interpolated unit normal at a hit, on the outward side; the geometric `normal` where there is none to interpolate.
fn shading_normal(hit: Hit, normal: vec3f) -> vec3f {
    if is_sphere(hit.primitive) {
        return normal;
    }
    let corners = corner_normals[hit.slot];
    let between = corners.a * (1.0 - hit.weights.x - hit.weights.y) + corners.b * hit.weights.x + corners.c * hit.weights.y;
    let shading = normalize_or(between, normal);
    return select(normal, shading, dot(shading, normal) > 0.0);
}

fn uniform_direction(u: vec2f) -> vec3f {
    let z = 1.0 - 2.0 * u.x;
    let r = sqrt(max(1.0 - z * z, 0.0));
    let sin_cos = sin_cos_of_turns(u.y);
    return vec3f(r * sin_cos.y, r * sin_cos.x, z);
}
