// Twin of `search.rs` and `walk.rs`: the first hit along a ray, in a binary tree whose nodes hold the boxes of both children.
//
// A tree of four children to a node, made from this one, was held against it in one kernel with the same rays (from the camera, then twice in a
// random direction, in the built-in scene of iced water, on Mesa's llvmpipe): 16 visits a ray in place of 25, and 0.9 times the rays a second, as the boxes and the order of four
// cost more than the visits that are saved. All hits were the same. In hardware neither has been measured.
//
// Of a direction's component only its magnitude and the order of the two distances to a box's sides are used, so that −0 is no special case.

/// Turns of loops that this thread has taken.
var<private> steps: u32;

/// Nodes to be visited. Private, because a variable of a function is set to zero at every call.
var<private> stack: array<u32, TREE_DEPTH>;

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

/// Where a ray leaves a triangle its origin may by rounding lie behind a neighbouring triangle of the same object. Near the start such hits
/// are told by the side on which the ray leaves: outside an object only fronts are met, inside only backs, even if a little behind the origin. So
/// nothing leaks through edges, and no path is shadowed by the neighbours of what it leaves. (On the CPU, in f64, this is too rare to matter.)
struct Start {
    /// The object that the ray leaves; `NOTHING`: no triangle is left.
    object: u32,
    is_outward: bool,
    /// How far the origin may be off.
    rounding: f32,
}

/// Roundings of an origin, as a share of its coordinates, and the least cosine by which they are divided along the ray.
const START_ROUNDING: f32 = 9.5367431640625e-7;
const LEAST_START_COSINE: f32 = 0.02;

fn start_of(ray: Ray) -> Start {
    if !TRIANGLES || ray.leaves >= scene.triangle_count || ray.after != NOTHING || ray.t_min != 0.0 {
        return Start(NOTHING, false, 0.0);
    }
    let is_outward = dot(ray.direction, faces[ray.leaves].normal) >= 0.0;
    return Start(faces[ray.leaves].object, is_outward, START_ROUNDING * max_component(abs(ray.origin)));
}

/// Whether a hit of a triangle counts, as far as the start of the ray decides.
fn is_after_start(ray: Ray, start: Start, hit: TriangleHit, triangle: Triangle) -> bool {
    if triangle.object == start.object && abs(hit.t) * LEAST_START_COSINE <= start.rounding {
        let cosine = max(abs(dot(ray.direction, faces[triangle.primitive].normal)), LEAST_START_COSINE);
        if abs(hit.t) * cosine <= start.rounding {
            return hit.is_front == start.is_outward;
        }
    }
    return is_behind_start(ray, hit.t, triangle.primitive);
}

struct BoxRay {
    inverse: vec3f,
    offset: vec3f,
    margin: vec3f,
    near_limit: f32,
}

fn box_ray(ray: Ray, start: Start) -> BoxRay {
    let size = max(abs(ray.direction), vec3f(SMALLEST));
    let inverse = select(vec3f(1.0), vec3f(-1.0), ray.direction < vec3f(0.0)) / size;
    let margin = BOX_MARGIN * max_component(abs(ray.origin));
    let near_limit = ray.t_min - abs(ray.t_min) * LIMIT_MARGIN - start.rounding / LEAST_START_COSINE;
    return BoxRay(inverse, -ray.origin * inverse, margin * abs(inverse), near_limit);
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
    let start = start_of(ray);
    let boxes = box_ray(ray, start);
    let sheared = sheared_ray(ray);
    var open = 0u;
    loop {
        steps += 1u;
        if (node & LEAF) == 0u {
            let far_limit = best.t + abs(best.t) * LIMIT_MARGIN;
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
                steps += (node >> COUNT_SHIFT) & 7u;
                let last = slot + ((node >> COUNT_SHIFT) & 7u);
                for (var k = slot; k <= last; k += 1u) {
                    search_triangle(ray, start, sheared, k, only_object, &best);
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

fn search_triangle(
    ray: Ray,
    start: Start,
    sheared: ShearedRay,
    slot: u32,
    only_object: u32,
    best: ptr<function, Hit>,
) {
    let triangle = triangles[slot];
    let hit = meet_triangle(sheared, triangle);
    let primitive = triangle.primitive;
    if !hit.is_met || primitive == ray.leaves || !is_before(hit.t, primitive, *best) {
        return;
    }
    if is_after_start(ray, start, hit, triangle) && is_sought(primitive, triangle.object, only_object) {
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
