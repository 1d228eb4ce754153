//! Stiff and extreme cases: thin gaps, coincidence, far and tiny and huge scenes, rays at vertices and edges, broken meshes, deep nests,
//! absorption from nothing to everything. Media are counted, and none may be miscounted.

use crate::common::truth::{Truth, is_above, media_along, rays, survey};
use crate::common::{
    Numbers, add, empty, icosphere, interfaces, mean, mesh_of, mesh_shape, nest, ready, render, sphere,
};
use glam::DVec3;
use iorect::geometry::{Mesh, Ray};
use iorect::scene::description::{Description, Environment, Shape, Transform};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;
use iorect::transport::inspect::{Follow, TracedPath, trace};

const RIGHT: [Mode; 2] = [Mode::Reference, Mode::Rectified];

/// Rays through a nest, from all sides, of which many start inside it.
fn many_rays(count: usize) -> Vec<Ray> {
    rays(count, 17, DVec3::splat(-0.6), DVec3::splat(0.6))
}

/// Rays straight through two shells a gap apart, at `center`, must meet in this order: world, glass, inner, glass, world. Returns the
/// number of rays that do not.
fn miscounted(scene: &Prepared, mode: Mode, center: DVec3, scale: f64, expected: &[(&str, &str)]) -> usize {
    let mut numbers = Numbers(29);
    let is_wrong = |_: &usize| {
        let direction = numbers.direction();
        let aim = numbers.direction() * 0.5;
        let ray = Ray::new(center + (aim - direction * 3.0) * scale, direction);
        let path = trace(scene, mode, ray, Follow::Transmit, 0, None);
        path.events.total() > 0 || !path.escaped || interfaces(&path) != expected
    };
    (0..2000).filter(is_wrong).count()
}

const OUT_AND_IN: [(&str, &str); 4] =
    [("world", "object 0"), ("object 0", "object 1"), ("object 1", "object 0"), ("object 0", "world")];

/// Two shells of equal IOR, so that rays go straight, a gap apart.
fn shells(gap: f64, subdivisions: u32, scale: f64, center: DVec3, is_analytic: bool) -> Description {
    let mut description = empty(1.0);
    for radius in [1.0, 1.0 - gap] {
        let shape = if is_analytic { sphere(DVec3::ZERO, radius) } else { icosphere(radius, subdivisions) };
        add(&mut description, shape, 1.0, 0.0);
        description.objects.refractors_mut().last_mut().unwrap().transform =
            Transform { scale: DVec3::splat(scale), rotate: DVec3::new(11.0, 22.0, 33.0), translate: center };
    }
    description
}

/// Case 35: gaps from 1e-2 to 1e-6.
#[test]
fn c35_gap_sweep() {
    for exponent in 2..=6 {
        let gap = 10f64.powi(-exponent);
        for is_analytic in [false, true] {
            let scene = ready(shells(gap, 3, 1.0, DVec3::ZERO, is_analytic));
            for mode in RIGHT {
                assert_eq!(miscounted(&scene, mode, DVec3::ZERO, 1.0, &OUT_AND_IN), 0, "gap {gap}, {mode}");
            }
            // Twin: the other way round it is another scene.
            let swapped =
                [("world", "object 1"), ("object 1", "object 0"), ("object 0", "object 1"), ("object 1", "world")];
            assert_eq!(miscounted(&scene, Mode::Rectified, DVec3::ZERO, 1.0, &swapped), 2000);
        }
    }
}

/// The same with light that bends: the paths from below a gap meet what a truth apart says.
#[test]
fn c35_gap_sweep_with_refraction() {
    for exponent in 2..=4 {
        let mut description = shells(10f64.powi(-exponent), 2, 1.0, DVec3::ZERO, false);
        for (medium, ior) in description.media.iter_mut().zip([1.5, 1.333]) {
            medium.ior = iorect::optics::Ior::Constant(ior);
        }
        let mut truth = Truth::new(&description);
        // Surfaces are as near to each other as the gap.
        truth.margin = 0.1 * 10f64.powi(-exponent);
        let scene = ready(description);
        for mode in RIGHT {
            let found = survey(&scene, &truth, mode, &many_rays(400));
            assert!(found.faults.is_empty() && found.checked > 400, "{found:?}");
        }
    }
}

/// Case 36: no gap. The same mesh twice is one surface, whose inside is that of the object that wins: by priority, then, at equal volume,
/// the later. Of a sphere in the file twice likewise.
#[test]
fn c36_no_gap() {
    for is_analytic in [false, true] {
        for (priorities, winner) in [([0, 0], "object 1"), ([1, 0], "object 0"), ([-1, 0], "object 1")] {
            let mut description = shells(0.0, 3, 1.0, DVec3::ZERO, is_analytic);
            description.objects.refractor_roles_mut().zip(priorities).for_each(|(r, p)| r.priority = p);
            let scene = ready(description);
            for mode in RIGHT {
                let once = [("world", winner), (winner, "world")];
                assert_eq!(
                    miscounted(&scene, mode, DVec3::ZERO, 1.0, &once),
                    0,
                    "{mode}, {priorities:?}, {is_analytic}"
                );
            }
            let loser = if winner == "object 0" { "object 1" } else { "object 0" };
            let other = [("world", loser), (loser, "world")];
            assert_eq!(miscounted(&scene, Mode::Rectified, DVec3::ZERO, 1.0, &other), 2000);
        }
    }
}

/// Case 36: coincident planar faces of other tessellation: a cylinder on a box, side by side with one of other segments, on a fine sheet
/// of triangles, wholly and in part, the same way and opposed.
#[test]
fn c36_planar_faces_of_other_tessellation() {
    let cylinder = |x: f64, y: f64, segments: u32| Shape::Cylinder {
        center: DVec3::new(x, y, 0.1),
        radius: 0.6,
        height: 1.0,
        segments,
    };
    let boxed = |min: [f64; 3], max: [f64; 3]| Shape::Box { min: min.into(), max: max.into() };
    // A box whose top and bottom are cut into many unequal triangles.
    let fine = {
        let profile =
            vec![[0.0, -1.0], [0.3, -1.0], [0.55, -1.0], [1.4, -1.0], [1.4, 0.0], [0.8, 0.0], [0.45, 0.0], [0.0, 0.0]];
        Shape::Lathe { profile, segments: 17 }
    };
    for (name, shapes) in [
        ("cylinder on a box", vec![boxed([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]), cylinder(0.1, 0.5, 24)]),
        ("cylinder over the edge of a box", vec![boxed([-1.0, -1.0, -1.0], [0.2, 0.0, 1.0]), cylinder(0.1, 0.5, 24)]),
        ("cylinder on a fine top", vec![fine.clone(), cylinder(0.1, 0.5, 24)]),
        ("cylinders on each other", vec![cylinder(0.0, -0.5, 17), cylinder(0.2, 0.5, 24), cylinder(-0.3, 0.5, 9)]),
        (
            "cylinder in a box, flush with its top",
            vec![boxed([-1.0, -2.0, -1.0], [1.0, 0.0, 1.0]), cylinder(0.1, -0.5, 24)],
        ),
        ("box in a fine one, flush with top and bottom", vec![fine, boxed([-0.4, -1.0, -0.5], [0.6, 0.0, 0.4])]),
        (
            "three boxes that share a face",
            vec![
                boxed([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]),
                boxed([-0.7, 0.0, -0.7], [0.3, 0.8, 0.9]),
                boxed([-0.2, -0.6, -0.4], [0.5, 0.0, 0.4]),
            ],
        ),
    ] {
        for rotate in [DVec3::ZERO, DVec3::new(12.0, -34.0, 56.0)] {
            for first in [0, 1] {
                let mut description = empty(1.0);
                for (k, shape) in shapes.iter().enumerate() {
                    add(&mut description, shape.clone(), 1.3 + 0.1 * k as f64, 0.0);
                    description.objects.refractors_mut()[k].transform.rotate = rotate;
                }
                description.objects.refractors_mut()[0].refractor_mut().unwrap().priority = first;
                let truth = Truth::new(&description);
                let scene = ready(description);
                let rays = truth.rays(500, 31);
                let mut coincident = 0;
                for mode in RIGHT {
                    let found = survey(&scene, &truth, mode, &rays);
                    assert!(
                        found.faults.is_empty() && found.checked > 500,
                        "{name}, turned by {rotate}, {first}: {} faults, {} checked, {:#?}",
                        found.faults.len(),
                        found.checked,
                        &found.faults[..found.faults.len().min(3)]
                    );
                    coincident += found.coincident;
                }
                assert!(coincident > 40, "{name}: only {coincident} coincident surfaces were met");
                assert!(survey(&scene, &truth, Mode::RectifiedObject, &rays).faults.len() > 20, "{name}");
            }
        }
    }
}

/// Case 37: 1e5 away from the origin, with a gap of 1e-1.
#[test]
fn c37_offset() {
    for center in [DVec3::new(1e5, -1e5, 0.5e5), DVec3::X * 1e5] {
        for is_analytic in [false, true] {
            let scene = ready(shells(0.1, 3, 1.0, center, is_analytic));
            for mode in RIGHT {
                assert_eq!(miscounted(&scene, mode, center, 1.0, &OUT_AND_IN), 0, "{center}, {mode}");
            }
        }
    }
    // Next to something at the origin, the vertices lie as far away as they say: within 0.0078 of where they were meant to be.
    let center = DVec3::new(1e5, 0.0, 0.0);
    let mut description = shells(0.1, 3, 1.0, center, false);
    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.0, 0.0);
    let scene = ready(description);
    for mode in RIGHT {
        assert_eq!(miscounted(&scene, mode, center, 1.0, &OUT_AND_IN), 0, "{mode}");
    }
}

/// Case 37: scaled by 2^±20, every bit is the same after scaling back.
#[test]
fn c37_scales() {
    let paths = |scale: f64| -> Vec<TracedPath> {
        let mut description = empty(1.0);
        add(&mut description, Shape::Box { min: DVec3::splat(-1.0), max: DVec3::new(1.0, 0.2, 1.0) }, 1.333, 0.0);
        add(&mut description, icosphere(0.8, 2), 1.5, 0.0);
        add(&mut description, sphere(DVec3::new(0.3, 0.1, 0.2), 0.5), 1.7, 0.0);
        add(
            &mut description,
            Shape::Box { min: DVec3::new(-0.5, 0.2, -0.5), max: DVec3::new(0.9, 0.6, 0.4) },
            1.2,
            0.0,
        );
        for refractor in description.objects.refractors_mut() {
            refractor.transform.scale = DVec3::splat(scale);
        }
        let scene = ready(description);
        let trace_one = |(k, ray): (usize, Ray), mode| {
            let ray = Ray::new(ray.origin * scale, ray.direction);
            trace(&scene, mode, ray, Follow::Sample, k as u64, Some(20)).scaled(scale.recip())
        };
        RIGHT
            .into_iter()
            .flat_map(|mode| many_rays(300).into_iter().enumerate().map(move |r| (r, mode)))
            .map(|(r, mode)| trace_one(r, mode))
            .collect()
    };
    let ordinary = paths(1.0);
    assert!(ordinary.iter().map(|p| p.vertices.len()).sum::<usize>() > 1500);
    assert!(ordinary.iter().all(|p| p.events.total() == 0));
    for scale in [2f64.powi(20), 2f64.powi(-20)] {
        assert_eq!(paths(scale), ordinary, "scale {scale}");
    }
    assert_ne!(paths(1.1), ordinary, "the comparison can fail");
}

/// Case 38: rays from inside and outside at every vertex, at points of every edge, and along the axes.
#[test]
fn c38_vertices_edges_and_axes() {
    let mut description = empty(1.0);
    let shapes = [icosphere(1.0, 2), icosphere(0.7, 1), icosphere(0.4, 0)];
    for shape in &shapes {
        add(&mut description, shape.clone(), 1.0, 0.0);
    }
    let truth = Truth::new(&description);
    let scene = ready(description);
    let mut numbers = Numbers(41);
    let mut aims = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    for shape in &shapes {
        let mesh = mesh_of(shape);
        let corner = |i: u32| mesh.positions[i as usize].as_vec3().as_dvec3();
        for t in &mesh.triangles {
            aims.extend(t.map(corner));
            let share = numbers.next();
            aims.push(corner(t[0]) * share + corner(t[1]) * (1.0 - share));
        }
    }
    let inside_out = [("object 2", "object 1"), ("object 1", "object 0"), ("object 0", "world")];
    for aim in &aims {
        for origin in [DVec3::ZERO, DVec3::new(0.01, -0.02, 0.03)] {
            let direction = (*aim - origin).normalize();
            for mode in RIGHT {
                let path = trace(&scene, mode, Ray::new(origin, direction), Follow::Transmit, 0, None);
                assert_eq!((interfaces(&path), path.events.total()), (inside_out.to_vec(), 0), "{mode}, at {aim}");
                // And straight through from outside.
                let ray = Ray::new(origin - direction * 3.0, direction);
                let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
                let names = media_along(&path, truth.together).unwrap();
                assert_eq!(Some(names), truth.straight_through(&ray), "{mode}, through {aim}");
                assert_eq!(path.events.total(), 0);
            }
        }
    }
    assert!(aims.len() > 1000);
}

/// Case 39: 5 % of the triangles missing, slivers, duplicates: nothing is not a number, and most of the answers are right.
#[test]
fn c39_broken_meshes() {
    let mut whole = empty(1.0);
    add(&mut whole, icosphere(1.0, 3), 1.4, 0.0);
    add(&mut whole, icosphere(0.6, 3), 1.5, 0.0);
    let truth = Truth::new(&whole);
    let mut numbers = Numbers(43);
    let mut broken = |mesh_to_break: Mesh| {
        let mut triangles = Vec::new();
        for t in mesh_to_break.triangles {
            match numbers.index(40) {
                // 5 %.
                0 | 1 => {}
                2 => triangles.extend([t, t]),
                3 => triangles.extend([t, [t[0], t[1], t[1]]]),
                _ => triangles.push(t),
            }
        }
        Mesh { triangles, ..mesh_to_break }
    };
    let mut description = whole.clone();
    for refractor in description.objects.refractors_mut() {
        refractor.shape = mesh_shape(broken(mesh_of(&refractor.shape)));
    }
    description.camera.vertical_fov = 15.0;
    let scene = ready(description);
    let rays = many_rays(1000);
    for mode in RIGHT {
        let started = rays.iter().filter(|ray| {
            trace(&scene, mode, **ray, Follow::Transmit, 0, Some(1)).camera_medium == truth.medium_at(ray.origin)
        });
        let started = started.count();
        assert!(started >= 995, "{mode}: {started} of 1000 start in the right medium");
        // Of paths that keep away from the holes nothing is wrong, so of all vertices most are right.
        let mut right = 0;
        let mut all = 0;
        for ray in &rays {
            let path = trace(&scene, mode, *ray, Follow::Transmit, 0, Some(12));
            for vertex in path.vertices.iter().filter(|v| v.from != v.to) {
                let position = DVec3::from(vertex.position);
                let shell = if position.length() > 0.8 { ("world", "object 0") } else { ("object 0", "object 1") };
                let seen = (vertex.from.as_deref().unwrap(), vertex.to.as_deref().unwrap());
                right += usize::from(seen == shell || (seen.1, seen.0) == shell);
                all += 1;
            }
            assert!(path.final_direction.iter().all(|x| x.is_finite()));
        }
        assert!(all > 2000 && right as f64 >= 0.99 * all as f64, "{mode}: {right} of {all}");
        let film = render(&scene, mode, (24, 24), 2, None);
        assert_eq!(film.events.non_finite, 0);
        assert!((0..24 * 24).all(|i| film.mean(i).is_finite()));
    }
    // The measure can tell: another truth is met by few.
    let wrong = truth.with_top(|a, b| !is_above(a, b));
    let started = rays.iter().filter(|ray| {
        trace(&scene, Mode::Rectified, **ray, Follow::Transmit, 0, Some(1)).camera_medium == wrong.medium_at(ray.origin)
    });
    assert!(started.count() < 800);
}

/// Case 40: 256 deep, in every mode: finite, and what does not fit is counted. All modes that see it from outside agree.
#[test]
fn c40_depth() {
    let shells: Vec<_> = (0..256).map(|k| (1.0 - f64::from(k) / 300.0, if k % 2 == 0 { 1.5 } else { 1.4 })).collect();
    let mut description = nest(1.0, &shells);
    for (k, refractor) in description.objects.refractors_mut().iter_mut().enumerate() {
        if k % 3 == 0 {
            let Shape::Sphere { radius, .. } = refractor.shape else { unreachable!() };
            // Vertices on the sphere, faces within it by less than the next shell.
            refractor.shape = icosphere(radius, 4);
        }
    }
    description.camera.vertical_fov = 8.0;
    let scene = ready(description);
    let ray = Ray::new(DVec3::new(-3.0, 0.011, 0.023), DVec3::X);
    let paths = [Mode::Rectified, Mode::Reference, Mode::Stack, Mode::Priority].map(|mode| {
        let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
        assert_eq!(path.events.total(), 0, "{mode}");
        assert!(path.escaped);
        (path.vertices.len(), path.final_direction)
    });
    assert_eq!(paths[0].0, 512);
    assert!(paths.iter().all(|path| *path == paths[0]), "{paths:?}");
    for mode in Mode::ALL {
        let film = render(&scene, mode, (6, 6), 1, None);
        assert!((0..36).all(|i| film.mean(i).is_finite()), "{mode}");
        assert_eq!(film.events.non_finite, 0, "{mode}");
        assert_eq!(film.events.total() > 0, matches!(mode, Mode::Naive | Mode::Declared), "{mode}: {:?}", film.events);
    }
}

/// Case 40: optical depths from 1e-6 to 1e3 through a nest of matched absorbers: exp(−σd) wherever it can be told from zero.
#[test]
fn c40_absorption() {
    for exponent in -6..=3 {
        let sigma = 10f64.powi(exponent);
        for world_ior in [1.0, 1.333] {
            let mut description = empty(world_ior);
            // Half of the way in each of two, the inner of which overlaps the outer's far wall.
            for (min, max) in [([-100.0, -100.0, -0.5], [100.0, 100.0, 0.25]), ([-90.0, -90.0, 0.0], [90.0, 90.0, 0.5])]
            {
                add(&mut description, Shape::Box { min: min.into(), max: max.into() }, world_ior, sigma);
            }
            description.camera.vertical_fov = 1e-3;
            let scene = ready(description);
            let expected = (-sigma).exp();
            for mode in RIGHT {
                let film = render(&scene, mode, (4, 4), 2, None);
                let (measured, _) = mean(&film);
                assert!(
                    (measured - expected).abs() <= 1e-8 * expected,
                    "{mode}, σd = {sigma}: {measured}, not {expected}"
                );
                assert_eq!(film.events.total(), 0);
            }
        }
    }
    // A path that turns in it: a drop of water that absorbs everything is black where it does not reflect, and finite.
    let mut description = nest(1.0, &[(1.0, 1.333)]);
    description.media[0].absorption = [1e3; 3];
    description.environment = Environment::Color([1.0; 3]);
    description.camera.vertical_fov = 5.0;
    let film = render(&ready(description), Mode::Rectified, (8, 8), 16, None);
    let (measured, error) = mean(&film);
    assert!((measured - 0.0203731878).abs() < 4.0 * error + 1e-3, "{measured}");
}

/// The global medium's absorption ends at the bounding sphere, and one 1e3 deep leaves nothing of it, in numbers.
#[test]
fn c40_global_absorption() {
    for exponent in -6..=3 {
        let mut description = nest(1.0, &[(1.0, 1.5), (0.5, 1.2)]);
        description.world.absorption = [10f64.powi(exponent); 3];
        for mode in Mode::ALL {
            let film = render(&ready(description.clone()), mode, (8, 8), 2, None);
            assert_eq!(film.events.non_finite, 0);
            assert!((0..64).all(|i| film.mean(i).is_finite() && film.mean(i).min_element() >= 0.0), "{mode}");
        }
    }
}
