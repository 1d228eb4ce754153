// Twin of `texture.rs`.

/// Whether solids have images.
override TEXTURES: bool = true;

/// What `objects[].texture` names in `light_tables`: where the texels begin, how many columns and rows they have, and where the coordinates of
/// the primitive 0 would begin. What follows makes coordinates in the image of those of a sphere: the columns of a matrix; others are made already.
const TEXELS: u32 = 0u;
const COLUMNS: u32 = 1u;
const ROWS: u32 = 2u;
const UVS: u32 = 3u;
const MATRIX: u32 = 4u;

/// The two texels of `count` in a row between whose centres a coordinate is, and how far it is from the first to the second.
struct Between {
    first: u32,
    second: u32,
    part: f32,
}

fn between_texels(coordinate: f32, count: u32) -> Between {
    // From −½; one texel more keeps it positive.
    let place = clamp(coordinate - floor(coordinate), 0.0, 1.0) * f32(count) + 0.5;
    let first = floor(place);
    let index = u32(first) + count - 1u;
    return Between(index % count, (index + 1u) % count, place - first);
}

/// Linear light of the texel at a place in `light_tables`.
fn texel_at(place: u32) -> vec3f {
    let bytes = light_tables[place];
    let first = scene.linear_light;
    return vec3f(
        light_number(first + (bytes & 255u)),
        light_number(first + (bytes >> 8u & 255u)),
        light_number(first + (bytes >> 16u & 255u)),
    );
}

/// Coordinates in the image at a hit of an object, whose outward normal there is `normal`.
fn uv_at(object: u32, hit: Hit, normal: vec3f) -> vec2f {
    if is_sphere(hit.primitive) {
        let x = dot(objects[object].checker_origin, normal);
        let y = dot(objects[object].u_axis, normal);
        let z = dot(objects[object].v_axis, normal);
        let u = 0.5 + angle_of(x, z) / TAU;
        let v = 0.5 + angle_of(y, length(vec2f(x, z))) / PI;
        let matrix = objects[object].texture + MATRIX;
        return vec2f(light_number(matrix), light_number(matrix + 1u)) * u
            + vec2f(light_number(matrix + 2u), light_number(matrix + 3u)) * v
            + vec2f(light_number(matrix + 4u), light_number(matrix + 5u));
    }
    let first = light_tables[objects[object].texture + UVS] + 6u * hit.primitive;
    let a = vec2f(light_number(first), light_number(first + 1u));
    let b = vec2f(light_number(first + 2u), light_number(first + 3u));
    let c = vec2f(light_number(first + 4u), light_number(first + 5u));
    return a * (1.0 - hit.weights.x - hit.weights.y) + b * hit.weights.x + c * hit.weights.y;
}

/// The colour of an object's image at a hit.
fn image_at(object: u32, hit: Hit, normal: vec3f) -> vec3f {
    let uv = uv_at(object, hit, normal);
    let record = objects[object].texture;
    let columns = light_tables[record + COLUMNS];
    let texels = light_tables[record + TEXELS];
    let across = between_texels(uv.x, columns);
    let down = between_texels(1.0 - uv.y, light_tables[record + ROWS]);
    let upper = texels + down.first * columns;
    let lower = texels + down.second * columns;
    let above = mix(texel_at(upper + across.first), texel_at(upper + across.second), across.part);
    let below = mix(texel_at(lower + across.first), texel_at(lower + across.second), across.part);
    return mix(above, below, down.part);
}
