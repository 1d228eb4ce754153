// Twin of `environment.rs`.

/// 0: constant; 1: gradient; 2: image.
override ENVIRONMENT_KIND: u32 = 2u;

/// (u, v) of a unit direction, and the sine of its angle to the vertical.
fn environment_uv(d: vec3f) -> vec3f {
    let x = d.x * scene.rotation.y - d.z * scene.rotation.x;
    let z = d.x * scene.rotation.x + d.z * scene.rotation.y;
    let sine = sqrt(d.x * d.x + d.z * d.z);
    return vec3f(0.5 + angle_of(x, -z) / TAU, angle_of(sine, d.y) / PI, sine);
}

/// Radiance arriving from unit `direction`.
fn environment_radiance(direction: vec3f) -> vec3f {
    if ENVIRONMENT_KIND == 0u {
        return scene.horizon;
    }
    if ENVIRONMENT_KIND == 1u {
        let end = select(scene.nadir, scene.zenith, direction.y >= 0.0);
        return scene.horizon + (end - scene.horizon) * abs(direction.y);
    }
    let uv = environment_uv(direction);
    let size = vec2i(scene.image_size);
    let at = uv.xy * vec2f(scene.image_size) - 0.5;
    let corner = floor(at);
    let inside = at - corner;
    let columns = vec2u((vec2i(i32(corner.x)) + vec2i(0, 1) + size.x) % size.x);
    let rows = vec2u(clamp(vec2i(i32(corner.y)) + vec2i(0, 1), vec2i(0), vec2i(size.y - 1)));
    let top = texel(columns.x, rows.x) * (1.0 - inside.x) + texel(columns.y, rows.x) * inside.x;
    let bottom = texel(columns.x, rows.y) * (1.0 - inside.x) + texel(columns.y, rows.y) * inside.x;
    return (top * (1.0 - inside.y) + bottom * inside.y) * scene.image_scale;
}

fn texel(column: u32, row: u32) -> vec3f {
    let first = scene.texels + 3u * (row * scene.image_size.x + column);
    return vec3f(light_number(first), light_number(first + 1u), light_number(first + 2u));
}

/// Probability per steradian with which `environment_sample` gives `direction`.
fn environment_pdf(direction: vec3f) -> f32 {
    let uv = environment_uv(direction);
    if uv.z == 0.0 {
        return 0.0;
    }
    let at = min(vec2u(uv.xy * vec2f(scene.image_size)), scene.image_size - 1u);
    return environment_density(at.x, at.y, uv.z);
}

/// Density per steradian at a texel where the sine of the angle to the vertical is `sine`.
fn environment_density(column: u32, row: u32, sine: f32) -> f32 {
    let first = scene.columns + row * scene.image_size.x;
    var before = 0.0;
    if column > 0u {
        before = light_number(first + column - 1u);
    }
    let share = light_number(first + column) - before;
    let texels = f32(scene.image_size.x) * f32(scene.image_size.y);
    return share * light_number(scene.row_shares + row) * texels / (2.0 * PI * PI * sine);
}

/// A direction for `u` uniform in [0, 1)².
fn environment_sample(u: vec2f) -> LightSample {
    let size = scene.image_size;
    let row = min(first_above(scene.rows, size.y, u.y), size.y - 1u);
    var row_before = 0.0;
    if row > 0u {
        row_before = light_number(scene.rows + row - 1u);
    }
    let first = scene.columns + row * size.x;
    let cut = scene.guide + row * (scene.cuts_per_row + 1u) + u32(u.x * f32(scene.cuts_per_row));
    let start = light_tables[cut];
    let column = min(start + first_above(first + start, light_tables[cut + 1u] - start, u.x), size.x - 1u);
    var before = 0.0;
    if column > 0u {
        before = light_number(first + column - 1u);
    }
    let dx = clamp((u.x - before) / (light_number(first + column) - before), 0.0, 1.0);
    let dy = clamp((u.y - row_before) / (light_number(scene.rows + row) - row_before), 0.0, 1.0);
    // Half a turn is added to the angle about the vertical, which changes the signs.
    let about = sin_cos_of_turns((f32(column) + dx) / f32(size.x));
    let down = sin_cos_of_turns(0.5 * (f32(row) + dy) / f32(size.y));
    let x = -down.x * about.x;
    let z = down.x * about.y;
    let direction =
        vec3f(x * scene.rotation.y + z * scene.rotation.x, down.y, z * scene.rotation.y - x * scene.rotation.x);
    if down.x <= 0.0 {
        return no_light();
    }
    return light_from_afar(direction, environment_density(column, row, down.x));
}

/// The first of `count` ascending numbers that is above `u`; `count` if none is.
fn first_above(first: u32, count: u32, u: f32) -> u32 {
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if light_number(first + middle) <= u {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}
