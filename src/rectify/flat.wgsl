// Twin of `flat.rs`, where the arrays are described. They follow each other in `table`, and `answers` begins with the answers.
//
// A member of an asked cell may have to be looked for by a ray. The walk through the members stops there, so that there is one place from which
// rays are sent: see `path.wgsl`.

/// Whether some face is divided into cells, and whether some cell is asked about.
override DIVIDED_FACES: bool = true;
override ASKED_CELLS: bool = true;

const DIVIDED: u32 = 0x80000000u;
const BY_FACE: u32 = 0xffffffffu;
const KNOWN: u32 = 3u;
/// Words of records.
const ASKED_WORDS: u32 = 5u;
const MEMBER_WORDS: u32 = 3u;
const PLANES_WORDS: u32 = 12u;

/// Where the walk through the members of a cell is.
struct Asking {
    /// The next member and the one after the last.
    member: u32,
    last: u32,
    answer: u32,
    stride: u32,
    /// The object that the ray is sent for.
    object: u32,
}

var<private> asking: Asking;

fn table_address(object: u32, primitive: u32) -> u32 {
    let address = table[object];
    if address == BY_FACE {
        return table[scene.address_of_primitive + primitive];
    }
    return address;
}

/// Tells the answer of that number; both media are `NOTHING` where the crossing is skipped.
fn tell_answer(crossing: Crossing, index: u32) {
    let outside = answers[2u * index];
    let inside = answers[2u * index + 1u];
    tell_sides(crossing, outside, inside);
    told.is_interface = !(outside == NOTHING && inside == NOTHING);
}

fn tell_masked() {
    told = Sides(NOTHING, NOTHING, false);
}

fn tracker_ask(walker: u32, crossing: Crossing, counts: bool) -> bool {
    let address = table_address(crossing.refractor, crossing.primitive);
    if !DIVIDED_FACES || (address & DIVIDED) == 0u {
        tell_answer(crossing, address);
        return true;
    }
    events.mixed += u32(counts);
    let leaf = descend(table[scene.divided_faces + 2u * (address & ~DIVIDED)], crossing);
    if !ASKED_CELLS || leaf.x == KNOWN {
        tell_answer(crossing, leaf.y);
        return true;
    }
    let asked = scene.asked + ASKED_WORDS * leaf.y;
    asking.answer = table[asked];
    asking.stride = 1u;
    asking.member = table[asked + 1u];
    asking.last = asking.member + table[asked + 2u];
    let first_opaque = table[asked + 3u];
    let opaque_count = table[asked + 4u];
    for (var k = first_opaque; k < first_opaque + opaque_count; k += 1u) {
        if covers(scene.opaque_planes + PLANES_WORDS * k, crossing.position) {
            tell_masked();
            return true;
        }
    }
    return tracker_go_on(crossing);
}

/// From the root of a face, or the first of the eight of a sphere, down to the leaf that holds the point: its kind and index.
fn descend(root: u32, crossing: Crossing) -> vec2u {
    var weights = vec3f(1.0 - crossing.weights.x - crossing.weights.y, crossing.weights);
    var index = root;
    if is_sphere(crossing.primitive) {
        let n = crossing.normal;
        weights = abs(n);
        index += u32(n.x < 0.0) | (u32(n.y < 0.0) << 1u) | (u32(n.z < 0.0) << 2u);
    }
    loop {
        let node = vec2u(table[scene.cells + 2u * index], table[scene.cells + 2u * index + 1u]);
        if node.x >= KNOWN {
            return node;
        }
        // Turned so that the edge that is cut goes from the first corner to the second.
        let turned = select(select(weights, weights.yzx, node.x == 1u), weights.zxy, node.x == 2u);
        let is_first = turned.x >= turned.y;
        let cut = select(
            vec3f(2.0 * turned.x, turned.y - turned.x, turned.z),
            vec3f(turned.x - turned.y, 2.0 * turned.y, turned.z),
            is_first,
        );
        weights = select(select(cut, cut.zxy, node.x == 1u), cut.yzx, node.x == 2u);
        index = node.y + u32(!is_first);
    }
    return vec2u(KNOWN, 0u);
}

/// Whether a face, given by the planes of its edges, covers a point in its plane.
fn covers(first: u32, point: vec3f) -> bool {
    for (var k = first; k < first + PLANES_WORDS; k += 4u) {
        let inward = bitcast<vec3f>(vec3u(table[k], table[k + 1u], table[k + 2u]));
        if dot(inward, point) + bitcast<f32>(table[k + 3u]) < 0.0 {
            return false;
        }
    }
    return true;
}

/// Goes on to the next member that a ray has to look for.
fn tracker_go_on(crossing: Crossing) -> bool {
    if !ASKED_CELLS {
        return true;
    }
    while asking.member < asking.last {
        let member = scene.members + MEMBER_WORDS * asking.member;
        let refractor = table[member];
        let first_coincident = table[member + 1u];
        let coincident_count = table[member + 2u];
        var twin = NOTHING;
        for (var k = first_coincident; k < first_coincident + coincident_count; k += 1u) {
            if covers(scene.coincident_planes + PLANES_WORDS * k, crossing.position) {
                twin = k;
                break;
            }
        }
        if twin != NOTHING {
            // Of twins, the first one stands for both.
            if table[scene.coincident + 2u * twin] < crossing.primitive {
                tell_masked();
                return true;
            }
            add_digit(select(3u, 2u, table[scene.coincident + 2u * twin + 1u] == 1u), 4u);
        } else if SPHERES && objects[refractor].sphere != NOTHING {
            let sphere = spheres[objects[refractor].sphere];
            let from_center = crossing.position - sphere.center;
            let is_inside = dot(from_center, from_center) < sphere.radius * sphere.radius;
            add_digit(u32(is_inside), select(4u, 2u, coincident_count == 0u));
        } else {
            asking.object = refractor;
            return false;
        }
    }
    tell_answer(crossing, asking.answer);
    return true;
}

fn add_digit(digit: u32, radix: u32) {
    asking.answer += digit * asking.stride;
    asking.stride *= radix;
    asking.member += 1u;
}

fn tracker_hear(is_inside: bool) {
    let coincident_count = table[scene.members + MEMBER_WORDS * asking.member + 2u];
    add_digit(u32(is_inside), select(4u, 2u, coincident_count == 0u));
}

fn member_object() -> u32 {
    return asking.object;
}

/// A ray into the outer side of the surface, in a direction that follows from the point alone.
fn member_ray(crossing: Crossing) -> Ray {
    let bits = bitcast<vec3u>(crossing.position);
    let first = mix_bits(mix_bits(mix_bits(bits.x ^ 0x9e3779b9u) ^ bits.y) ^ bits.z);
    let second = mix_bits(first ^ 0x85ebca6bu);
    let direction = uniform_direction(vec2f(vec2u(first, second) >> vec2u(8u)) * 5.9604644775390625e-8);
    let outward = select(direction, -direction, dot(direction, crossing.normal) < 0.0);
    return ray_leaving(crossing.position, outward, crossing.primitive);
}
