//! Images.

use std::sync::atomic::AtomicBool;

use glam::DVec3;
use iorect::formats;
use iorect::render::cpu::Cpu;
use iorect::render::gpu::Gpu;
use iorect::render::{Film, Renderer};
use iorect::scene::description::{Environment, Shape};
use iorect::tracking::Mode;

use super::{Difference, MODES, Subject, device, settings, workshop};
use crate::common::{add, nest};

/// Most pixels whose paths may part ways by rounding alone. Behind many curved surfaces a difference of one rounding becomes one of direction: of four samples of
/// a pixel in iced water one is enough.
const MOST_PARTED: f64 = 0.04;

static NEVER: AtomicBool = AtomicBool::new(false);

fn films(gpu: &Gpu, subject: &Subject, mode: Mode, size: (u32, u32), samples: u32) -> [Film; 2] {
    let settings = settings(mode, 5);
    let task = subject.task(&settings);
    let renderers: [&dyn Renderer; 2] = [&Cpu, gpu];
    renderers.map(|renderer| {
        renderer.require(&task).unwrap();
        let mut film = Film::new(size.0, size.1);
        assert!(renderer.pass(&task, &mut film, samples, &NEVER), "{:?}", gpu.fault());
        film
    })
}

/// The same where faces coincide, in modes that do not merge them: rounding decides which of two is met first, and whether the other is.
const MOST_PARTED_WHERE_FACES_COINCIDE: f64 = 0.08;

/// At equal seeds all but a few pixels agree to rounding, and so do the counts of crossings.
fn compare(gpu: &Gpu, name: &str, subject: &Subject, modes: &[Mode], most_parted: f64) -> Vec<String> {
    let mut problems = Vec::new();
    for &mode in modes {
        let [cpu, on_gpu] = films(gpu, subject, mode, (48, 32), 4);
        let difference = Difference::between(&cpu, &on_gpu);
        let Difference { parted, rounding, mean } = difference;
        eprintln!("{name}, {mode}: {:.2} % parted, others {rounding:.1e} off, means {mean:.1e}", 100.0 * parted);
        let crossings = [&cpu, &on_gpu].map(|film| film.events.crossings as f64);
        let are_equal = (crossings[0] - crossings[1]).abs() <= 0.05 * crossings[0];
        if difference.parted > most_parted || !are_equal {
            problems.push(format!("{name}, {mode}: {difference:?}, crossings {crossings:?}"));
        }
    }
    problems
}

/// Every mode in every built-in scene.
#[test]
fn all_scenes_are_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let problems: Vec<String> = (formats::builtin::all().iter())
        .flat_map(|scene| compare(&gpu, scene.name, &Subject::builtin(scene.name), &MODES, MOST_PARTED))
        .collect();
    assert_eq!(problems, Vec::<String>::new());
}

/// Every mode where much meets: faces that coincide, lights, everything that a scene can need.
#[test]
fn all_modes_are_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let (gpu, workshop) = (Gpu::new(device), Subject::new(workshop()));
    let mut problems = compare(&gpu, "workshop", &workshop, &MODES[..5], MOST_PARTED_WHERE_FACES_COINCIDE);
    problems.extend(compare(&gpu, "workshop", &workshop, &[Mode::Rectified], MOST_PARTED));
    assert_eq!(problems, Vec::<String>::new());
}

/// In the mean over many samples with other seeds, of each pixel: the difference by its standard deviation is distributed as it should be.
#[test]
fn images_agree_in_the_mean() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::new(workshop());
    let (width, height, samples, runs) = (12, 8, 8, 12);
    let sums = |renderer: &dyn Renderer, first_seed: u64| -> Vec<(f64, f64)> {
        let mut sums = vec![(0.0, 0.0); width as usize * height as usize];
        for seed in first_seed..first_seed + runs {
            let settings = settings(Mode::Rectified, seed);
            let mut film = Film::new(width, height);
            assert!(renderer.pass(&subject.task(&settings), &mut film, samples, &NEVER));
            for (pixel, (sum, squares)) in sums.iter_mut().enumerate() {
                // Bounded, so that the rare sample that is very bright does not decide.
                let value = film.mean(pixel).element_sum().min(6.0);
                *sum += value;
                *squares += value * value;
            }
        }
        sums
    };
    let (cpu, on_gpu) = (sums(&Cpu, 1000), sums(&gpu, 2000));
    let n = runs as f64;
    let mut squares = 0.0;
    for (a, b) in cpu.iter().zip(&on_gpu) {
        let variance = |(sum, squares): (f64, f64)| ((squares - sum * sum / n) / (n - 1.0)).max(0.0);
        let error = ((variance(*a) + variance(*b)) / n).sqrt() + 1e-6;
        squares += ((a.0 - b.0) / n / error).powi(2);
    }
    // The square of Student's t with 22 degrees of freedom has mean 22/20 and a standard deviation of some 1.8.
    let pixels = cpu.len() as f64;
    let mean = squares / pixels;
    assert!((0.6..1.1 + 4.0 * 1.8 / pixels.sqrt()).contains(&mean), "{mean}");
}

/// What else a film can be: with samples where they matter, gone on with after it was cancelled, a part with exact sums.
#[test]
fn films_of_all_kinds() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::builtin("nested-spheres");
    let settings = settings(Mode::Rectified, 3);
    let task = subject.task(&settings);
    let exponent = iorect::render::exact::unit_exponent(&subject.prepared.description);
    let render = |renderer: &dyn Renderer, mut film: Film| {
        for samples in [8, 4] {
            assert!(renderer.pass(&task, &mut film, samples, &NEVER));
            Film::allocate(&mut [&mut film]);
        }
        film
    };
    let films: [fn(i32) -> Film; 3] =
        [|_| Film::new(24, 16), |_| Film::adaptive(24, 16), |exponent| Film::partial(24, 16, 7, exponent)];
    for make in films {
        let (cpu, on_gpu) = (render(&Cpu, make(exponent)), render(&gpu, make(exponent)));
        assert_eq!((&cpu.counts, cpu.samples, cpu.events), (&on_gpu.counts, on_gpu.samples, on_gpu.events));
        assert!(Difference::between(&cpu, &on_gpu).parted < MOST_PARTED);
        assert_eq!(cpu.allocation.is_some(), on_gpu.allocation.is_some());
    }
    // Cancelled before it began: nothing has happened, and the rest is as if it had not been.
    let mut film = Film::new(24, 16);
    assert!(!gpu.pass(&task, &mut film, 4, &AtomicBool::new(true)));
    assert_eq!((film.samples, film.counts.iter().sum::<u32>()), (0, 0));
    // Rows that are ahead are left alone.
    film.ahead = (0..16).map(|row| if row < 5 { 4 } else { 0 }).collect();
    assert!(gpu.pass(&task, &mut film, 4, &NEVER));
    assert!(film.counts.iter().enumerate().all(|(pixel, count)| *count == if pixel < 5 * 24 { 0 } else { 4 }));
}

/// Long paths are interrupted and go on: in a ball that absorbs nothing and reflects totally, they last for hundreds of segments.
#[test]
fn long_paths_do_not_end_early() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::builtin("diamond-in-water");
    for mode in [Mode::Rectified, Mode::Priority] {
        let [cpu, on_gpu] = films(&gpu, &subject, mode, (40, 25), 24);
        let crossings = [&cpu, &on_gpu].map(|film| film.events.crossings as f64);
        assert!((crossings[0] / crossings[1] - 1.0).abs() < 0.03, "{mode}: {crossings:?}");
    }
}

/// What shaders cannot do is refused with a reason.
#[test]
fn what_cannot_be_rendered_is_refused() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::builtin("nested-spheres");
    let reference = settings(Mode::Reference, 1);
    let refused = gpu.require(&subject.task(&reference)).unwrap_err().to_string();
    assert!(refused.contains("mode reference") && refused.contains("CPU"), "{refused}");
    let mut description = formats::open("nested-spheres").unwrap();
    for light in [1e60, 1.0] {
        description.environment = Environment::Color([light; 3]);
        let subject = Subject::new(description.clone());
        let settings = settings(Mode::Naive, 1);
        let result = gpu.make_ready(&subject.task(&settings));
        assert_eq!(result.is_ok(), light == 1.0, "{result:?}");
    }
}

/// Enlarged by a power of two a scene has the same image to the bit, far beyond what f32 would hold of squares of its lengths.
#[test]
fn scale_does_not_matter() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let image = |exponent: i32| {
        let scale = 2_f64.powi(exponent);
        let mut description = nest(1.0, &[(scale, 1.5), (0.6 * scale, 1.333)]);
        let at = DVec3::new(0.2, 0.5, 0.0) * scale;
        add(&mut description, Shape::Box { min: at, max: at + 0.4 * scale }, 2.0, 0.5 / scale);
        description.camera.position *= scale;
        let (zenith, horizon, nadir) = ([1.0, 2.0, 3.0], [0.5, 0.4, 0.3], [0.1, 0.0, 0.2]);
        description.environment = Environment::Gradient { zenith, horizon, nadir };
        let subject = Subject::new(description);
        let settings = settings(Mode::Rectified, 1);
        let mut film = Film::new(16, 16);
        assert!(gpu.pass(&subject.task(&settings), &mut film, 2, &NEVER));
        film.sums
    };
    let still = image(0);
    assert!(still.iter().any(|sum| *sum != still[0]));
    for exponent in [-20, 20] {
        assert_eq!(image(exponent), still, "{exponent}");
    }
}
