//! What lowers the noise changes nothing else: splitting paths, and spreading samples over the pixels by need.

use std::sync::atomic::AtomicBool;

use glam::DVec3;
use iorect::formats;
use iorect::render::{Film, ImageSettings, RenderTask};
use iorect::scene::camera::Camera;
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

use crate::common::ready;

const SIZE: (u32, u32) = (24, 16);

fn scene(name: &str) -> Prepared {
    ready(formats::open(name).expect("a built-in scene"))
}

fn settings(seed: u64, splits: u32) -> ImageSettings {
    ImageSettings { max_depth: Some(24), splits, ..ImageSettings::new(Mode::Rectified, seed) }
}

/// Adds samples to a film, in slices that end with each of `ends`, and allocates as soon as it is due.
fn add(prepared: &Prepared, settings: &ImageSettings, film: &mut Film, ends: &[u32]) {
    let camera = Camera::new(&prepared.description.camera).expect("the camera is fine");
    for &end in ends {
        let slice = (end - film.samples).min(film.samples_to_decision());
        assert!(RenderTask { prepared, camera: &camera, settings }.pass(film, slice, &AtomicBool::new(false)));
        Film::allocate(&mut [film]);
        let rest = end - film.samples;
        assert!(RenderTask { prepared, camera: &camera, settings }.pass(film, rest, &AtomicBool::new(false)));
    }
}

fn uniform(prepared: &Prepared, seed: u64, splits: u32, spp: u32) -> Film {
    let mut film = Film::new(SIZE.0, SIZE.1);
    add(prepared, &settings(seed, splits), &mut film, &[spp]);
    film
}

fn adaptive(prepared: &Prepared, seed: u64, spp: u32) -> Film {
    let mut film = Film::adaptive(SIZE.0, SIZE.1);
    add(prepared, &settings(seed, 0), &mut film, &[spp]);
    film
}

/// Mean and variance of the mean, for each pixel of independent films, of the radiance's sum over the channels.
fn over_films(films: &[Film]) -> Vec<(f64, f64)> {
    let count = films.len() as f64;
    (0..films[0].sums.len())
        .map(|pixel| {
            let values = || films.iter().map(|film| film.mean(pixel).element_sum());
            let mean = values().sum::<f64>() / count;
            let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
            (mean, variance / count)
        })
        .collect()
}

/// Largest pixel difference in standard deviations, and the mean of the squares of all, which is 1 where only noise differs.
fn deviation(a: &[(f64, f64)], b: &[(f64, f64)]) -> (f64, f64) {
    let squares: Vec<f64> =
        (a.iter().zip(b)).filter(|(a, b)| a.1 + b.1 > 1e-12).map(|(a, b)| (a.0 - b.0).powi(2) / (a.1 + b.1)).collect();
    assert!(squares.len() > a.len() / 4, "most pixels are noisy");
    (squares.iter().fold(0.0_f64, |most, s| most.max(s.sqrt())), squares.iter().sum::<f64>() / squares.len() as f64)
}

/// Geometric mean of the noisy pixels' variances: that a rare bright path was found or not says little.
fn noise(pixels: &[(f64, f64)]) -> f64 {
    let logs: Vec<f64> = pixels.iter().filter(|p| p.1 > 1e-12).map(|p| p.1.ln()).collect();
    (logs.iter().sum::<f64>() / logs.len() as f64).exp()
}

/// Both branches of a split together bring what a choice between them brings, in every pixel, with flat and with interpolated normals.
#[test]
fn splitting_changes_the_noise_alone() {
    for name in ["plain-glass", "three-shells", "diamond-in-water"] {
        let scene = scene(name);
        let films = |splits: u32, first: u64| -> Vec<Film> {
            (first..first + 150).map(|seed| uniform(&scene, seed, splits, 4)).collect()
        };
        let [never, twice, often] =
            [(0, 0), (2, 1000), (8, 2000)].map(|(splits, first)| over_films(&films(splits, first)));
        for split in [&twice, &often] {
            let (most, mean) = deviation(&never, split);
            assert!(most < 5.0 && (0.75..1.25).contains(&mean), "{name}: {most} at most, {mean}");
            assert!(noise(split) < 0.97 * noise(&never), "{name}: {} and {}", noise(split), noise(&never));
        }
    }
}

/// A pixel's own samples do not decide how many they are: no pixel is too bright or too dark.
#[test]
fn allocation_changes_the_noise_alone() {
    for name in ["nested-spheres", "iced-water", "camera-in-water"] {
        let scene = scene(name);
        let spread = over_films(&(0..200).map(|seed| adaptive(&scene, seed, 24)).collect::<Vec<_>>());
        let even = over_films(&(1000..1200).map(|seed| uniform(&scene, seed, 0, 24)).collect::<Vec<_>>());
        let (most, mean) = deviation(&spread, &even);
        assert!(most < 5.0 && (0.75..1.25).contains(&mean), "{name}: {most} at most, {mean}");
    }
}

#[test]
fn samples_go_where_the_noise_is() {
    let scene = scene("camera-in-water");
    let film = adaptive(&scene, 5, 32);
    let even = film.counts.len() as u32 * 32;
    let all: u32 = film.counts.iter().sum();
    assert!((0.7..=1.0).contains(&(f64::from(all) / f64::from(even))), "{all} of {even}");
    assert!(film.counts.iter().all(|&count| count >= 8));
    let (most, least) = (film.counts.iter().max(), film.counts.iter().min());
    assert!(most >= Some(&64) && least <= Some(&16), "{most:?}, {least:?}");
}

/// Neither threads nor slices decide anything, before or after the allocation.
#[test]
fn allocated_films_do_not_depend_on_threads_or_slices() {
    let scene = scene("three-shells");
    let with = |threads: usize, ends: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut film = Film::adaptive(SIZE.0, SIZE.1);
        pool.install(|| add(&scene, &settings(3, 2), &mut film, ends));
        film
    };
    let film = with(1, &[21]);
    assert!(film.allocation.is_some());
    for other in [with(3, &[21]), with(2, &[1, 7, 8, 9, 21]), with(2, &[2, 11, 20, 21])] {
        assert_eq!(film, other);
    }
}

/// Films that are compared are sampled alike: where two modes agree, their films are equal to the bit.
#[test]
fn compared_films_share_an_allocation() {
    let scene = scene("nested-spheres");
    let camera = Camera::new(&scene.description.camera).expect("the camera is fine");
    let mut films = [Mode::Rectified, Mode::Reference].map(|mode| (mode, Film::adaptive(SIZE.0, SIZE.1)));
    for slice in [8, 8] {
        for (mode, film) in &mut films {
            let settings = ImageSettings { mode: *mode, ..settings(1, 2) };
            assert!(RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
                film,
                slice,
                &AtomicBool::new(false)
            ));
        }
        let [(_, a), (_, b)] = &mut films;
        Film::allocate(&mut [a, b]);
    }
    let [(_, a), (_, b)] = &films;
    assert!(a.allocation.is_some() && a.allocation == b.allocation);
    assert_eq!((&a.sums, &a.counts), (&b.sums, &b.counts));
    assert!(a.sums.iter().any(|sum| *sum != DVec3::ZERO));
}

/// Light that a small lamp throws through ice is missed by most pilot samples: to go by those that have not would starve the pixels that it falls
/// on, and doubled the error.
#[test]
fn rare_light_starves_no_pixel() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/truth/A1");
    let scene = crate::common::ready(iorect::formats::file(&path.with_extension("toml")).unwrap());
    let truth = iorect::formats::image_from_file(&path.with_extension("exr")).unwrap();
    let error = |film: Film| {
        let error = |(a, t): (&[f32; 3], &[f32; 3])| {
            (0..3).map(|k| f64::from(a[k] - t[k]).powi(2) / (f64::from(t[k]).powi(2) + 0.01)).sum::<f64>()
        };
        film.to_rgb().iter().zip(&truth.pixels).map(error).sum::<f64>()
    };
    let size = (truth.width as u32, truth.height as u32);
    let mean = |make: fn(u32, u32) -> Film| -> f64 {
        let of_seed = |seed: u64| {
            let mut film = make(size.0, size.1);
            add(&scene, &settings(seed, 2), &mut film, &[128]);
            error(film)
        };
        (0..3).map(of_seed).sum()
    };
    let (spread, even) = (mean(Film::adaptive), mean(Film::new));
    assert!(spread < 1.25 * even, "{spread} and {even}");
}
