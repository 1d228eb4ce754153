//! Pixels that are no light: negative components, and such as are no finite number.

use crate::scene::LoadNote;
use crate::scene::environment::EnvironmentImage;

/// Sets negative components to 0, and gives each component that is not finite the mean of the finite ones among its eight neighbours (the
/// image wraps around sideways). Where no neighbour is finite, an infinite component gets the largest finite value of its channel, and one
/// that is no number 0. Both are counted.
pub(super) fn repair(image: &mut EnvironmentImage) {
    // Most images are fine, and many components are compared at once.
    let are_fine = |some: &[f32]| some.iter().fold(true, |fine, x| fine & (*x >= 0.0) & (*x <= f32::MAX));
    if image.pixels.as_flattened().chunks(4096).all(are_fine) {
        return;
    }
    let (mut clipped, mut broken) = (0, 0);
    let mut largest = [0.0_f32; 3];
    for pixel in &mut image.pixels {
        for (component, largest) in pixel.iter_mut().zip(&mut largest) {
            if !component.is_finite() {
                continue;
            }
            if *component < 0.0 {
                *component = 0.0;
                clipped += 1;
            }
            *largest = largest.max(*component);
        }
        broken += u64::from(!is_finite(*pixel));
    }
    if broken > 0 {
        replace(image, largest);
        note_replaced(image, broken, "the environment image");
    }
    if clipped > 0 {
        let message = format!("{clipped} components of the environment image were negative and have been set to 0");
        image.notes.push(LoadNote::new("clipped_pixels", clipped, message));
    }
}

/// As [`repair`], but negative components stay: for pictures, of which denoisers and filters with negative lobes leave some.
pub(super) fn replace_broken(image: &mut EnvironmentImage) {
    let broken = image.pixels.iter().filter(|pixel| !is_finite(**pixel)).count() as u64;
    if broken > 0 {
        let finite = image.pixels.iter().flatten().filter(|component| component.is_finite());
        let largest = finite.fold(0.0_f32, |largest, component| largest.max(*component));
        replace(image, [largest; 3]);
        note_replaced(image, broken, "the image");
    }
}

fn note_replaced(image: &mut EnvironmentImage, count: u64, what: &str) {
    let pixels = if count == 1 { "pixel" } else { "pixels" };
    let message = format!(
        "{count} {pixels} of {what} had components that are no finite numbers; each has been replaced by the mean of its neighbours"
    );
    image.notes.push(LoadNote::new("replaced_pixels", count, message));
}

fn is_finite(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|component| component.is_finite())
}

fn replace(image: &mut EnvironmentImage, largest: [f32; 3]) {
    let width = image.width;
    // What was replaced must not count as a neighbour: the rows at hand as they were.
    let mut above = Vec::new();
    for row in 0..image.height {
        let here = image.pixels[row * width..][..width].to_vec();
        if here.iter().any(|pixel| !is_finite(*pixel)) {
            let (now, below) = image.pixels[row * width..].split_at_mut(width);
            let rows = [&above[..], &here[..], &below[..width.min(below.len())]];
            for (column, pixel) in now.iter_mut().enumerate() {
                for channel in 0..3 {
                    if !pixel[channel].is_finite() {
                        let fallback = if pixel[channel] == f32::INFINITY { largest[channel] } else { 0.0 };
                        pixel[channel] = mean_around(rows, column, channel).unwrap_or(fallback);
                    }
                }
            }
        }
        above = here;
    }
}

/// Mean of the finite components around `column` of the middle row; rows beyond the image are empty.
fn mean_around(rows: [&[[f32; 3]]; 3], column: usize, channel: usize) -> Option<f32> {
    let width = rows[1].len();
    let columns = [(column + width - 1) % width, column, (column + 1) % width];
    let (mut sum, mut count) = (0.0, 0);
    for row in rows.into_iter().filter(|row| !row.is_empty()) {
        for value in columns.map(|column| row[column][channel]).into_iter().filter(|value| value.is_finite()) {
            sum += f64::from(value);
            count += 1;
        }
    }
    (count > 0).then(|| (sum / f64::from(count)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repaired(width: usize, values: &[f32]) -> (Vec<f32>, Vec<(&'static str, u64)>) {
        let pixels = values.iter().map(|value| [*value, 1.0, 2.0]).collect();
        let mut image = EnvironmentImage { width, height: values.len() / width, pixels, notes: Vec::new() };
        repair(&mut image);
        assert!(image.pixels.iter().all(|pixel| pixel[1..] == [1.0, 2.0]));
        let notes = image.notes.iter().map(|note| (note.kind, note.count)).collect();
        (image.pixels.iter().map(|pixel| pixel[0]).collect(), notes)
    }

    const INF: f32 = f32::INFINITY;
    const NAN: f32 = f32::NAN;

    #[test]
    fn negative_components_become_zero_and_nothing_else() {
        assert_eq!(repaired(2, &[-1.0, 0.5, 3.0, -1e-30]), (vec![0.0, 0.5, 3.0, 0.0], vec![("clipped_pixels", 2)]));
        assert_eq!(repaired(2, &[0.0, 0.5, 1e30, f32::MAX]), (vec![0.0, 0.5, 1e30, f32::MAX], vec![]));
    }

    #[test]
    fn others_become_the_mean_of_their_neighbors() {
        for broken in [INF, -INF, NAN] {
            let values = [1.0, 2.0, 3.0, 4.0, broken, 6.0, 7.0, 8.0, 17.0];
            let (pixels, notes) = repaired(3, &values);
            assert_eq!((pixels[4], notes), (6.0, vec![("replaced_pixels", 1)]));
        }
        // A negative neighbour counts as 0; the image wraps around sideways, not up and down.
        assert_eq!(repaired(4, &[INF, 2.0, 99.0, -8.0]).0, [1.0, 2.0, 99.0, 0.0]);
    }

    #[test]
    fn negative_components_of_pictures_stay() {
        let pixels = [-1.0, 2.0, NAN, 5.0].map(|value| [value, 1.0, -2.0]).to_vec();
        let mut image = EnvironmentImage { width: 4, height: 1, pixels, notes: Vec::new() };
        replace_broken(&mut image);
        assert_eq!(image.pixels, [-1.0, 2.0, 3.5, 5.0].map(|value| [value, 1.0, -2.0]));
        assert_eq!((image.notes[0].kind, image.notes[0].count), ("replaced_pixels", 1));
    }

    #[test]
    fn neighbors_count_as_they_were() {
        assert_eq!(repaired(4, &[NAN, NAN, 2.0, 4.0]).0, [4.0, 2.0, 2.0, 4.0]);
        let (pixels, _) = repaired(1, &[NAN, NAN, 8.0]);
        assert_eq!(pixels, [0.0, 8.0, 8.0]);
    }

    #[test]
    fn without_finite_neighbors() {
        let far = [INF, INF, INF, INF, INF, INF, INF, NAN, INF, 0.5, 0.5, 7.0];
        let (pixels, notes) = repaired(3, &far);
        assert_eq!(pixels[..6], [7.0; 6]);
        assert_eq!(notes, [("replaced_pixels", 9)]);
        assert_eq!(repaired(2, &[NAN; 4]).0, [0.0; 4]);
        assert_eq!(repaired(2, &[INF; 4]).0, [0.0; 4]);
    }
}
