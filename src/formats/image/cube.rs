//! Cube maps: crosses are converted to latitude–longitude, strips are named and refused. Images of other odd shapes are read as they are.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::LoadNote;
use crate::scene::environment::EnvironmentImage;

/// Tells latitude–longitude images from cube maps, by shape and contents:
///
/// - 4 squares by 3 or 3 by 4 are a **cross** if the six squares outside it are of one colour and the faces are not (see [`is_cross`]). It
///   is converted.
/// - 6 squares by 1 or 1 by 6 are a **strip** of faces if the picture breaks off where they meet (see [`is_strip`]). Its order and
///   orientations differ from program to program, so it is refused.
/// - Anything else is stretched over the sphere, with a note unless it is twice as wide as high.
pub(super) fn unfold(image: &mut EnvironmentImage) -> Result<(), String> {
    let (width, height) = (image.width, image.height);
    let cross = [&HORIZONTAL, &VERTICAL].into_iter().find(|layout| {
        width * layout.rows == height * layout.columns && width % layout.columns == 0 && is_cross(image, layout)
    });
    if let Some(layout) = cross {
        *image = from_cross(image, layout);
        let message = format!(
            "the environment image is a cube map unfolded into a cross, and was converted to latitude–longitude of {}×{} pixels",
            image.width, image.height
        );
        image.notes.push(LoadNote::new("converted_cross", 1, message));
        return Ok(());
    }
    if (width == 6 * height || height == 6 * width) && is_strip(image) {
        return Err(format!(
            "looks like the six faces of a cube map in a strip ({width}×{height}), which is not read: convert it to a latitude–longitude \
             image, twice as wide as high, or arrange its faces in a cross"
        ));
    }
    if width.abs_diff(2 * height) * 100 > height {
        let message = format!(
            "the environment image has {width}×{height} pixels, but latitude–longitude images are twice as wide as high: it is \
             stretched over the whole sphere. A cube map, a mirror ball or a part of a panorama must be converted first"
        );
        image.notes.push(LoadNote::new("unusual_aspect", 1, message));
    }
    Ok(())
}

/// A cross: squares in columns and rows, six of them faces. All continue one another, around the one that is looked at straight ahead (−z,
/// the middle of a latitude–longitude image).
struct Cross {
    columns: usize,
    rows: usize,
    /// The one that differs: right of the others, or below them, upside down.
    behind: Face,
}

/// A face as seen from the middle of the cube: its pixel at (s, t) in [−1, 1]², to the right and down, lies in the direction
/// `forward` + s `right` + t `down`.
struct Face {
    column: usize,
    row: usize,
    forward: DVec3,
    right: DVec3,
    down: DVec3,
}

const fn face(column: usize, row: usize, forward: DVec3, right: DVec3, down: DVec3) -> Face {
    Face { column, row, forward, right, down }
}

/// Where they are in both crosses.
const FACES: [Face; 5] = [
    face(1, 0, DVec3::Y, DVec3::X, DVec3::NEG_Z),
    face(0, 1, DVec3::NEG_X, DVec3::NEG_Z, DVec3::NEG_Y),
    face(1, 1, DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
    face(2, 1, DVec3::X, DVec3::Z, DVec3::NEG_Y),
    face(1, 2, DVec3::NEG_Y, DVec3::X, DVec3::Z),
];

const HORIZONTAL: Cross = Cross { columns: 4, rows: 3, behind: face(3, 1, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y) };
const VERTICAL: Cross = Cross { columns: 3, rows: 4, behind: face(1, 3, DVec3::Z, DVec3::X, DVec3::Y) };

impl Cross {
    fn faces(&self) -> impl Iterator<Item = &Face> {
        FACES.iter().chain([&self.behind])
    }
}

/// Whether all of the squares that are no faces have one colour (but for the noise of JPEG, and a sixteenth at their edges, where it is
/// strongest), while most of the faces have others: at least half of their pixels, in at least five of the six.
fn is_cross(image: &EnvironmentImage, layout: &Cross) -> bool {
    let side = image.width / layout.columns;
    if side < 2 {
        return false;
    }
    let is_face = |column, row| layout.faces().any(|face| (face.column, face.row) == (column, row));
    let background = image.pixels[side / 2 * image.width + side / 2];
    let is_background =
        |pixel: [f32; 3]| pixel.iter().zip(background).all(|(a, b)| (a - b).abs() <= 0.002 + 0.04 * b.abs());
    // Pixels of a square that are not of the background's colour.
    let others = |column: usize, row: usize, margin: usize| {
        let rows = row * side + margin..(row + 1) * side - margin;
        let columns = column * side + margin..(column + 1) * side - margin;
        let row = |y: usize| &image.pixels[y * image.width..][columns.clone()];
        rows.map(|y| row(y).iter().filter(|pixel| !is_background(**pixel)).count()).sum::<usize>()
    };
    let squares = (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
    if squares.clone().any(|(column, row)| !is_face(column, row) && others(column, row, side / 16) > 0) {
        return false;
    }
    let filled: Vec<usize> = layout.faces().map(|face| others(face.column, face.row, 0)).collect();
    filled.iter().filter(|count| **count > 0).count() >= 5 && 2 * filled.iter().sum::<usize>() >= 6 * side * side
}

/// Whether at four or more of the five places where faces would meet neighbouring pixels differ more than twice as much as beside them.
/// A panorama that is just very wide goes on there.
fn is_strip(image: &EnvironmentImage) -> bool {
    let is_wide = image.width > image.height;
    let (side, stride, across) = if is_wide { (image.height, 1, image.width) } else { (image.width, image.width, 1) };
    if side < 2 {
        return false;
    }
    let luminance = |at: usize| image.pixels[at].iter().map(|x| f64::from(*x)).sum::<f64>();
    // Mean relative difference between lines `line` − 1 and `line` of pixels.
    let jump = |line: usize| {
        let differences = (0..side).map(|along| {
            let (a, b) = (luminance((line - 1) * stride + along * across), luminance(line * stride + along * across));
            if a == b { 0.0 } else { (a - b).abs() / (a + b) }
        });
        differences.sum::<f64>() / side as f64
    };
    let breaks = (1..6).filter(|face| {
        let line = face * side;
        jump(line) > 0.01 + (jump(line - 1) + jump(line + 1))
    });
    breaks.count() >= 4
}

/// A latitude–longitude image about as fine as the faces are in their middle: four of them wide, two high.
fn from_cross(image: &EnvironmentImage, layout: &Cross) -> EnvironmentImage {
    let side = image.width / layout.columns;
    let (width, height) = (4 * side, 2 * side);
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
        let (sin_theta, cos_theta) = (PI * (row as f64 + 0.5) / height as f64).sin_cos();
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let (sin_phi, cos_phi) = (TAU * ((column as f64 + 0.5) / width as f64 - 0.5)).sin_cos();
            *pixel = look_up(image, layout, DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi));
        }
    });
    EnvironmentImage { width, height, pixels, notes: image.notes.clone() }
}

/// Bilinear between the pixels of a face; pixels at its edges reach over it.
fn look_up(image: &EnvironmentImage, layout: &Cross, direction: DVec3) -> [f32; 3] {
    let side = image.width / layout.columns;
    let ahead = |face: &Face| face.forward.dot(direction);
    let face = layout.faces().max_by(|a, b| ahead(a).total_cmp(&ahead(b))).expect("there are six");
    let place = |axis: DVec3| {
        let x = (0.5 + 0.5 * axis.dot(direction) / ahead(face)) * side as f64 - 0.5;
        let x = x.clamp(0.0, (side - 1) as f64);
        let low = x.floor() as usize;
        (low, (low + 1).min(side - 1), x - x.floor())
    };
    let ((left, right, fx), (top, bottom, fy)) = (place(face.right), place(face.down));
    let texel = |column: usize, row: usize| {
        let at = (face.row * side + row) * image.width + face.column * side + column;
        DVec3::from(image.pixels[at].map(f64::from))
    };
    let above = texel(left, top).lerp(texel(right, top), fx);
    let below = texel(left, bottom).lerp(texel(right, bottom), fx);
    above.lerp(below, fy).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, color: impl Fn(usize, usize) -> [f32; 3]) -> EnvironmentImage {
        let pixels = (0..width * height).map(|i| color(i % width, i / width)).collect();
        EnvironmentImage { width, height, pixels, notes: Vec::new() }
    }

    fn kinds(image: &EnvironmentImage) -> Vec<&'static str> {
        image.notes.iter().map(|note| note.kind).collect()
    }

    /// What is seen in a direction: smooth, and different all around.
    fn sky(direction: DVec3) -> [f32; 3] {
        (direction.normalize() * 0.4 + 0.5).as_vec3().to_array()
    }

    /// The six faces by their places in the cross, each with a rule of its own that was worked out by hand: (s, t) to the direction.
    type Rule = fn(f64, f64) -> DVec3;
    const MIDDLE: [((usize, usize), Rule); 5] = [
        ((1, 0), |s, t| DVec3::new(s, 1.0, -t)),
        ((0, 1), |s, t| DVec3::new(-1.0, -t, -s)),
        ((1, 1), |s, t| DVec3::new(s, -t, -1.0)),
        ((2, 1), |s, t| DVec3::new(1.0, -t, s)),
        ((1, 2), |s, t| DVec3::new(s, -1.0, t)),
    ];

    fn cross(
        [columns, rows]: [usize; 2],
        back: ((usize, usize), Rule),
        side: usize,
        ground: [f32; 3],
    ) -> EnvironmentImage {
        image(columns * side, rows * side, |x, y| {
            let of = |at: usize| 2.0 * ((at % side) as f64 + 0.5) / side as f64 - 1.0;
            let place = (x / side, y / side);
            let rule = MIDDLE.iter().chain([&back]).find(|(square, _)| *square == place);
            rule.map_or(ground, |(_, rule)| sky(rule(of(x), of(y))))
        })
    }

    fn crosses(side: usize, ground: [f32; 3]) -> [EnvironmentImage; 2] {
        [
            cross([4, 3], ((3, 1), |s, t| DVec3::new(-s, -t, 1.0)), side, ground),
            cross([3, 4], ((1, 3), |s, t| DVec3::new(s, t, 1.0)), side, ground),
        ]
    }

    #[test]
    fn crosses_become_what_they_show() {
        for side in [2, 16, 64] {
            for mut image in crosses(side, [0.0; 3]).into_iter().chain(crosses(side, [1.0; 3])) {
                unfold(&mut image).unwrap();
                assert_eq!((image.width, image.height), (4 * side, 2 * side));
                assert_eq!(kinds(&image), ["converted_cross"]);
                for (at, pixel) in image.pixels.iter().enumerate() {
                    let theta = PI * ((at / image.width) as f64 + 0.5) / image.height as f64;
                    let phi = TAU * (((at % image.width) as f64 + 0.5) / image.width as f64 - 0.5);
                    let right = sky(DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()));
                    let error = (DVec3::from(pixel.map(f64::from)) - DVec3::from(right.map(f64::from))).length();
                    assert!(error < 0.6 / side as f64, "{side}: {at}: {pixel:?} {right:?}");
                }
            }
        }
    }

    #[test]
    fn odd_shapes_that_are_no_crosses() {
        // A photograph; one colour; lamps on black, in some of the faces' squares only.
        let photo = image(64, 48, |x, y| [0.1 + x as f32 / 64.0, 0.2 + y as f32 / 48.0, 0.5]);
        let plain = image(64, 48, |_, _| [0.25; 3]);
        let lamps = image(64, 48, |x, y| [if (20..24).contains(&x) && y % 16 == 8 { 9.0 } else { 0.0 }; 3]);
        let tall = image(48, 64, |x, y| [0.1 + x as f32 / 48.0, 0.2 + y as f32 / 64.0, 0.5]);
        for mut odd in [photo, plain, lamps, tall] {
            let before = odd.clone();
            unfold(&mut odd).unwrap();
            assert_eq!(kinds(&odd), ["unusual_aspect"]);
            assert_eq!(odd.pixels, before.pixels);
        }
    }

    #[test]
    fn noise_of_jpeg_does_not_hide_a_cross() {
        for image in crosses(32, [0.0; 3]) {
            let mut noisy = image;
            noisy.pixels.iter_mut().enumerate().for_each(|(i, pixel)| pixel[i % 3] += (i * i % 7) as f32 * 2e-4);
            unfold(&mut noisy).unwrap();
            assert_eq!(kinds(&noisy), ["converted_cross"]);
        }
    }

    #[test]
    fn strips_are_named_and_wide_panoramas_read() {
        let side = 16;
        let faces: [Rule; 6] = [
            |s, t| DVec3::new(1.0, -t, -s),
            |s, t| DVec3::new(-1.0, -t, s),
            |s, t| DVec3::new(s, 1.0, t),
            |s, t| DVec3::new(s, -1.0, -t),
            |s, t| DVec3::new(s, -t, 1.0),
            |s, t| DVec3::new(-s, -t, -1.0),
        ];
        let of = |at: usize| 2.0 * ((at % side) as f64 + 0.5) / side as f64 - 1.0;
        let wide = image(6 * side, side, |x, y| sky(faces[x / side](of(x), of(y))));
        let tall = image(side, 6 * side, |x, y| sky(faces[y / side](of(x), of(y))));
        let plain = image(6 * side, side, |x, _| [(x / side) as f32; 3]);
        for mut strip in [wide, tall, plain] {
            let message = unfold(&mut strip).unwrap_err();
            assert!(message.contains("strip") && message.contains("latitude–longitude"), "{message}");
        }
        let panorama = image(6 * side, side, |x, y| [1.5 + (x as f32 / 9.0).sin(), 0.2 + y as f32 / 16.0, 0.5]);
        let noise = image(6 * side, side, |x, y| [(x * 7919 + y * 104_729) as f32 % 31.0; 3]);
        let tiny = image(6, 1, |x, _| [x as f32; 3]);
        for mut odd in [panorama, noise, tiny] {
            unfold(&mut odd).unwrap();
            assert_eq!(kinds(&odd), ["unusual_aspect"]);
        }
    }

    #[test]
    fn latitude_longitude_is_not_remarked_upon() {
        for (width, height) in [(2, 1), (64, 32), (1000, 499)] {
            let mut image = image(width, height, |x, y| [x as f32, y as f32, 1.0]);
            unfold(&mut image).unwrap();
            assert_eq!(image.notes, []);
        }
    }
}
