//! Error metrics against values worked out by hand, and against other implementations.

use iorect::measure::flip::{self, Flip, Reference};
use iorect::measure::{MetricError, block_means, difference, difference_from_two};
use iorect::render::{Display, ToneCurve};
use serde_json::Value;

fn close(got: f64, expected: f64) {
    assert!((got - expected).abs() <= 1e-7 * expected.abs().max(1e-9), "{got} is not {expected}");
}

#[test]
fn figures_by_hand() {
    // Pixel 1: 0.5 against 0.25 in all channels; pixel 2: black against black in red, 1 against 0 in green, 0 against 1 in blue.
    let image = [[0.5; 3], [0.0, 1.0, 0.0]];
    let reference = [[0.25; 3], [0.0, 0.0, 1.0]];
    let d = difference(&image, &reference).unwrap();
    // (3 · 0.0625 + 0 + 1 + 1) / 6
    close(d.mse, 2.1875 / 6.0);
    // (3 · 0.25 + 0 + 1 + 1) / 6
    close(d.mean_abs, 2.75 / 6.0);
    // 0.0625/(0.0625 + 0.01) three times, then 0, 1/0.01, 1/1.01
    close(d.relmse, (3.0 * 0.0625 / 0.0725 + 100.0 + 1.0 / 1.01) / 6.0);
    // 2 · 0.25/0.76 three times, then 0, 2/1.01, 2/1.01
    close(d.smape, (3.0 * 0.5 / 0.76 + 4.0 / 1.01) / 6.0);
    // Two pixels are too few to leave one out.
    close(d.relmse_trimmed, d.relmse);
}

#[test]
fn equal_images_do_not_differ() {
    let image = vec![[0.1, 0.0, 7.0]; 50];
    let d = difference(&image, &image).unwrap();
    assert_eq!([d.mse, d.relmse, d.relmse_trimmed, d.mean_abs, d.smape], [0.0; 5]);
}

#[test]
fn trimming_leaves_out_the_worst_thousandth_and_no_more() {
    // 2000 pixels of relative error 0.01²/(1 + 0.01), three of them fireflies: two are left out, one stays.
    let reference = vec![[1.0_f32; 3]; 2000];
    let mut image = vec![[1.0_f32 + 0.0625; 3]; 2000];
    image[5] = [1001.0; 3];
    image[700] = [501.0; 3];
    image[1999] = [3.0; 3];
    let d = difference(&image, &reference).unwrap();
    let ordinary = 0.0625 * 0.0625 / 1.01;
    close(d.relmse_trimmed, (1997.0 * ordinary + 4.0 / 1.01) / 1998.0);
    close(d.relmse, (1997.0 * ordinary + (4.0 + 250_000.0 + 1_000_000.0) / 1.01) / 2000.0);
}

#[test]
fn block_means_by_hand() {
    // 3×2 pixels in blocks of 2: the right column is a block of its own, one pixel wide.
    let pixels: Vec<[f32; 3]> = [1.0, 2.0, 10.0, 3.0, 4.0, 20.0].map(|x| [x, 2.0 * x, 0.0]).into();
    let means = block_means(&pixels, 3, 2, 2).unwrap();
    assert_eq!(means, [[2.5, 5.0, 0.0], [15.0, 30.0, 0.0]]);
    // Noise that cancels within a block leaves no difference.
    let noisy: Vec<[f32; 3]> = (0..256).map(|i| [if i % 2 == 0 { 0.5 } else { 1.5 }; 3]).collect();
    assert_eq!(block_means(&noisy, 16, 16, 16).unwrap(), [[1.0; 3]]);
}

#[test]
fn what_is_not_finite_or_does_not_fit_is_refused() {
    let good = vec![[1.0_f32; 3]; 4];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut image = good.clone();
        image[2][1] = bad;
        assert_eq!(difference(&image, &good), Err(MetricError::NotFinite { which: "image", pixel: 2 }));
        assert_eq!(difference(&good, &image), Err(MetricError::NotFinite { which: "reference", pixel: 2 }));
        assert_eq!(block_means(&image, 2, 2, 1), Err(MetricError::NotFinite { which: "image", pixel: 2 }));
    }
    assert_eq!(difference(&good, &good[..3]), Err(MetricError::SizesDiffer { image: 4, reference: 3 }));
    assert_eq!(difference(&[], &[]), Err(MetricError::Empty));
    assert_eq!(block_means(&[], 0, 0, 16), Err(MetricError::Empty));
    assert_eq!(block_means(&good, 3, 2, 16), Err(MetricError::WrongShape { pixels: 4, width: 3, height: 2 }));
}

const WIDTH: usize = 56;
const HEIGHT: usize = 40;
type Image = Vec<[f32; 3]>;

/// Uniform in [0, 1): as in `data/make_metrics.py`.
fn noise(seed: u32, component: usize) -> f64 {
    let mut h = (component as u32).wrapping_add(seed.wrapping_mul(1_000_003)).wrapping_mul(0x9E37_79B1);
    h = (h ^ (h >> 15)).wrapping_mul(0x85EB_CA77);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE3D);
    f64::from(h ^ (h >> 16)) / 4_294_967_296.0
}

/// One component of the picture of `data/make_metrics.py`.
fn picture(x: usize, y: usize, c: usize) -> f64 {
    let ramp = ((x * (c + 1) * 5 + y * (3 - c) * 7) % 256) as f64 / 256.0;
    let is_in_disc = (x as i32 - 20).pow(2) + (y as i32 - 18).pow(2) < 150;
    let is_striped = (x / 3 + c).is_multiple_of(2) && y > 28;
    let value = 0.25 + 0.5 * ramp + if is_striped { 0.25 } else { 0.0 };
    if is_in_disc { 0.5 * value + if c == 0 { 0.5 } else { 0.0 } } else { value }
}

/// An image from a function of column, row, channel and the number of the component.
fn image(of: impl Fn(usize, usize, usize, usize) -> f64) -> Image {
    let pixel = |i: usize| [0, 1, 2].map(|c| of(i % WIDTH, i / WIDTH, c, 3 * i + c) as f32);
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// The test image and the reference of that name.
fn images(name: &str) -> (Image, Image) {
    let reference = image(|x, y, c, _| picture(x, y, c));
    let radiance = |x: usize, y: usize, c: usize, i: usize| {
        if x < 6 && y < 6 {
            return 0.0;
        }
        let scale = if noise(2, i - c) < 0.02 { 1024.0 } else { 1.0 };
        picture(x, y, c) * picture(x, y, c) * (scale * if x < 9 { 0.000_976_562_5 } else { 1.0 })
    };
    match name {
        "noisy" => (image(|x, y, c, i| (picture(x, y, c) + 0.25 * (noise(1, i) - 0.5)).clamp(0.0, 1.0)), reference),
        "moved" => (image(|x, y, c, _| picture((x + WIDTH - 2) % WIDTH, y, c)), reference),
        "radiance" => {
            let is_firefly = |x: usize, y: usize| (x, y) == (11, 30);
            let test =
                image(|x, y, c, i| if is_firefly(x, y) { 5000.0 } else { radiance(x, y, c, i) * (0.5 + noise(3, i)) });
            (test, image(radiance))
        }
        _ => panic!("there is no `{name}`"),
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn cases() -> Vec<Value> {
    let text = include_str!("../data/metrics.json");
    serde_json::from_str::<Value>(text).unwrap()["cases"].as_array().unwrap().clone()
}

#[test]
fn figures_agree_with_numpy() {
    for case in cases() {
        let (test, reference) = images(case["name"].as_str().unwrap());
        let got = serde_json::to_value(difference(&test, &reference).unwrap()).unwrap();
        for (name, expected) in case["figures"].as_object().unwrap() {
            let (got, expected) = (number(&got[name]), number(expected));
            assert!((got / expected - 1.0).abs() < 1e-6, "{} {name}: {got}, numpy says {expected}", case["name"]);
        }
    }
}

/// The greatest difference from the error map of a case, over its pixels, and from its mean.
fn from_expected(case: &Value, got: &Flip) -> (f64, f64) {
    let expected = case["error"].as_array().unwrap();
    assert_eq!(expected.len(), got.error.len());
    let worst = got.error.iter().zip(expected).map(|(&got, expected)| (f64::from(got) - number(expected)).abs());
    (worst.fold(0.0, f64::max), (got.mean() - number(&case["mean"])).abs())
}

fn flip_of(case: &Value, test: &[[f32; 3]], reference: &[[f32; 3]]) -> Flip {
    let of = if case["dynamic_range"] == "HDR" { Reference::hdr } else { Reference::ldr };
    of(reference, WIDTH, HEIGHT, number(&case["pixels_per_degree"]) as f32).unwrap().flip(test).unwrap()
}

#[test]
fn flip_agrees_with_the_package_of_its_authors() {
    for case in cases() {
        let (test, reference) = images(case["name"].as_str().unwrap());
        let (worst, mean) = from_expected(&case, &flip_of(&case, &test, &reference));
        let name = format!("{} at {}", case["name"], case["pixels_per_degree"]);
        assert!(worst < 1e-4, "{name}: a pixel is wrong by {worst}");
        assert!(mean < 1e-5, "{name}: the mean is wrong by {mean}");
    }
}

/// The twin: a little less contrast must be found out, as must images that are taken for each other.
#[test]
fn flip_of_other_images_does_not_agree() {
    for case in cases() {
        let (mut test, reference) = images(case["name"].as_str().unwrap());
        let (worst, _) = from_expected(&case, &flip_of(&case, &reference, &reference));
        assert!(worst > 1e-2);
        test.iter_mut().for_each(|pixel| pixel[1] *= 0.99);
        let (worst, mean) = from_expected(&case, &flip_of(&case, &test, &reference));
        assert!(worst > 1e-3 && mean > 1e-5, "{} passes: {worst} {mean}", case["name"]);
    }
}

/// Bindings of NVIDIA's older C++ code, on 8 bits a channel.
#[test]
fn flip_agrees_with_nv_flip() {
    let (test, reference) = images("noisy");
    let bytes = |image: &Image| -> Vec<u8> { image.iter().flatten().map(|x| (x * 255.0).round() as u8).collect() };
    let back =
        |bytes: &[u8]| -> Image { bytes.chunks(3).map(|b| [0, 1, 2].map(|c| f32::from(b[c]) / 255.0)).collect() };
    let (test, reference) = (bytes(&test), bytes(&reference));
    let theirs = |bytes: &[u8]| nv_flip::FlipImageRgb8::with_data(WIDTH as u32, HEIGHT as u32, bytes);
    for pixels_per_degree in [67.0, 30.0] {
        let expected = nv_flip::flip(theirs(&reference), theirs(&test), pixels_per_degree).to_vec();
        let got = Reference::ldr(&back(&reference), WIDTH, HEIGHT, pixels_per_degree).unwrap();
        let got = got.flip(&back(&test)).unwrap();
        let worst = got.error.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-4, "a pixel is wrong by {worst}");
    }
}

type Way = fn(&[[f32; 3]], usize, usize, f32) -> Result<Reference, MetricError>;
/// The ways to show images.
const WAYS: [Way; 3] = [Reference::ldr, Reference::hdr, |reference, width, height, pixels_per_degree| {
    Reference::displayed(reference, width, height, pixels_per_degree, CLIPPED)
}];
const CLIPPED: Display = Display { exposure: 0.0, curve: ToneCurve::Clip };

/// What is displayed is what the picture's bytes say, by exposure and tone curve; and neither is without effect.
#[test]
fn flip_of_what_is_displayed_is_that_of_the_bytes() {
    let (test, reference) = images("radiance");
    let bytes = |image: &Image, display: Display| -> Image {
        image.iter().map(|rgb| display.encode(*rgb).map(|byte| f32::from(byte) / 255.0)).collect()
    };
    let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
    let displays = [CLIPPED, Display { exposure: -2.0, ..CLIPPED }, Display { curve: ToneCurve::Soft, ..CLIPPED }];
    let means = displays.map(|display| {
        let got = Reference::displayed(&reference, WIDTH, HEIGHT, viewed, display).unwrap().flip(&test).unwrap();
        let expected = Reference::ldr(&bytes(&reference, display), WIDTH, HEIGHT, viewed).unwrap();
        assert_eq!(got, expected.flip(&bytes(&test, display)).unwrap(), "{display:?}");
        got.mean()
    });
    assert!((means[0] - means[1]).abs() > 1e-3 && (means[0] - means[2]).abs() > 1e-3, "{means:?}");
}

#[test]
fn flip_of_equal_images_is_zero_and_of_opposite_ones_is_one() {
    for (width, height) in [(1, 1), (1, 7), (5, 1), (40, 3)] {
        let (black, white) = (vec![[0.0_f32; 3]; width * height], vec![[1.0_f32; 3]; width * height]);
        for of in WAYS {
            let against = |reference| of(reference, width, height, 67.0).unwrap();
            for same in [&black, &white] {
                assert_eq!(against(same).flip(same).unwrap().error, vec![0.0; width * height]);
            }
            let mean = against(&white).flip(&black).unwrap().mean();
            assert!((0.9..=1.0).contains(&mean), "{mean}");
            // Against a black reference HDR has one exposure.
            assert!(against(&black).flip(&white).unwrap().mean() > 0.8);
        }
    }
}

#[test]
fn flip_refuses_what_it_cannot_compare() {
    let good = vec![[0.5_f32; 3]; 12];
    for way in WAYS {
        let of = |image: &[[f32; 3]], reference: &[[f32; 3]], width, height, pixels_per_degree| {
            way(reference, width, height, pixels_per_degree)?.flip(image)
        };
        for bad in [f32::NAN, f32::INFINITY] {
            let mut image = good.clone();
            image[7][2] = bad;
            assert_eq!(of(&image, &good, 4, 3, 67.0), Err(MetricError::NotFinite { which: "image", pixel: 7 }));
            assert_eq!(of(&good, &image, 4, 3, 67.0), Err(MetricError::NotFinite { which: "reference", pixel: 7 }));
        }
        assert_eq!(of(&good[1..], &good, 4, 3, 67.0), Err(MetricError::SizesDiffer { image: 11, reference: 12 }));
        assert_eq!(of(&good, &good, 5, 3, 67.0), Err(MetricError::WrongShape { pixels: 12, width: 5, height: 3 }));
        assert_eq!(of(&[], &[], 0, 0, 67.0), Err(MetricError::Empty));
        for ppd in [0.0, -67.0, f32::NAN, f32::INFINITY, 0.5] {
            assert_eq!(of(&good, &good, 4, 3, ppd), Err(MetricError::PixelsPerDegree));
        }
    }
}

/// Two noisy references against an image whose error is known: their noise, twice that error, cancels.
#[test]
fn the_noise_of_two_references_cancels() {
    const PIXELS: usize = 200_000;
    let reference = |seed: u32| -> Image {
        let component = |i: usize| (2.0 + 0.5 * (noise(seed, i) - 0.5)) as f32;
        (0..PIXELS).map(|i| [0, 1, 2].map(|c| component(3 * i + c))).collect()
    };
    let (first, second) = (reference(11), reference(12));
    let image = vec![[2.1_f32; 3]; PIXELS];
    let d = difference_from_two(&image, [&first, &second]).unwrap();
    // A reference's variance is 1/48. The product's deviation is 0.03 with that of its error; of 600,000 products, 4e-5. Four of these.
    assert!((d.mse - 0.01).abs() < 1.6e-4, "{}", d.mse);
    // 0.01/4, and what the denominator's noise of 7 % leaves: 0.07² · 0.05 = 2.5e-4, at most thrice.
    assert!((d.relmse - 0.0025).abs() < 7.5e-4, "{}", d.relmse);
    assert!((d.relmse_trimmed - 0.0025).abs() < 7.5e-4, "{}", d.relmse_trimmed);
    // The twin: one reference, given twice, keeps its noise.
    let one = difference_from_two(&image, [&first, &first]).unwrap();
    let plain = difference(&image, &first).unwrap();
    close(one.mse, plain.mse);
    close(one.relmse, plain.relmse);
    close(one.relmse_trimmed, plain.relmse_trimmed);
    assert!((one.mse - 0.01 - 1.0 / 48.0).abs() < 1e-3, "{}", one.mse);
    assert!(one.relmse > 0.007 && one.relmse_trimmed > 0.007);
}

#[test]
fn two_references_by_hand() {
    let image = vec![[1.0_f32; 3]; 2000];
    let (mut first, mut second) = (vec![[1.5_f32; 3]; 2000], vec![[0.5_f32; 3]; 2000]);
    // Two fireflies of the image's error, and one of the references' noise, whose product is as negative as can be.
    (first[3], second[3]) = ([11.0; 3], [11.0; 3]);
    (first[4], second[4]) = ([21.0; 3], [21.0; 3]);
    (first[5], second[5]) = ([101.0; 3], [-99.0; 3]);
    let d = difference_from_two(&image, [&first, &second]).unwrap();
    close(d.mse, (-0.25 * 1997.0 + 100.0 + 400.0 - 10_000.0) / 2000.0);
    close(d.relmse, (-0.25 / 1.01 * 1997.0 + 100.0 / 121.01 + 400.0 / 441.01 - 10_000.0 / 1.01) / 2000.0);
    close(d.relmse_trimmed, (-0.25 / 1.01 * 1997.0 - 10_000.0 / 1.01) / 1998.0);
    assert_eq!(
        difference_from_two(&image, [&first, &second[1..]]),
        Err(MetricError::SizesDiffer { image: 2000, reference: 1999 })
    );
}
