//! How much is measured: as much as two minutes allow, or as is worth publishing.

use serde::Serialize;

use super::backends::BackendsPlan;
use super::editing::EditingPlan;
use super::estimators::EstimatorsPlan;
use super::experiment::Effort;
use super::first_look::{self, FirstLookPlan};
use super::growth::{GrowthPlan, Timing};
use super::left_out::LeftOutPlan;
use super::pictures::PicturePlan;
use super::stability;
use crate::render::BackendChoice;

/// Which of the stability checks are run, from the first on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StabilityPlan {
    pub effort: stability::Effort,
    pub cases: usize,
    pub sweeps: usize,
    pub has_maps: bool,
}

impl StabilityPlan {
    fn all(effort: stability::Effort) -> Self {
        Self { effort, cases: usize::MAX, sweeps: usize::MAX, has_maps: true }
    }
}

/// Pixels of one of four panes in a picture of 1280×720.
const PANE: [u32; 2] = [640, 360];

/// How much of each is measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Extent {
    pub is_quick: bool,
    pub pictures: PicturePlan,
    pub errors: Effort,
    pub stability: StabilityPlan,
    pub left_out: LeftOutPlan,
    pub editing: EditingPlan,
    pub first_look: FirstLookPlan,
    pub estimators: EstimatorsPlan,
    pub backends: BackendsPlan,
    pub growth: GrowthPlan,
}

/// Powers of two below `most`, and `most`.
fn doublings(most: usize) -> Vec<u64> {
    let most = most as u64;
    (0..).map(|k| 1_u64 << k).take_while(|&threads| threads < most).chain([most]).collect()
}

/// 1, 3, 10, 30, … from `first` to `last`, which are powers of ten or three times such.
fn half_decades(first: u64, last: u64) -> Vec<u64> {
    let sizes = (0..19).flat_map(|k| [1, 3].map(|digit| digit * 10_u64.pow(k)));
    sizes.filter(|size| (first..=last).contains(size)).collect()
}

/// Sizes of all quantities of [`GrowthPlan`], up to so many triangles and on up to so many threads.
fn sizes(triangles: u64, threads: usize) -> [Vec<u64>; 4] {
    [half_decades(1000, triangles), half_decades(1, 1000), half_decades(1, 10_000), doublings(threads)]
}

fn estimators(side: u32, secs: f64, seed: u64) -> EstimatorsPlan {
    EstimatorsPlan { size: [side; 2], runs: 3, secs, most_samples: 1 << 16, truth_factor: 4, seed }
}

fn backends(size: [u32; 2], slices: usize, slice_secs: f64, seed: u64) -> BackendsPlan {
    BackendsPlan { size, compared_size: [128; 2], compared_samples: 4, seed, slices, slice_secs }
}

impl Extent {
    /// All built-in scenes within two minutes on two cores.
    pub fn quick(seed: u64, threads: usize) -> Self {
        Self {
            is_quick: true,
            pictures: PicturePlan { width: 192, height: 108, samples: 16, seed, secs: 1.2 },
            errors: Effort { first_seed: seed, ..Effort::QUICK },
            stability: StabilityPlan::all(stability::Effort::Quick),
            left_out: LeftOutPlan { width: 96, height: 54, seed, pairs: 6, slice_secs: 0.02, each: false },
            editing: EditingPlan { size: PANE, edits: 3, within_secs: 0.1, backend: BackendChoice::Cpu },
            first_look: FirstLookPlan { size: [121, 108], converged_samples: 128, most_secs: 3.0, seed },
            estimators: EstimatorsPlan { runs: 2, ..estimators(64, 0.1, seed) },
            backends: backends([512; 2], 3, 0.1, seed),
            growth: GrowthPlan {
                sizes: sizes(1_000_000, threads),
                timing: Timing { side: 32, seed, slices: 3, slice_secs: 0.03 },
            },
        }
    }

    /// As much as is worth publishing.
    pub fn full(seed: u64, threads: usize) -> Self {
        Self {
            is_quick: false,
            pictures: PicturePlan { width: 384, height: 216, samples: 128, seed, secs: 30.0 },
            errors: Effort { first_seed: seed, ..Effort::FULL },
            stability: StabilityPlan::all(stability::Effort::Full),
            left_out: LeftOutPlan { width: 192, height: 108, seed, pairs: 15, slice_secs: 0.25, each: true },
            editing: EditingPlan { size: PANE, edits: 12, within_secs: 0.7, backend: BackendChoice::Cpu },
            first_look: FirstLookPlan { size: first_look::PANE, converged_samples: 256, most_secs: 600.0, seed },
            estimators: estimators(256, 4.0, seed),
            backends: backends([1024; 2], 7, 0.5, seed),
            growth: GrowthPlan {
                sizes: sizes(10_000_000, threads),
                timing: Timing { side: 64, seed, slices: 9, slice_secs: 0.2 },
            },
        }
    }

    /// As little as possible of everything, for tests.
    pub fn tiny(seed: u64, threads: usize) -> Self {
        let few: Vec<u64> = (0..6).map(|k| 1 << k).collect();
        Self {
            is_quick: true,
            // Time decides nothing here.
            pictures: PicturePlan { width: 32, height: 18, samples: 9, seed, secs: 1e9 },
            errors: Effort {
                size: [32, 20],
                seeds: 4,
                first_seed: seed,
                secs: 1e9,
                largest_spp: 32,
                reference_factor: 8,
                ..Effort::QUICK
            },
            stability: StabilityPlan { effort: stability::Effort::Quick, cases: 11, sweeps: 1, has_maps: false },
            left_out: LeftOutPlan { width: 16, height: 9, seed, pairs: 2, slice_secs: 1e-4, each: true },
            editing: EditingPlan { size: [32, 18], edits: 1, within_secs: 0.01, backend: BackendChoice::Cpu },
            first_look: FirstLookPlan { size: [24, 16], converged_samples: 64, most_secs: 1e9, seed },
            estimators: EstimatorsPlan { most_samples: 4, truth_factor: 1, secs: 1e9, ..estimators(12, 1.0, seed) },
            backends: BackendsPlan { compared_size: [8; 2], compared_samples: 1, ..backends([8; 2], 1, 1e-5, seed) },
            growth: GrowthPlan {
                sizes: [(0..6).map(|k| 500 << k).collect(), few.clone(), few, doublings(threads.min(2))],
                timing: Timing { side: 8, seed, slices: 1, slice_secs: 1e-5 },
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_grow_by_half_decades_and_threads_by_doublings() {
        assert_eq!(half_decades(1, 30), [1, 3, 10, 30]);
        assert_eq!(half_decades(1000, 10_000), [1000, 3000, 10_000]);
        assert_eq!(doublings(1), [1]);
        assert_eq!(doublings(2), [1, 2]);
        assert_eq!(doublings(12), [1, 2, 4, 8, 12]);
    }
}
