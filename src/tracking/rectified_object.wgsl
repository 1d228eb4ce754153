// Twin of `rectified_object.rs` and of `declared.rs`: one exterior for each object.

fn tracker_ask(walker: u32, crossing: Crossing, counts: bool) -> bool {
    tell_sides(crossing, objects[crossing.refractor].outside, crossing.interior);
    return true;
}
