//! IOR against wavelength.
//!
//! Everything is worked out as n − 1: near 1, as in air, most digits of n are the leading 1, and Fresnel needs the others.

use std::borrow::Cow;

use crate::spectrum::WAVELENGTH_D_UM;

/// Indices that are taken for real: far beyond any material and any test of stability, and far from where f64 gives out.
pub const IOR_RANGE: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Fraunhofer's F and C lines of hydrogen, in µm: Abbe's number says how much an index differs between them.
pub const WAVELENGTH_F_UM: f64 = 0.486_13;
pub const WAVELENGTH_C_UM: f64 = 0.656_27;

/// An index of refraction, as a number or by a dispersion formula; λ in µm.
#[derive(Debug, Clone, PartialEq)]
pub enum Ior {
    /// The same at every wavelength.
    Constant(f64),
    /// n = A + B/λ² + C/λ⁴.
    Cauchy([f64; 3]),
    /// n² = 1 + Σ Bλ²/(λ² − C), C in µm².
    Sellmeier(Cow<'static, [[f64; 2]]>),
    /// n = 1 + Σ K/(L − λ⁻²), pairs of K and L in µm⁻²: the form for gases, which only the catalogue uses.
    Gas(Cow<'static, [[f64; 2]]>),
    /// By name, from [`super::catalog`].
    Catalog(&'static Entry),
}

impl Ior {
    /// n − 1 at a wavelength in micrometres, with full relative precision. NaN where a formula has no real answer, as a
    /// Sellmeier sum has near its poles.
    pub fn ior_minus_one(&self, wavelength_um: f64) -> f64 {
        match self {
            Self::Constant(n) => n - 1.0,
            Self::Cauchy(coefficients) => cauchy(coefficients, wavelength_um),
            Self::Sellmeier(terms) => sellmeier(terms, wavelength_um),
            Self::Gas(terms) => {
                let inverse_square = 1.0 / (wavelength_um * wavelength_um);
                terms.iter().map(|[k, l]| k / (l - inverse_square)).sum()
            }
            Self::Catalog(entry) => entry.model.ior_minus_one(wavelength_um),
        }
    }

    /// n at the d line.
    pub fn ior(&self) -> f64 {
        match self {
            // Not (n − 1) + 1: a number that was typed comes back as typed.
            Self::Constant(n) => *n,
            _ => 1.0 + self.ior_minus_one(WAVELENGTH_D_UM),
        }
    }

    /// Abbe's number V = (n_d − 1)/(n_F − n_C), small where dispersion is strong; `None` where there is none, or n does not fall
    /// from F to C.
    pub fn abbe_number(&self) -> Option<f64> {
        let [d, f, c] = [WAVELENGTH_D_UM, WAVELENGTH_F_UM, WAVELENGTH_C_UM].map(|um| self.ior_minus_one(um));
        let abbe = d / (f - c);
        (self.is_dispersive() && abbe.is_finite() && abbe > 0.0).then_some(abbe)
    }

    /// Whether n changes with wavelength.
    pub fn is_dispersive(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Cauchy([_, b, c]) => *b != 0.0 || *c != 0.0,
            Self::Sellmeier(terms) => terms.iter().any(|[b, c]| *b != 0.0 && *c != 0.0),
            Self::Gas(terms) => terms.iter().any(|[k, _]| *k != 0.0),
            Self::Catalog(entry) => entry.model.is_dispersive(),
        }
    }
}

/// An entry of the catalogue.
#[derive(Debug, PartialEq)]
pub struct Entry {
    /// The name used in scene files, such as `water`: lower case, words joined by `-`.
    pub name: &'static str,
    /// The name for people.
    pub label: &'static str,
    /// Who measured it, and under which conditions.
    pub source: &'static str,
    pub model: Ior,
}

impl Entry {
    /// n at the d line, 587.56 nm.
    pub fn ior(&self) -> f64 {
        self.model.ior()
    }
}

/// A + B/λ² + C/λ⁴ − 1.
fn cauchy([a, b, c]: &[f64; 3], wavelength_um: f64) -> f64 {
    let inverse_square = 1.0 / (wavelength_um * wavelength_um);
    (a - 1.0) + (b + c * inverse_square) * inverse_square
}

/// n − 1 = (n² − 1)/(n + 1), where n² − 1 is the Sellmeier sum itself.
fn sellmeier(terms: &[[f64; 2]], wavelength_um: f64) -> f64 {
    let square = wavelength_um * wavelength_um;
    let sum: f64 = terms.iter().map(|[b, c]| b * square / (square - c)).sum();
    sum / ((1.0 + sum).sqrt() + 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::catalog;
    use super::*;

    #[test]
    fn a_typed_number_comes_back_as_typed() {
        for n in [1.1, 1.333, 1.000277, 0.7] {
            assert_eq!(Ior::Constant(n).ior(), n);
        }
    }

    #[test]
    fn digits_near_one_survive() {
        // One term that makes n² − 1 = 2e-12: n − 1 = 1e-12 − 5e-25.
        let model = Ior::Sellmeier([[2e-12, 0.0]].to_vec().into());
        let got = model.ior_minus_one(WAVELENGTH_D_UM);
        assert!((got / (1e-12 - 5e-25) - 1.0).abs() < 1e-15, "{got:e}");
        assert_eq!(Ior::Cauchy([1.25, 0.0, 0.0]).ior_minus_one(0.5), 0.25);
    }

    #[test]
    fn cauchy_and_sellmeier_by_hand() {
        // λ = 0.5: λ² = 0.25, 1/λ² = 4, 1/λ⁴ = 16.
        assert!((Ior::Cauchy([1.5, 0.01, 0.001]).ior_minus_one(0.5) - 0.556).abs() < 1e-15);
        // n² = 1 + 0.75·0.25/(0.25 − 0.1) = 2.25.
        assert!((Ior::Sellmeier([[0.75, 0.1]].to_vec().into()).ior_minus_one(0.5) - 0.5).abs() < 1e-15);
    }

    /// As SCHOTT's data sheets and refractiveindex.info print them.
    #[test]
    fn abbe_numbers() {
        for (name, abbe) in [("n-bk7", 64.17), ("sf11", 25.76), ("fused-silica", 67.82), ("water", 55.7)] {
            let got = catalog::find(name).unwrap().model.abbe_number().unwrap();
            assert!((got / abbe - 1.0).abs() < 2e-3, "{name}: {got} is not {abbe}");
        }
        assert_eq!(Ior::Constant(1.5).abbe_number(), None);
    }

    #[test]
    fn dispersive_or_not() {
        assert!(!Ior::Constant(1.5).is_dispersive());
        assert!(!Ior::Cauchy([1.5, 0.0, 0.0]).is_dispersive());
        assert!(Ior::Sellmeier([[1.0, 0.01]].to_vec().into()).is_dispersive());
        assert!(Ior::Catalog(catalog::find("water").unwrap()).is_dispersive());
        assert!(!Ior::Catalog(catalog::find("ice").unwrap()).is_dispersive());
    }
}
