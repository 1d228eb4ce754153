//! Errors of Fresnel's equations over index and angle, against 32 digits.
//!
//! Every formula gets the same numbers: indices and cosines are rounded to f32 first, which all can hold exactly, so that an error is one
//! of arithmetic and not of input. Light comes out of vacuum into n ≥ 1, or out of n into vacuum, as in scenes.

use super::definition::{Subject, Unmeasured};
use super::extended::{critical_cosine, fresnel};
use super::formula::{Evaluated, Formula};
use super::outcome::Map;

/// c²/b² up to which an angle is far from the critical one.
const WELL_CONDITIONED: f64 = 10.0;

struct Grid {
    /// (m1, m2): index minus one before and behind.
    pairs: Vec<[f64; 2]>,
    row_parameter: &'static str,
    rows: Vec<f64>,
    /// Cosine at a row and a column.
    cosine: fn(f64, [f64; 2]) -> Option<f64>,
}

fn eta([m1, m2]: [f64; 2]) -> f64 {
    (1.0 + m2) / (1.0 + m1)
}

/// Powers of ten between these, ends included.
fn powers(decades: std::ops::RangeInclusive<i32>, per_decade: i32) -> impl Iterator<Item = f64> {
    let steps = decades.start() * per_decade..=decades.end() * per_decade;
    steps.map(move |k| 10f64.powf(f64::from(k) / f64::from(per_decade)))
}

/// From 1000:1 to 1:1000, and as near to 1 as 1 ± 1e-7, where f32 has its first steps.
fn pairs(per_decade: i32) -> Vec<[f64; 2]> {
    let near = powers(-7..=0, per_decade).map(|x| 1.0 + x);
    let far = powers(0..=3, per_decade).filter(|n| *n > 2.0);
    let indices: Vec<f64> = near.chain(far).map(|n| f64::from(n as f32) - 1.0).collect();
    let mut pairs: Vec<_> = indices.iter().rev().map(|&m| [m, 0.0]).collect();
    pairs.push([0.0, 0.0]);
    pairs.extend(indices.iter().map(|&m| [0.0, m]));
    pairs.dedup();
    pairs
}

/// Error of one quantity; `None` where both say that reflection is total.
fn relative_error(is_reflectance: bool, truth: &Evaluated, evaluated: &Evaluated) -> Option<f64> {
    let (expected, measured) = if is_reflectance {
        (truth.reflectance, evaluated.reflectance)
    } else {
        (truth.transmittance, evaluated.transmittance)
    };
    match (truth.is_total, evaluated.is_total) {
        (true, true) => None,
        (true, false) if !is_reflectance => Some(1.0),
        _ if measured == expected => Some(0.0),
        // Nothing is reflected between equal media: any reflection is infinitely too much, and is shown as all of it.
        _ if expected == 0.0 => Some(1.0),
        _ => Some((measured / expected - 1.0).abs()),
    }
}

fn map(subject: &Subject, formula: Formula, grid: &Grid, is_reflectance: bool) -> Result<Map, Unmeasured> {
    let (mut wrong_decisions, mut worst, mut worst_well_conditioned) = (0, 0.0f64, 0.0f64);
    let mut relative_errors = Vec::new();
    for &row in &grid.rows {
        subject.go_on()?;
        let mut of_pair = |pair: &[f64; 2]| {
            let [m1, m2] = *pair;
            let c = (grid.cosine)(row, *pair)?;
            let (truth, evaluated) = (fresnel(m1, m2, c), formula.evaluate(m1, m2, c));
            wrong_decisions += usize::from(truth.is_total != evaluated.is_total);
            let error = relative_error(is_reflectance, &truth, &evaluated)?;
            worst = worst.max(error);
            if truth.condition(m1, m2, c) < WELL_CONDITIONED {
                worst_well_conditioned = worst_well_conditioned.max(error);
            }
            Some(error)
        };
        relative_errors.push(grid.pairs.iter().map(&mut of_pair).collect());
    }
    Ok(Map {
        quantity: if is_reflectance { "reflectance" } else { "transmittance" }.to_owned(),
        formula: formula.name().to_owned(),
        etas: grid.pairs.iter().map(|pair| eta(*pair)).collect(),
        row_parameter: grid.row_parameter.to_owned(),
        rows: grid.rows.clone(),
        relative_errors,
        wrong_decisions,
        worst,
        worst_well_conditioned,
    })
}

/// Reflectance and transmittance by every [`Formula`], over all angles and just inside the critical one. `None` when cancelled.
pub fn maps(subject: &Subject) -> Option<Vec<Map>> {
    let per_decade = subject.amount(5, 10);
    let rows: Vec<f64> = powers(-7..=0, per_decade).collect();
    let all_angles = Grid {
        pairs: pairs(per_decade),
        row_parameter: "cos θi",
        rows: rows.clone(),
        cosine: |c, _| Some(f64::from(c as f32)),
    };
    // Where light leaves a denser medium.
    let near_critical = Grid {
        pairs: pairs(per_decade).into_iter().filter(|pair| eta(*pair) < 1.0).collect(),
        row_parameter: "cos θi / cos θc − 1",
        rows,
        cosine: |offset, [m1, m2]| {
            let c = f64::from((critical_cosine(m1, m2)? * (1.0 + offset)) as f32);
            (c <= 1.0).then_some(c)
        },
    };
    let mut maps = Vec::new();
    for grid in [all_angles, near_critical] {
        for formula in Formula::ALL {
            for is_reflectance in [true, false] {
                maps.push(map(subject, formula, &grid, is_reflectance).ok()?);
            }
        }
    }
    Some(maps)
}
