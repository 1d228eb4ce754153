// Twin of `area.rs`, and of the choice among emitters in `mod.rs`.

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
    pad: u32,
}

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
    if SPHERES && emitter.sphere != NOTHING {
        sample = sphere_light_sample(spheres[emitter.sphere], position, u);
    } else if TRIANGLES {
        sample = mesh_light_sample(emitter, position, vec3f(rest, u));
    }
    sample.object = emitter.object;
    sample.pdf *= emitter.probability;
    return sample;
}

/// By the cone under which the sphere is seen.
fn sphere_light_sample(sphere: Sphere, position: vec3f, u: vec2f) -> LightSample {
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
    return LightSample(normalized(direction), 1.0 / (TAU * one_minus_cos_max), NOTHING);
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
    let pdf = triangle_pdf(emitter.area, squared, direction, faces[triangle.primitive].normal);
    return LightSample(direction, pdf, NOTHING);
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
    return emitter.probability * triangle_pdf(emitter.area, dot(to_point, to_point), direction, point.normal);
}

fn triangle_pdf(area: f32, squared_distance: f32, direction: vec3f, normal: vec3f) -> f32 {
    let cosine = -dot(direction, normal);
    if cosine <= 0.0 {
        return 0.0;
    }
    return squared_distance / (area * cosine);
}

/// 1 − cos of the half angle under which a sphere is seen from outside.
fn one_minus_cos_of_cone(distance: f32, radius: f32) -> f32 {
    let sine = radius / distance;
    let sin_squared = sine * sine;
    return sin_squared / (1.0 + sqrt(max(1.0 - sin_squared, 0.0)));
}
