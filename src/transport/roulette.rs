//! Russian roulette: paths that bring little are ended at random, and survivors stand for those that were.

use super::dimension;
use super::sampler::Sampler;
use crate::spectrum::Spectrum;

/// Segments after which Russian roulette looks at the throughput.
const FROM: u32 = 4;
/// Share of the throughput at the first diffuse vertex below which paths are ended at random. What such a path still brings counts against
/// what its pixel shows, so a dark surface seen directly is no reason to end it; at that share the noise of ending it is small.
const SHARE: f64 = 0.25;
/// Segments after which every path may be ended whatever its throughput, or trapped lossless paths would never end.
const LONG_PATH: u32 = 64;

/// Probability of going on from a segment beyond [`LONG_PATH`]. It starts at 0.95 and rises, so that the chance of lasting k segments
/// more falls as 1/k and the weight of those that do grows no faster than k. With a constant 0.95 that weight grows exponentially: the
/// paths through hundreds of interfaces, which do arrive, would be too rare to find, and the few that are caught between facets for
/// thousands of segments would come back as fireflies. From the ten thousandth on it is constant, which bounds the time of one path;
/// a trapped path lasts some 140 segments more in the mean.
#[inline]
fn survival_of_long_path(segment: u32) -> f64 {
    (1.0 - 1.0 / (f64::from(segment - LONG_PATH) + 19.0)).min(0.9999)
}

/// What a path's throughput is compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roulette {
    /// Throughput below which a path may be ended.
    below: f64,
}

impl Default for Roulette {
    /// For paths that begin with a throughput of 1.
    fn default() -> Self {
        Self { below: SHARE }
    }
}

impl Roulette {
    /// For a path that has this `throughput`, largest component, where it first scatters.
    pub fn after_first_scatter(throughput: f64) -> Self {
        Self { below: SHARE * throughput }
    }

    /// The probability with which a path has survived, which its throughput is to be divided by; `None` where it ends. `segment` is the number of
    /// the next segment, from 1, and the random number is that of the block that begins at `dimensions`.
    #[inline]
    pub fn survival(&self, throughput: Spectrum, segment: u32, sampler: &Sampler, dimensions: u32) -> Option<f64> {
        if segment <= FROM {
            return Some(1.0);
        }
        let mut survival = (throughput.max_component() / self.below).min(1.0);
        if segment > LONG_PATH {
            survival = survival.min(survival_of_long_path(segment));
        }
        if survival < 1.0 && sampler.get_1d(dimensions + dimension::ROULETTE) >= survival {
            return None;
        }
        Some(survival)
    }
}
