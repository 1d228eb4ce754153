//! Random meshes of several parts, made by `common::meshes`: `rectified`, `reference` and a truth worked out apart, from the parts that the
//! meshes are made of, agree on every well-conditioned ray.
//!
//! - `IORECT_MESHES=N` sets how many meshes are tried; 10,000 take some minutes. The seeds go on from those of the default run.
//! - `IORECT_CLASS=corner_touch` tries one class only; its name is that of a [`Class`] in small letters.
//! - `IORECT_MODE=reference` asks one mode only.
//! - `IORECT_SEED=N` tries one seed, as a failure names it, and says more.

use std::collections::BTreeMap;

use crate::common::meshes::{Case, Class};
use crate::common::ready;
use crate::common::truth::{Survey, is_above, survey};
use iorect::tracking::Mode;
use rayon::prelude::*;

/// Meshes in the default run.
const MESHES: usize = 320;
/// Rays for each mesh.
const RAYS: usize = 12;

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// Seeds with their classes.
fn cases() -> Vec<(u64, Class)> {
    let number =
        |name: &str| variable(name).map(|text| text.parse::<u64>().unwrap_or_else(|_| panic!("{name} is a number")));
    let classes: Vec<Class> = match variable("IORECT_CLASS") {
        Some(name) => {
            let valid: Vec<String> = Class::ALL.into_iter().map(Class::name).collect();
            let class = Class::ALL.into_iter().find(|class| class.name() == name);
            vec![class.unwrap_or_else(|| panic!("no class `{name}`; valid: {}", valid.join(", ")))]
        }
        None => Class::ALL.to_vec(),
    };
    let count = number("IORECT_MESHES").unwrap_or(MESHES as u64);
    match number("IORECT_SEED") {
        Some(seed) => classes.into_iter().map(|class| (seed, class)).collect(),
        None => (0..count).map(|k| (k, classes[k as usize % classes.len()])).collect(),
    }
}

fn modes() -> Vec<Mode> {
    match variable("IORECT_MODE") {
        Some(name) => vec![name.parse().expect("IORECT_MODE is a mode")],
        None => vec![Mode::Reference, Mode::Rectified],
    }
}

/// What came of one mesh.
struct Outcome {
    seed: u64,
    class: Class,
    label: String,
    surveys: Vec<(Mode, Survey)>,
    /// Rays that found errors planted in the truth: a part that was forgotten, and the other rule for overlaps.
    of_forgotten: usize,
    of_wrong_rule: usize,
}

fn outcome(seed: u64, class: Class) -> Outcome {
    let case = Case::new(seed, class);
    let prepared = ready(case.description.clone());
    let origin = prepared.scene.geometry.origin;
    let truth = case.truth(origin);
    let rays = case.rays(&truth, RAYS, seed);
    let surveys = modes().into_iter().map(|mode| (mode, survey(&prepared, &truth, mode, &rays))).collect();
    let forgotten = case.truth_without(origin, Some(0));
    let of_forgotten = survey(&prepared, &forgotten, modes()[0], &rays).faults.len();
    let of_wrong_rule = survey(&prepared, &truth.with_top(|a, b| !is_above(a, b)), modes()[0], &rays).faults.len();
    Outcome { seed, class, label: case.to_string(), surveys, of_forgotten, of_wrong_rule }
}

#[test]
fn three_ways_to_ask_agree() {
    let cases = cases();
    let outcomes: Vec<Outcome> = cases.par_iter().map(|&(seed, class)| outcome(seed, class)).collect();
    // Faulty meshes of all, and vertices compared, by class and mode.
    let mut table: BTreeMap<(Class, &str), (usize, usize, usize)> = BTreeMap::new();
    let mut faults = Vec::new();
    for outcome in &outcomes {
        for (mode, survey) in &outcome.surveys {
            let row = table.entry((outcome.class, mode.name())).or_default();
            row.0 += usize::from(!survey.faults.is_empty());
            row.1 += 1;
            row.2 += survey.checked;
            if let Some(fault) = survey.faults.first() {
                faults.push(format!(
                    "IORECT_CLASS={} IORECT_SEED={} ({}): {} faults, first {fault}",
                    outcome.class.name(),
                    outcome.seed,
                    outcome.label,
                    survey.faults.len(),
                ));
            }
        }
    }
    for ((class, mode), (faulty, meshes, checked)) in &table {
        println!("{:16} {mode:10} {faulty:5} of {meshes:5} meshes, {checked} vertices", class.name());
    }
    if variable("IORECT_SEED").is_some() {
        outcomes.iter().for_each(|outcome| println!("{}: {:#?}", outcome.label, outcome.surveys));
    }
    let shown = &faults[..faults.len().min(12)];
    assert!(faults.is_empty(), "{} disagreements on {} meshes:\n{}", faults.len(), cases.len(), shown.join("\n"));
    let total = |count: fn(&Outcome) -> usize| outcomes.iter().map(count).sum::<usize>();
    let checked = total(|outcome| outcome.surveys.iter().map(|(_, survey)| survey.checked).sum());
    assert!(checked > 8 * cases.len() * modes().len(), "too little was compared: {checked}");
    if cases.len() >= MESHES {
        // Errors planted in the truth are seen.
        let (of_forgotten, of_wrong_rule) = (total(|o| o.of_forgotten), total(|o| o.of_wrong_rule));
        assert!(of_forgotten > cases.len() / 2, "a part that is forgotten is seen by {of_forgotten} rays");
        assert!(of_wrong_rule > cases.len() / 20, "a wrong rule is seen by {of_wrong_rule} rays");
    }
}
