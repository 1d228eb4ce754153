//! Cases 26 to 34: what whole images show. Rainbows, Snell's window, furnaces, and cameras inside media.

use glam::DVec3;

use super::closed_forms::{furnace_deficit, radiance_in_ball, rainbow};
use super::definition::{CaseDefinition, Measured, Subject, Unmeasured};
use super::nests::{EVER_DENSER, GLASS_WATER_AIR_DIAMOND};
use super::outcome::Measurement;
use super::scenes::{add, empty, mean, mean_and_error, nest, ready, render, samples_of, sphere};
use crate::geometry::Ray;
use crate::scene::SceneError;
use crate::scene::description::{Environment, Object, Paint, Shape, Solid};
use crate::tracking::Mode;
use crate::tracking::Prepared;
use crate::transport::inspect::{Follow, VertexEvent, trace};

pub(super) const CASES: &[CaseDefinition] = &[
    CaseDefinition::new(
        26,
        "Rainbow of a drop of water",
        "Descartes: 180° + 2 asin b − 4 asin(b/n), b² = (4 − n²)/3",
        bow,
    ),
    CaseDefinition::new(27, "Edge of Snell's window", "asin(1/1.333)", snells_window),
    CaseDefinition::new(28, "Matched rod that does not absorb", "it is not there", matched_rod),
    CaseDefinition::new(29, "Furnace: a lossless nest in a white room, from outside", "radiance 1", furnace),
    CaseDefinition::new(30, "Furnace with a cap of 8 interface vertices", "mean of T R⁷ over the disc", capped_furnace),
    CaseDefinition::new(31, "Camera at the centre of a ball of water", "n²: radiance over n² is invariant", water_ball),
    CaseDefinition::new(
        32,
        "Camera at 0.9 in a ball of glass, where some directions never escape",
        "n² (1 − √(1 − 1/(0.9 n)²))",
        trapped,
    ),
    CaseDefinition::new(33, "Camera paths against light paths, camera in water", "reciprocity (Veach 1997)", |_| {
        Err(Unmeasured::Missing("light paths need the bidirectional estimator, which does not exist yet"))
    }),
    CaseDefinition::new(
        34,
        "Camera at the centre of 1.5 in a world of 1.333",
        "(1.5/1.333)²; naive 1.5²",
        glass_in_water,
    ),
];

/// Paths through a drop, chosen at random as the renderer does; of those with one reflection inside, the turn is counted in bins of half
/// a degree, the first of which begins at the caustic and must be the fullest.
fn bow(subject: &Subject) -> Measured {
    const BIN_DEGREES: f64 = 0.5;
    let drop = ready(nest(1.0, &[(1.0, 1.333)]))?;
    let expected = rainbow(1.333);
    let bow = [VertexEvent::Transmit, VertexEvent::Reflect, VertexEvent::Transmit];
    let mut measurements = Vec::new();
    let count: u32 = subject.amount(40_000, 400_000);
    for &mode in subject.modes {
        subject.go_on()?;
        let mut bins = [0u32; 80];
        let mut least = f64::INFINITY;
        for k in 0..count {
            // Uniform over the disc.
            let b = ((f64::from(k) + 0.5) / f64::from(count)).sqrt();
            let ray = Ray::new(DVec3::new(-10.0, b, 0.0), DVec3::X);
            let path = trace(&drop, mode, ray, Follow::Sample, u64::from(k), Some(4));
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
        let of_bin = Measurement::absolute(format!("fullest bin of the turn, {mode}"), fullest, expected, BIN_DEGREES);
        measurements.push(of_bin.in_unit("°"));
        measurements.push(Measurement::absolute(format!("least turn, {mode}"), least, expected, 1e-2).in_unit("°"));
    }
    Ok(measurements)
}

fn black(name: &str, shape: Shape) -> Object {
    Object::new(name, shape, Solid::of(Paint::Color([0.0; 3])))
}

/// Looking up from under water over a black ground: bright within the window, black beyond. The edge is the last pixel of the middle row
/// that light reaches.
fn snells_window(subject: &Subject) -> Measured {
    const WIDTH: u32 = 201;
    const FOV_DEGREES: f64 = 110.0;
    let mut description = empty(1.0);
    add(
        &mut description,
        Shape::Box { min: DVec3::new(-1e4, -50.0, -1e4), max: DVec3::new(1e4, 0.0, 1e4) },
        1.333,
        0.0,
    );
    let ground = Shape::Quad { center: DVec3::Y * -20.0, edge_u: DVec3::Z * 1e4, edge_v: DVec3::X * 1e4 };
    description.objects.push(black("ground", ground));
    description.camera.position = DVec3::Y * -1.0;
    description.camera.up = DVec3::Z;
    description.camera.vertical_fov = FOV_DEGREES;
    let scene = ready(description)?;
    let half = f64::from(WIDTH) / 2.0;
    let expected = half * (1.0f64 / 1.333).asin().tan() / (FOV_DEGREES / 2.0).to_radians().tan();
    let mut measurements = Vec::new();
    for &mode in subject.modes {
        subject.go_on()?;
        let film = render(&scene, mode, (WIDTH, WIDTH), subject.amount(4, 64), 1, None)?;
        let middle = (WIDTH / 2 * WIDTH) as usize;
        let is_lit = |column: &u32| film.mean(middle + *column as usize).y > 0.0;
        let left = half - (0..WIDTH).find(is_lit).map_or(f64::NAN, f64::from);
        let right = (0..WIDTH).rfind(is_lit).map_or(f64::NAN, |column| f64::from(column + 1)) - half;
        for (side, measured) in [("left", left), ("right", right)] {
            let what = format!("{side} edge from the middle, {mode}");
            measurements.push(Measurement::absolute(what, measured, expected, 1.0).in_unit("pixels"));
        }
    }
    Ok(measurements)
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
    let mut measurements = Vec::new();
    for &mode in subject.modes {
        subject.go_on()?;
        let samples = subject.amount(4, 64);
        let [a, b] = [&with, &without].map(|scene| render(scene, mode, (48, 48), samples, 1, None));
        let (a, b) = (a?, b?);
        let differing = a.sums.iter().zip(&b.sums).filter(|(a, b)| a != b).count();
        measurements.push(Measurement::none_of(format!("pixels that differ, {mode}"), differing, "pixels"));
    }
    Ok(measurements)
}

fn furnace(subject: &Subject) -> Measured {
    let mut measurements = Vec::new();
    for (name, shells) in [("ever denser", &EVER_DENSER[..]), ("with air and diamond", &GLASS_WATER_AIR_DIAMOND)] {
        let mut description = nest(1.0, shells);
        description.camera.vertical_fov = 12.0;
        let scene = ready(description)?;
        for &mode in subject.modes {
            subject.go_on()?;
            let samples = samples_of(mode, subject.amount(16, 256));
            let film = render(&scene, mode, (48, 48), samples, 1, None)?;
            // Only Russian roulette is random: every path that ends has met the same white room.
            let (measured, error) = mean(&film);
            let what = format!("mean, nest {name}, {mode}");
            measurements.push(Measurement::absolute(what, measured, 1.0, 1e-5).with_noise(error));
            let events = film.events.total() as usize;
            measurements.push(Measurement::none_of(format!("events, nest {name}, {mode}"), events, "events"));
        }
    }
    Ok(measurements)
}

/// Means of images with seeds of their own, and their mean and its standard error: for images with structure.
fn replicated(
    subject: &Subject,
    scene: &Prepared,
    mode: Mode,
    size: (u32, u32),
    samples: u32,
    max_depth: Option<u32>,
) -> Result<(f64, f64), Unmeasured> {
    const REPLICATES: u64 = 8;
    let means = (0..REPLICATES).map(|seed| {
        subject.go_on()?;
        Ok(mean(&render(scene, mode, size, samples, seed, max_depth)?).0)
    });
    Ok(mean_and_error(&means.collect::<Result<Vec<f64>, Unmeasured>>()?))
}

/// The ball fills a disc in the image, of the image's width.
fn capped_furnace(subject: &Subject) -> Measured {
    let mut description = nest(1.0, &[(1.0, 1.5)]);
    description.camera.position = DVec3::new(0.0, 0.0, 1e6);
    description.camera.vertical_fov = 2.0 * (1e-6f64).atan().to_degrees();
    let scene = ready(description)?;
    let mut measurements = Vec::new();
    for vertices in [4, 8] {
        for &mode in subject.modes {
            let samples = samples_of(mode, subject.amount(4, 64));
            let (mean, error) = replicated(subject, &scene, mode, (96, 96), samples, Some(vertices + 1))?;
            let measured = (1.0 - mean) / std::f64::consts::FRAC_PI_4;
            let expected = furnace_deficit(1.5, vertices);
            let what = format!("deficit with {vertices} vertices, {mode}");
            measurements.push(Measurement::absolute(what, measured, expected, 5e-6).with_noise(error));
        }
    }
    Ok(measurements)
}

/// A ball with the camera at (0, 0, `offset`).
fn inside(world: f64, ior: f64, offset: f64) -> Result<Prepared, SceneError> {
    let mut description = nest(world, &[(1.0, ior)]);
    description.camera.position = DVec3::new(0.0, 0.0, offset);
    description.camera.target = DVec3::new(0.3, 0.2, 0.7);
    description.camera.vertical_fov = 90.0;
    ready(description)
}

/// At the centre every path leaves, sooner or later, with the same factor.
fn water_ball(subject: &Subject) -> Measured {
    let scene = inside(1.0, 1.333, 0.0)?;
    let mut measurements = Vec::new();
    for &mode in subject.modes {
        let (measured, error) = mean(&render(&scene, mode, (16, 16), subject.amount(16, 256), 1, None)?);
        let what = format!("mean, {mode}");
        measurements.push(Measurement::absolute(what, measured, 1.333 * 1.333, 1e-9).with_noise(error));
    }
    Ok(measurements)
}

fn glass_in_water(subject: &Subject) -> Measured {
    let scene = inside(1.333, 1.5, 0.0)?;
    let mut measurements = Vec::new();
    let right = subject.modes.iter().map(|&mode| (mode, (1.5f64 / 1.333).powi(2)));
    // What a mode gets wrong can be foretold as well.
    for (mode, expected) in right.chain([(Mode::Naive, 2.25)]) {
        let (measured, error) = mean(&render(&scene, mode, (16, 16), subject.amount(16, 256), 1, None)?);
        measurements.push(Measurement::absolute(format!("mean, {mode}"), measured, expected, 1e-6).with_noise(error));
    }
    Ok(measurements)
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
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for sign in [1.0, -1.0] {
            description.camera.target = description.camera.position + axis * sign;
            description.camera.up = if axis == DVec3::Y { DVec3::X } else { DVec3::Y };
            scenes.push(ready(description.clone())?);
        }
    }
    let expected = radiance_in_ball(1.5, 0.9);
    let mut measurements = Vec::new();
    for &mode in subject.modes {
        let (side, samples) =
            if mode == Mode::Reference { (8, subject.amount(1, 8)) } else { (16, subject.amount(4, 64)) };
        let mut means = Vec::new();
        for seed in 0..8 {
            let mut sum = 0.0;
            for scene in &scenes {
                subject.go_on()?;
                let film = render(scene, mode, (side, side), samples, seed, None)?;
                let pixels = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
                sum += pixels
                    .map(|(row, column)| solid_angle(side, column, row) * film.mean((row * side + column) as usize).y)
                    .sum::<f64>();
            }
            means.push(sum / (4.0 * std::f64::consts::PI));
        }
        let (measured, error) = mean_and_error(&means);
        // Within a pixel on the edge of what is trapped, solid angle is not quite even.
        let what = format!("mean over all directions, {mode}");
        measurements.push(Measurement::absolute(what, measured, expected, 2e-3).with_noise(error));
    }
    Ok(measurements)
}
