// Of modes that answer at once.

fn tracker_go_on(crossing: Crossing) -> bool {
    return true;
}

fn tracker_hear(is_inside: bool) {}

fn member_ray(crossing: Crossing) -> Ray {
    return ray_leaving(crossing.position, crossing.normal, crossing.primitive);
}

fn member_object() -> u32 {
    return NOTHING;
}
