//! Sweeps over indices, angles and absorption.

use glam::DVec3;

use super::closed_forms::{absorbing_slab, ball_deflection, bubble_deflection, reflectance};
use super::definition::{Subject, SweepDefinition, Unmeasured};
use super::extended::{critical_cosine, fresnel};
use super::harsh::matched_absorbers;
use super::outcome::{Measurement, Step};
use super::scenes::{add, empty, layers, mean, nest, ready, render, samples_of, through};
use crate::geometry::Ray;
use crate::scene::description::Shape;
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

fn contrast(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    const B: f64 = 0.5;
    let mut steps = Vec::new();
    for contrast in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.5, 1.0, 3.0, 9.0, 99.0, 999.0] {
        // The scene holds n; n − 1 is what it then stands for.
        let n = 1.0 + contrast;
        let m = n - 1.0;
        let ball = ready(nest(1.0, &[(1.0, n)]))?;
        let bubble = ready(nest(n, &[(1.0, 1.0)]))?;
        for &mode in subject.modes {
            subject.go_on()?;
            for (what, scene, b, expected) in
                [("ball", &ball, B, ball_deflection(m, B)), ("bubble", &bubble, B / n, bubble_deflection(m, B / n))]
            {
                let path = through(scene, mode, b);
                let [x, y, _] = path.final_direction;
                let is_sound = path.escaped && path.vertices.len() == 2 && path.events.total() == 0;
                let measured = if is_sound { -y.atan2(x) } else { f64::NAN };
                let measurement =
                    Measurement::relative(format!("deflection by a {what}, {mode}"), measured, expected, 1e-7);
                steps.push(Step::at(contrast, measurement.in_unit("rad")));
            }
        }
    }
    Ok(steps)
}

fn grazing(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    for (name, n) in [("1.5", 1.5), ("1.0001", 1.0001), ("1000", 1000.0)] {
        let mut description = empty(1.0);
        let (min, max) = (DVec3::new(-1.0, -2.0, -1.0), DVec3::new(1.0, 0.0, 1.0));
        add(&mut description, Shape::Box { min, max }, n, 0.0);
        let scene = ready(description)?;
        for &mode in subject.modes {
            for exponent in 0..=14 {
                subject.go_on()?;
                let c = 10f64.powf(-0.5 * f64::from(exponent));
                let direction = DVec3::new((1.0 - c * c).sqrt(), -c, 0.0).normalize();
                // From far enough away that the start is not on the surface.
                let ray = Ray::new(direction * -(1e-3 / c).max(10.0), direction);
                let path = trace(&scene, mode, ray, Follow::Transmit, 0, Some(1));
                let measured = path.vertices.first().and_then(|v| v.fresnel).unwrap_or(f64::NAN);
                let expected = fresnel(0.0, n - 1.0, -direction.y).reflectance;
                let measurement = Measurement::relative(format!("R, 1 | {name}, {mode}"), measured, expected, 1e-12);
                steps.push(Step::at(c, measurement));
            }
        }
    }
    Ok(steps)
}

fn critical(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    /// Roundings that few operations in a row may make.
    const ROUNDINGS: f64 = 64.0;
    let mut steps = Vec::new();
    for (name, m1, m2) in [("1.5 | 1", 0.5, 0.0), ("1.333001 | 1.333", 0.333001, 0.333), ("1000 | 1", 999.0, 0.0)] {
        let Some(critical) = critical_cosine(m1, m2) else { continue };
        for exponent in 1..=14 {
            subject.go_on()?;
            let offset = 10f64.powi(-exponent);
            let inside = critical * (1.0 + offset);
            if inside <= 1.0 {
                let truth = fresnel(m1, m2, inside);
                let evaluated = subject.formula.evaluate(m1, m2, inside);
                let error = (evaluated.transmittance / truth.transmittance - 1.0).abs();
                let roundings = error / (0.5 * f64::EPSILON * (1.0 + truth.condition));
                let what = format!("error of T, {name}");
                let measurement = Measurement::absolute(what, roundings, 0.0, ROUNDINGS);
                steps.push(Step::at(offset, measurement.in_unit("roundings")));
            }
            let is_wrong = |c: f64| {
                c > 0.0 && c <= 1.0 && subject.formula.evaluate(m1, m2, c).is_total != fresnel(m1, m2, c).is_total
            };
            let wrong = [inside, critical * (1.0 - offset)].into_iter().filter(|c| is_wrong(*c)).count();
            steps.push(Step::at(offset, Measurement::none_of(format!("wrong decisions, {name}"), wrong, "of 2")));
        }
    }
    Ok(steps)
}

fn absorption(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    let r = reflectance(1.0, 1.5, 1.0);
    for depth in [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 300.0, 1000.0] {
        let matched = ready(matched_absorbers(depth))?;
        let slab = ready(layers(&[(0.0, -1.0, 1.5, depth)], 0.0))?;
        for &mode in subject.modes {
            subject.go_on()?;
            let (measured, _) = mean(&render(&matched, mode, (4, 4), 2, 1, None)?);
            let of_block = Measurement::relative(format!("T of a block, {mode}"), measured, (-depth).exp(), 1e-8);
            let samples = samples_of(mode, subject.amount(16, 256));
            let (measured, error) = mean(&render(&slab, mode, (32, 32), samples, 1, None)?);
            let of_slab =
                Measurement::absolute(format!("T of a slab, {mode}"), measured, absorbing_slab(r, depth).0, 1e-6);
            steps.push(Step::at(depth, of_block));
            steps.push(Step::at(depth, of_slab.with_noise(error)));
        }
    }
    Ok(steps)
}
