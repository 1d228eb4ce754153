// Twin of `point.rs` and `directional.rs`: lights that nothing meets.

/// A light at a point, whose intensity at the angle of that 1 − cos to its axis is a share of its color.
fn point_light_sample(emitter: Emitter, position: vec3f) -> LightSample {
    let to_light = emitter.position - position;
    let distance = sqrt(dot(to_light, to_light));
    if distance == 0.0 {
        return no_light();
    }
    let direction = to_light / distance;
    var sample = no_light();
    sample.direction = direction;
    sample.radiance = emitter.color;
    if emitter.kind == SPOT_LIGHT {
        sample.radiance *= spot_falloff(emitter, -direction);
    }
    // Twice, since the square of a distance may be too large or too small.
    sample.radiance = sample.radiance / distance / distance;
    if any(sample.radiance > vec3f(0.0)) {
        sample.pdf = 1.0;
    }
    sample.is_delta = true;
    sample.distance = distance;
    return sample;
}

fn spot_falloff(emitter: Emitter, direction: vec3f) -> f32 {
    let difference = direction - emitter.axis;
    let one_minus_cos = 0.5 * dot(difference, difference);
    if one_minus_cos <= emitter.inner {
        return 1.0;
    }
    if one_minus_cos >= emitter.outer {
        return 0.0;
    }
    let share = (emitter.outer - one_minus_cos) / (emitter.outer - emitter.inner);
    return share * share;
}

/// The one direction of a directional light, or one within its disc.
fn directional_light_sample(emitter: Emitter, u: vec2f) -> LightSample {
    var sample = no_light();
    sample.radiance = emitter.color;
    sample.direction = emitter.axis;
    sample.pdf = 1.0;
    sample.is_delta = emitter.outer == 0.0;
    if !sample.is_delta {
        let one_minus_cos = u.x * emitter.outer;
        let sine = sqrt(one_minus_cos * (2.0 - one_minus_cos));
        let sin_cos = sin_cos_of_turns(u.y);
        let basis = frame(emitter.axis);
        let around = basis.tangent * sin_cos.y + basis.bitangent * sin_cos.x;
        sample.direction = normalized(emitter.axis * (1.0 - one_minus_cos) + around * sine);
        sample.pdf = 1.0 / (TAU * emitter.outer);
    }
    return sample;
}

/// Radiance of the suns that a ray sees which escapes along `direction`. `scattered` is the density with which the path was scattered there; 0 where
/// light sampling does not compete with that.
fn suns_radiance(direction: vec3f, scattered: f32) -> vec3f {
    var radiance = vec3f(0.0);
    var index = scene.first_sun;
    while index != NOTHING {
        let sun = emitters[index];
        let difference = direction - sun.axis;
        if 0.5 * dot(difference, difference) < sun.outer {
            var weight = 1.0;
            if scattered > 0.0 && EMITTERS {
                weight = power_heuristic(scattered, sun.probability / (TAU * sun.outer));
            }
            radiance += sun.color * weight;
        }
        index = sun.next_sun;
    }
    return radiance;
}
