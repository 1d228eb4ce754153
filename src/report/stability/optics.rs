//! Cases 1 to 11: Fresnel's equations and Snell's law where usual formulas lose their digits. Truth by [`extended`](super::extended)
//! precision, or by short closed forms.

use glam::DVec3;

use super::definition::{CaseDefinition, Measured, Subject, case};
use super::extended::{critical_cosine, fresnel};
use super::outcome::Measurement;
use super::scenes::{block, onto_block, ready};
use crate::transport::inspect::{Follow, trace};

pub(super) const CASES: &[CaseDefinition] = &[
    case(1, "Matched media, 1.5 | 1.5, cosines 1e-7 to 1", "R = 0, the ray goes straight on", matched),
    case(2, "1.5 | 1.500001 at 89.9°", "Fresnel, 32 digits", |subject| nearly_equal(subject, 0.500001)),
    case(3, "1.5 | 1.5001 at 89.9°", "Fresnel, 32 digits", |subject| nearly_equal(subject, 0.5001)),
    case(4, "Vacuum | air at normal incidence", "R = (m/(2 + m))², m = n − 1", |subject| {
        let m: f64 = 2.77e-4;
        Ok(vec![reflectance(subject, [0.0, m], 1.0, (m / (2.0 + m)).powi(2), 1e-6)])
    }),
    case(
        5,
        "Total reflection, 1.333001 → 1.333, 200 f32 steps to either side",
        "total where cos θ² ≤ 1 − (n2/n1)²",
        total_reflection,
    ),
    case(6, "1 : 1000 at normal incidence", "T = 4n/(1 + n)²", |subject| {
        let measured = subject.formula.evaluate(0.0, 999.0, 1.0).transmittance;
        Ok(vec![Measurement::relative("transmittance", measured, 4000.0 / (1001.0 * 1001.0), 1e-6)])
    }),
    case(7, "1000 : 1, critical angle", "asin(1/1000)", |subject| Ok(vec![critical(subject, 1000.0, 1.0)])),
    case(8, "n = 0.5", "R = ((n − 1)/(n + 1))² = 1/9, critical angle asin(1/2)", |subject| {
        Ok(vec![reflectance(subject, [0.0, -0.5], 1.0, 1.0 / 9.0, 1e-6), critical(subject, 1.0, 0.5)])
    }),
    case(9, "Brewster's angle, 1.5", "R = ½ ((n² − 1)/(n² + 1))² at atan n", |subject| {
        let n: f64 = 1.5;
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        Ok(vec![reflectance(subject, [0.0, n - 1.0], n.atan().cos(), expected, 1e-6)])
    }),
    case(10, "Grazing entry into 1.5, cosine 1e-7", "Fresnel, 32 digits: T/cos θ", |subject| {
        let c = 1e-7;
        let measured = subject.formula.evaluate(0.0, 0.5, c).transmittance / c;
        Ok(vec![Measurement::relative("T/cos θ", measured, fresnel(0.0, 0.5, c).transmittance / c, 1e-6)])
    }),
    case(
        11,
        "Reciprocity and closure, indices 0.5 to 1000",
        "R12(θi) = R21(θt) (Stokes), R + T = 1",
        reciprocity_and_closure,
    ),
];

/// The formula's reflectance between 1 + m1 and 1 + m2 at cosine `c`.
fn reflectance(subject: &Subject, [m1, m2]: [f64; 2], c: f64, expected: f64, bound: f64) -> Measurement {
    Measurement::relative("reflectance", subject.formula.evaluate(m1, m2, c).reflectance, expected, bound)
}

/// Largest R over the angles, and rays that a surface between equal media bends or reflects, by so much as one bit.
fn matched(subject: &Subject) -> Measured {
    let cosines: Vec<f64> = (0..=280).map(|k| 10f64.powf(-7.0 + f64::from(k) / 40.0)).collect();
    let largest = cosines.iter().map(|&c| subject.formula.evaluate(0.5, 0.5, c).reflectance).fold(0.0, f64::max);
    let mut measurements = vec![Measurement::absolute("largest reflectance", largest, 0.0, 0.0)];
    let scene = ready(block(1.5, 1.5))?;
    measurements.extend(subject.in_modes(|mode| {
        let (mut bent, mut missed) = (0, 0);
        for &c in &cosines {
            let ray = onto_block(c);
            let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
            missed += usize::from(path.vertices.len() != 2);
            bent += usize::from(DVec3::from(path.final_direction) != ray.direction.normalize());
        }
        let missed = Measurement::none_of("rays without two surfaces", missed, "rays");
        Ok([Measurement::none_of("rays bent", bent, "rays"), missed])
    })?);
    Ok(measurements)
}

fn nearly_equal(subject: &Subject, m2: f64) -> Measured {
    let c = 89.9_f64.to_radians().cos();
    Ok(vec![reflectance(subject, [0.5, m2], c, fresnel(0.5, m2, c).reflectance, 1e-5)])
}

fn total_reflection(subject: &Subject) -> Measured {
    let (m1, m2) = (0.333001, 0.333);
    let critical = critical_cosine(m1, m2).unwrap_or(f64::NAN);
    let center = (critical as f32).to_bits();
    let is_wrong = |c: &f64| subject.formula.evaluate(m1, m2, *c).is_total != fresnel(m1, m2, *c).is_total;
    let wrong = (center - 200..=center + 200).map(|bits| f64::from(f32::from_bits(bits))).filter(is_wrong).count();
    Ok(vec![Measurement::absolute("wrong decisions of 401", wrong as f64, 0.0, 1.0)])
}

/// The angle, in degrees, at which the formula begins to call reflection total, by bisection; over cosines, which keep their digits near
/// 90°, and sines near 0°.
fn critical(subject: &Subject, n1: f64, n2: f64) -> Measurement {
    let is_total = |degrees: f64| subject.formula.evaluate(n1 - 1.0, n2 - 1.0, degrees.to_radians().cos()).is_total;
    let (mut below, mut above) = (0.0, 90.0);
    for _ in 0..100 {
        let middle = 0.5 * (below + above);
        if is_total(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    Measurement::relative("critical angle", below, (n2 / n1).asin().to_degrees(), 1e-6).in_unit("°")
}

/// Both errors grow with the condition of the problem, and are shown as a share of what is allowed.
fn reciprocity_and_closure(subject: &Subject) -> Measured {
    let (mut reciprocity, mut closure): (f64, f64) = (0.0, 0.0);
    for n1 in [1.0, 1.000277, 1.333, 1.5, 1.500001, 2.4, 63.0, 1000.0, 0.5] {
        for n2 in [1.0, 1.31, 1.333, 1.5, 4.0, 1000.0] {
            let (m1, m2) = (n1 - 1.0, n2 - 1.0);
            for step in 1..=1000 {
                let c = f64::from(step) / 1000.0;
                let there = subject.formula.evaluate(m1, m2, c);
                if there.is_total {
                    continue;
                }
                closure = closure.max((there.reflectance + there.transmittance - 1.0).abs());
                if there.cos_t <= 1e-6 || there.cos_t >= 1.0 {
                    continue;
                }
                let back = subject.formula.evaluate(m2, m1, there.cos_t);
                // The way back starts from a rounded cosine, which its own condition amplifies once more.
                let b = n2 / n1 * there.cos_t;
                let condition = (1.0 + (c / b).powi(2)) * (1.0 + (b / c).powi(2));
                reciprocity = reciprocity.max((back.reflectance - there.reflectance).abs() / condition);
            }
        }
    }
    Ok(vec![
        Measurement::absolute("|R12 − R21|/(1 + c²/b²)", reciprocity, 0.0, 2e-6),
        Measurement::absolute("|R + T − 1|", closure, 0.0, 5e-7),
    ])
}
