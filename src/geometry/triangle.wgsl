// Twin of `triangle.rs`: watertight (Woop, Benthin and Wald 2013), with the same rule for rays through edges and corners.
//
// The corners are rounded to f32 in the ray's own frame, alike for all triangles that share them. From there on every decision is exact: an
// edge function that rounding could have given the wrong sign is worked out in integers. So no ray slips between neighbours, whether or
// not the compiler fuses or reorders operations.

struct Triangle {
    a: vec3f,
    /// Id of the primitive.
    primitive: u32,
    b: vec3f,
    object: u32,
    c: vec3f,
    pad: u32,
}

struct ShearedRay {
    /// The axis along which the direction is longest.
    longest: u32,
    is_swapped: bool,
    origin: vec3f,
    shear: vec3f,
}

struct TriangleHit {
    is_met: bool,
    t: f32,
    weights: vec2f,
    is_front: bool,
}

/// The axes across the longest one, then that; the first two are swapped where needed to keep the winding.
fn permuted(p: vec3f, longest: u32, is_swapped: bool) -> vec3f {
    let turned = select(select(p, p.zxy, longest == 1u), p.yzx, longest == 0u);
    return select(turned, turned.yxz, is_swapped);
}

fn sheared_ray(ray: Ray) -> ShearedRay {
    let d = abs(ray.direction);
    let longest = select(select(2u, 1u, d.y > d.z), 0u, d.x > d.y && d.x > d.z);
    let is_swapped = select(select(ray.direction.z, ray.direction.y, longest == 1u), ray.direction.x, longest == 0u) < 0.0;
    let direction = permuted(ray.direction, longest, is_swapped);
    let along = 1.0 / direction.z;
    let shear = vec3f(direction.x / direction.z, direction.y / direction.z, along);
    return ShearedRay(longest, is_swapped, permuted(ray.origin, longest, is_swapped), shear);
}

/// A corner in the ray's frame: across it, and along it.
fn sheared_corner(ray: ShearedRay, corner: vec3f) -> vec3f {
    let p = permuted(corner, ray.longest, ray.is_swapped) - ray.origin;
    return vec3f(p.x - ray.shear.x * p.z, p.y - ray.shear.y * p.z, ray.shear.z * p.z);
}

fn meet_triangle(ray: ShearedRay, triangle: Triangle) -> TriangleHit {
    let a = sheared_corner(ray, triangle.a);
    let b = sheared_corner(ray, triangle.b);
    let c = sheared_corner(ray, triangle.c);
    let nothing = TriangleHit(false, 0.0, vec2f(0.0), false);
    // Edge functions opposite each corner, and what rounding can have done to them at the most.
    let forth = vec3f(c.x, a.x, b.x) * vec3f(b.y, c.y, a.y);
    let back = vec3f(c.y, a.y, b.y) * vec3f(b.x, c.x, a.x);
    var edges = forth - back;
    let rounding = (abs(forth) + abs(back)) * 4e-7;
    if any(edges > rounding) && any(edges < -rounding) {
        return nothing;
    }
    var signs = sign(edges);
    if any(abs(edges) <= rounding) {
        signs = vec3f(edge_sign(c.xy, b.xy), edge_sign(a.xy, c.xy), edge_sign(b.xy, a.xy));
        edges = signs * max(signs * edges, vec3f(0.0));
    }
    let is_front = signs.x > 0.0;
    let same = vec3f(select(-1.0, 1.0, is_front));
    if any(signs != same) {
        return nothing;
    }
    let determinant = edges.x + edges.y + edges.z;
    if determinant == 0.0 {
        return nothing;
    }
    let weights = edges / determinant;
    let t = dot(weights, vec3f(a.z, b.z, c.z));
    return TriangleHit(true, t, weights.yz, is_front);
}

/// The sign of the edge function of two points. Of a line through the origin: of that moved aside by (ε, ε²); 0 only for one point twice.
fn edge_sign(p: vec2f, q: vec2f) -> f32 {
    let exact = order_of_products(p.x, q.y, p.y, q.x);
    if exact != 0.0 {
        return exact;
    }
    return select(sign(q.x - p.x), sign(p.y - q.y), p.y != q.y);
}

/// The sign of a·b − c·d, exact. Numbers too small to be normal count as 0.
fn order_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let left_sign = sign_of_product(a, b);
    let right_sign = sign_of_product(c, d);
    if left_sign != right_sign {
        return select(-1.0, 1.0, left_sign > right_sign);
    }
    if left_sign == 0.0 {
        return 0.0;
    }
    let left = magnitude_of_product(a, b);
    let right = magnitude_of_product(c, d);
    if all(left == right) {
        return 0.0;
    }
    let is_larger = left.x > right.x
        || (left.x == right.x && (left.y > right.y || (left.y == right.y && left.z > right.z)));
    return select(-left_sign, left_sign, is_larger);
}

fn sign_of_product(a: f32, b: f32) -> f32 {
    let bits = bitcast<vec2u>(vec2f(a, b));
    if any((bits & vec2u(0x7f800000u)) == vec2u(0u)) {
        return 0.0;
    }
    return select(1.0, -1.0, ((bits.x ^ bits.y) >> 31u) == 1u);
}

/// |a·b| of normal numbers as an exponent and two halves of a significand of 48 bits, the upper one first. They compare in this order.
fn magnitude_of_product(a: f32, b: f32) -> vec3u {
    let bits = bitcast<vec2u>(vec2f(a, b));
    let exponents = (bits >> vec2u(23u)) & vec2u(0xffu);
    let significands = (bits & vec2u(0x7fffffu)) | vec2u(0x800000u);
    let high = significands >> vec2u(12u);
    let low = significands & vec2u(0xfffu);
    let middle = high.x * low.y + low.x * high.y;
    let lower = low.x * low.y + ((middle & 0xfffu) << 12u);
    let upper = high.x * high.y + (middle >> 12u) + (lower >> 24u);
    let rest = lower & 0xffffffu;
    let exponent = exponents.x + exponents.y;
    if upper < 0x800000u {
        return vec3u(exponent, (upper << 1u) | (rest >> 23u), (rest << 1u) & 0xffffffu);
    }
    return vec3u(exponent + 1u, upper, rest);
}
