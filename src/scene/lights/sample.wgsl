// Twin of `sample.rs`.

/// A direction towards light.
struct LightSample {
    /// Unit.
    direction: vec3f,
    /// Per steradian; 0: there is no light to be seen.
    pdf: f32,
    /// The object that a shadow ray has to arrive at; `NOTHING`: the environment.
    object: u32,
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0), 0.0, NOTHING);
}

/// A number of the tables of lights.
fn light_number(index: u32) -> f32 {
    return bitcast<f32>(light_tables[index]);
}
