//! What holds for every scattering function: sampling follows the density that is told, light is neither made nor lost, and scattering of
//! importance is the adjoint of that of radiance.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::*;
use crate::geometry::uniform_direction;
use crate::optics::Interface;

/// White ones, with their names.
fn all() -> Vec<(&'static str, Scattering)> {
    let dielectric = |from, to| Scattering::Dielectric(Dielectric { interface: Interface::new(from, to), segment: 1 });
    vec![
        ("lambert", Scattering::Lambert(Lambert { albedo: Spectrum::ONE })),
        ("mirror", Scattering::Mirror(Mirror { albedo: Spectrum::ONE })),
        ("glass from outside", dielectric(0.0, 0.5)),
        ("glass from inside", dielectric(0.5, 0.0)),
        ("water to glass", dielectric(0.333, 0.5)),
    ]
}

fn normals(tilt_degrees: f64) -> Normals {
    let (sin, cos) = tilt_degrees.to_radians().sin_cos();
    Normals { face: DVec3::Y, shading: DVec3::new(sin, cos, 0.0) }
}

fn at_degrees(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(0.8 * sin, cos, 0.6 * sin)
}

/// Points of a grid in the unit square.
fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
    (0..n * n).map(move |i| [f64::from(i / n) + 0.5, f64::from(i % n) + 0.5].map(|x| x / f64::from(n)))
}

/// Random numbers in [0, 1) (Steele et al. 2014, SplitMix).
fn numbers(index: u32) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let mut z = (3 * u64::from(index) + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    })
}

fn luminance(spectrum: Spectrum) -> f64 {
    spectrum.to_rgb()[1]
}

/// Pearson's test of `counts` against `expected`; cells of few are taken together. The p-value.
fn p_value(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells, mut few) = (0.0, 0, (0.0, 0.0));
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            few = (few.0 + count, few.1 + expected);
        } else {
            statistic += (count - expected) * (count - expected) / expected;
            cells += 1;
        }
    }
    if few.1 >= 5.0 {
        statistic += (few.0 - few.1) * (few.0 - few.1) / few.1;
        cells += 1;
    } else {
        assert!(few.0 <= 20.0, "{} where {} were expected", few.0, few.1);
    }
    1.0 - ChiSquared::new(f64::from(cells - 1)).unwrap().cdf(statistic)
}

/// Cells of the sphere: bands of equal height, cut into equal angles.
const CELLS: [usize; 2] = [20, 20];

fn cell_of(direction: DVec3) -> usize {
    let band = ((direction.y + 1.0) / 2.0 * CELLS[0] as f64) as usize;
    let part = ((direction.x.atan2(direction.z) / TAU + 0.5) * CELLS[1] as f64) as usize;
    band.min(CELLS[0] - 1) * CELLS[1] + part.min(CELLS[1] - 1)
}

/// How often each cell should be met by `samples` samples of `density`, by midpoints.
fn expected_counts(samples: f64, density: impl Fn(DVec3) -> f64) -> Vec<f64> {
    const FINE: u32 = 24;
    let mut expected = vec![0.0; CELLS[0] * CELLS[1]];
    for band in 0..CELLS[0] as u32 * FINE {
        let y = 2.0 * (f64::from(band) + 0.5) / (CELLS[0] as f64 * f64::from(FINE)) - 1.0;
        for part in 0..CELLS[1] as u32 * FINE {
            let phi = TAU * ((f64::from(part) + 0.5) / (CELLS[1] as f64 * f64::from(FINE)) - 0.5);
            let r = (1.0 - y * y).sqrt();
            let direction = DVec3::new(r * phi.sin(), y, r * phi.cos());
            let solid_angle = 4.0 * PI / (CELLS[0] * CELLS[1]) as f64 / f64::from(FINE * FINE);
            expected[cell_of(direction)] += samples * density(direction) * solid_angle;
        }
    }
    expected
}

#[test]
fn samples_follow_the_density() {
    const SAMPLES: u32 = 100_000;
    for (name, scattering) in all() {
        for (degrees, tilt) in [(0.0, 0.0), (50.0, 0.0), (70.0, 30.0), (20.0, -40.0)] {
            let (wo, normals) = (at_degrees(degrees), normals(tilt));
            // Delta functions have cells for their two ways; others for directions.
            let mut counts = vec![0.0; CELLS[0] * CELLS[1]];
            let mut ways = [0.0; 2];
            let mut share_through = 0.0;
            for index in 0..SAMPLES {
                let [choice, u, v] = numbers(index);
                let sample = scattering.sample(&normals, wo, Choice::Sample(choice), || [u, v], Transport::Radiance);
                ways[usize::from(sample.is_transmitted)] += 1.0;
                share_through = 1.0 - sample.reflectance;
                counts[cell_of(sample.wi)] += 1.0;
                let told = scattering.pdf(&normals, wo, sample.wi);
                assert!((sample.pdf - told).abs() <= 1e-9 * told.max(1.0), "{name}: {} {told}", sample.pdf);
            }
            let samples = f64::from(SAMPLES);
            let p = if scattering.is_delta() {
                let expected = [1.0 - share_through, share_through].map(|share| samples * share);
                if share_through == 0.0 {
                    assert_eq!(ways, expected, "{name}");
                    continue;
                }
                p_value(&ways, &expected)
            } else {
                p_value(&counts, &expected_counts(samples, |wi| scattering.pdf(&normals, wo, wi)))
            };
            assert!(p > 1e-4, "{name} at {degrees}, tilt {tilt}: p = {p:e}");
        }
    }
}

/// The twin: a density that is a little off is found.
#[test]
fn a_wrong_density_is_found() {
    let (_, lambert) = all()[0];
    let normals = normals(0.0);
    let mut counts = vec![0.0; CELLS[0] * CELLS[1]];
    for index in 0..100_000 {
        let [_, u, v] = numbers(index);
        let sample = lambert.sample(&normals, DVec3::Y, Choice::Reflect, || [u, v], Transport::Radiance);
        counts[cell_of(sample.wi)] += 1.0;
    }
    let wrong = |wi: DVec3| wi.y.max(0.0).powf(1.1) * 2.1 / TAU;
    assert!(p_value(&counts, &expected_counts(1e5, wrong)) < 1e-6);
}

/// All of a white surface's light goes somewhere: the shares of the ways that it can go sum to 1, and what is evaluated integrates to 1.
#[test]
fn no_light_is_lost_or_made() {
    for (name, scattering) in all() {
        for (degrees, tilt) in (0..89).step_by(4).flat_map(|d| [0.0, 25.0].map(|tilt| (f64::from(d), tilt))) {
            let (wo, normals) = (at_degrees(degrees), normals(tilt));
            let of = |choice| scattering.sample(&normals, wo, choice, || [0.3, 0.6], Transport::Radiance);
            if scattering.is_delta() {
                let (through, back) = (of(Choice::Transmit), of(Choice::Reflect));
                let total = if through.is_transmitted { through.share() + back.share() } else { back.share() };
                assert!((total - 1.0).abs() < 1e-15, "{name} at {degrees}: {total}");
                assert_eq!((luminance(through.weight), luminance(back.weight)), (1.0, 1.0), "{name}");
                assert!(scattering.evaluate(&normals, wo, back.wi, Transport::Radiance).is_black());
            } else {
                let n = 200;
                let total: f64 = grid(n)
                    .map(uniform_direction)
                    .map(|wi| luminance(scattering.evaluate(&normals, wo, wi, Transport::Radiance)))
                    .sum::<f64>()
                    * 4.0
                    * PI
                    / f64::from(n * n);
                assert!((total - 1.0).abs() < 2e-3, "{name} at {degrees}: {total}");
                // The weight of a sample is what is evaluated over its density.
                let sample = of(Choice::Reflect);
                let value = scattering.evaluate(&normals, wo, sample.wi, Transport::Radiance);
                assert!((luminance(value) / sample.pdf / luminance(sample.weight) - 1.0).abs() < 1e-9, "{name}");
            }
        }
    }
}

/// Radiance that is scattered and then weighed by importance is importance that is scattered and then weighed by radiance: with
/// W and L smooth over the sphere, ∫ W(wo) |wo·g| (K L)(wo) dwo = ∫ L(wi) |wi·g| (K* W)(wi) dwi (Veach 1997, section 4.7). A surface is met from both
/// sides; on its other side a dielectric's indices change places.
#[test]
fn importance_is_scattered_as_the_adjoint_of_radiance() {
    let importance = |d: DVec3| 1.3 + d.dot(DVec3::new(0.3, 0.9, -0.2)) + 0.5 * d.x * d.z;
    let radiance = |d: DVec3| 1.1 + d.dot(DVec3::new(-0.5, 0.2, 0.4)) + 0.4 * d.y * d.z;
    for (name, from, to) in [("glass", 0.0, 0.5), ("water and glass", 0.333, 0.5), ("nearly alike", 0.3, 0.31)] {
        let side = |above: bool| {
            let (from, to) = if above { (from, to) } else { (to, from) };
            let normal = if above { DVec3::Y } else { DVec3::NEG_Y };
            let interface = Interface::new(from, to);
            (Scattering::Dielectric(Dielectric { interface, segment: 1 }), Normals::flat(normal))
        };
        let n = 600;
        let sum = |weigh: &dyn Fn(DVec3) -> f64, gather: &dyn Fn(DVec3) -> f64, transport| -> f64 {
            grid(n)
                .map(|u| {
                    let wo = uniform_direction(u);
                    let (scattering, normals) = side(wo.y > 0.0);
                    let of = |choice| scattering.sample(&normals, wo, choice, || [0.0; 2], transport);
                    let (through, back) = (of(Choice::Transmit), of(Choice::Reflect));
                    let light = |s: &ScatterSample| s.share() * luminance(s.weight) * s.radiance_scale * gather(s.wi);
                    let scattered = light(&back) + if through.is_transmitted { light(&through) } else { 0.0 };
                    weigh(wo) * wo.y.abs() * scattered
                })
                .sum::<f64>()
                / f64::from(n * n)
        };
        let of_radiance = sum(&importance, &radiance, Transport::Radiance);
        let of_importance = sum(&radiance, &importance, Transport::Importance);
        assert!((of_radiance / of_importance - 1.0).abs() < 1e-4, "{name}: {of_radiance} {of_importance}");
        // The twin: with the factor of radiance, importance is not scattered as the adjoint.
        let wrong = sum(&radiance, &importance, Transport::Radiance);
        assert!((of_radiance / wrong - 1.0).abs() > 1e-3, "{name}: {wrong}");
    }
    // Functions of two directions are compared at once: f(wo, wi) |wi·g| against f*(wi, wo) |wo·g|.
    for tilt in [0.0, 15.0, 50.0] {
        let (_, lambert) = all()[0];
        let normals = normals(tilt);
        for (a, b) in grid(12).flat_map(|u| grid(7).map(move |v| (uniform_direction(u), uniform_direction(v)))) {
            if [a, b].iter().any(|d| d.y <= 0.0 || d.dot(normals.shading) <= 0.0) {
                continue;
            }
            let forth = luminance(lambert.evaluate(&normals, a, b, Transport::Radiance)) / b.y;
            let back = luminance(lambert.evaluate(&normals, b, a, Transport::Importance)) / a.y;
            assert!((forth - back).abs() < 1e-12 * forth, "tilt {tilt}: {forth} {back}");
        }
    }
}
