// Twin of `area.rs`, and of the choice among emitters in `emitters.rs`.

struct Emitter {
    object: u32,
    /// Index of its sphere, or `NOTHING`.
    sphere: u32,
    /// Where the running sums of its triangles' areas begin in the tables of lights, and behind them the triangles' slots.
    first: u32,
    triangle_count: u32,
    probability: f32,
    /// Sum of the probabilities up to and including this one.
    cumulative: f32,
    area: f32,
    /// One of those below.
    kind: u32,
    /// Of a light at a point.
    position: vec3f,
    /// Of a spot, 1 − cos of the half angle within which it is brightest.
    inner: f32,
    /// Unit: a spot's, or from afar towards the light.
    axis: vec3f,
    /// Of a spot, 1 − cos of the half angle beyond which it is dark; of a light from afar, of half the angle that it is seen under.
    outer: f32,
    /// Radiance; intensity of a light at a point; irradiance of one from afar that has no extent.
    color: vec3f,
    is_two_sided: u32,
    /// The next one from afar that has an extent.
    next_sun: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

const AREA_LIGHT: u32 = 0u;
const POINT_LIGHT: u32 = 1u;
const SPOT_LIGHT: u32 = 2u;
const DIRECTIONAL_LIGHT: u32 = 3u;

/// A direction from `position` towards a point that emits.
fn emitters_sample(position: vec3f, choice: f32, u: vec2f) -> LightSample {
    var low = 0u;
    var high = scene.emitter_count;
    while low < high {
        let middle = (low + high) / 2u;
        if emitters[middle].cumulative <= choice {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let emitter = emitters[min(low, scene.emitter_count - 1u)];
    let before = emitter.cumulative - emitter.probability;
    let rest = clamp((choice - before) / emitter.probability, 0.0, 0.99999994);
    var sample = no_light();
    if emitter.kind == DIRECTIONAL_LIGHT {
        sample = directional_light_sample(emitter, u);
    } else if emitter.kind != AREA_LIGHT {
        sample = point_light_sample(emitter, position);
    } else if SPHERES && emitter.sphere != NOTHING {
        sample = sphere_light_sample(emitter.sphere, position, u);
    } else if TRIANGLES {
        sample = mesh_light_sample(emitter, position, vec3f(rest, u));
    }
    if emitter.kind == AREA_LIGHT {
        sample.object = emitter.object;
        sample.radiance = emitter.color;
    }
    sample.pdf *= emitter.probability;
    return sample;
}

/// Whether a light emits from the side that `is_front` tells.
fn emits(object: u32, is_front: bool) -> bool {
    let emitter = objects[object].emitter;
    return is_front || (emitter != NOTHING && emitters[emitter].is_two_sided != 0u);
}

/// By the cone under which the sphere is seen.
fn sphere_light_sample(index: u32, position: vec3f, u: vec2f) -> LightSample {
    let sphere = spheres[index];
    let to_center = sphere.center - position;
    let distance = sqrt(dot(to_center, to_center));
    if distance <= sphere.radius {
        return no_light();
    }
    let one_minus_cos_max = one_minus_cos_of_cone(distance, sphere.radius);
    let one_minus_cos = u.x * one_minus_cos_max;
    let sine = sqrt(one_minus_cos * (2.0 - one_minus_cos));
    let sin_cos = sin_cos_of_turns(u.y);
    let axis = to_center / distance;
    let basis = frame(axis);
    let direction = axis * (1.0 - one_minus_cos) + (basis.tangent * sin_cos.y + basis.bitangent * sin_cos.x) * sine;
    var sample = light_from_afar(normalized(direction), 1.0 / (TAU * one_minus_cos_max));
    sample.primitive = scene.triangle_count + index;
    return sample;
}

/// By area.
fn mesh_light_sample(emitter: Emitter, position: vec3f, u: vec3f) -> LightSample {
    let index = min(first_above(emitter.first, emitter.triangle_count, u.x), emitter.triangle_count - 1u);
    let triangle = triangles[light_tables[emitter.first + emitter.triangle_count + index]];
    // A square folded along its diagonal.
    var weights = u.yz;
    if weights.x + weights.y > 1.0 {
        weights = 1.0 - weights;
    }
    let point = triangle.a + (triangle.b - triangle.a) * weights.x + (triangle.c - triangle.a) * weights.y;
    let to_point = point - position;
    let squared = dot(to_point, to_point);
    if squared == 0.0 {
        return no_light();
    }
    let direction = to_point * (1.0 / sqrt(squared));
    let pdf = triangle_pdf(emitter, squared, direction, faces[triangle.primitive].normal);
    var sample = light_from_afar(direction, pdf);
    sample.primitive = triangle.primitive;
    return sample;
}

/// Density per steradian with which `emitters_sample` gives the `direction` from `position` to a point of an emitter.
fn emitters_pdf(emitter: Emitter, position: vec3f, direction: vec3f, point: SurfacePoint) -> f32 {
    if SPHERES && emitter.sphere != NOTHING {
        let sphere = spheres[emitter.sphere];
        let to_center = sphere.center - position;
        let distance = sqrt(dot(to_center, to_center));
        if distance <= sphere.radius {
            return 0.0;
        }
        return emitter.probability / (TAU * one_minus_cos_of_cone(distance, sphere.radius));
    }
    let to_point = point.position - position;
    return emitter.probability * triangle_pdf(emitter, dot(to_point, to_point), direction, point.normal);
}

fn triangle_pdf(emitter: Emitter, squared_distance: f32, direction: vec3f, normal: vec3f) -> f32 {
    var cosine = -dot(direction, normal);
    if emitter.is_two_sided != 0u {
        cosine = abs(cosine);
    }
    if cosine <= 0.0 {
        return 0.0;
    }
    return squared_distance / (emitter.area * cosine);
}

/// 1 − cos of the half angle under which a sphere is seen from outside.
fn one_minus_cos_of_cone(distance: f32, radius: f32) -> f32 {
    let sine = radius / distance;
    let sin_squared = sine * sine;
    return sin_squared / (1.0 + sqrt(max(1.0 - sin_squared, 0.0)));
}
