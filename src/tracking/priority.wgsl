// Twin of `priority.rs`: a list of the refractors entered so far, ordered by their priorities (Schmidt and Budge 2002). Here there is room for
// `TRACKER_ROOM` of them; entries beyond that are counted and lost.

/// By ascending priority, and by the order of entry among equals. The refractor, and entries less exits.
var<private> list_entries: array<vec2u, STATE_WORDS>;
var<private> list_lengths: array<u32, 2>;

fn tracker_start(walker: u32) {
    list_lengths[walker] = 0u;
}

fn tracker_copy() {
    let length = list_lengths[PATH];
    list_lengths[SHADOW] = length;
    for (var k = 0u; k < length; k += 1u) {
        list_entries[TRACKER_ROOM + k] = list_entries[k];
    }
}

/// The refractor's place in the list; `NOTHING` if it is not there.
fn list_place(walker: u32, refractor: u32) -> u32 {
    for (var k = list_lengths[walker]; k > 0u; k -= 1u) {
        if list_entries[walker * TRACKER_ROOM + k - 1u].x == refractor {
            return k - 1u;
        }
    }
    return NOTHING;
}

/// The medium of the entry below `place`; the global one below all.
fn list_medium(walker: u32, place: u32) -> u32 {
    if place == 0u {
        return WORLD;
    }
    return objects[list_entries[walker * TRACKER_ROOM + place - 1u].x].medium;
}

fn tracker_ask(walker: u32, crossing: Crossing, counts: bool) -> bool {
    let length = list_lengths[walker];
    let place = list_place(walker, crossing.refractor);
    let priority = objects[crossing.refractor].priority;
    let is_empty = length == 0u;
    var current = 0;
    if !is_empty {
        current = objects[list_entries[walker * TRACKER_ROOM + length - 1u].x].priority;
    }
    let around = list_medium(walker, length);
    if crossing.is_entering {
        told = Sides(around, crossing.interior, place == NOTHING && (is_empty || current <= priority));
        return true;
    }
    if place == NOTHING {
        events.stack_underflow += u32(counts);
        told = Sides(crossing.interior, around, is_empty || current < priority);
        return true;
    }
    let was_current = place + 1u == length && list_entries[walker * TRACKER_ROOM + place].y == 1u;
    told = Sides(crossing.interior, list_medium(walker, place), was_current);
    return true;
}

fn tracker_transmit(walker: u32, crossing: Crossing) {
    let first = walker * TRACKER_ROOM;
    let length = list_lengths[walker];
    let place = list_place(walker, crossing.refractor);
    if crossing.is_entering {
        if place != NOTHING {
            list_entries[first + place].y += 1u;
            return;
        }
        if length == TRACKER_ROOM {
            events.stack_overflow += u32(walker == PATH);
            return;
        }
        let priority = objects[crossing.refractor].priority;
        var at = length;
        while at > 0u && objects[list_entries[first + at - 1u].x].priority > priority {
            list_entries[first + at] = list_entries[first + at - 1u];
            at -= 1u;
        }
        list_entries[first + at] = vec2u(crossing.refractor, 1u);
        list_lengths[walker] = length + 1u;
    } else if place != NOTHING {
        list_entries[first + place].y -= 1u;
        if list_entries[first + place].y == 0u {
            for (var k = place; k + 1u < length; k += 1u) {
                list_entries[first + k] = list_entries[first + k + 1u];
            }
            list_lengths[walker] = length - 1u;
        }
    }
}

fn tracker_save(first: u32) {
    tracker_states[first] = list_lengths[PATH];
    for (var k = 0u; k < list_lengths[PATH]; k += 1u) {
        tracker_states[first + 1u + 2u * k] = list_entries[k].x;
        tracker_states[first + 2u + 2u * k] = list_entries[k].y;
    }
}

fn tracker_load(first: u32) {
    list_lengths[PATH] = tracker_states[first];
    for (var k = 0u; k < list_lengths[PATH]; k += 1u) {
        list_entries[k] = vec2u(tracker_states[first + 1u + 2u * k], tracker_states[first + 2u + 2u * k]);
    }
}
