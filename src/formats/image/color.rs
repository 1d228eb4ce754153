//! Colours of other primaries, converted to linear Rec. 709.
//!
//! ITU-R BT.709-6 for the target; the matrix between RGB and XYZ as in SMPTE RP 177-1993; whites are adapted by the Bradford transform
//! (Lam 1985, as in ICC.1:2022, annex E), so that what was neutral stays neutral.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::scene::LoadNote;

/// CIE 1931 (x, y) of red, green, blue, and the white that equal parts of them make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chromaticities(pub [[f64; 2]; 4]);

pub(super) const REC_709: Chromaticities = Chromaticities([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]]);

/// Differences below this are rounding in the file.
const TOLERANCE: f64 = 5e-4;

const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Chromaticities {
    fn is_near(&self, other: &Self) -> bool {
        self.0.iter().flatten().zip(other.0.iter().flatten()).all(|(a, b)| (a - b).abs() <= TOLERANCE)
    }

    /// The matrix that takes RGB to XYZ, with Y = 1 at white; `None` if these are no primaries.
    fn xyz_from_rgb(&self) -> Option<DMat3> {
        let [red, green, blue, white] = self.0;
        if self.0.iter().flatten().any(|x| !x.is_finite()) || white[1].abs() < 1e-6 {
            return None;
        }
        // Each primary up to its intensity: (x, y, z), which unlike XYZ / Y exists for y = 0 too, as that of ACES blue nearly is.
        let xyz = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y);
        let primaries = DMat3::from_cols(xyz(red), xyz(green), xyz(blue));
        if primaries.determinant().abs() < 1e-9 {
            return None;
        }
        let intensities = primaries.inverse() * (xyz(white) / white[1]);
        let matrix = primaries * DMat3::from_diagonal(intensities);
        (matrix.is_finite() && matrix.determinant().abs() > 1e-9).then_some(matrix)
    }

    /// The matrix to Rec. 709; `None` if these are Rec. 709 already. An error: no three lights have such chromaticities.
    pub fn to_rec_709(self) -> Result<Option<DMat3>, &'static str> {
        const IMPOSSIBLE: &str = "are those of no three lights";
        if self.is_near(&REC_709) {
            return Ok(None);
        }
        let xyz_from_rgb = self.xyz_from_rgb().ok_or(IMPOSSIBLE)?;
        let adaptation = adaptation(xyz_from_rgb * DVec3::ONE).ok_or(IMPOSSIBLE)?;
        Ok(Some(rec_709_from_xyz() * adaptation * xyz_from_rgb))
    }

    /// The shares of red, green and blue in luminance; those of Rec. 709 if these are no primaries.
    pub fn luminance_weights(&self) -> DVec3 {
        let matrix = self.xyz_from_rgb().or_else(|| REC_709.xyz_from_rgb()).expect("Rec. 709 has primaries");
        matrix.row(1)
    }
}

/// XYZ relative to the white of Rec. 709, whose Y is 1.
pub(super) fn rec_709_from_xyz() -> DMat3 {
    REC_709.xyz_from_rgb().expect("Rec. 709 has primaries").inverse()
}

/// Takes XYZ under a white to XYZ under that of Rec. 709.
fn adaptation(white: DVec3) -> Option<DMat3> {
    let target = REC_709.xyz_from_rgb()? * DVec3::ONE;
    let scale = (BRADFORD * target) / (BRADFORD * white);
    let matrix = BRADFORD.inverse() * DMat3::from_diagonal(scale) * BRADFORD;
    matrix.is_finite().then_some(matrix)
}

/// Applies `matrix` to every pixel.
pub(super) fn convert(pixels: &mut [[f32; 3]], matrix: DMat3) {
    pixels.par_iter_mut().with_min_len(1 << 12).for_each(|pixel| {
        *pixel = (matrix * DVec3::from(pixel.map(f64::from))).as_vec3().to_array();
    });
}

/// Says that colours were converted.
pub(super) fn note(from: &str) -> LoadNote {
    LoadNote::new("converted_colors", 1, format!("its colours were converted from {from} to Rec. 709"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: DVec3, b: [f64; 3], tolerance: f64) -> bool {
        (a - DVec3::from(b)).abs().max_element() < tolerance
    }

    #[test]
    fn rec_709_is_the_published_matrix() {
        // IEC 61966-2-1, annex; its digits are rounded.
        let matrix = rec_709_from_xyz();
        assert!(near(matrix.row(0), [3.2406, -1.5372, -0.4986], 5e-4), "{matrix}");
        assert!(near(matrix.row(1), [-0.9689, 1.8758, 0.0415], 5e-4), "{matrix}");
        assert!(near(matrix.row(2), [0.0557, -0.2040, 1.0570], 5e-4), "{matrix}");
        assert!(near(REC_709.luminance_weights(), [0.2126, 0.7152, 0.0722], 1e-4));
        assert_eq!(REC_709.to_rec_709(), Ok(None));
    }

    #[test]
    fn other_primaries() {
        // ITU-R BT.2087-0, the inverse of its matrix from BT.709 to BT.2020.
        let rec_2020 = Chromaticities([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]]);
        let matrix = rec_2020.to_rec_709().unwrap().unwrap();
        assert!(near(matrix.row(0), [1.6605, -0.5876, -0.0728], 2e-4), "{matrix}");
        assert!(near(matrix.row(1), [-0.1246, 1.1329, -0.0083], 2e-4), "{matrix}");
        assert!(near(matrix.row(2), [-0.0182, -0.1006, 1.1187], 2e-4), "{matrix}");
        // ACES2065-1 under D60: published by the Academy, with Bradford adaptation.
        let aces = Chromaticities([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]]);
        let matrix = aces.to_rec_709().unwrap().unwrap();
        assert!(near(matrix.row(0), [2.5217, -1.1341, -0.3876], 2e-3), "{matrix}");
        assert!(near(matrix * DVec3::ONE, [1.0; 3], 1e-9), "neutral must stay neutral: {matrix}");
    }

    #[test]
    fn numbers_that_are_no_primaries() {
        for value in [0.0, f64::NAN, 0.3] {
            assert!(Chromaticities([[value; 2]; 4]).to_rec_709().is_err(), "{value}");
        }
    }
}
