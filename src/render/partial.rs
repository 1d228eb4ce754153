//! A part of an image: the samples of some ranges of the sequence, which can be put together with others of the same image.

use std::fmt;

use super::exact::ExactSums;
use super::film::{Film, capped};
use super::settings::ImageSettings;
use crate::scene::Fingerprint;
use crate::tracking::Events;

/// Indices of samples, from the first up to but without the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct SampleRange(pub u32, pub u32);

impl SampleRange {
    /// How many there are.
    pub fn count(self) -> u32 {
        self.1.saturating_sub(self.0)
    }
}

impl fmt::Display for SampleRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.0, self.1)
    }
}

/// What decides which sample has which radiance. Parts can be put together where all of it is equal, but for the names.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Recipe {
    /// Of the program.
    pub version: String,
    /// For people: it decides nothing.
    pub scene: String,
    /// Of all that can be seen: contents of meshes and images, not names.
    pub content: Fingerprint,
    pub camera: Fingerprint,
    /// The graphics processors that took samples, if any did. For people: it decides nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    pub width: u32,
    pub height: u32,
    #[serde(flatten)]
    pub settings: ImageSettings,
    /// The unit of the sums is 2 to the power of this.
    pub unit_exponent: i32,
}

impl Recipe {
    /// # Errors
    /// When the other's samples are of another image: the first field that differs.
    pub fn require_same_image(&self, other: &Self) -> Result<(), CannotMerge> {
        // Taken apart so that no field can be forgotten.
        let fields = |recipe: &Self| {
            let Self { version, scene: _, content, camera, adapter: _, width, height, settings, unit_exponent } =
                recipe;
            let mut fields = vec![
                ("iorect's version", version.clone()),
                ("the scene's content", content.short()),
                ("the camera", camera.short()),
                ("the size", format!("{width}×{height}")),
            ];
            fields.extend(settings.named());
            fields.push(("the unit of the sums", format!("2^{unit_exponent}")));
            fields
        };
        match fields(self).into_iter().zip(fields(other)).find(|((_, here), (_, there))| here != there) {
            Some(((field, here), (_, there))) => Err(CannotMerge::Differs { field, here, there }),
            None => Ok(()),
        }
    }
}

/// Sums and counts of some samples of an image, without rounding.
#[derive(Debug, Clone, PartialEq)]
pub struct Partial {
    pub recipe: Recipe,
    /// In ascending order, apart from each other: what touches is one.
    pub ranges: Vec<SampleRange>,
    pub events: Events,
    /// Of each pixel, row 0 at the top.
    pub sums: ExactSums,
    /// Samples in each pixel's sum: fewer than the ranges have where some were not finite.
    pub counts: Vec<u32>,
}

/// Parts that do not belong together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CannotMerge {
    /// Other samples of another image.
    #[error("{field} differs: {here} here, {there} there")]
    Differs {
        /// In words.
        field: &'static str,
        here: String,
        there: String,
    },
    /// Samples that would be counted twice.
    #[error("the samples {0} are in both; each may be counted once only")]
    Overlap(SampleRange),
}

impl Partial {
    /// What an image with exact sums has so far; `None` where `film` has none.
    pub fn of_film(film: Film, recipe: Recipe) -> Option<Self> {
        let ranges = vec![SampleRange(film.first, film.first + film.samples)];
        Some(Self { recipe, ranges, events: film.events, sums: film.exact?, counts: film.counts })
    }

    /// Samples of every pixel, finite or not.
    pub fn samples(&self) -> u32 {
        self.ranges.iter().map(|range| range.count()).sum()
    }

    /// What lies between the ranges.
    pub fn gaps(&self) -> Vec<SampleRange> {
        self.ranges.windows(2).map(|pair| SampleRange(pair[0].1, pair[1].0)).collect()
    }

    /// Mean radiance of all pixels.
    pub fn to_rgb(&self) -> Vec<[f32; 3]> {
        let mean = |pixel: usize| capped(self.sums.mean(pixel, self.counts[pixel]));
        (0..self.counts.len()).map(mean).collect()
    }

    /// Adds the samples of `other`. The result is the same to the bit in whatever order and grouping parts are added, and as if all had
    /// been rendered at once. The name is that of the part with the earlier samples.
    ///
    /// # Errors
    /// When they are not of one image, or share samples. `self` is then unchanged.
    pub fn add(&mut self, other: &Self) -> Result<(), CannotMerge> {
        self.recipe.require_same_image(&other.recipe)?;
        if let Some(shared) = shared(&self.ranges, &other.ranges) {
            return Err(CannotMerge::Overlap(shared));
        }
        if other.ranges < self.ranges {
            self.recipe.scene.clone_from(&other.recipe.scene);
        }
        self.ranges = union(&self.ranges, &other.ranges);
        self.events += other.events;
        for (to, from) in self.sums.sums.iter_mut().zip(&other.sums.sums) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        }
        self.counts.iter_mut().zip(&other.counts).for_each(|(to, from)| *to += from);
        Ok(())
    }
}

/// Samples that are in both.
fn shared(a: &[SampleRange], b: &[SampleRange]) -> Option<SampleRange> {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| SampleRange(a.0.max(b.0), a.1.min(b.1))));
    pairs.into_iter().find(|shared| shared.count() > 0)
}

/// Both, in ascending order, those that touch as one.
fn union(a: &[SampleRange], b: &[SampleRange]) -> Vec<SampleRange> {
    let mut all: Vec<SampleRange> = a.iter().chain(b).copied().collect();
    all.sort();
    let mut joined: Vec<SampleRange> = Vec::new();
    for range in all {
        match joined.last_mut() {
            Some(last) if last.1 == range.0 => last.1 = range.1,
            _ => joined.push(range),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_that_touch_become_one() {
        let r = SampleRange;
        assert_eq!(union(&[r(0, 4), r(8, 9)], &[r(4, 8)]), [r(0, 9)]);
        assert_eq!(union(&[r(10, 12)], &[r(0, 3), r(3, 5)]), [r(0, 5), r(10, 12)]);
        assert_eq!(shared(&[r(0, 4), r(8, 9)], &[r(4, 8), r(9, 20)]), None);
        assert_eq!(shared(&[r(0, 4), r(8, 12)], &[r(4, 10)]), Some(r(8, 10)));
    }
}
