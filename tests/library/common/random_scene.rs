//! Random scenes, for property tests: anything that a file can say without naming other files.

use glam::DVec3;
use iorect::optics::{Ior, Medium, catalog};
use iorect::scene::Description;
use iorect::scene::description::{
    CameraDescription, Environment, Light, Object, Paint, Quantity, Refractor, Shape, Solid, Transform, WorldMedium,
};
use proptest::prelude::*;

/// Of any size that scenes have, with all its digits.
pub fn number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        -10.0..10.0_f64,
        (-1.0..1.0_f64, -12..6_i32).prop_map(|(mantissa, exponent)| mantissa * 10.0_f64.powi(exponent)),
        (-100..100_i32).prop_map(f64::from),
    ]
}

fn positive() -> impl Strategy<Value = f64> + Clone {
    number().prop_map(|x| x.abs().max(1e-12))
}

fn share() -> impl Strategy<Value = f64> + Clone {
    0.0..=1.0_f64
}

pub fn vector() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

fn roughness() -> impl Strategy<Value = [f64; 2]> {
    prop_oneof![Just([0.0; 2]), share().prop_map(|alpha| [alpha; 2]), [share(), share()]]
}

fn three(one: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = [f64; 3]> {
    [one.clone(), one.clone(), one]
}

fn ior() -> impl Strategy<Value = Ior> {
    prop_oneof![
        (0.05..20.0_f64).prop_map(Ior::Constant),
        (1.0..2.5_f64, 0.0..0.02_f64, 0.0..1e-3_f64).prop_map(|(a, b, c)| Ior::Cauchy([a, b, c])),
        prop::collection::vec((0.1..1.5_f64, 0.0..0.2_f64).prop_map(|(b, c)| [b, c]), 1..4)
            .prop_map(|terms| Ior::Sellmeier(terms.into())),
        prop::sample::select(catalog::ALL.iter().collect::<Vec<_>>()).prop_map(Ior::Catalog),
    ]
}

pub fn transform() -> impl Strategy<Value = Transform> {
    let scale = prop_oneof![
        Just(DVec3::ONE),
        positive().prop_map(DVec3::splat),
        // A sphere takes no other; mirrored is allowed.
        positive().prop_map(|x| DVec3::new(-x, x, x)),
    ];
    (scale, vector(), vector()).prop_map(|(scale, rotate, translate)| Transform { scale, rotate, translate })
}

fn shape() -> impl Strategy<Value = Shape> {
    prop_oneof![
        (vector(), positive()).prop_map(|(center, radius)| Shape::Sphere { center, radius }),
        (vector(), positive(), 0..4_u32).prop_map(|(center, radius, subdivisions)| Shape::Icosphere {
            center,
            radius,
            subdivisions
        }),
        (vector(), three(1e-3..5.0_f64)).prop_map(|(min, size)| Shape::Box { min, max: min + DVec3::from_array(size) }),
        (vector(), positive(), positive(), 3..90_u32).prop_map(|(center, radius, height, segments)| Shape::Cylinder {
            center,
            radius,
            height,
            segments
        }),
        (vector(), positive(), 0.01..0.99_f64, 3..90_u32, 3..90_u32).prop_map(
            |(center, major, share, segments, rings)| {
                Shape::Torus { center, major, minor: major * share, segments, rings }
            }
        ),
        // A bottle: it rises, so it cannot cross itself.
        (prop::collection::vec(0.1..2.0_f64, 1..6), 3..90_u32).prop_map(|(radii, segments)| {
            let top = radii.len() as f64 + 1.0;
            let side = radii.into_iter().enumerate().map(|(index, radius)| [radius, index as f64 + 0.5]);
            Shape::Lathe { profile: std::iter::once([0.0, 0.0]).chain(side).chain([[0.0, top]]).collect(), segments }
        }),
        (vector(), 0.1..5.0_f64, 0.1..5.0_f64, vector()).prop_map(|(center, u, v, towards)| {
            let edge_u = towards.try_normalize().unwrap_or(DVec3::X) * u;
            Shape::Quad { center, edge_u, edge_v: edge_u.any_orthogonal_vector().normalize() * v }
        }),
    ]
}

/// Of every kind, by either quantity.
fn light() -> impl Strategy<Value = (Shape, Light)> {
    let way = || vector().prop_map(|way| way.try_normalize().unwrap_or(DVec3::Y));
    let shape = prop_oneof![
        4 => shape(),
        1 => vector().prop_map(|position| Shape::Point { position }),
        1 => (vector(), way(), share(), 0.1..180.0_f64).prop_map(|(position, way, share, outer_angle)| Shape::Spot {
            position,
            target: position + way,
            inner_angle: share * outer_angle,
            outer_angle
        }),
        1 => (way(), prop_oneof![Just(0.0), 0.001..180.0_f64])
            .prop_map(|(direction, angle)| Shape::Directional { direction, angle }),
    ];
    (shape, three(positive()), any::<[bool; 2]>()).prop_map(|(shape, rgb, [has_power, two_sided])| {
        let own = shape.quantity();
        let quantity = if has_power && own != Quantity::Irradiance { Quantity::Power } else { own };
        let two_sided = two_sided && shape.has_surface();
        (shape, Light { two_sided, ..Light::of(quantity, rgb) })
    })
}

fn camera() -> impl Strategy<Value = CameraDescription> {
    let optional = prop::option::of(positive());
    (vector(), 1.0..100.0_f64, 1.0..179.0_f64, prop_oneof![Just(0.0), positive()], optional).prop_map(
        |(target, distance, vertical_fov, aperture_radius, focus_distance)| CameraDescription {
            position: target + DVec3::new(0.6, 0.0, 0.8) * distance,
            target,
            up: DVec3::Y,
            vertical_fov,
            aperture_radius,
            focus_distance,
        },
    )
}

fn environment() -> impl Strategy<Value = Environment> {
    let color = || three(share());
    prop_oneof![
        color().prop_map(Environment::Color),
        (color(), color(), color()).prop_map(|(zenith, horizon, nadir)| Environment::Gradient {
            zenith,
            horizon,
            nadir
        }),
    ]
}

fn paint() -> impl Strategy<Value = Paint> {
    let color = || three(share());
    prop_oneof![
        color().prop_map(Paint::Color),
        (color(), color(), positive()).prop_map(|(a, b, size)| Paint::Checker { a, b, size }),
    ]
}

/// Letters, quotes, signs and marks of any script, but no control characters.
fn word() -> impl Strategy<Value = String> {
    "\\PC{0,12}"
}

/// Names must differ: a number makes sure of that.
fn named<T>(kind: &'static str, things: Vec<(String, T)>) -> Vec<(String, T)> {
    let name = |(index, (word, thing)): (usize, (String, T))| (format!("{kind}{index}{word}"), thing);
    things.into_iter().enumerate().map(name).collect()
}

pub fn description() -> impl Strategy<Value = Description> {
    let media = prop::collection::vec((word(), (ior(), three(positive()))), 1..4);
    let refractors = prop::collection::vec(
        (word(), (any::<prop::sample::Index>(), shape(), any::<i32>(), (any::<[bool; 4]>(), roughness()), transform())),
        0..4,
    );
    let solids =
        prop::collection::vec((word(), (shape(), paint(), (any::<[bool; 3]>(), roughness()), transform())), 0..3);
    let lights = prop::collection::vec((word(), (light(), any::<bool>(), transform())), 0..3);
    let world = (ior(), three(positive())).prop_map(|(ior, absorption)| WorldMedium { ior, absorption });
    (word(), camera(), world, environment(), media, refractors, solids, lights).prop_map(
        |(name, camera, world, environment, media, refractors, solids, lights)| {
            let media: Vec<Medium> = (named("m", media).into_iter())
                .map(|(name, (ior, absorption))| Medium { name, ior, absorption })
                .collect();
            Description {
                name: format!("scene {name}"),
                camera,
                camera_medium: (media.len() > 2).then(|| media[1].name.clone()),
                world,
                environment,
                objects: (named("r", refractors).into_iter())
                    .map(|(name, (medium, shape, priority, flags, transform))| {
                        let medium = medium.get(&media).name.clone();
                        let ([smooth, visible, is_declared, thin], roughness) = flags;
                        let outside = is_declared.then(|| media[0].name.clone());
                        let role = Refractor { medium, priority, smooth, roughness, thin, outside }.into();
                        Object { name, shape, transform, visible, role }
                    })
                    .chain((named("s", solids).into_iter()).map(
                        |(name, (shape, paint, ([mirror, smooth, visible], roughness), transform))| {
                            let roughness = if mirror { roughness } else { [0.0; 2] };
                            let role = Solid { paint, mirror, roughness, smooth }.into();
                            Object { name, shape, transform, visible, role }
                        },
                    ))
                    .chain((named("l", lights).into_iter()).map(|(name, ((shape, light), visible, transform))| {
                        Object { name, shape, transform, visible, role: light.into() }
                    }))
                    .collect(),
                media,
                source: None,
            }
        },
    )
}
