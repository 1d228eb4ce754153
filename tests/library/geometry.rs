//! What a ray hits: against brute force in f64, at edges and vertices, along axes, far from zero, huge and tiny.

use crate::common::Numbers;
use glam::DVec3;
use iorect::geometry::{Geometry, Hit, Mesh, Part, Ray};
use iorect::scene::description::Shape;
use iorect::scene::shapes::tessellate;

fn icosphere(center: DVec3, radius: f64, subdivisions: u32) -> Mesh {
    tessellate(&Shape::Icosphere { center, radius, subdivisions }).unwrap().unwrap()
}

fn mesh_part(mesh: Mesh) -> Part {
    Part::Mesh { mesh, smooth: false }
}

/// Nested shells of tessellated spheres.
fn shells(radii: &[f64], center: DVec3) -> Geometry {
    Geometry::build(radii.iter().map(|&r| mesh_part(icosphere(center, r, 3))).collect::<Vec<_>>())
}

/// Whether the walk along `ray` from the middle of `count` nested closed shells meets each exactly once, from behind.
fn leaves_all_shells(geometry: &Geometry, ray: &Ray, count: usize) -> bool {
    let hits = geometry.all_hits(ray);
    hits.len() == count && hits.iter().all(|hit| !hit.is_front)
}

/// Möller–Trumbore in f64 over all triangles, rounded as `origin` rounds them: slow and separate. The ray is in local coordinates.
fn brute_force(mesh: &Mesh, origin: DVec3, ray: &Ray) -> Option<(f64, usize)> {
    let mut best: Option<(f64, usize)> = None;
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|i| (mesh.positions[i as usize] - origin).as_vec3().as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let determinant = e1.dot(p);
        let s = ray.origin - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) / determinant;
        let t = e2.dot(q) / determinant;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && best.is_none_or(|(nearest, _)| t < nearest) {
            best = Some((t, index));
        }
    }
    best
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mut numbers = Numbers(1);
    // Triangles in all sizes and shapes, many of them long and thin.
    let positions: Vec<DVec3> = (0..900)
        .map(|k| {
            let size = if k % 9 == 0 { 3.0 } else { 0.3 };
            numbers.direction() * numbers.next() * size + DVec3::new(0.0, 0.0, 0.5)
        })
        .collect();
    let triangles = (0..300).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let mesh = Mesh { positions, normals: Vec::new(), triangles, uvs: Vec::new() };
    let geometry = Geometry::build(&[mesh_part(mesh.clone())]);
    let mut hits = 0;
    for _ in 0..20_000 {
        let origin = numbers.direction() * 4.0;
        let aim = numbers.direction() * numbers.next();
        let ray = Ray::new(origin, (aim - origin).normalize());
        let found = geometry.closest(&ray);
        let expected = brute_force(&mesh, geometry.origin, &ray);
        match (found, expected) {
            (Some(hit), Some((t, index))) => {
                hits += 1;
                assert_eq!(hit.primitive as usize, index);
                assert!((hit.t - t).abs() < 1e-9 * t.max(1.0));
            }
            (None, None) => {}
            other => panic!("{other:?}"),
        }
        assert_eq!(geometry.is_occluded(&ray, f64::INFINITY), found.is_some());
    }
    assert!(hits > 1000, "the test must test something: {hits}");
}

#[test]
fn all_hits_are_what_closest_finds_one_by_one() {
    let mut numbers = Numbers(2);
    let mut parts: Vec<Part> = [1.0, 0.8, 0.5].map(|r| mesh_part(icosphere(DVec3::ZERO, r, 2))).to_vec();
    parts.push(Part::Sphere { center: DVec3::new(0.3, 0.0, 0.0), radius: 0.9 });
    parts.push(Part::Sphere { center: DVec3::ZERO, radius: 0.2 });
    let geometry = Geometry::build(&parts);
    for _ in 0..2000 {
        let start = Ray::new(numbers.direction() * 2.0, numbers.direction());
        let all = geometry.all_hits(&start);
        let mut ray = start;
        for expected in &all {
            let hit = geometry.closest(&ray).unwrap();
            assert_eq!(&hit, expected);
            ray = ray.beyond(&hit);
        }
        assert_eq!(geometry.closest(&ray), None);
    }
}

/// From the middle, every ray leaves every shell once, wherever it is aimed. Aimed at a vertex or an edge it may meet several faces of
/// one shell at the same place, all from behind.
#[test]
fn no_ray_slips_through_vertices_and_edges() {
    let mesh = icosphere(DVec3::ZERO, 1.0, 3);
    let geometry = Geometry::build(&[mesh_part(mesh.clone())]);
    let corner = |i: u32| mesh.positions[i as usize].as_vec3().as_dvec3();
    let mut numbers = Numbers(3);
    let inside = DVec3::new(0.01, 0.02, -0.03);
    let mut aims: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
    for t in &mesh.triangles {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let share = numbers.next();
            aims.push(corner(t[a]) * share + corner(t[b]) * (1.0 - share));
        }
    }
    for origin in [inside, DVec3::ZERO] {
        for &aim in &aims {
            let ray = Ray::new(origin, (aim - origin).normalize());
            let hit = geometry.closest(&ray).expect("a closed surface has no gaps");
            assert!(!hit.is_front);
            assert!((ray.at(hit.t) - aim).length() < 1e-9);
        }
    }
}

#[test]
fn directions_along_axes_and_negative_zero() {
    let geometry = shells(&[1.0, 0.7, 0.4], DVec3::ZERO);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for sign in [1.0, -1.0] {
            for zero in [0.0, -0.0] {
                let direction = DVec3::select(axis.cmpeq(DVec3::ZERO), DVec3::splat(zero), axis * sign);
                let ray = Ray::new(DVec3::new(0.011, 0.017, 0.013), direction);
                assert!(leaves_all_shells(&geometry, &ray, 3), "{direction}");
            }
        }
    }
}

/// Gaps from 1e-2 to 1e-6 between shells: no miscounts.
#[test]
fn thin_gaps() {
    let mut numbers = Numbers(4);
    for gap in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let geometry = shells(&[1.0, 1.0 - gap, 1.0 - 2.0 * gap], DVec3::ZERO);
        for _ in 0..3000 {
            let ray = Ray::new(numbers.direction() * 0.3, numbers.direction());
            assert!(leaves_all_shells(&geometry, &ray, 3), "gap {gap}");
        }
    }
}

/// A gap of 0.1 at an offset of 1e5, where f32 alone has a resolution of 0.008.
#[test]
fn far_from_zero() {
    let center = DVec3::new(1e5, -1e5, 1e5);
    let geometry = shells(&[1.0, 0.9, 0.8], center);
    let mut numbers = Numbers(5);
    for _ in 0..3000 {
        let ray = Ray::new(center - geometry.origin + numbers.direction() * 0.3, numbers.direction());
        assert!(leaves_all_shells(&geometry, &ray, 3));
    }
}

/// Scaled by a power of two, everything scales with it, bit for bit.
#[test]
fn huge_and_tiny() {
    let hits = |scale: f64| -> Vec<Hit> {
        let parts = [1.0, 0.7].map(|radius| {
            let mut mesh = icosphere(DVec3::new(0.1, 0.2, 0.3), radius, 3);
            mesh.positions.iter_mut().for_each(|p| *p *= scale);
            mesh_part(mesh)
        });
        let geometry = Geometry::build(&parts);
        let mut numbers = Numbers(6);
        (0..1000)
            .flat_map(|_| {
                let (origin, aim) = (numbers.direction() * 3.0, numbers.direction());
                geometry.all_hits(&Ray::new(origin * scale, (aim - origin).normalize()))
            })
            .map(|hit| Hit { t: hit.t / scale, ..hit })
            .collect()
    };
    let ordinary = hits(1.0);
    assert!(ordinary.len() > 100);
    for scale in [2f64.powi(20), 2f64.powi(-20), 2f64.powi(60), 2f64.powi(-60)] {
        assert_eq!(hits(scale), ordinary, "scale {scale}");
    }
}

/// Rays from far away keep their precision: the walk is shifted next to the tree.
#[test]
fn a_far_origin() {
    let geometry = shells(&[1.0], DVec3::ZERO);
    let mut numbers = Numbers(7);
    for _ in 0..1000 {
        let aim = numbers.direction() * 0.9 * numbers.next();
        let origin = numbers.direction() * 1e7;
        let hits = geometry.all_hits(&Ray::new(origin, (aim - origin).normalize()));
        assert_eq!(hits.len(), 2);
        assert!(hits[0].is_front && !hits[1].is_front);
    }
}

#[test]
fn an_empty_scene_is_hit_by_nothing() {
    let geometry = Geometry::build(&[]);
    assert_eq!(geometry.closest(&Ray::new(DVec3::ZERO, DVec3::X)), None);
    assert!(geometry.bounding_sphere().is_none());
}

/// Degenerate triangles are hit by nothing and harm nothing.
#[test]
fn slivers_and_points() {
    let mut mesh = icosphere(DVec3::ZERO, 1.0, 1);
    let first = mesh.triangles[0];
    mesh.triangles.push([first[0], first[0], first[1]]);
    mesh.triangles.push([first[2], first[2], first[2]]);
    let geometry = Geometry::build(&[mesh_part(mesh)]);
    let mut numbers = Numbers(8);
    for _ in 0..1000 {
        assert!(leaves_all_shells(&geometry, &Ray::new(DVec3::ZERO, numbers.direction()), 1));
    }
}

/// Tables that are filled in parallel, over more triangles than one thread takes at a time.
#[test]
fn areas_and_bounds_are_the_same_on_any_number_of_threads() {
    let mesh = icosphere(DVec3::new(0.5, -0.25, 0.0), 1.5, 5);
    let expected: f64 = (mesh.triangles.iter())
        .map(|t| t.map(|i| mesh.positions[i as usize].as_vec3().as_dvec3()))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum();
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        let parts = || vec![mesh_part(mesh.clone()), mesh_part(icosphere(DVec3::ZERO, 0.5, 2))];
        let geometry = pool.install(|| Geometry::build(parts()));
        let of_object = |object| (geometry.area(object), geometry.bounds_of(object));
        (of_object(0), of_object(1), *geometry.bounding_sphere().unwrap())
    };
    let one = on_threads(1);
    assert_eq!(one.0.0, expected, "the sum runs from the first face to the last");
    let (min, max) = one.0.1;
    let extreme =
        |of: fn(DVec3, DVec3) -> DVec3| mesh.positions.iter().map(|p| p.as_vec3().as_dvec3()).reduce(of).unwrap();
    assert_eq!((min, max), (extreme(DVec3::min), extreme(DVec3::max)));
    for count in [2, 3, 7] {
        assert_eq!(on_threads(count), one, "{count} threads");
    }
}
