//! A table of errors as a picture: one cell for each place, its colour the logarithm of the error.

use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use maud::{Markup, html};

use super::plot::superscript;
use super::words::number;
use crate::color::along;
use crate::export::png_bytes;
use crate::report::stability::Map;

/// Decimal logarithms at the ends of the scale. f64 rounds at 1.1e-16.
const LOW: f64 = -17.0;
const HIGH: f64 = 0.0;
/// Where there is no error to show, because there is no such quantity.
const NOTHING: [u8; 3] = [0x80, 0x80, 0x86];
/// Nine places of *viridis* (Smith and van der Walt 2015), whose brightness rises evenly, for eyes with any of the usual colour deficiencies.
const STOPS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of an error; of 0, that of the low end.
fn color(error: f64) -> [u8; 3] {
    let part = (error.log10() - LOW) / (HIGH - LOW);
    along(&STOPS, (part * (STOPS.len() - 1) as f64) as f32)
}

/// Row 0 of the picture is the highest row of the map.
fn picture(map: &Map) -> Option<String> {
    let (width, height) = (map.etas.len() as u32, map.rows.len() as u32);
    let bytes = (map.relative_errors.iter().rev())
        .flat_map(|row| row.iter().flat_map(|error| error.map_or(NOTHING, color)))
        .collect();
    let image = image::RgbImage::from_raw(width, height, bytes)?;
    Some(BASE64_STANDARD.encode(png_bytes(&image, &[], Path::new(&map.formula)).ok()?))
}

/// The picture with its axes.
pub fn figure(map: &Map) -> Markup {
    let Some(png) = picture(map) else { return html! {} };
    let about = format!("Relative error of the {} by {}, over index and angle", map.quantity, map.formula);
    html! {
        figure class="map" {
            figcaption { (map.quantity) ", " (map.formula) }
            div class="map-axes" { span { "↑ " (map.row_parameter) ", " (ends(&map.rows)) } }
            img src={ "data:image/png;base64," (png) } width=(map.etas.len()) height=(map.rows.len()) alt=(about);
            div class="map-axes" { @for eta in places(&map.etas) { span { (number(eta)) } } }
            figcaption {
                "→ relative index η. Largest error " (number(map.worst)) "; where the problem is well conditioned " (number(map.worst_well_conditioned))
                "; " (map.wrong_decisions) " wrong decisions about total reflection."
            }
        }
    }
}

/// Values at the ends and three places between, at even distances in the picture.
fn places(values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..5).filter_map(|k| values.get(last * k / 4).copied()).collect()
}

fn ends(values: &[f64]) -> String {
    match (values.first(), values.last()) {
        (Some(first), Some(last)) => format!("{} to {}", number(*first), number(*last)),
        _ => String::new(),
    }
}

/// The colours with their errors, for all maps.
pub fn scale() -> Markup {
    let stops: Vec<String> = (0..=16)
        .map(|k| {
            let [r, g, b] = color(10_f64.powf(LOW + (HIGH - LOW) * f64::from(k) / 16.0));
            format!("rgb({r} {g} {b})")
        })
        .collect();
    html! {
        div style="max-width: 34rem" {
            div class="ramp" style={ "background: linear-gradient(to right, " (stops.join(", ")) ")" } role="img" aria-label="Scale of the relative errors" {}
            div class="ramp-ends" {
                span { "10" (superscript(LOW as i32)) " or exact" } span { "10⁻¹³" } span { "10⁻⁹" } span { "10⁻⁴" } span { "1 or more" }
            }
            p class="muted" { "Grey: reflection is total, or there is no such angle." }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_with_the_error() {
        let brightness = |error: f64| {
            let [r, g, b] = color(error).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let rising: Vec<f64> = (-18..=1).map(|k| brightness(10_f64.powi(k))).collect();
        assert!(rising.windows(2).all(|pair| pair[0] <= pair[1]), "{rising:?}");
        assert_eq!((color(0.0), color(7.0)), (STOPS[0], STOPS[8]));
        assert_eq!(color(f64::NAN), [255, 0, 255]);
    }
}
