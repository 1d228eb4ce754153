//! Indices of refraction by the names that other renderers have for them.

use crate::optics::{Ior, catalog};

/// As Mitsuba lists them.
const MITSUBA: [(&str, f64); 24] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
    ("sf11", 1.7847),
];

/// Spectra of pbrt, at 587.56 nm.
const PBRT: [(&str, f64); 7] = [
    ("glass-bk7", 1.5168),
    ("glass-baf10", 1.67),
    ("glass-fk51a", 1.486_56),
    ("glass-lasf9", 1.8502),
    ("glass-f5", 1.6034),
    ("glass-f10", 1.6234),
    ("glass-f11", 1.7847),
];

/// The index that Mitsuba has under a name.
pub fn of_mitsuba(name: &str) -> Option<f64> {
    find(&MITSUBA, name)
}

/// The index that pbrt has under a name, at the d line.
pub fn of_pbrt(name: &str) -> Option<f64> {
    find(&PBRT, name)
}

/// The same at all wavelengths, where the catalogue has that glass.
pub fn formula_of_pbrt(name: &str) -> Option<Ior> {
    let name = match name.trim().to_lowercase().as_str() {
        "glass-bk7" => "n-bk7",
        "glass-f11" => "sf11",
        _ => return None,
    };
    catalog::find(name).map(Ior::Catalog)
}

/// All names, for errors.
pub fn mitsuba_names() -> impl Iterator<Item = &'static str> {
    MITSUBA.iter().map(|(name, _)| *name)
}

fn find(list: &[(&str, f64)], name: &str) -> Option<f64> {
    let name = name.trim().to_lowercase();
    list.iter().find(|(known, _)| *known == name).map(|(_, ior)| *ior)
}

/// The name of a medium with that index, such as `water`.
pub fn name_of(ior: f64) -> Option<&'static str> {
    const FEW: [(&str, f64); 7] = [
        ("air", 1.000_277),
        ("water", 1.333),
        ("ice", 1.31),
        ("glass", 1.5046),
        ("glass", 1.5168),
        ("glass", 1.5),
        ("diamond", 2.419),
    ];
    FEW.iter().find(|(_, known)| (known - ior).abs() < 1e-6).map(|(name, _)| *name)
}
