// Twin of `frame.rs`.

struct Frame {
    tangent: vec3f,
    bitangent: vec3f,
}

/// Two unit vectors that make a right-handed frame with unit `normal`.
fn frame(normal: vec3f) -> Frame {
    let sign = select(1.0, -1.0, normal.z < 0.0);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    return Frame(
        vec3f(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        vec3f(b, sign + normal.y * normal.y * a, -normal.y),
    );
}
