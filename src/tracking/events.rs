//! What went wrong along the way, counted and shown, never hidden.

use std::ops::AddAssign;

/// Counts over all paths of a render. All zero where a mode is right for a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Events {
    /// Exits with nothing to pop.
    pub stack_underflow: u64,
    /// Entries with no room to push.
    pub stack_overflow: u64,
    /// Containment questions whose voting rays did not agree.
    pub ambiguous: u64,
    /// Crossings that leave another medium than the one the path was in.
    pub inconsistent: u64,
    /// Samples that came out NaN or infinite; they are left out of the film's mean.
    pub non_finite: u64,
    /// Samples of more radiance than the f32 of pictures and EXR files hold, 3.4e38. They are kept; a pixel whose mean is beyond that is
    /// capped where it becomes f32.
    pub radiance_overflow: u64,
    /// Crossings of refractors' surfaces in all: no event, but what others are a share of.
    pub crossings: u64,
    /// Of these, crossings of faces whose surroundings differ from place to place; `rectified` counts them.
    pub mixed: u64,
}

impl Events {
    /// Each count with its name, as in JSON.
    pub fn named(&self) -> [(&'static str, u64); 6] {
        [
            ("stack_underflow", self.stack_underflow),
            ("stack_overflow", self.stack_overflow),
            ("ambiguous", self.ambiguous),
            ("inconsistent", self.inconsistent),
            ("non_finite", self.non_finite),
            ("radiance_overflow", self.radiance_overflow),
        ]
    }

    /// Share of the crossings that were of mixed faces; `None` where there were no crossings.
    pub fn mixed_share(&self) -> Option<f64> {
        (self.crossings > 0).then(|| self.mixed as f64 / self.crossings as f64)
    }

    pub fn total(&self) -> u64 {
        self.named().iter().map(|(_, count)| count).sum()
    }
}

impl AddAssign for Events {
    fn add_assign(&mut self, other: Self) {
        self.stack_underflow += other.stack_underflow;
        self.stack_overflow += other.stack_overflow;
        self.ambiguous += other.ambiguous;
        self.inconsistent += other.inconsistent;
        self.non_finite += other.non_finite;
        self.radiance_overflow += other.radiance_overflow;
        self.crossings += other.crossings;
        self.mixed += other.mixed;
    }
}
