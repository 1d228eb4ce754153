// Twin of `tracker.rs`: what every mode answers. A mode's file defines
//
// - `tracker_start(walker)`: makes the state that of a fresh path;
// - `tracker_copy()`: gives shadow rays the state of the path;
// - `tracker_ask(walker, crossing, counts)`: which media the crossing lies between, into `told`; events are counted if `counts`. `false`: that depends
//   on what the ray `member_ray()` hits first of the object `member_object()`. Then `tracker_hear` takes whether that is met from behind, and
//   `tracker_go_on` is as `tracker_ask`;
// - `tracker_transmit(walker, crossing)`: records that the walker went through;
// - `tracker_save(first)` and `tracker_load(first)`: keep the state of the path in `tracker_states`, where it has room for `TRACKER_WORDS` words.

/// The walkers: a path, and its shadow rays.
const PATH: u32 = 0u;
const SHADOW: u32 = 1u;

/// A ray meeting a refractor's surface.
struct Crossing {
    refractor: u32,
    /// The medium inside it.
    interior: u32,
    is_entering: bool,
    primitive: u32,
    /// Of the second and third corner.
    weights: vec2f,
    position: vec3f,
    normal: vec3f,
}

/// The media on both sides of a crossing, seen along the ray.
struct Sides {
    before: u32,
    behind: u32,
    /// `false`: there is no interface here.
    is_interface: bool,
}

/// The answer of `tracker_ask`.
var<private> told: Sides;

fn tell_sides(crossing: Crossing, outside: u32, inside: u32) {
    told = Sides(
        select(inside, outside, crossing.is_entering),
        select(outside, inside, crossing.is_entering),
        true,
    );
}

struct Events {
    stack_underflow: u32,
    stack_overflow: u32,
    inconsistent: u32,
    non_finite: u32,
    crossings: u32,
    mixed: u32,
}

var<private> events: Events;
