//! How much one dispatch takes on, by how fast those before it were.
//!
//! Work is counted in steps: turns of the loops in which a thread goes through the tree. A dispatch is bounded by its threads and by the steps after
//! which each puts its path away, so that it takes the time of a slice whatever the paths do: an edit waits for one dispatch at the most, and a
//! desktop that shares the hardware too.

use std::time::Duration;

/// Time that one dispatch should take.
const SLICE: Duration = Duration::from_millis(8);
/// Steps of a thread in one dispatch while most threads have a path: about a ray's worth. Then paths are put away and taken up once for each ray, which
/// costs little, and few threads wait long for others of their group whose rays take longer.
const USUAL_STEPS: u32 = 128;
/// A path goes on by one ray at least, so that less than this saves nothing.
const LEAST_STEPS: u32 = 64;
/// In hardware, drivers end what takes long.
const MOST_STEPS: u32 = 1 << 14;
/// In software eight threads are one, and their loops count together: Mesa's llvmpipe ends all loops of a thread at 65,535 turns.
const MOST_STEPS_IN_SOFTWARE: u32 = 5000;
/// Before anything has been measured.
const FIRST_RATE: f64 = 2e9;
const FIRST_RATE_IN_SOFTWARE: f64 = 1e8;

/// The pace of one device.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    most_steps: u32,
    /// Of all threads together.
    steps_per_sec: f64,
    tally: Tally,
}

/// What a device has done so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    pub dispatches: u64,
    /// Turns of the loops in which threads go through the tree: nodes whose boxes, and triangles and spheres that rays were held against.
    pub steps: u64,
    /// Of all paths, from surface to surface. Rays towards lights are not among them.
    pub segments: u64,
    /// How often a path was put away and taken up again.
    pub resumed: u64,
    /// From submitting each dispatch until it was done, together and of the longest, in seconds.
    pub secs: f64,
    pub longest_secs: f64,
}

impl Tally {
    /// What has been done since an earlier time; the longest dispatch is that of all.
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self {
            dispatches: self.dispatches - earlier.dispatches,
            steps: self.steps - earlier.steps,
            segments: self.segments - earlier.segments,
            resumed: self.resumed - earlier.resumed,
            secs: self.secs - earlier.secs,
            longest_secs: self.longest_secs,
        }
    }
}

impl Pace {
    pub fn new(is_software: bool) -> Self {
        if is_software {
            Self { most_steps: MOST_STEPS_IN_SOFTWARE, steps_per_sec: FIRST_RATE_IN_SOFTWARE, tally: Tally::default() }
        } else {
            Self { most_steps: MOST_STEPS, steps_per_sec: FIRST_RATE, tally: Tally::default() }
        }
    }

    fn steps_per_slice(&self) -> f64 {
        self.steps_per_sec * SLICE.as_secs_f64()
    }

    /// Threads for one dispatch, each with a path.
    pub fn threads(&self) -> u32 {
        (self.steps_per_slice() / f64::from(USUAL_STEPS)) as u32
    }

    /// Steps for each of so many threads.
    pub fn steps(&self, threads: u32) -> u32 {
        ((self.steps_per_slice() / f64::from(threads.max(1))) as u32).clamp(LEAST_STEPS, self.most_steps)
    }

    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Takes note of the segments of paths that are at their ends.
    pub fn count_segments(&mut self, segments: u64) {
        self.tally.segments += segments;
    }

    /// Takes note of a dispatch that took so many steps together, and left so many paths to go on.
    pub fn learn(&mut self, steps: u64, open: u32, elapsed: Duration) {
        let secs = elapsed.as_secs_f64();
        self.tally.dispatches += 1;
        self.tally.steps += steps;
        self.tally.resumed += u64::from(open);
        self.tally.secs += secs;
        self.tally.longest_secs = self.tally.longest_secs.max(secs);
        let rate = steps as f64 / secs.max(1e-6);
        // By no more than twice at a time: the first dispatches of a shader are slow, and parts of an image differ.
        self.steps_per_sec = rate.clamp(0.5 * self.steps_per_sec, 2.0 * self.steps_per_sec).clamp(1e6, 1e13);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On devices of any speed, dispatches come to take the time of a slice, whether their threads are few or many.
    #[test]
    fn dispatches_take_the_time_of_a_slice() {
        for is_software in [false, true] {
            for steps_per_sec in [2e7, 1e9, 1e11] {
                let mut pace = Pace::new(is_software);
                for threads in [64, 5000, 1 << 20, 64] {
                    let mut last = (0, 0.0);
                    for _ in 0..30 {
                        let each = pace.steps(threads);
                        let all = u64::from(each) * u64::from(threads);
                        last = (each, all as f64 / steps_per_sec);
                        pace.learn(all, 0, Duration::from_secs_f64(last.1));
                    }
                    let (each, secs) = last;
                    assert!(each == LEAST_STEPS || secs < 1.2 * SLICE.as_secs_f64(), "{secs} s, {each} each");
                    assert!(each == pace.most_steps || secs > 0.8 * SLICE.as_secs_f64(), "{secs} s, {each} each");
                    let secs = f64::from(pace.threads()) * f64::from(USUAL_STEPS) / steps_per_sec;
                    assert!(secs < 1.2 * SLICE.as_secs_f64(), "{secs} s, {} threads", pace.threads());
                }
            }
        }
    }
}
