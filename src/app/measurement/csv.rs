//! The measured points as a table for other programs.

use super::Measurements;
use crate::export::csv;

/// What the columns hold. Times are in seconds, figures as in the panel; FLIP is empty where it was not asked for. An image
/// from a file counts as one sample.
const COLUMNS: &str = "scene,width,height,mode,samples,seconds,rectification_seconds,\
    relmse,relmse_standard_error,relmse_trimmed,mse,smape,flip,reference_samples";

/// The whole table.
pub fn table(scene: &str, measurements: &Measurements) -> String {
    let points =
        measurements.curves.iter().flat_map(|(mode, curve)| curve.points.iter().map(move |p| (mode, curve, p)));
    let rows = points.map(|(mode, curve, point)| {
        let figures = &point.squared;
        let times = (point.samples, point.seconds, curve.rectification_seconds);
        let squared = (figures.relmse, point.relmse_standard_error, figures.relmse_trimmed, figures.mse);
        (scene, measurements.size, mode.name(), times, squared, point.smape, point.flip, point.truth_samples)
    });
    csv::text(COLUMNS.split(','), rows)
}
