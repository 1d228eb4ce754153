//! Fresnel's equations against 60-digit arithmetic (`data/make_fresnel.py`), over typical, nearly equal, extreme and inverted indices,
//! dense around critical angles.

use iorect::optics::Interface;
use iorect::optics::fresnel::Refraction;

#[derive(serde::Deserialize)]
struct Row {
    class: String,
    m1: f64,
    m2: f64,
    c: f64,
    reflectance: f64,
    transmittance: f64,
}

fn rows() -> Vec<Row> {
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).from_reader(include_bytes!("../data/fresnel.csv").as_slice());
    reader.deserialize().map(|row| row.expect("a name and five numbers")).collect()
}

/// Largest error of `formula`, in units of 2⁻⁵³ (1 + c²/b²): what one rounding of the inputs does to the answer.
fn worst_error(formula: impl Fn(&Row) -> (f64, f64)) -> (f64, String) {
    let mut worst = (0.0, String::new());
    for row in rows() {
        let ratio = (1.0 + row.m2) / (1.0 + row.m1);
        let b_squared = ratio * ratio - (1.0 - row.c * row.c);
        let condition = if b_squared > 0.0 { 1.0 + row.c * row.c / b_squared } else { 1.0 };
        let (r, t) = formula(&row);
        let mut errors = vec![(r / row.reflectance - 1.0).abs()];
        if row.transmittance > 0.0 {
            errors.push((t / row.transmittance - 1.0).abs());
        }
        let error = errors.into_iter().fold(0.0, f64::max) / (condition * f64::EPSILON / 2.0);
        if error.is_nan() || error > worst.0 {
            worst = (error, format!("{}: {} → {} at {}", row.class, row.m1, row.m2, row.c));
        }
    }
    worst
}

#[test]
fn every_class_of_interface_keeps_its_digits() {
    assert!(rows().len() > 400);
    let (error, place) = worst_error(|row| {
        let interface = Interface::new(row.m1, row.m2);
        match interface.refraction(row.c) {
            Refraction::TotalReflection => (1.0, 0.0),
            Refraction::Partial { reflectance, b } => (reflectance, interface.transmittance(row.c, b)),
        }
    });
    assert!(error < 64.0, "{error} roundings at {place}");
}

/// The same test fails for the usual formulas on n instead of n − 1.
#[test]
fn the_usual_formulas_do_not() {
    let (error, _) = worst_error(|row| {
        let (n1, n2) = (1.0 + row.m1, 1.0 + row.m2);
        let sin2_t = (n1 / n2) * (n1 / n2) * (1.0 - row.c * row.c);
        if sin2_t >= 1.0 {
            return (1.0, 0.0);
        }
        let ct = (1.0 - sin2_t).sqrt();
        let rs = (n1 * row.c - n2 * ct) / (n1 * row.c + n2 * ct);
        let rp = (n2 * row.c - n1 * ct) / (n2 * row.c + n1 * ct);
        let r = 0.5 * (rs * rs + rp * rp);
        (r, 1.0 - r)
    });
    assert!(error > 1e6, "{error}");
}
