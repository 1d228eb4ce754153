// Twin of `naive.rs`: the exterior is always vacuum.

fn tracker_ask(walker: u32, crossing: Crossing, counts: bool) -> bool {
    tell_sides(crossing, VACUUM, crossing.interior);
    return true;
}
