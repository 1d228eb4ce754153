//! Media with measured, cited indices.
//!
//! Coefficients as collected by M. N. Polyanskiy, refractiveindex.info; the measurement behind each is cited with its entry.

use std::borrow::Cow::Borrowed;

pub use super::ior::Entry;
use super::ior::Ior;

/// Squares a wavelength, for sources that print Sellmeier's C unsquared.
const fn squared(wavelength_um: f64) -> f64 {
    wavelength_um * wavelength_um
}

const N_BK7: &[[f64; 2]] =
    &[[1.039_612_12, 0.006_000_698_67], [0.231_792_344, 0.020_017_914_4], [1.010_469_45, 103.560_653]];
const PMMA: &[[f64; 2]] = &[[1.1819, 0.011_313]];

/// Every entry, roughly by rising IOR.
pub const ALL: &[Entry] = &[
    Entry {
        name: "air",
        label: "Air",
        source: "P. E. Ciddor, Appl. Opt. 35, 1566 (1996): dry, 15 °C, 101.325 kPa, 450 ppm CO2",
        model: Ior::Gas(Borrowed(&[[0.057_921_05, 238.0185], [0.001_679_17, 57.362]])),
    },
    Entry {
        name: "ice",
        label: "Ice",
        source: "S. G. Warren and R. E. Brandt, J. Geophys. Res. 113, D14220 (2008): 266 K, at 587.56 nm",
        model: Ior::Constant(1.3097),
    },
    Entry {
        name: "water",
        label: "Water",
        source: "M. Daimon and A. Masumura, Appl. Opt. 46, 3811 (2007): 20 °C",
        model: Ior::Sellmeier(Borrowed(&[
            [0.568_402_756_5, 0.005_101_829_712],
            [0.172_617_739_1, 0.018_211_539_36],
            [0.020_861_895_78, 0.026_207_222_93],
            [0.113_074_868_8, 10.697_927_21],
        ])),
    },
    Entry {
        name: "ethanol",
        label: "Ethanol",
        source: "J. Rheims, J. Köser and T. Wriedt, Meas. Sci. Technol. 8, 601 (1997): 20 °C",
        model: Ior::Cauchy([1.352_650, 0.003_06, 0.000_02]),
    },
    Entry {
        name: "fused-silica",
        label: "Fused silica",
        source: "I. H. Malitson, J. Opt. Soc. Am. 55, 1205 (1965): 20 °C",
        model: Ior::Sellmeier(Borrowed(&[
            [0.696_166_3, squared(0.068_404_3)],
            [0.407_942_6, squared(0.116_241_4)],
            [0.897_479_4, squared(9.896_161)],
        ])),
    },
    Entry {
        name: "glycerol",
        label: "Glycerol",
        source: "J. Rheims, J. Köser and T. Wriedt, Meas. Sci. Technol. 8, 601 (1997): 20 °C",
        model: Ior::Cauchy([1.457_97, 0.005_98, -0.000_36]),
    },
    Entry {
        name: "pmma",
        label: "Acrylic (PMMA)",
        source: "G. Beadie et al., Appl. Opt. 54, F139 (2015), one-term fit: 20 °C",
        model: Ior::Sellmeier(Borrowed(PMMA)),
    },
    Entry { name: "acrylic", label: "Acrylic", source: "Another name for pmma", model: Ior::Sellmeier(Borrowed(PMMA)) },
    Entry {
        name: "n-bk7",
        label: "Crown glass N-BK7",
        source: "SCHOTT optical glass data sheets: 20 °C",
        model: Ior::Sellmeier(Borrowed(N_BK7)),
    },
    Entry {
        name: "glass",
        label: "Glass",
        source: "Another name for n-bk7, the commonest optical glass; window glass is within 0.01 of it",
        model: Ior::Sellmeier(Borrowed(N_BK7)),
    },
    Entry {
        name: "sapphire",
        label: "Sapphire (ordinary ray)",
        source: "I. H. Malitson and M. J. Dodge, J. Opt. Soc. Am. 62, 1405 (1972): 20 °C",
        model: Ior::Sellmeier(Borrowed(&[
            [1.431_349_3, squared(0.072_663_1)],
            [0.650_547_13, squared(0.119_324_2)],
            [5.341_402_1, squared(18.028_251)],
        ])),
    },
    Entry {
        name: "sf11",
        label: "Flint glass SF11",
        source: "SCHOTT optical glass data sheets: 20 °C",
        model: Ior::Sellmeier(Borrowed(&[
            [1.738_484_03, 0.013_606_860_4],
            [0.311_168_974, 0.061_596_046_3],
            [1.174_908_71, 121.922_711],
        ])),
    },
    Entry {
        name: "p-sf68",
        label: "Dense flint glass P-SF68",
        source: "SCHOTT optical glass data sheets: 20 °C",
        model: Ior::Sellmeier(Borrowed(&[
            [2.333_006_7, 0.016_883_841_9],
            [0.452_961_396, 0.071_608_632_5],
            [1.251_723_39, 118.707_479],
        ])),
    },
    Entry {
        name: "diamond",
        label: "Diamond",
        source: "F. Peter, Z. Phys. 15, 358 (1923)",
        model: Ior::Sellmeier(Borrowed(&[[0.3306, squared(0.1750)], [4.3356, squared(0.1060)]])),
    },
];

/// The entry of that name. Case does not matter, and spaces and underscores count as `-`.
pub fn find(name: &str) -> Option<&'static Entry> {
    let wanted: String =
        name.trim().chars().map(|c| if matches!(c, ' ' | '_') { '-' } else { c.to_ascii_lowercase() }).collect();
    ALL.iter().find(|entry| entry.name == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::WAVELENGTH_D_UM;
    use std::collections::HashSet;

    /// n as refractiveindex.info prints it, at the wavelength stated there: an agreement to half of the last printed digit.
    #[test]
    fn indices_to_their_printed_digits() {
        let d = WAVELENGTH_D_UM;
        for (name, wavelength_um, n, half_digit) in [
            ("water", d, 1.333_403_3, 5e-8),
            ("n-bk7", d, 1.516_800_0, 5e-8),
            ("sf11", d, 1.784_719_8, 5e-8),
            ("p-sf68", d, 2.005_199_9, 5e-8),
            ("fused-silica", d, 1.458_463_7, 5e-8),
            ("diamond", d, 2.417_485_9, 5e-8),
            ("sapphire", d, 1.768_172_1, 5e-8),
            ("pmma", d, 1.490_618_2, 5e-8),
            ("air", 0.5893, 1.000_277_15, 5e-9),
            ("ice", d, 1.3097, 1e-12),
            ("ethanol", 0.5893, 1.361_63, 5e-6),
            ("glycerol", 0.5893, 1.472_20, 5e-6),
        ] {
            let got = 1.0 + find(name).unwrap().model.ior_minus_one(wavelength_um);
            assert!((got - n).abs() <= half_digit, "{name}: {got} is not {n}");
        }
    }

    #[test]
    fn air_keeps_its_digits() {
        // 0.05792105/(238.0185 − 1/0.25) + 0.00167917/(57.362 − 1/0.25), by hand at λ = 0.5 µm.
        let expected = 0.057_921_05 / 234.0185 + 0.001_679_17 / 53.362;
        let got = find("air").unwrap().model.ior_minus_one(0.5);
        assert!((got / expected - 1.0).abs() < 1e-15);
    }

    #[test]
    fn names_are_unique_and_found_in_any_spelling() {
        let names: HashSet<_> = ALL.iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), ALL.len());
        assert!(ALL.iter().all(|entry| find(entry.name) == Some(entry)));
        assert_eq!(find("Fused Silica").unwrap().name, "fused-silica");
        assert!(find("unobtainium").is_none());
        assert_eq!(find("glass").unwrap().ior(), find("N-BK7").unwrap().ior());
    }
}
