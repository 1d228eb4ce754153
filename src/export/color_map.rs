//! False colours for differences: blue through black to orange, which eyes with any of the usual colour deficiencies keep apart.
//! Black is no difference, and brightness alone tells how large one is.

use crate::color::along;

/// At −1, −0.6, −0.2, 0, 0.2, 0.6 and 1, with brightness rising away from 0 on both sides.
const STOPS: [[u8; 3]; 7] =
    [[199, 237, 255], [69, 158, 240], [18, 61, 115], [11, 11, 14], [102, 48, 13], [237, 135, 33], [255, 235, 184]];

/// The sRGB colour of `x`; beyond ±1 as at ±1, NaN magenta.
pub fn diverging(x: f32) -> [u8; 3] {
    let steps_from_middle = (x.abs() / 0.2).min((x.abs() + 0.2) / 0.4);
    along(&STOPS, 3.0 + steps_from_middle.copysign(x))
}

pub use crate::color::luminance;

/// The smallest of 1, 2 or 5 times a power of ten that is at least `x`, for the ends of a scale; 1e-6 at least, so that noise in the
/// last digits of equal images is not blown up to full colour.
pub fn round_up_to_125(x: f32) -> f32 {
    let x = f64::from(x.max(1e-6));
    if !x.is_finite() {
        return f32::MAX;
    }
    let decade = 10_f64.powi(x.log10().floor() as i32);
    // The tolerance keeps 0.2, which is a little more in binary, from becoming 0.5.
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * decade >= x * (1.0 - 1e-6)).unwrap_or(10.0);
    (factor * decade) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_difference_is_dark_and_the_ends_are_bright_and_apart() {
        let brightness = |x: f32| diverging(x).map(u32::from).iter().sum::<u32>();
        assert!(brightness(0.0) < 60);
        for side in [-1.0, 1.0] {
            let rising: Vec<u32> = (0..=100).map(|i| brightness(side * i as f32 / 100.0)).collect();
            assert!(rising.windows(2).all(|w| w[1] >= w[0]), "brightness must rise with the difference");
        }
        let (less, more) = (diverging(-0.6), diverging(0.6));
        assert!(less[2] > less[0] && more[0] > more[2], "blue below, orange above");
        assert_eq!(diverging(-7.0), diverging(-1.0));
        assert_eq!(diverging(f32::NAN), [255, 0, 255]);
    }

    #[test]
    fn scales_end_on_round_numbers() {
        for (x, expected) in
            [(0.2, 0.2), (0.21, 0.5), (0.7, 1.0), (1.0, 1.0), (1.3, 2.0), (4.0e-3, 5.0e-3), (0.0, 1e-6)]
        {
            let got = round_up_to_125(x);
            assert!((got / expected - 1.0).abs() < 1e-5, "{x} gives {got}, not {expected}");
        }
    }
}
