//! The scale of an IOR control: which place on the rail stands for which index, and the media that are marked on it.

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use crate::app::objects::{decade, rounded};
use crate::optics::ior::IOR_RANGE;
use crate::optics::{Ior, catalog};

/// Indices and their places in [0, 1]: liquids and glasses, between 1.3 and 1.6, have more than half of the rail.
const KNOTS: [[f64; 2]; 4] = [[1.0, 0.0], [1.3, 0.17], [1.6, 0.72], [2.5, 1.0]];
/// Share of the rail that is added on a side where an index lies outside of [`KNOTS`].
const MARGIN: f64 = 0.2;
/// Ends of the rail beyond [`KNOTS`], of which the first beyond the index is taken.
const LOWER_ENDS: [f64; 4] = [0.5, 0.1, 1e-3, *IOR_RANGE.start()];
const UPPER_ENDS: [f64; 5] = [4.0, 10.0, 100.0, 1e4, *IOR_RANGE.end()];
/// The finest step of a free drag between the ends of [`KNOTS`].
const STEP: f64 = 0.001;

/// Straight lines between pairs of index and place, both rising.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rail {
    knots: [[f64; 2]; 6],
}

impl Rail {
    /// From 1 to 2.5, or further where `n` is outside.
    pub fn around(n: f64) -> Self {
        let [first, .., last] = KNOTS;
        let below = || LOWER_ENDS.into_iter().find(|end| *end < n).unwrap_or(LOWER_ENDS[3]);
        let above = || UPPER_ENDS.into_iter().find(|end| *end > n).unwrap_or(UPPER_ENDS[4]);
        let (lower, upper) = ((n < first[0]).then(below), (n > last[0]).then(above));
        let begin = if lower.is_some() { MARGIN } else { 0.0 };
        let end = if upper.is_some() { 1.0 - MARGIN } else { 1.0 };
        let placed = |[n, place]: [f64; 2]| [n, begin + place * (end - begin)];
        let [a, b, c, d] = KNOTS.map(placed);
        // Where nothing is added, the ends stand twice.
        Self { knots: [lower.map_or(a, |n| [n, 0.0]), a, b, c, d, upper.map_or(d, |n| [n, 1.0])] }
    }

    pub fn range(&self) -> RangeInclusive<f64> {
        self.knots[0][0]..=self.knots[5][0]
    }

    /// The place of an index in [0, 1]; those outside are at the ends.
    pub fn place(&self, n: f64) -> f64 {
        let n = n.clamp(*self.range().start(), *self.range().end());
        let [from, to] = self.piece(|[index, _]| n <= index);
        interpolate([from[0], to[0]], [from[1], to[1]], n)
    }

    /// The index at a place; beyond the ends, that of the end.
    pub fn ior_at(&self, place: f64) -> f64 {
        let place = place.clamp(0.0, 1.0);
        let [from, to] = self.piece(|[_, at]| place <= at);
        interpolate([from[1], to[1]], [from[0], to[0]], place)
    }

    /// [`Self::ior_at`], rounded to what a step of `share` of the rail can tell apart.
    pub fn rounded_ior_at(&self, place: f64, share: f64) -> f64 {
        let [from, to] = self.piece(|[_, at]| place.clamp(0.0, 1.0) <= at);
        let slope = (to[0] - from[0]) / (to[1] - from[1]).max(1e-9);
        let step = decade(slope * share);
        let is_inside = from[0] >= KNOTS[0][0] && to[0] <= KNOTS[3][0];
        let n = rounded(self.ior_at(place), if is_inside { step.min(STEP) } else { step });
        n.clamp(*self.range().start(), *self.range().end())
    }

    /// Indices to be written under the rail.
    pub fn numbers(&self) -> Vec<f64> {
        let inside = [1.0, 1.3, 1.4, 1.5, 1.6, 2.0, 2.5];
        let (low, high) = (*self.range().start(), *self.range().end());
        let ends = [low, high].into_iter().filter(|n| !(KNOTS[0][0]..=KNOTS[3][0]).contains(n));
        inside.into_iter().chain(ends).collect()
    }

    /// The first piece of the line whose end is not before what is looked for.
    fn piece(&self, is_before_end: impl Fn([f64; 2]) -> bool) -> [[f64; 2]; 2] {
        let end = (1..5).find(|&end| self.knots[end][0] > self.knots[end - 1][0] && is_before_end(self.knots[end]));
        // Of the last two pieces the last one may be empty.
        let end = end.unwrap_or(if self.knots[5] == self.knots[4] { 4 } else { 5 });
        [self.knots[end - 1], self.knots[end]]
    }
}

fn interpolate(from: [f64; 2], to: [f64; 2], x: f64) -> f64 {
    let share = ((x - from[0]) / (from[1] - from[0])).clamp(0.0, 1.0);
    // Exact at both ends.
    if share == 1.0 { to[1] } else { to[0] + share * (to[1] - to[0]) }
}

/// A medium that is marked on rails.
#[derive(Debug, PartialEq)]
pub struct Tick {
    /// A short name.
    pub name: String,
    /// For people, in full.
    pub label: &'static str,
    pub ior: f64,
    /// What a medium becomes that is put there.
    pub model: Ior,
    /// Ticks of low numbers have their names written first.
    pub rank: usize,
}

/// The media that are named first, where there is no room for all.
const RANKS: [&str; 11] =
    ["water", "n-bk7", "diamond", "air", "ice", "sapphire", "pmma", "fused-silica", "ethanol", "glycerol", "p-sf68"];

static TICKS: LazyLock<Vec<Tick>> = LazyLock::new(|| {
    let vacuum =
        Tick { name: "vacuum".to_owned(), label: "Vacuum", ior: 1.0, model: Ior::Constant(1.0), rank: RANKS.len() };
    let mut ticks = vec![vacuum];
    for entry in catalog::ALL {
        // Not a second name for the same thing.
        if ticks.iter().any(|tick| matches!(tick.model, Ior::Catalog(other) if other.model == entry.model)) {
            continue;
        }
        let rank = RANKS.iter().position(|name| *name == entry.name).unwrap_or(RANKS.len());
        ticks.push(Tick {
            name: short_name(entry.name),
            label: entry.label,
            ior: entry.ior(),
            model: Ior::Catalog(entry),
            rank,
        });
    }
    ticks.sort_by(|a, b| a.ior.total_cmp(&b.ior));
    ticks
});

/// All ticks, by rising index.
pub fn ticks() -> &'static [Tick] {
    &TICKS
}

/// The name of a medium of the catalogue where there is little room.
pub fn short_name(name: &str) -> String {
    match name {
        "n-bk7" => "BK7".to_owned(),
        "pmma" => "acrylic".to_owned(),
        "fused-silica" => "silica".to_owned(),
        _ if name.contains(|c: char| c.is_ascii_digit()) => name.to_uppercase(),
        _ => name.replace('-', " "),
    }
}

/// The tick nearest to a place, if it is within `reach` of it.
pub fn tick_near(rail: &Rail, place: f64, reach: f64) -> Option<&'static Tick> {
    let distance = |tick: &Tick| (rail.place(tick.ior) - place).abs();
    let is_on_rail = |tick: &&Tick| rail.range().contains(&tick.ior);
    let nearest = ticks().iter().filter(is_on_rail).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(nearest) <= reach).then_some(nearest)
}

/// The next tick above or below an index.
pub fn next_tick(n: f64, is_above: bool) -> Option<&'static Tick> {
    const SAME: f64 = 1e-9;
    if is_above {
        ticks().iter().find(|tick| tick.ior > n + SAME)
    } else {
        ticks().iter().rev().find(|tick| tick.ior < n - SAME)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_indices_are_each_others_inverse() {
        for around in [1e-6, 0.003, 0.7, 1.0, 1.5, 2.5, 2.6, 50.0, 1e6] {
            let rail = Rail::around(around);
            assert!(rail.range().contains(&around) && rail.range().contains(&1.0) && rail.range().contains(&2.5));
            let mut last = f64::NEG_INFINITY;
            for step in 0..=1000 {
                let place = f64::from(step) / 1000.0;
                let n = rail.ior_at(place);
                assert!(n > last, "the rail of {around} does not rise at {place}");
                assert!((rail.place(n) - place).abs() < 1e-9, "{around}: {place} is {n} is {}", rail.place(n));
                last = n;
            }
            assert_eq!([rail.ior_at(-1.0), rail.ior_at(2.0)], [*rail.range().start(), *rail.range().end()]);
        }
        assert_eq!(Rail::around(1.0).range(), 1.0..=2.5);
        assert_eq!(Rail::around(2.5).range(), 1.0..=2.5);
        assert_eq!(Rail::around(3.0).range(), 1.0..=4.0);
        assert_eq!(Rail::around(0.9).range(), 0.5..=2.5);
    }

    #[test]
    fn ice_and_water_stand_apart() {
        // On a rail of 250 points, by more than the reach of snapping.
        let rail = Rail::around(1.333);
        assert!((rail.place(1.3334) - rail.place(1.3097)) * 250.0 > 10.0);
    }

    #[test]
    fn ticks_rise_and_are_found() {
        assert!(ticks().windows(2).all(|pair| pair[0].ior < pair[1].ior));
        let rail = Rail::around(1.5);
        for tick in ticks() {
            let found = tick_near(&rail, rail.place(tick.ior), 0.001).unwrap();
            assert!((found.ior - tick.ior).abs() < 1e-3, "{}", tick.name);
        }
        assert!(tick_near(&rail, rail.place(1.2), 0.01).is_none());
        assert_eq!(next_tick(1.32, true).unwrap().name, "water");
        assert_eq!(next_tick(1.32, false).unwrap().name, "ice");
        assert_eq!(next_tick(next_tick(1.32, true).unwrap().ior, false).unwrap().name, "ice");
        assert!(next_tick(1.0, false).is_none() && next_tick(3.0, true).is_none());
    }

    #[test]
    fn free_values_are_short_and_on_the_rail() {
        let rail = Rail::around(1.5);
        assert_eq!(rail.rounded_ior_at(rail.place(1.512_345), 1.0 / 300.0), 1.512);
        assert_eq!(rail.rounded_ior_at(rail.place(1.512_345), 0.05 / 300.0), 1.51235);
        for around in [1e-6, 0.5, 1.0, 1e6] {
            let rail = Rail::around(around);
            for step in -5..=105 {
                assert!(rail.range().contains(&rail.rounded_ior_at(f64::from(step) / 100.0, 0.01)));
            }
        }
    }
}
