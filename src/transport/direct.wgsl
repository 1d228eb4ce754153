// Twin of `direct.rs`: light that is looked for where a path scatters. Its shadow rays are walked in `path.wgsl`.

/// Whether there are emitters, and some from afar that rays see which escape, whether the environment is sampled, and whether a shadow ray may pass through a refractor unbent, and so must look at
/// each one it meets.
override EMITTERS: bool = true;
override SUNS: bool = true;
override SAMPLED_ENVIRONMENT: bool = true;
override CAN_PASS: bool = true;

/// The lights that a vertex asks, one after the other, then nothing.
const ASK_ENVIRONMENT: u32 = 0u;
const ASK_EMITTERS: u32 = 1u;
const ASKED_ALL: u32 = 2u;

/// A diffuse vertex.
struct Vertex {
    position: vec3f,
    primitive: u32,
    normals: Normals,
    /// Throughput up to here, the scale of radiance and the albedo.
    factor: vec3f,
    dimensions: u32,
}

/// A sampled direction with what reaches the camera from it if nothing is in the way; of density 0 if there is nothing.
struct ShadowRay {
    sample: LightSample,
    radiance: vec3f,
}

fn shadow_ray(vertex: Vertex, sampler_: Sampler, light: u32) -> ShadowRay {
    var sample = no_light();
    if light == ASK_ENVIRONMENT && SAMPLED_ENVIRONMENT {
        sample = environment_sample(get_2d(sampler_, vertex.dimensions + ENVIRONMENT));
        if sample.pdf > 0.0 {
            sample.radiance = environment_radiance(sample.direction);
        }
    } else if light == ASK_EMITTERS && EMITTERS {
        let choice = get_1d(sampler_, vertex.dimensions + EMITTER_CHOICE);
        sample = emitters_sample(vertex.position, choice, get_2d(sampler_, vertex.dimensions + EMITTER));
    }
    let scattered = lambert_pdf(vertex.normals, sample.direction);
    if !(sample.pdf > 0.0 && sample.pdf < FAR && scattered > 0.0) {
        sample.pdf = 0.0;
        return ShadowRay(sample, vec3f(0.0));
    }
    var weight = 1.0;
    if !sample.is_delta {
        weight = power_heuristic(sample.pdf, scattered);
    }
    return ShadowRay(sample, vertex.factor * sample.radiance * (scattered * weight / sample.pdf));
}

fn environment_density_of(direction: vec3f) -> f32 {
    if !SAMPLED_ENVIRONMENT {
        return 0.0;
    }
    return environment_pdf(direction);
}

/// Density with which emitters are sampled in the `direction` from `position` to `point` of `object`.
fn emitter_density_of(position: vec3f, direction: vec3f, object: u32, point: SurfacePoint) -> f32 {
    if !EMITTERS || objects[object].emitter == NOTHING {
        return 0.0;
    }
    return emitters_pdf(emitters[objects[object].emitter], position, direction, point);
}

/// Weight of a sample of density `pdf` > 0 against another way of density `other` (Veach 1997, section 9.2).
fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // Squares could be too large for f32.
    let ratio = min(other / pdf, 1e18);
    return 1.0 / (1.0 + ratio * ratio);
}
