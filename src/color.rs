//! Colours as screens and files hold them: the transfer function of sRGB, and scales of false colours.

/// What stands for a number that is none, in every picture: magenta, which no scale holds.
pub const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// An encoded component in [0, 1] as linear light: IEC 61966-2-1.
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Linear light in [0, 1] as an encoded component: IEC 61966-2-1.
#[inline]
pub fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Luminance of linear Rec. 709.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// From `a` at 0 to `b` at 1, in encoded components.
pub fn mixed(a: [u8; 3], b: [u8; 3], part: f32) -> [u8; 3] {
    std::array::from_fn(|i| (f32::from(a[i]) + part * (f32::from(b[i]) - f32::from(a[i]))).round() as u8)
}

/// The colour at `place`, from 0 at the first of `stops` to their number less one at the last; beyond the ends as at them.
pub fn along(stops: &[[u8; 3]], place: f32) -> [u8; 3] {
    if place.is_nan() {
        return NOT_A_NUMBER;
    }
    let place = place.clamp(0.0, (stops.len() - 1) as f32);
    let below = (place as usize).min(stops.len() - 2);
    mixed(stops[below], stops[below + 1], place - below as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transfer_function_has_its_known_values_and_its_inverse() {
        assert!((srgb_from_linear(0.214_041_14) - 0.5).abs() < 1e-6);
        assert_eq!([linear_from_srgb(0.0), linear_from_srgb(1.0)], [0.0, 1.0]);
        for value in 0..=255 {
            let x = f32::from(value as u8) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-6, "{value}");
        }
    }

    #[test]
    fn scales_end_at_their_ends() {
        let stops = [[0, 0, 0], [100, 200, 50], [255, 255, 255]];
        let places = [-1.0, 0.5, 1.0, 7.0, f32::NAN].map(|place| along(&stops, place));
        assert_eq!(places, [stops[0], [50, 100, 25], stops[1], stops[2], NOT_A_NUMBER]);
    }
}
