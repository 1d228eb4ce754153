// Twin of `scene.rs`: the tables of a scene, and what is read from them.

/// Whether some medium absorbs.
override ABSORPTION: bool = true;

const REFRACTOR: u32 = 0u;
const DIFFUSE: u32 = 1u;
const MIRROR: u32 = 2u;
const LIGHT: u32 = 3u;

const WORLD: u32 = 0u;
const VACUUM: u32 = 1u;

struct Object {
    kind: u32,
    medium: u32,
    priority: i32,
    is_smooth: u32,
    /// The largest magnitude of a coordinate.
    reach: f32,
    /// Index of the emitter that it is, or `NOTHING`.
    emitter: u32,
    /// Index of the sphere that it is, or `NOTHING`.
    sphere: u32,
    /// What lies outside it by the object table.
    outside: u32,
    /// Albedo, that of the even squares, what multiplies an image, or radiance.
    color: vec3f,
    /// Whether it has squares or an image.
    is_varied: u32,
    /// Of the odd squares.
    other_color: vec3f,
    pad0: u32,
    /// Of a sphere with an image this and the two axes are the rows of the matrix from the world's directions to the object's.
    checker_origin: vec3f,
    /// Where its image is described: see `scene/texture.wgsl`. `NOTHING`: it has squares.
    texture: u32,
    u_axis: vec3f,
    pad2: u32,
    v_axis: vec3f,
    pad3: u32,
}

struct Medium {
    /// σ per unit of length.
    absorption: vec3f,
    pad0: u32,
    /// n − 1 as the sum of two numbers.
    ior_minus_one: vec2f,
    pad1: vec2u,
}

fn albedo_at(object: u32, hit: Hit, point: SurfacePoint) -> vec3f {
    if objects[object].is_varied == 0u {
        return objects[object].color;
    }
    if TEXTURES && objects[object].texture != NOTHING {
        return objects[object].color * image_at(object, hit, point.normal);
    }
    let p = point.position - objects[object].checker_origin;
    let half = 0.5 * (floor(dot(p, objects[object].u_axis)) + floor(dot(p, objects[object].v_axis)));
    return select(objects[object].other_color, objects[object].color, floor(half) == half);
}

/// The interface between two media; of more media than are kept in pairs it is worked out here.
fn interface_between(before: u32, behind: u32) -> Interface {
    if scene.pairs_of_media != 0u {
        return interfaces[before * scene.pairs_of_media + behind];
    }
    let m1 = media[before].ior_minus_one;
    let m2 = media[behind].ior_minus_one;
    let n1 = 1.0 + m1.x;
    let n2 = 1.0 + m2.x;
    let e = ((m2.x - m1.x) + (m2.y - m1.y)) * (2.0 + m1.x + m2.x) / (n1 * n1);
    return Interface(n2 / n1, n1 / n2, e, (n1 / n2) * (n1 / n2));
}

/// Whether leaving the medium `left` is what a path in the medium `current` must do.
fn is_consistent(current: u32, left: u32) -> bool {
    return current == left || (scene.world_is_vacuum != 0u && current <= VACUUM && left <= VACUUM);
}

/// What is left of light after the part of `ray` from its start to `t`; `FAR` is infinite.
fn transmittance(medium: u32, ray: Ray, t: f32) -> vec3f {
    if !ABSORPTION {
        return vec3f(1.0);
    }
    let absorption = media[medium].absorption;
    if all(absorption == vec3f(0.0)) {
        return vec3f(1.0);
    }
    var length = t - ray.t_min;
    if medium == WORLD && scene.bounds_radius > 0.0 {
        // The global medium fills the bounding sphere and no more.
        let bounds = Sphere(scene.bounds_center, scene.bounds_radius);
        let hits = meet_sphere(bounds, ray.origin, ray.direction, false);
        length = 0.0;
        if hits.has_enter && hits.has_leave {
            length = max(min(t, hits.leave) - max(ray.t_min, hits.enter), 0.0);
        }
    } else if t >= FAR {
        return vec3f(0.0);
    }
    return exp(-absorption * length);
}
