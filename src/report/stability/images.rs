//! Cases 26 to 34: what whole images show. Rainbows, Snell's window, furnaces, and cameras inside media.

use glam::DVec3;

use super::closed_forms::{furnace_deficit, radiance_in_ball, rainbow};
use super::definition::{CaseDefinition, Measured, Subject, Unmeasured, case, of_each};
use super::nests::{EVER_DENSER, GLASS_WATER_AIR_DIAMOND};
use super::outcome::Measurement;
use super::scenes::{add, empty, mean, mean_and_error, nest, onto_disc, ready, render_by, samples_of, sphere};
use crate::render::Estimator;
use crate::scene::SceneError;
use crate::scene::description::{Environment, Light, Object, Paint, Shape, Solid};
use crate::tracking::{Mode, Prepared};
use crate::transport::inspect::{Follow, VertexEvent, trace};

pub(super) const CASES: &[CaseDefinition] = &[
    case(26, "Rainbow of a drop of water", "Descartes: 180° + 2 asin b − 4 asin(b/n), b² = (4 − n²)/3", bow),
    case(27, "Edge of Snell's window", "asin(1/1.333)", snells_window).of_images(),
    case(28, "Matched rod that does not absorb", "it is not there", matched_rod).of_images(),
    case(29, "Furnace: a lossless nest in a white room, from outside", "radiance 1", furnace).of_images(),
    case(30, "Furnace with a cap of 8 interface vertices", "mean of T R⁷ over the disc", capped_furnace).of_images(),
    case(31, "Camera at the centre of a ball of water", "n²: radiance over n² is invariant", |subject| {
        from_centre(subject, 1.0, 1.333, 1.333 * 1.333, 1e-9)
    })
    .of_images(),
    case(
        32,
        "Camera at 0.9 in a ball of glass, where some directions never escape",
        "n² (1 − √(1 − 1/(0.9 n)²))",
        trapped,
    )
    .of_images(),
    case(
        33,
        "Camera paths against paths from both ends, camera and lamp in air, water and ice",
        "reciprocity (Veach 1997): paths from the camera, mode rectified",
        both_ends,
    ),
    case(34, "Camera at the centre of 1.5 in a world of 1.333", "(1.5/1.333)²; naive 1.5²", glass_in_water).of_images(),
];

/// Paths through a drop, chosen at random as the renderer does; of those with one reflection inside, the turn is counted in bins of half
/// a degree, the first of which begins at the caustic and must be the fullest.
fn bow(subject: &Subject) -> Measured {
    const BIN_DEGREES: f64 = 0.5;
    let drop = ready(nest(1.0, &[(1.0, 1.333)]))?;
    let expected = rainbow(1.333);
    let bow = [VertexEvent::Transmit, VertexEvent::Reflect, VertexEvent::Transmit];
    let count: u32 = subject.amount(40_000, 400_000);
    subject.in_modes(|mode| {
        let mut bins = [0u32; 80];
        let mut least = f64::INFINITY;
        for k in 0..count {
            let path = trace(&drop, mode, onto_disc(k, count), Follow::Sample, u64::from(k), Some(4));
            if path.vertices.len() == 3 && path.vertices.iter().map(|v| v.event).eq(bow) {
                let turned = DVec3::X.angle_between(DVec3::from(path.final_direction)).to_degrees();
                least = least.min(turned);
                // 20 bins below the caustic stay empty.
                let bin = ((turned - expected) / BIN_DEGREES).floor() + 20.0;
                if let Some(bin) = bins.get_mut(bin as usize) {
                    *bin += 1;
                }
            }
        }
        let fullest = (0..bins.len()).max_by_key(|&k| bins[k]).unwrap_or(0);
        let fullest = expected + (fullest as f64 - 20.0 + 0.5) * BIN_DEGREES;
        let rows = [("fullest bin of the turn", fullest, BIN_DEGREES), ("least turn", least, 1e-2)];
        Ok(rows.map(|(what, measured, bound)| Measurement::absolute(what, measured, expected, bound).in_unit("°")))
    })
}

/// Looking up from under water over a black ground: bright within the window, black beyond. The edge is the last pixel of the middle row
/// that light reaches.
fn snells_window(subject: &Subject) -> Measured {
    const WIDTH: u32 = 201;
    const FOV_DEGREES: f64 = 110.0;
    let mut description = empty(1.0);
    let (min, max) = (DVec3::new(-1e4, -50.0, -1e4), DVec3::new(1e4, 0.0, 1e4));
    add(&mut description, Shape::Box { min, max }, 1.333, 0.0);
    let ground = Shape::Quad { center: DVec3::Y * -20.0, edge_u: DVec3::Z * 1e4, edge_v: DVec3::X * 1e4 };
    description.objects.push(Object::new("ground", ground, Solid::of(Paint::Color([0.0; 3]))));
    description.camera.position = DVec3::Y * -1.0;
    description.camera.up = DVec3::Z;
    description.camera.vertical_fov = FOV_DEGREES;
    let scene = ready(description)?;
    let half = f64::from(WIDTH) / 2.0;
    let expected = half * (1.0f64 / 1.333).asin().tan() / (FOV_DEGREES / 2.0).to_radians().tan();
    subject.in_modes(|mode| {
        let film = subject.render(&scene, mode, (WIDTH, WIDTH), subject.amount(4, 64), 1, None)?;
        let middle = (WIDTH / 2 * WIDTH) as usize;
        let is_lit = |column: &u32| film.mean(middle + *column as usize).y > 0.0;
        let left = half - (0..WIDTH).find(is_lit).map_or(f64::NAN, f64::from);
        let right = (0..WIDTH).rfind(is_lit).map_or(f64::NAN, |column| f64::from(column + 1)) - half;
        Ok([("left", left), ("right", right)].map(|(side, measured)| {
            let what = format!("{side} edge from the middle");
            Measurement::absolute(what, measured, expected, 1.0).in_unit("pixels")
        }))
    })
}

/// Pixels that differ between images with and without the rod.
fn matched_rod(subject: &Subject) -> Measured {
    let scene = |with_rod: bool| -> Result<Prepared, SceneError> {
        let mut description = empty(1.47);
        description.environment =
            Environment::Gradient { zenith: [0.2, 0.4, 1.0], horizon: [1.0; 3], nadir: [0.3, 0.1, 0.0] };
        add(&mut description, sphere(DVec3::new(0.3, 0.1, 0.0), 0.8), 1.6, 0.3);
        if with_rod {
            let rod = Shape::Cylinder { center: DVec3::new(0.0, 0.0, 2.0), radius: 0.5, height: 4.0, segments: 32 };
            add(&mut description, rod, 1.47, 0.0);
        }
        description.camera.vertical_fov = 30.0;
        ready(description)
    };
    let (with, without) = (scene(true)?, scene(false)?);
    subject.in_modes(|mode| {
        let [a, b] =
            [&with, &without].map(|scene| subject.render(scene, mode, (48, 48), subject.amount(4, 64), 1, None));
        let differing = a?.sums.iter().zip(&b?.sums).filter(|(a, b)| a != b).count();
        Ok([Measurement::none_of("pixels that differ", differing, "pixels")])
    })
}

fn furnace(subject: &Subject) -> Measured {
    let nests = [("ever denser", &EVER_DENSER[..]), ("with air and diamond", &GLASS_WATER_AIR_DIAMOND)];
    of_each(nests, |(name, shells)| {
        let mut description = nest(1.0, shells);
        description.camera.vertical_fov = 12.0;
        let scene = ready(description)?;
        subject.in_modes(|mode| {
            let film = subject.render(&scene, mode, (48, 48), samples_of(mode, subject.amount(16, 256)), 1, None)?;
            // Only Russian roulette is random: every path that ends has met the same white room.
            let (measured, error) = mean(&film);
            let events = film.events.total() as usize;
            Ok([
                Measurement::absolute(format!("mean, nest {name}"), measured, 1.0, 1e-5).with_noise(error),
                Measurement::none_of(format!("events, nest {name}"), events, "events"),
            ])
        })
    })
}

/// Mean of a figure over images with seeds of their own, and its standard error: for images with structure.
fn replicated(subject: &Subject, of_seed: impl Fn(u64) -> Result<f64, Unmeasured>) -> Result<(f64, f64), Unmeasured> {
    let figures = (0..8).map(|seed| {
        subject.go_on()?;
        of_seed(seed)
    });
    Ok(mean_and_error(&figures.collect::<Result<Vec<f64>, Unmeasured>>()?))
}

/// Ice in water over a floor. Light finds its way from the lamp as from the camera, wherever they stand.
fn both_ends(subject: &Subject) -> Measured {
    let cameras = [
        ("air", DVec3::new(0.5, 3.0, 4.5)),
        ("water", DVec3::new(-0.3, 2.1, -0.3)),
        ("ice", DVec3::new(0.0, 1.4, -0.1)),
    ];
    let lamps = [
        ("air", DVec3::new(1.6, 1.9, 1.4), 0.45),
        ("water", DVec3::new(-0.6, 1.5, 0.3), 0.2),
        ("ice", DVec3::new(0.3, 1.3, 0.2), 0.2),
    ];
    let pairs = cameras.into_iter().flat_map(|camera| lamps.map(|lamp| (camera, lamp)));
    of_each(pairs, |((camera_in, from), (lamp_in, at, radius))| {
        let mut description = empty(1.0);
        description.environment = Environment::Color([0.0; 3]);
        add(&mut description, sphere(DVec3::new(0.0, 1.3, 0.0), 1.2), 1.333, 0.1);
        add(&mut description, sphere(DVec3::new(0.2, 1.2, 0.1), 0.6), 1.31, 0.05);
        let floor = Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 8.0, edge_v: DVec3::X * 8.0 };
        description.objects.push(Object::new("floor", floor, Solid::of(Paint::Color([0.6; 3]))));
        description.objects.push(Object::new("lamp", sphere(at, radius), Light::of_radiance([5.0; 3])));
        (description.camera.position, description.camera.target) = (from, DVec3::new(0.3, 0.0, 0.2));
        let scene = ready(description)?;
        let mean_by = |estimator, mode, samples| {
            replicated(subject, |seed| {
                let film = render_by(&scene, estimator, mode, (24, 18), samples, seed, None)?;
                Ok((0..film.sums.len()).map(|pixel| film.mean(pixel).y).sum::<f64>() / film.sums.len() as f64)
            })
        };
        let (expected, noise) = mean_by(Estimator::Path, Mode::Rectified, subject.amount(96, 1024))?;
        subject.in_modes(|mode| {
            let samples = samples_of(mode, subject.amount(32, 256));
            let (measured, error) = mean_by(Estimator::Bidirectional, mode, samples)?;
            let what = format!("mean, camera in {camera_in}, lamp in {lamp_in}");
            Ok([Measurement::relative(what, measured, expected, 1e-4).with_noise(error.hypot(noise))])
        })
    })
}

/// The ball fills a disc in the image, of the image's width.
fn capped_furnace(subject: &Subject) -> Measured {
    let mut description = nest(1.0, &[(1.0, 1.5)]);
    description.camera.position = DVec3::new(0.0, 0.0, 1e6);
    description.camera.vertical_fov = 2.0 * (1e-6f64).atan().to_degrees();
    let scene = ready(description)?;
    of_each([4, 8], |vertices| {
        subject.in_modes(|mode| {
            let samples = samples_of(mode, subject.amount(4, 64));
            let (mean, error) = replicated(subject, |seed| {
                Ok(mean(&subject.render(&scene, mode, (96, 96), samples, seed, Some(vertices + 1))?).0)
            })?;
            let measured = (1.0 - mean) / std::f64::consts::FRAC_PI_4;
            let what = format!("deficit with {vertices} vertices");
            Ok([Measurement::absolute(what, measured, furnace_deficit(1.5, vertices), 5e-6).with_noise(error)])
        })
    })
}

/// The mean seen from the centre of a ball: every path leaves, sooner or later, with the same factor.
fn from_centre(subject: &Subject, world: f64, ior: f64, expected: f64, bound: f64) -> Measured {
    let mut description = nest(world, &[(1.0, ior)]);
    description.camera.position = DVec3::ZERO;
    description.camera.target = DVec3::new(0.3, 0.2, 0.7);
    description.camera.vertical_fov = 90.0;
    let scene = ready(description)?;
    subject.in_modes(|mode| {
        let (measured, error) = mean(&subject.render(&scene, mode, (16, 16), subject.amount(16, 256), 1, None)?);
        Ok([Measurement::absolute("mean", measured, expected, bound).with_noise(error)])
    })
}

fn glass_in_water(subject: &Subject) -> Measured {
    // What a mode gets wrong can be foretold as well.
    let naive = Subject { modes: &[Mode::Naive], ..*subject };
    of_each([(subject, (1.5f64 / 1.333).powi(2)), (&naive, 2.25)], |(subject, expected)| {
        from_centre(subject, 1.333, 1.5, expected, 1e-6)
    })
}

/// Solid angle of a pixel of a square image of `side` pixels that sees 90°.
fn solid_angle(side: u32, column: u32, row: u32) -> f64 {
    // Of a rectangle with a corner straight ahead, at distance 1.
    let corner = |x: f64, y: f64| (x * y).atan2((1.0 + x * x + y * y).sqrt());
    let edge = |k: u32| f64::from(2 * k) / f64::from(side) - 1.0;
    let ([a, b], [c, d]) = ([edge(column), edge(column + 1)], [edge(row), edge(row + 1)]);
    corner(b, d) - corner(a, d) - corner(b, c) + corner(a, c)
}

/// Six square images make all directions; each pixel counts by its solid angle.
fn trapped(subject: &Subject) -> Measured {
    let mut description = nest(1.0, &[(1.0, 1.5)]);
    description.camera.position = DVec3::new(0.0, 0.0, 0.9);
    description.camera.vertical_fov = 90.0;
    let mut scenes = Vec::new();
    for forward in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
        description.camera.target = description.camera.position + forward;
        description.camera.up = if forward.y == 0.0 { DVec3::Y } else { DVec3::X };
        scenes.push(ready(description.clone())?);
    }
    subject.in_modes(|mode| {
        let (side, samples) =
            if mode == Mode::Reference { (8, subject.amount(1, 8)) } else { (16, subject.amount(4, 64)) };
        let (measured, error) = replicated(subject, |seed| {
            let mut sum = 0.0;
            for scene in &scenes {
                let film = subject.render(scene, mode, (side, side), samples, seed, None)?;
                let pixels = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
                sum += pixels
                    .map(|(row, column)| solid_angle(side, column, row) * film.mean((row * side + column) as usize).y)
                    .sum::<f64>();
            }
            Ok(sum / (4.0 * std::f64::consts::PI))
        })?;
        // Within a pixel on the edge of what is trapped, solid angle is not quite even.
        let expected = radiance_in_ball(1.5, 0.9);
        Ok([Measurement::absolute("mean over all directions", measured, expected, 2e-3).with_noise(error)])
    })
}
