// Twin of `sample.rs`.

/// A direction towards light.
struct LightSample {
    /// Unit.
    direction: vec3f,
    /// Per steradian; of a delta light the probability. 0: there is no light to be seen.
    pdf: f32,
    /// What arrives along it if nothing is in the way: radiance, or the irradiance across it of a delta light.
    radiance: vec3f,
    /// Whether no other way of sampling finds it.
    is_delta: bool,
    /// The object that a shadow ray has to arrive at, and the part of its surface; `NOTHING`: nothing may be in the way up to `distance`.
    object: u32,
    primitive: u32,
    distance: f32,
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0), 0.0, vec3f(0.0), false, NOTHING, NOTHING, FAR);
}

/// A sample of density `pdf` from afar, whose radiance is looked up later.
fn light_from_afar(direction: vec3f, pdf: f32) -> LightSample {
    var sample = no_light();
    sample.direction = direction;
    sample.pdf = pdf;
    return sample;
}

/// A number of the tables of lights.
fn light_number(index: u32) -> f32 {
    return bitcast<f32>(light_tables[index]);
}
