//! Cases 17 to 24: rays through concentric spheres, by Bouguer's invariant.

use super::closed_forms::{eaton, graded, luneburg, passage, wrapped};
use super::definition::{CaseDefinition, Measured, Subject, case, of_each};
use super::outcome::Measurement;
use super::scenes::{deflection_degrees, nest, ready, through};
use crate::tracking::Prepared;
use crate::transport::inspect::VertexEvent;

const BOUGUER: &str = "Bouguer's invariant n r sin i";

pub(super) const CASES: &[CaseDefinition] = &[
    case(17, "Ball of glass", BOUGUER, |subject| of_shells(subject, 1.0, &[(1.0, 1.5)], 1e-4)),
    case(18, "Nest of glass, water, air and diamond, total at 0.7", BOUGUER, |subject| {
        of_shells(subject, 1.0, &GLASS_WATER_AIR_DIAMOND, 1e-3)
    }),
    case(19, "Nest of ever denser media", BOUGUER, |subject| of_shells(subject, 1.0, &EVER_DENSER, 1e-3)),
    case(20, "Hollow ball, radii 1 and 0.9", BOUGUER, |subject| {
        of_shells(subject, 1.0, &[(1.0, 1.5), (0.9, 1.0)], 1e-3)
    }),
    case(21, "Bubble in a world of water, total at 0.9", BOUGUER, |subject| {
        of_shells(subject, 1.333, &[(1.0, 1.0)], 1e-3)
    }),
    case(22, "Shell of thickness 1e-6", BOUGUER, thin_shell),
    case(23, "Luneburg lens of 10, 100 and 1000 shells", BOUGUER, luneburg_lens),
    case(24, "Eaton lens of 1000 shells, n up to 63", BOUGUER, eaton_lens),
];

pub(super) const GLASS_WATER_AIR_DIAMOND: [(f64, f64); 4] = [(1.0, 1.5), (0.8, 1.333), (0.6, 1.0), (0.4, 2.417)];
pub(super) const EVER_DENSER: [(f64, f64); 5] = [(1.0, 1.31), (0.9, 1.333), (0.8, 1.5), (0.7, 1.7), (0.6, 2.417)];
pub(super) const HEIGHTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Deflection at `b` in every mode, NaN for a path that does not go through as many interfaces as it must, or that had events.
pub(super) fn deflections(
    subject: &Subject,
    scene: &Prepared,
    n0: f64,
    shells: &[(f64, f64)],
    b: f64,
    bound: f64,
) -> Measured {
    let expected = passage(n0, shells, b);
    subject.in_modes(|mode| {
        let path = through(scene, mode, b);
        let count = |event| path.vertices.iter().filter(|v| v.event == event).count();
        let is_as_foretold = count(VertexEvent::Transmit) == expected.crossings
            && (count(VertexEvent::TotalReflection) > 0) == expected.is_reflected;
        let is_sound = path.escaped && path.events.total() == 0 && (is_as_foretold || expected.is_marginal);
        // The same angle, written near the expected one.
        let measured = expected.degrees + wrapped(deflection_degrees(&path) - expected.degrees);
        let measured = if is_sound { measured } else { f64::NAN };
        let what = format!("deflection at b = {b}");
        Ok([Measurement::absolute(what, measured, expected.degrees, bound).in_unit("°")])
    })
}

fn of_shells(subject: &Subject, n0: f64, shells: &[(f64, f64)], bound: f64) -> Measured {
    let scene = ready(nest(n0, shells))?;
    of_each(HEIGHTS, |b| deflections(subject, &scene, n0, shells, b, bound))
}

fn thin_shell(subject: &Subject) -> Measured {
    let shells = [(1.0, 1.5), (1.0 - 1e-6, 1.0)];
    let scene = ready(nest(1.0, &shells))?;
    let mut found = deflections(subject, &scene, 1.0, &shells, 0.5, 2e-7f64.to_degrees())?;
    found.extend(subject.in_modes(|mode| {
        let hits = through(&scene, mode, 0.5).vertices.len();
        Ok([Measurement::absolute("hits", hits as f64, 4.0, 0.0)])
    })?);
    Ok(found)
}

fn luneburg_lens(subject: &Subject) -> Measured {
    of_each([10, 100, 1000], |count| {
        let shells = graded(count, luneburg);
        let scene = ready(nest(1.0, &shells))?;
        let mut found = of_each([0.25, 0.5], |b| deflections(subject, &scene, 1.0, &shells, b, 1e-3))?;
        found.iter_mut().for_each(|m| m.what = format!("{count} shells, {}", m.what));
        Ok(found)
    })
}

fn eaton_lens(subject: &Subject) -> Measured {
    let shells = graded(1000, eaton);
    deflections(subject, &ready(nest(1.0, &shells))?, 1.0, &shells, 0.5, 1e-2)
}
