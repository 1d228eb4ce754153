//! Indices that look like ratios of two: some renderers want the IOR of a surface, n inside over n outside. Here every medium has its own,
//! and is rendered wrong, silently, if it is given by a ratio.

use std::collections::{BTreeMap, BTreeSet};

use super::Problem;
use super::names::brief;
use crate::optics::Ior;
use crate::rectify::containment::medium_of;
use crate::scene::{MediumId, Scene};
use crate::tracking::Prepared;

/// Least index of a real medium: n − 1 is positive at visible wavelengths; the margin is for rounding.
const LEAST: f64 = 1.0 - 1e-4;
/// Indices between gases and liquids, which hardly any medium has and ratios often have.
const RATIOS: std::ops::Range<f64> = 1.02..1.25;
/// Relative difference of an index and a ratio that was rounded to four digits.
const ROUNDED: f64 = 2e-4;
/// In scenes of more media than this, one in the range of ratios is equal to the ratio of two others by chance.
const MOST_MEDIA: usize = 12;
/// Indices that people type, for media that need not be in the scene.
const USUAL: [(&str, f64); 5] = [("air", 1.0), ("water", 1.33), ("water", 1.333), ("glass", 1.5), ("glass", 1.52)];

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let neighbours = neighbours(prepared);
    let known = Known::new(prepared, neighbours.keys().copied());
    (neighbours.iter())
        .filter_map(|(&medium, others)| {
            let value = given(prepared, medium)?;
            // Between two media, one of them the world's vacuum, the ratio and the index are the same thing.
            let is_nested = others.iter().any(|other| scene.medium(*other).ior_minus_one != 0.0);
            let name = &scene.medium(medium).name;
            if !is_nested {
                None
            } else if value < LEAST {
                Some(Problem::warning(
                    name,
                    "ratio_index",
                    below_one(value, known.explanation(scene, medium, value, others)),
                ))
            } else if RATIOS.contains(&value) && known.count <= MOST_MEDIA {
                let explanation = known.explanation(scene, medium, value, others)?;
                Some(Problem::advice(name, "ratio_index", above_one(value, &explanation)))
            } else {
                None
            }
        })
        .collect()
}

/// The media that each medium of a refractor has a surface with.
fn neighbours(prepared: &Prepared) -> BTreeMap<MediumId, BTreeSet<MediumId>> {
    let scene = &*prepared.scene;
    let mut found: BTreeMap<MediumId, BTreeSet<MediumId>> = BTreeMap::new();
    let mut add = |a: MediumId, b: MediumId| {
        if a != b {
            found.entry(a).or_default().insert(b);
            found.entry(b).or_default().insert(a);
        }
    };
    for patch in &prepared.table.patches {
        if let (Some(outside), Some(inside)) = (patch.outside, patch.inside) {
            add(outside, inside);
        }
        let own = medium_of(scene, Some(patch.refractor));
        patch.crossed_by.iter().for_each(|&other| add(own, medium_of(scene, Some(other))));
    }
    found.remove(&MediumId::WORLD);
    found
}

/// The index of a medium that was given by a number.
fn given(prepared: &Prepared, medium: MediumId) -> Option<f64> {
    // The media of a scene come after the global medium and the reserved one.
    let index = (medium.0 as usize).checked_sub(2)?;
    match prepared.description.media.get(index)?.ior {
        Ior::Constant(value) => Some(value),
        _ => None,
    }
}

/// Why an index is what it is: `inner` over `outer`.
struct Explanation {
    /// Name and index, of a medium in the scene or else of one in [`USUAL`].
    inner: (String, f64),
    outer: (String, f64),
}

/// Indices by value.
struct Known {
    /// Ascending; with the name of a medium, or `None` and one of [`USUAL`].
    by_value: Vec<(f64, Option<MediumId>, &'static str)>,
    /// Media in use.
    count: usize,
}

impl Known {
    fn new(prepared: &Prepared, media: impl Iterator<Item = MediumId>) -> Self {
        let scene = &*prepared.scene;
        let mut by_value: Vec<_> = media.map(|medium| (scene.medium(medium).ior(), Some(medium), "")).collect();
        let count = by_value.len();
        by_value.push((scene.medium(MediumId::WORLD).ior(), Some(MediumId::WORLD), ""));
        by_value.extend(USUAL.map(|(name, ior)| (ior, None, name)));
        by_value.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { by_value, count }
    }

    /// The nearest ratio, within rounding, that `value` may be: of a medium in the scene, or a usual one, to a neighbour.
    fn explanation(
        &self,
        scene: &Scene,
        medium: MediumId,
        value: f64,
        neighbours: &BTreeSet<MediumId>,
    ) -> Option<Explanation> {
        /// Media of about the same index that are looked at.
        const MOST: usize = 16;
        let mut best: Option<(f64, Explanation)> = None;
        // A ratio to vacuum is the index itself.
        for &neighbour in neighbours.iter().filter(|id| scene.medium(**id).ior_minus_one != 0.0) {
            let outer = scene.medium(neighbour);
            let inner = value * outer.ior();
            let from = self.by_value.partition_point(|known| known.0 < inner * (1.0 - ROUNDED));
            let near = self.by_value[from..].iter().take_while(|known| known.0 <= inner * (1.0 + ROUNDED)).take(MOST);
            for &(ior, id, usual) in near.filter(|known| known.1 != Some(medium) && known.1 != Some(neighbour)) {
                // What is usual is a guess: media of the scene come first.
                let distance = (ior / inner - 1.0).abs() + if id.is_none() { ROUNDED } else { 0.0 };
                if best.as_ref().is_none_or(|best| distance < best.0) {
                    let name = id.map_or(usual.to_owned(), |id| scene.medium(id).name.clone());
                    let explanation = Explanation { inner: (name, ior), outer: (outer.name.clone(), outer.ior()) };
                    best = Some((distance, explanation));
                }
            }
        }
        best.map(|(_, explanation)| explanation)
    }
}

fn below_one(value: f64, explanation: Option<Explanation>) -> String {
    let value = brief(value, 6);
    let start =
        format!("its index is {value}, and no medium's own index is below 1 at visible wavelengths (vacuum has 1)");
    match explanation {
        Some(e) => format!("{start}. {}", advice(&e)),
        None => format!(
            "{start}: it looks like the ratio of what is inside to what is outside. Give the medium's own index"
        ),
    }
}

fn above_one(value: f64, explanation: &Explanation) -> String {
    let (value, advice) = (brief(value, 6), advice(explanation));
    format!("its index, {value}, is that of no liquid or solid but some foams. {advice}, unless it is meant")
}

fn advice(Explanation { inner, outer }: &Explanation) -> String {
    let (own, around) = (brief(inner.1, 6), brief(outer.1, 6));
    let (inner, outer) = (&inner.0, &outer.0);
    format!(
        "It looks like the ratio {own}/{around} of `{inner}` to `{outer}`: give the medium's own index, here {own}, and that of what is \
         around is found"
    )
}
