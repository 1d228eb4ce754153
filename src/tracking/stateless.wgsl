// Of modes whose paths carry nothing.

fn tracker_start(walker: u32) {}

fn tracker_copy() {}

fn tracker_transmit(walker: u32, crossing: Crossing) {}

fn tracker_save(first: u32) {}

fn tracker_load(first: u32) {}
