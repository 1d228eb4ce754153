//! Spectra as colours and as formulas, and metals by their names.

use crate::optics::Ior;
use crate::spectrum::WAVELENGTH_D_UM;

/// Reflectances at normal incidence of metals, by the names that pbrt and Mitsuba have for them.
const METALS: [(&str, [f64; 3]); 8] = [
    ("Au", [1.0, 0.78, 0.34]),
    ("Ag", [0.97, 0.96, 0.91]),
    ("Al", [0.91, 0.92, 0.92]),
    ("Cu", [0.95, 0.64, 0.54]),
    ("CuZn", [0.89, 0.79, 0.43]),
    ("Cr", [0.55, 0.56, 0.55]),
    ("W", [0.5, 0.48, 0.45]),
    ("MgO", [0.07; 3]),
];
/// Of a metal that is not known.
const SOME_METAL: [f64; 3] = [0.9; 3];

/// The reflectance of a metal at normal incidence.
pub fn metal(name: &str) -> [f64; 3] {
    METALS.iter().find(|(known, _)| *known == name).map_or(SOME_METAL, |(_, color)| *color)
}

/// Means over a third each of what is seen, of wavelengths in nanometres with values: red, green and blue.
pub fn bands(mut samples: Vec<(f64, f64)>) -> [f64; 3] {
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at_wavelength = |nm: f64| {
        let next = samples.partition_point(|sample| sample.0 < nm);
        match (next.checked_sub(1).map(|before| samples[before]), samples.get(next)) {
            (Some(a), Some(b)) if b.0 > a.0 => a.1 + (b.1 - a.1) * (nm - a.0) / (b.0 - a.0),
            (Some(a), _) => a.1,
            (None, Some(b)) => b.1,
            (None, None) => 0.0,
        }
    };
    [600.0, 500.0, 400.0]
        .map(|from: f64| (0..10).map(|k| at_wavelength(from + 10.0 * (f64::from(k) + 0.5))).sum::<f64>() / 10.0)
}

/// The wavelength that an index without dispersion is given at.
pub const D_LINE_NM: f64 = 1e3 * WAVELENGTH_D_UM;
/// Fewer samples than this say nothing of dispersion.
const LEAST_SAMPLES: usize = 4;
/// A formula that is off by more is not taken.
const LARGEST_ERROR: f64 = 2e-3;
/// Wavelengths in nanometres over which a formula must fit.
const SEEN: std::ops::RangeInclusive<f64> = 380.0..=780.0;

/// Cauchy's formula through indices at wavelengths in nanometres; `None` where it does not fit them, or they are all equal.
pub fn cauchy(samples: &[(f64, f64)]) -> Option<Ior> {
    let seen: Vec<(f64, f64)> = samples.iter().copied().filter(|(nm, _)| SEEN.contains(nm)).collect();
    if seen.len() < LEAST_SAMPLES || seen.iter().all(|(_, n)| *n == seen[0].1) {
        return None;
    }
    // Least squares over the powers of 1/λ², counted from the middle of what is seen and in its width, so that no digits are lost.
    let inverse_square = |nm: f64| 1e6 / (nm * nm);
    let (middle, width) = (3.5, 2.5);
    let powers = |nm: f64| {
        let t = (inverse_square(nm) - middle) / width;
        glam::DVec3::new(1.0, t, t * t)
    };
    let (mut matrix, mut right) = (glam::DMat3::ZERO, glam::DVec3::ZERO);
    for &(nm, n) in &seen {
        let p = powers(nm);
        matrix += glam::DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * n;
    }
    let [a, b, c] = (matrix.inverse() * right).to_array();
    let (b, c) = (b / width, c / (width * width));
    let a = a - b * middle + c * middle * middle;
    let b = b - 2.0 * c * middle;
    // Nearest to the d line, which other colours stand for, it is exact.
    let (nm, n) = *seen.iter().min_by(|x, y| (x.0 - D_LINE_NM).abs().total_cmp(&(y.0 - D_LINE_NM).abs()))?;
    let off = n - 1.0 - Ior::Cauchy([a, b, c]).ior_minus_one(1e-3 * nm);
    let formula = Ior::Cauchy([a + off, b, c]);
    let fits = |&(nm, n): &(f64, f64)| (1.0 + formula.ior_minus_one(1e-3 * nm) - n).abs() < LARGEST_ERROR;
    seen.iter().all(fits).then_some(formula)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::catalog;

    fn samples(of: &Ior) -> Vec<(f64, f64)> {
        (0..=94).map(|k| 360.0 + 5.0 * f64::from(k)).map(|nm| (nm, 1.0 + of.ior_minus_one(1e-3 * nm))).collect()
    }

    #[test]
    fn cauchys_formula_comes_back_and_fits_glasses() {
        let expected = [1.5, 0.004, 1e-4];
        let Some(Ior::Cauchy(found)) = cauchy(&samples(&Ior::Cauchy(expected))) else { panic!("no formula") };
        assert!(expected.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-10), "{found:?}");
        for name in ["water", "sf11", "n-bk7"] {
            let glass = Ior::Catalog(catalog::find(name).unwrap());
            let found = cauchy(&samples(&glass)).unwrap();
            assert!((found.ior() - glass.ior()).abs() < 1e-5, "{name}: {} {}", found.ior(), glass.ior());
            let ratio = found.abbe_number().unwrap() / glass.abbe_number().unwrap();
            assert!((ratio - 1.0).abs() < 0.03, "{name}: {ratio}");
        }
        assert_eq!(cauchy(&samples(&Ior::Constant(1.5))), None);
        assert_eq!(cauchy(&[(400.0, 1.5), (700.0, 1.4)]), None);
        let jump = [(400.0, 1.5), (500.0, 1.5), (501.0, 1.6), (600.0, 1.6), (700.0, 1.6)];
        assert_eq!(cauchy(&jump), None);
    }

    #[test]
    fn bands_are_means() {
        assert_eq!(bands(vec![(400.0, 2.0), (700.0, 2.0)]), [2.0; 3]);
        let ramp = bands(vec![(700.0, 7.0), (400.0, 4.0)]);
        assert!((ramp[0] - 6.5).abs() < 1e-12 && (ramp[2] - 4.5).abs() < 1e-12);
    }
}
