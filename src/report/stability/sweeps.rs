//! Sweeps over lengths: scale, offset, gaps, depth, slivers; and over the built-in scenes.

use glam::{DVec2, DVec3};

use super::closed_forms::passage;
use super::definition::{Measured, Subject, SweepDefinition, of_each, steps};
use super::nests::{EVER_DENSER, HEIGHTS, deflections};
use super::outcome::{Measurement, Step};
use super::scenes::{Numbers, add, deflection_degrees, empty, icosphere, interfaces, nest, ready, sphere};
use super::shells::{Kind, OUT_AND_IN, miscounted, miscounts, scaled, shells};
use crate::formats::{self, builtin};
use crate::geometry::Ray;
use crate::scene::camera::Camera;
use crate::scene::description::{Description, Shape, Transform};
use crate::tracking::{Mode, Prepared};
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

/// The largest; NaN if one is, which `f64::max` would drop.
fn largest(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |worst: f64, e| if e.is_nan() || e > worst { e } else { worst })
}

/// Largest error of the deflection by [`EVER_DENSER`] spheres scaled and moved, over heights; NaN if a path is not as it must be.
fn worst_deflection(scene: &Prepared, mode: Mode, scale: f64, center: DVec3, bound: f64) -> Measurement {
    deflection_error(
        HEIGHTS.map(|b| {
            let ray = Ray::new(center + DVec3::new(-10.0, b, 0.0) * scale, DVec3::X);
            let path = trace(scene, mode, ray, Follow::Transmit, 0, None);
            let expected = passage(1.0, &EVER_DENSER, b);
            let met = path.vertices.iter().filter(|v| v.from != v.to && v.event == VertexEvent::Transmit).count();
            if !path.escaped || path.events.total() > 0 || met != expected.crossings {
                return f64::NAN;
            }
            super::closed_forms::wrapped(deflection_degrees(&path) - expected.degrees).abs()
        }),
        bound,
    )
}

fn deflection_error(errors: impl IntoIterator<Item = f64>, bound: f64) -> Measurement {
    Measurement::absolute("deflection error, spheres", largest(errors), 0.0, bound).in_unit("°")
}

fn scale(subject: &Subject) -> Measured<Step> {
    steps((-6..=6).map(|exponent| 10f64.powi(exponent)), |scale| {
        let spheres = ready(transformed(nest(1.0, &EVER_DENSER), scale, DVec3::ZERO))?;
        let two = ready(shells(1e-4, Kind::Triangles, scale, DVec3::ZERO))?;
        subject.in_modes(|mode| {
            let count = miscounted(&two, mode, DVec3::ZERO, scale, &OUT_AND_IN, subject.amount(200, 2000));
            let miscounts = Measurement::none_of("miscounts, triangles", count, "rays");
            Ok([worst_deflection(&spheres, mode, scale, DVec3::ZERO, 1e-9), miscounts])
        })
    })
}

fn powers_of_two(subject: &Subject) -> Measured<Step> {
    of_each([-40, -20, -7, -1, 1, 7, 20, 40], |exponent| {
        let found = scaled(subject, "paths with another bit", exponent, subject.amount(60, 600))?;
        Ok(found.into_iter().map(|m| Step::named(2f64.powi(exponent), format!("2^{exponent}"), m)).collect())
    })
}

/// Why meshes far from the origin, beside something near it, lose their shape.
const STORED_SHORT: &str = "vertices are stored in f32 about one origin for the whole scene, and faces within 8 of its steps are one \
                            surface: so far out that is more than the gap";

/// Why what lies very close together is one.
const MERGED: &str = "by design: triangles within 8 steps of f32 of each other, and spheres within 1e-12, are one surface, so that what \
                      is meant to touch need not be modelled to the last bit";

fn offset(subject: &Subject) -> Measured<Step> {
    steps([0.0, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6], |distance| {
        let center = DVec3::new(1.0, -0.75, 0.5) * distance;
        let spheres = ready(transformed(nest(1.0, &EVER_DENSER), 1.0, center))?;
        // A ray's own origin is rounded to 1e-16 of the distance, which a nest amplifies.
        let bound = 1e-9 + 1e-12 * distance;
        let mut found = subject.in_modes(|mode| Ok([worst_deflection(&spheres, mode, 1.0, center, bound)]))?;
        let places = [(0.1, "alone"), (0.001, "alone"), (0.1, BESIDE), (0.001, BESIDE)];
        for (gap, place) in places.into_iter().filter(|(_, place)| *place != BESIDE || distance >= 10.0) {
            for kind in Kind::BOTH {
                let mut description = shells(gap, kind, 1.0, center);
                if place == BESIDE {
                    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.0, 0.0);
                }
                let what = format!(", {}, gap {gap}, {place}", kind.name());
                let rays = subject.amount(200, 2000);
                let counts = miscounts(subject, what, &ready(description)?, center, &OUT_AND_IN, rays)?;
                let is_limited = kind == Kind::Triangles;
                found.extend(counts.into_iter().map(|m| if is_limited { m.limited_by(STORED_SHORT) } else { m }));
            }
        }
        Ok(found)
    })
}

const BESIDE: &str = "beside an object at the origin";

fn gap(subject: &Subject) -> Measured<Step> {
    let rays = subject.amount(200, 2000);
    let merged = [("world", "object 1"), ("object 1", "world")];
    let mut found = steps((1..=12).map(|exponent| 10f64.powi(-exponent)), |gap| {
        of_each(Kind::BOTH, |kind| {
            let scene = ready(shells(gap, kind, 1.0, DVec3::ZERO))?;
            subject.in_modes(|mode| {
                let count = miscounted(&scene, mode, DVec3::ZERO, 1.0, &OUT_AND_IN, rays);
                // Rays that see the gap and rays that see one surface are all the rays there are.
                let unmerged = miscounted(&scene, mode, DVec3::ZERO, 1.0, &merged, rays);
                let neither = (count + unmerged).saturating_sub(rays);
                let what = format!("neither a gap nor one surface, {}", kind.name());
                Ok([
                    Measurement::none_of(format!("miscounts, {}", kind.name()), count, "rays").limited_by(MERGED),
                    Measurement::none_of(what, neither, "rays").limited_by(
                        "vertices are stored in f32, whose neighbours lie 6e-8 apart at radius 1: of closer shells some faces \
                         coincide and others do not",
                    ),
                ])
            })
        })
    })?;
    found.extend(of_each(Kind::BOTH, |kind| {
        let scene = ready(shells(0.0, kind, 1.0, DVec3::ZERO))?;
        let counts = miscounts(subject, format!(", {}", kind.name()), &scene, DVec3::ZERO, &merged, rays)?;
        Ok(counts.into_iter().map(|m| Step::named(0.0, "coincident", m)).collect())
    })?);
    Ok(found)
}

fn depth(subject: &Subject) -> Measured<Step> {
    steps([1.0, 2.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0], |count| {
        let of = |k: usize| (1.0 - k as f64 / (count + 1.0), [1.5, 1.4][k % 2]);
        let list: Vec<_> = (0..count as usize).map(of).collect();
        let scene = ready(nest(1.0, &list))?;
        subject.in_modes(|mode| {
            let one = Subject { modes: &[mode], ..*subject };
            let of_heights = of_each(HEIGHTS, |b| deflections(&one, &scene, 1.0, &list, b, 1e-6))?;
            Ok([deflection_error(of_heights.iter().map(|m| m.error), 1e-6)])
        })
    })
}

/// Bodies with faces `aspect` times as long as wide, around the origin; each ray through the middle goes in and out of all of them.
fn slivers(subject: &Subject) -> Measured<Step> {
    let turned = Transform { rotate: DVec3::new(11.0, 22.0, 33.0), ..Transform::IDENTITY };
    let turn = turned.matrix().matrix3;
    let once = [("world", "object 0"), ("object 0", "world")];
    let boxed = |half: DVec3| Shape::Box { min: -half, max: half };
    steps((0..=6).map(|exponent| 10f64.powi(exponent)), |aspect| {
        let thin = 1.0 / aspect;
        let squashed = Transform { scale: DVec3::new(1.0, thin, 1.0), ..turned };
        let (plate, needle) = (DVec3::new(1.0, thin, 1.0), DVec3::new(thin, 1.0, thin));
        let balls = vec![icosphere(1.0, 3), icosphere(0.5, 3)];
        let rows = [
            ("plate", vec![boxed(plate)], turned, plate, &once[..]),
            ("needle", vec![boxed(needle)], turned, needle, &once),
            ("squashed balls", balls, squashed, DVec3::new(0.25, 0.25 * thin, 0.25), &OUT_AND_IN),
        ];
        of_each(rows, |(name, shapes, transform, size, expected)| {
            let mut description = empty(1.0);
            shapes.into_iter().for_each(|shape| add(&mut description, shape, 1.0, 0.0));
            description.objects.refractors_mut().iter_mut().for_each(|refractor| refractor.transform = transform);
            let scene = ready(description)?;
            subject.in_modes(|mode| {
                let mut numbers = Numbers(61);
                let mut wrong = 0;
                for _ in 0..subject.amount(300, 3000) {
                    let aim = turn * numbers.point(size * -0.5, size * 0.5);
                    let direction = numbers.direction();
                    let ray = Ray::new(aim - direction * 3.0, direction);
                    let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
                    wrong += usize::from(interfaces(&path) != expected || path.events.total() > 0);
                }
                Ok([Measurement::none_of(format!("miscounts, {name}"), wrong, "rays").limited_by(MERGED)])
            })
        })
    })
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

fn builtin_scenes(subject: &Subject) -> Measured<Step> {
    of_each(builtin::all().iter().enumerate(), |(index, scene)| {
        let prepared = ready(formats::open(scene.name)?)?;
        let camera = Camera::new(&prepared.description.camera)?;
        let mut numbers = Numbers(67);
        let size = DVec2::splat(512.0);
        let rays: Vec<Ray> = (0..subject.amount(300, 5000))
            .map(|_| camera.ray(size * DVec2::new(numbers.next(), numbers.next()), size, DVec2::ZERO))
            .collect();
        let paths = |mode: Mode| -> Vec<TracedPath> {
            let one = |(seed, ray): (usize, &Ray)| trace(&prepared, mode, *ray, Follow::Sample, seed as u64, Some(30));
            rays.iter().enumerate().map(one).collect()
        };
        let truth = paths(Mode::Reference);
        let others: Vec<Mode> = subject.modes.iter().copied().filter(|mode| *mode != Mode::Reference).collect();
        let found = Subject { modes: &others, ..*subject }.in_modes(|mode| {
            let other = paths(mode).iter().zip(&truth).filter(|(a, b)| !went_alike(a, b)).count();
            Ok([Measurement::none_of("paths unlike reference", other, "paths")])
        })?;
        Ok(found.into_iter().map(|m| Step::named(index as f64, scene.name, m)).collect())
    })
}
