// Twin of `stack.rs`: the media entered so far. Here there is room for `TRACKER_ROOM` of them; entries beyond that are counted and lost.

var<private> stack_media: array<u32, STATE_WORDS>;
var<private> stack_heights: array<u32, 2>;

fn tracker_start(walker: u32) {
    stack_heights[walker] = 0u;
}

fn tracker_copy() {
    let height = stack_heights[PATH];
    stack_heights[SHADOW] = height;
    for (var k = 0u; k < height; k += 1u) {
        stack_media[TRACKER_ROOM + k] = stack_media[k];
    }
}

/// The medium `depth` below the top, counted from 1; the global one below all.
fn stack_below(walker: u32, depth: u32) -> u32 {
    let height = stack_heights[walker];
    if height < depth {
        return WORLD;
    }
    return stack_media[walker * TRACKER_ROOM + height - depth];
}

fn tracker_ask(walker: u32, crossing: Crossing, counts: bool) -> bool {
    if crossing.is_entering {
        told = Sides(stack_below(walker, 1u), crossing.interior, true);
        return true;
    }
    if stack_heights[walker] == 0u {
        events.stack_underflow += u32(counts);
        told = Sides(crossing.interior, WORLD, true);
        return true;
    }
    events.inconsistent += u32(counts && stack_below(walker, 1u) != crossing.interior);
    told = Sides(stack_below(walker, 1u), stack_below(walker, 2u), true);
    return true;
}

fn tracker_transmit(walker: u32, crossing: Crossing) {
    let height = stack_heights[walker];
    if crossing.is_entering {
        if height == TRACKER_ROOM {
            events.stack_overflow += u32(walker == PATH);
            return;
        }
        stack_media[walker * TRACKER_ROOM + height] = crossing.interior;
        stack_heights[walker] = height + 1u;
    } else if height > 0u {
        stack_heights[walker] = height - 1u;
    }
}

fn tracker_save(first: u32) {
    tracker_states[first] = stack_heights[PATH];
    for (var k = 0u; k < stack_heights[PATH]; k += 1u) {
        tracker_states[first + 1u + k] = stack_media[k];
    }
}

fn tracker_load(first: u32) {
    stack_heights[PATH] = tracker_states[first];
    for (var k = 0u; k < stack_heights[PATH]; k += 1u) {
        stack_media[k] = tracker_states[first + 1u + k];
    }
}
