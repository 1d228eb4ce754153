//! Sweeps over indices, angles and absorption.

use super::closed_forms::{absorbing_slab, ball_deflection, bubble_deflection, reflectance};
use super::definition::{Measured, Subject, SweepDefinition, of_each, steps};
use super::extended::{critical_cosine, fresnel};
use super::harsh::matched_absorbers;
use super::outcome::{Measurement, Step};
use super::scenes::{block, layers, mean, nest, onto_block, ready, samples_of, through};
use crate::transport::inspect::{Follow, trace};

pub(super) const SWEEPS: &[SweepDefinition] = &[
    SweepDefinition {
        name: "Contrast",
        about: "A ball of index n in vacuum, and a bubble in a world of n: relative error of the deflection against 2 (asin b − asin(b/n)), \
                evaluated without cancellation.",
        parameter: "n − 1",
        measure: contrast,
    },
    SweepDefinition {
        name: "Grazing angles",
        about: "Rays onto a block: reflectance at the surface met, relative to Fresnel's equations with 32 digits.",
        parameter: "cosine of the angle of incidence",
        measure: grazing,
    },
    SweepDefinition {
        name: "Critical angles",
        about: "From a denser medium, so near to the critical angle: error of the transmittance inside it, in roundings of 2⁻⁵³ (1 + c²/b²), \
                which is what rounding the cosine alone does; and wrong decisions on either side.",
        parameter: "distance from the critical cosine, relative",
        measure: critical,
    },
    SweepDefinition {
        name: "Absorption",
        about: "Transmittance of a matched block of optical depth σd, relative to e^(−σd), and of a slab of glass, against the series of \
                its internal reflections.",
        parameter: "optical depth σd",
        measure: absorption,
    },
];

fn contrast(subject: &Subject) -> Measured<Step> {
    const B: f64 = 0.5;
    steps([1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.5, 1.0, 3.0, 9.0, 99.0, 999.0], |contrast| {
        // The scene holds n; n − 1 is what it then stands for.
        let n = 1.0 + contrast;
        let m = n - 1.0;
        let ball = ready(nest(1.0, &[(1.0, n)]))?;
        let bubble = ready(nest(n, &[(1.0, 1.0)]))?;
        let rows = [("ball", &ball, B, ball_deflection(m, B)), ("bubble", &bubble, B / n, bubble_deflection(m, B / n))];
        subject.in_modes(|mode| {
            Ok(rows.map(|(what, scene, b, expected)| {
                let path = through(scene, mode, b);
                let [x, y, _] = path.final_direction;
                let is_sound = path.escaped && path.vertices.len() == 2 && path.events.total() == 0;
                let measured = if is_sound { -y.atan2(x) } else { f64::NAN };
                Measurement::relative(format!("deflection by a {what}"), measured, expected, 1e-7).in_unit("rad")
            }))
        })
    })
}

fn grazing(subject: &Subject) -> Measured<Step> {
    of_each([1.5, 1.0001, 1000.0], |n| {
        let scene = ready(block(1.0, n))?;
        steps((0..=14).map(|exponent| 10f64.powf(-0.5 * f64::from(exponent))), |c| {
            subject.in_modes(|mode| {
                let ray = onto_block(c);
                let path = trace(&scene, mode, ray, Follow::Transmit, 0, Some(1));
                let measured = path.vertices.first().and_then(|v| v.fresnel).unwrap_or(f64::NAN);
                let expected = fresnel(0.0, n - 1.0, -ray.direction.y).reflectance;
                Ok([Measurement::relative(format!("R, 1 | {n}"), measured, expected, 1e-12)])
            })
        })
    })
}

fn critical(subject: &Subject) -> Measured<Step> {
    /// Roundings that few operations in a row may make.
    const ROUNDINGS: f64 = 64.0;
    of_each(
        [("1.5 | 1", 0.5, 0.0), ("1.333001 | 1.333", 0.333001, 0.333), ("1000 | 1", 999.0, 0.0)],
        |(name, m1, m2)| {
            let critical = critical_cosine(m1, m2).unwrap_or(f64::NAN);
            steps((1..=14).map(|exponent| 10f64.powi(-exponent)), |offset| {
                subject.go_on()?;
                let mut found = Vec::new();
                let inside = critical * (1.0 + offset);
                if inside <= 1.0 {
                    let truth = fresnel(m1, m2, inside);
                    let evaluated = subject.formula.evaluate(m1, m2, inside);
                    let error = (evaluated.transmittance / truth.transmittance - 1.0).abs();
                    let roundings = error / (0.5 * f64::EPSILON * (1.0 + truth.condition(m1, m2, inside)));
                    let what = format!("error of T, {name}");
                    found.push(Measurement::absolute(what, roundings, 0.0, ROUNDINGS).in_unit("roundings"));
                }
                let is_wrong = |c: f64| {
                    c > 0.0 && c <= 1.0 && subject.formula.evaluate(m1, m2, c).is_total != fresnel(m1, m2, c).is_total
                };
                let wrong = [inside, critical * (1.0 - offset)].into_iter().filter(|c| is_wrong(*c)).count();
                found.push(Measurement::none_of(format!("wrong decisions, {name}"), wrong, "of 2"));
                Ok(found)
            })
        },
    )
}

fn absorption(subject: &Subject) -> Measured<Step> {
    let r = reflectance(1.0, 1.5, 1.0);
    steps([0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 300.0, 1000.0], |depth| {
        let matched = ready(matched_absorbers(depth))?;
        let slab = ready(layers(&[(0.0, -1.0, 1.5, depth)], 0.0))?;
        subject.in_modes(|mode| {
            let (of_block, _) = mean(&subject.render(&matched, mode, (4, 4), 2, 1, None)?);
            let samples = samples_of(mode, subject.amount(16, 256));
            let (of_slab, error) = mean(&subject.render(&slab, mode, (32, 32), samples, 1, None)?);
            Ok([
                Measurement::relative("T of a block", of_block, (-depth).exp(), 1e-8),
                Measurement::absolute("T of a slab", of_slab, absorbing_slab(r, depth).0, 1e-6).with_noise(error),
            ])
        })
    })
}
