//! Error metrics against values worked out by hand.

use iorect::measure::{MetricError, block_means, difference};

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
