// Twin of `search.rs` and `walk.rs`: the first hit along a ray, in a binary tree whose nodes hold the boxes of both children.
//
// Of a direction's component only its magnitude and the order of the two distances to a box's sides are used, so that −0 is no special case.

/// Whether there are triangles, spheres, primitives that rays need not meet.
override TRIANGLES: bool = true;
override SPHERES: bool = true;
override MASKED: bool = true;

/// A reference to a child: a node, or with `LEAF` a run of triangles or, with `OF_SPHERE`, one sphere.
const LEAF: u32 = 0x80000000u;
const OF_SPHERE: u32 = 0x40000000u;
/// Triangles of a leaf less one stand above its first slot.
const COUNT_SHIFT: u32 = 27u;
const SLOT: u32 = 0x07ffffffu;

/// By how much boxes are larger for a ray, as a share of its origin's coordinates: 16 roundings, for the distance to a side and for the corners
/// in the ray's frame. (Boxes are made larger by the same share of theirs.)
const BOX_MARGIN: f32 = 9.5367431640625e-7;
/// Relative growth of the range in which boxes are met.
const LIMIT_MARGIN: f32 = 2e-6;
/// Components of a direction are taken to be at least this large: 2⁻⁴⁰.
const SMALLEST: f32 = 9.094947017729282e-13;

struct Node {
    min0: vec3f,
    child0: u32,
    max0: vec3f,
    child1: u32,
    min1: vec3f,
    pad0: u32,
    max1: vec3f,
    pad1: u32,
}

struct BoxRay {
    inverse: vec3f,
    offset: vec3f,
    margin: vec3f,
    near_limit: f32,
}

fn box_ray(ray: Ray) -> BoxRay {
    let size = max(abs(ray.direction), vec3f(SMALLEST));
    let inverse = select(vec3f(1.0), vec3f(-1.0), ray.direction < vec3f(0.0)) / size;
    let margin = BOX_MARGIN * max_component(abs(ray.origin));
    return BoxRay(inverse, -ray.origin * inverse, margin * abs(inverse), ray.t_min * (1.0 - LIMIT_MARGIN));
}

/// The distance at which a ray enters a box, not too large; `FAR` if it misses it up to `far_limit`.
fn enter_box(ray: BoxRay, low: vec3f, high: vec3f, far_limit: f32) -> f32 {
    let to_low = low * ray.inverse + ray.offset;
    let to_high = high * ray.inverse + ray.offset;
    let near = min(to_low, to_high) - ray.margin;
    let far = max(to_low, to_high) + ray.margin;
    let enter = max(max(near.x, near.y), max(near.z, ray.near_limit));
    let leave = min(min(far.x, far.y), min(far.z, far_limit));
    return select(FAR, enter, enter <= leave);
}

fn is_masked(primitive: u32) -> bool {
    return MASKED && ((answers[scene.mask + (primitive >> 5u)] >> (primitive & 31u)) & 1u) == 1u;
}

/// The first hit of `ray` up to `t_max`, as if the masked primitives were not there. With an `only_object`, the first of that object, masked or not.
/// If `is_any`, any hit will do.
fn search(ray: Ray, t_max: f32, only_object: u32, is_any: bool) -> Hit {
    var best = Hit(t_max, NOTHING, 0u, vec2f(0.0), false);
    var node = scene.root;
    if node == NOTHING {
        return best;
    }
    let boxes = box_ray(ray);
    let sheared = sheared_ray(ray);
    var stack: array<u32, TREE_DEPTH>;
    var open = 0u;
    loop {
        if (node & LEAF) == 0u {
            let far_limit = best.t + best.t * LIMIT_MARGIN;
            let enter0 = enter_box(boxes, nodes[node].min0, nodes[node].max0, far_limit);
            let enter1 = enter_box(boxes, nodes[node].min1, nodes[node].max1, far_limit);
            let is_first_nearer = enter0 <= enter1;
            let nearer = select(nodes[node].child1, nodes[node].child0, is_first_nearer);
            if min(enter0, enter1) < FAR {
                if max(enter0, enter1) < FAR {
                    stack[open] = select(nodes[node].child0, nodes[node].child1, is_first_nearer);
                    open += 1u;
                }
                node = nearer;
                continue;
            }
        } else {
            let slot = node & SLOT;
            if SPHERES && (!TRIANGLES || (node & OF_SPHERE) != 0u) {
                search_sphere(ray, slot, only_object, &best);
            } else if TRIANGLES {
                let last = slot + ((node >> COUNT_SHIFT) & 7u);
                for (var k = slot; k <= last; k += 1u) {
                    search_triangle(ray, sheared, k, only_object, &best);
                }
            }
            if is_any && best.primitive != NOTHING {
                return best;
            }
        }
        if open == 0u {
            return best;
        }
        open -= 1u;
        node = stack[open];
    }
    return best;
}

fn search_triangle(ray: Ray, sheared: ShearedRay, slot: u32, only_object: u32, best: ptr<function, Hit>) {
    let triangle = triangles[slot];
    let hit = meet_triangle(sheared, triangle);
    let primitive = triangle.primitive;
    if !hit.is_met || primitive == ray.leaves || !is_behind_start(ray, hit.t, primitive) {
        return;
    }
    if is_before(hit.t, primitive, *best) && is_sought(primitive, triangle.object, only_object) {
        *best = Hit(hit.t, primitive, slot, hit.weights, hit.is_front);
    }
}

fn search_sphere(ray: Ray, slot: u32, only_object: u32, best: ptr<function, Hit>) {
    let primitive = scene.triangle_count + slot;
    let hits = meet_sphere(spheres[slot], ray.origin, ray.direction, primitive == ray.leaves);
    let can_enter = hits.has_enter && is_behind_start(ray, hits.enter, primitive);
    let can_leave = hits.has_leave && is_behind_start(ray, hits.leave, primitive);
    if !(can_enter || can_leave) {
        return;
    }
    // The entry comes first where both count.
    let t = select(hits.leave, hits.enter, can_enter);
    if is_before(t, primitive, *best) && is_sought(primitive, faces[primitive].object, only_object) {
        *best = Hit(t, primitive, slot, vec2f(0.0), can_enter);
    }
}

fn is_sought(primitive: u32, object: u32, only_object: u32) -> bool {
    if only_object != NOTHING {
        return object == only_object;
    }
    return !is_masked(primitive);
}
