//! Sweeps over lengths: scale, offset, gaps, depth, slivers; and over the built-in scenes.

use glam::DVec3;

use super::closed_forms::passage;
use super::definition::{Subject, SweepDefinition, Unmeasured};
use super::nests::{EVER_DENSER, HEIGHTS, deflections};
use super::outcome::{Measurement, Step};
use super::scenes::{Numbers, add, deflection_degrees, empty, icosphere, interfaces, nest, ready, sphere};
use super::shells::{Kind, OUT_AND_IN, miscounted, scaled_paths, shells};
use crate::formats::{self, builtin};
use crate::geometry::Ray;
use crate::scene::camera::Camera;
use crate::scene::description::{Description, Shape, Transform};
use crate::tracking::Mode;
use crate::tracking::Prepared;
use crate::transport::inspect::{Follow, TracedPath, Vertex, VertexEvent, trace};

pub(super) const SWEEPS: &[SweepDefinition] = &[
    SweepDefinition {
        name: "Scale",
        about: "A nest of five spheres and two shells of triangles a ten-thousandth apart, scaled: deflection by Bouguer's invariant, \
                and rays that miss or misjudge a surface.",
        parameter: "size, scene units",
        measure: scale,
    },
    SweepDefinition {
        name: "Scale by powers of two",
        about: "Paths through boxes and balls that contain, touch and cross each other, scaled and scaled back: not one bit may differ.",
        parameter: "size, scene units",
        measure: powers_of_two,
    },
    SweepDefinition {
        name: "Offset",
        about: "A nest of five spheres and shells a tenth apart, moved away from the origin: alone, where the program moves its own \
                origin along, and with an object left behind.",
        parameter: "distance from the origin, radii",
        measure: offset,
    },
    SweepDefinition {
        name: "Gap",
        about: "Straight rays through two shells a gap apart, down to coincidence, where they are one surface.",
        parameter: "gap, radii",
        measure: gap,
    },
    SweepDefinition {
        name: "Depth of nesting",
        about: "Concentric shells of 1.5 and 1.4 in turn: largest error of the deflection at five heights, by Bouguer's invariant. A path \
                that misses an interface has no deflection.",
        parameter: "shells",
        measure: depth,
    },
    SweepDefinition {
        name: "Slivers",
        about: "Rays through plates, needles and two squashed balls one in the other, whose triangles are ever longer: none may be missed \
                or misjudged.",
        parameter: "aspect ratio",
        measure: slivers,
    },
    SweepDefinition {
        name: "Built-in scenes",
        about: "Paths from the camera, chosen at random, in a mode and in `reference`, which asks for containment anew at every hit: paths \
                that meet other media or go another way.",
        parameter: "scene",
        measure: builtin_scenes,
    },
];

fn transformed(mut description: Description, scale: f64, center: DVec3) -> Description {
    for refractor in description.objects.refractors_mut() {
        refractor.transform = Transform { scale: DVec3::splat(scale), translate: center, ..Transform::IDENTITY };
    }
    description
}

/// Largest error of the deflection by spheres scaled and moved, in degrees, over heights; NaN if a path is not as it must be.
fn worst_deflection(scene: &Prepared, mode: Mode, n0: f64, nest: &[(f64, f64)], scale: f64, center: DVec3) -> f64 {
    let error = |b: f64| {
        let ray = Ray::new(center + DVec3::new(-10.0, b, 0.0) * scale, DVec3::X);
        let path = trace(scene, mode, ray, Follow::Transmit, 0, None);
        let expected = passage(n0, nest, b);
        let met = path.vertices.iter().filter(|v| v.from != v.to && v.event == VertexEvent::Transmit).count();
        if !path.escaped || path.events.total() > 0 || met != expected.crossings {
            return f64::NAN;
        }
        super::closed_forms::wrapped(deflection_degrees(&path) - expected.degrees).abs()
    };
    // `max` would drop a NaN.
    HEIGHTS.into_iter().map(error).fold(0.0, |worst: f64, e| if e.is_nan() || e > worst { e } else { worst })
}

fn deflection_step(x: f64, what: &str, mode: Mode, error: f64, bound: f64) -> Step {
    Step::at(x, Measurement::absolute(format!("deflection error, {what}, {mode}"), error, 0.0, bound).in_unit("°"))
}

fn scale(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    for exponent in -6..=6 {
        let scale = 10f64.powi(exponent);
        let spheres = ready(transformed(nest(1.0, &EVER_DENSER), scale, DVec3::ZERO))?;
        let two = ready(shells(1e-4, Kind::Triangles, scale, DVec3::ZERO))?;
        for &mode in subject.modes {
            subject.go_on()?;
            let error = worst_deflection(&spheres, mode, 1.0, &EVER_DENSER, scale, DVec3::ZERO);
            steps.push(deflection_step(scale, "spheres", mode, error, 1e-9));
            let count = miscounted(&two, mode, DVec3::ZERO, scale, &OUT_AND_IN, subject.amount(200, 2000));
            steps.push(Step::at(scale, Measurement::none_of(format!("miscounts, triangles, {mode}"), count, "rays")));
        }
    }
    Ok(steps)
}

fn powers_of_two(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let count = subject.amount(60, 600);
    let mut steps = Vec::new();
    for &mode in subject.modes {
        let ordinary = scaled_paths(mode, 1.0, count)?;
        for exponent in [-40, -20, -7, -1, 1, 7, 20, 40] {
            subject.go_on()?;
            let scale = 2f64.powi(exponent);
            let scaled = scaled_paths(mode, scale, count)?;
            let differing = ordinary.iter().zip(&scaled).filter(|(a, b)| a != b).count();
            let measurement = Measurement::none_of(format!("paths with another bit, {mode}"), differing, "paths");
            steps.push(Step::named(scale, format!("2^{exponent}"), measurement));
        }
    }
    Ok(steps)
}

/// Why meshes far from the origin, beside something near it, lose their shape.
const STORED_SHORT: &str = "vertices are stored in f32 about one origin for the whole scene, and faces within 8 of its steps are one \
                            surface: so far out that is more than the gap";

/// Why what lies very close together is one.
const MERGED: &str = "by design: triangles within 8 steps of f32 of each other, and spheres within 1e-12, are one surface, so that what \
                      is meant to touch need not be modelled to the last bit";

fn offset(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    let rays = subject.amount(200, 2000);
    for distance in [0.0, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6] {
        let center = DVec3::new(1.0, -0.75, 0.5) * distance;
        let spheres = ready(transformed(nest(1.0, &EVER_DENSER), 1.0, center))?;
        for &mode in subject.modes {
            subject.go_on()?;
            let error = worst_deflection(&spheres, mode, 1.0, &EVER_DENSER, 1.0, center);
            // A ray's own origin is rounded to 1e-16 of the distance, which a nest amplifies.
            steps.push(deflection_step(distance, "spheres", mode, error, 1e-9 + 1e-12 * distance));
        }
        for (what, gap, is_alone) in [
            ("gap 0.1, alone", 0.1, true),
            ("gap 0.001, alone", 0.001, true),
            ("gap 0.1, beside an object at the origin", 0.1, false),
            ("gap 0.001, beside an object at the origin", 0.001, false),
        ] {
            if !is_alone && distance < 10.0 {
                continue;
            }
            for kind in Kind::BOTH {
                let mut description = shells(gap, kind, 1.0, center);
                if !is_alone {
                    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.0, 0.0);
                }
                let scene = ready(description)?;
                for &mode in subject.modes {
                    subject.go_on()?;
                    let count = miscounted(&scene, mode, center, 1.0, &OUT_AND_IN, rays);
                    let what = format!("miscounts, {}, {what}, {mode}", kind.name());
                    let mut measurement = Measurement::none_of(what, count, "rays");
                    if kind == Kind::Triangles {
                        measurement = measurement.limited_by(STORED_SHORT);
                    }
                    steps.push(Step::at(distance, measurement));
                }
            }
        }
    }
    Ok(steps)
}

fn gap(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    let rays = subject.amount(200, 2000);
    let merged = [("world", "object 1"), ("object 1", "world")];
    for exponent in 1..=12 {
        let gap = 10f64.powi(-exponent);
        for kind in Kind::BOTH {
            let scene = ready(shells(gap, kind, 1.0, DVec3::ZERO))?;
            for &mode in subject.modes {
                subject.go_on()?;
                let count = miscounted(&scene, mode, DVec3::ZERO, 1.0, &OUT_AND_IN, rays);
                let what = format!("miscounts, {}, {mode}", kind.name());
                steps.push(Step::at(gap, Measurement::none_of(what, count, "rays").limited_by(MERGED)));
                // Rays that see the gap and rays that see one surface are all the rays there are.
                let unmerged = miscounted(&scene, mode, DVec3::ZERO, 1.0, &merged, rays);
                let neither = (count + unmerged).saturating_sub(rays);
                let what = format!("neither a gap nor one surface, {}, {mode}", kind.name());
                let measurement = Measurement::none_of(what, neither, "rays").limited_by(
                    "vertices are stored in f32, whose neighbours lie 6e-8 apart at radius 1: of closer shells some faces coincide and \
                     others do not",
                );
                steps.push(Step::at(gap, measurement));
            }
        }
    }
    for kind in Kind::BOTH {
        let scene = ready(shells(0.0, kind, 1.0, DVec3::ZERO))?;
        for &mode in subject.modes {
            let count = miscounted(&scene, mode, DVec3::ZERO, 1.0, &merged, rays);
            let measurement = Measurement::none_of(format!("miscounts, {}, {mode}", kind.name()), count, "rays");
            steps.push(Step::named(0.0, "coincident", measurement));
        }
    }
    Ok(steps)
}

fn depth(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    for count in [1, 2, 3, 10, 30, 100, 300, 1000] {
        let of = |k: usize| (1.0 - k as f64 / (count as f64 + 1.0), [1.5, 1.4][k % 2]);
        let list: Vec<_> = (0..count).map(of).collect();
        let scene = ready(nest(1.0, &list))?;
        for &mode in subject.modes {
            let mut of_heights = Vec::new();
            let one = Subject { modes: &[mode], ..*subject };
            for b in HEIGHTS {
                deflections(&one, &scene, 1.0, &list, b, 1e-6, &mut of_heights)?;
            }
            let error =
                of_heights.iter().map(|m| m.error).fold(0.0, |a: f64, e| if e.is_nan() || e > a { e } else { a });
            steps.push(deflection_step(count as f64, "spheres", mode, error, 1e-6));
        }
    }
    Ok(steps)
}

/// Bodies with faces `aspect` times as long as wide, around the origin; each ray through the middle goes in and out of all of them.
fn slivers(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    let boxed = |half: DVec3| Shape::Box { min: -half, max: half };
    let turned = Transform { rotate: DVec3::new(11.0, 22.0, 33.0), ..Transform::IDENTITY };
    let turn = turned.matrix().matrix3;
    for exponent in 0..=6 {
        let aspect = 10f64.powi(exponent);
        let thin = 1.0 / aspect;
        let mut squashed = empty(1.0);
        for radius in [1.0, 0.5] {
            add(&mut squashed, icosphere(radius, 3), 1.0, 0.0);
            if let Some(refractor) = squashed.objects.refractors_mut().last_mut() {
                refractor.transform = Transform { scale: DVec3::new(1.0, thin, 1.0), ..turned };
            }
        }
        let single = |shape: Shape| {
            let mut description = empty(1.0);
            add(&mut description, shape, 1.0, 0.0);
            description.objects.refractors_mut()[0].transform = turned;
            description
        };
        let once = [("world", "object 0"), ("object 0", "world")];
        for (name, description, size, expected) in [
            ("plate", single(boxed(DVec3::new(1.0, thin, 1.0))), DVec3::new(1.0, thin, 1.0), &once[..]),
            ("needle", single(boxed(DVec3::new(thin, 1.0, thin))), DVec3::new(thin, 1.0, thin), &once),
            ("squashed balls", squashed, DVec3::new(0.25, 0.25 * thin, 0.25), &OUT_AND_IN),
        ] {
            let scene = ready(description)?;
            for &mode in subject.modes {
                subject.go_on()?;
                let mut numbers = Numbers(61);
                let mut wrong = 0;
                for _ in 0..subject.amount(300, 3000) {
                    let aim = turn * numbers.point(size * -0.5, size * 0.5);
                    let direction = numbers.direction();
                    let path =
                        trace(&scene, mode, Ray::new(aim - direction * 3.0, direction), Follow::Transmit, 0, None);
                    wrong += usize::from(interfaces(&path) != expected || path.events.total() > 0);
                }
                let measurement =
                    Measurement::none_of(format!("miscounts, {name}, {mode}"), wrong, "rays").limited_by(MERGED);
                steps.push(Step::at(aspect, measurement));
            }
        }
    }
    Ok(steps)
}

/// Whether two paths met the same media and events. The modes do not pass surfaces at which nothing changes by the same vertices.
fn went_alike(a: &TracedPath, b: &TracedPath) -> bool {
    let events = |path: &TracedPath| -> Vec<_> {
        let is_interface = |v: &&Vertex| v.from != v.to || v.solid.is_some();
        (path.vertices.iter().filter(is_interface))
            .map(|v| (v.from.clone(), v.to.clone(), v.solid.clone(), v.event))
            .collect()
    };
    a.camera_medium == b.camera_medium && a.escaped == b.escaped && events(a) == events(b)
}

fn builtin_scenes(subject: &Subject) -> Result<Vec<Step>, Unmeasured> {
    let mut steps = Vec::new();
    for (index, scene) in builtin::all().iter().enumerate() {
        subject.go_on()?;
        let prepared = ready(formats::open(scene.name)?)?;
        let camera = Camera::new(&prepared.description.camera)?;
        let mut numbers = Numbers(67);
        let size = glam::DVec2::splat(512.0);
        let rays: Vec<Ray> = (0..subject.amount(300, 5000))
            .map(|_| camera.ray(size * glam::DVec2::new(numbers.next(), numbers.next()), size, glam::DVec2::ZERO))
            .collect();
        let paths = |mode: Mode| -> Vec<TracedPath> {
            let one = |(seed, ray): (usize, &Ray)| trace(&prepared, mode, *ray, Follow::Sample, seed as u64, Some(30));
            rays.iter().enumerate().map(one).collect()
        };
        let truth = paths(Mode::Reference);
        for &mode in subject.modes.iter().filter(|mode| **mode != Mode::Reference) {
            let other = paths(mode).iter().zip(&truth).filter(|(a, b)| !went_alike(a, b)).count();
            let measurement = Measurement::none_of(format!("paths unlike reference, {mode}"), other, "paths");
            steps.push(Step::named(index as f64, scene.name, measurement));
        }
    }
    Ok(steps)
}
