//! Every kernel that this processor can run against the portable one.

use glam::{DQuat, DVec3};

use super::KernelChoice;
use crate::geometry::geometry::Geometry;
use crate::geometry::part::Part;
use crate::geometry::{Hit, Mesh, Ray, uniform_direction};

struct Numbers(u64);

impl Numbers {
    /// In [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        uniform_direction([self.next(), self.next()])
    }
}

/// A grid of `CELLS`² squares in the plane z = −¼, with corners at multiples of a tenth; some of its triangles are points or lines.
fn grid() -> Mesh {
    const CELLS: u32 = 20;
    let positions = (0..=CELLS)
        .flat_map(|i| (0..=CELLS).map(move |j| DVec3::new(f64::from(i) / 10.0 - 1.0, f64::from(j) / 10.0 - 1.0, -0.25)))
        .collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
        let a = i * (CELLS + 1) + j;
        triangles.extend([[a, a + CELLS + 1, a + CELLS + 2], [a, a + CELLS + 2, a + 1]]);
        if i % 5 == 0 {
            triangles.extend([[a, a, a + 1], [a, a, a], [a, a + 1, a]]);
        }
    }
    Mesh { positions, normals: Vec::new(), triangles, uvs: Vec::new() }
}

/// What a scene holds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Contents {
    Triangles,
    Spheres,
    Both,
}

/// A grid, tangled tetrahedra of all sizes and shapes, one of them twice, and spheres.
fn parts(numbers: &mut Numbers, scale: f64, offset: DVec3, contents: Contents) -> Vec<Part> {
    let mut meshes = vec![grid()];
    for _ in 0..150 {
        let turn = DQuat::from_axis_angle(numbers.direction(), 6.0 * numbers.next());
        let stretch = DVec3::new(0.02, 0.6, 0.3) * numbers.next();
        let place = numbers.direction() * numbers.next();
        let corner = |x, y, z| turn * (DVec3::new(x, y, z) * stretch) + place;
        meshes.push(Mesh {
            positions: vec![corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(0.0, 1.0, 0.0), corner(0.0, 0.0, 1.0)],
            normals: Vec::new(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            uvs: Vec::new(),
        });
    }
    meshes.push(meshes[1].clone());
    let mut parts: Vec<Part> = (meshes.into_iter())
        .map(|mut mesh| {
            mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
            Part::Mesh { mesh, smooth: false }
        })
        .collect();
    if contents == Contents::Spheres {
        parts.clear();
    }
    if contents != Contents::Triangles {
        parts.extend((0..20).map(|_| Part::Sphere {
            center: numbers.direction() * numbers.next() * scale + offset,
            radius: 0.2 * (0.1 + numbers.next()) * scale,
        }));
    }
    parts
}

/// Rays of every kind, in local coordinates.
fn rays(geometry: &Geometry, numbers: &mut Numbers, scale: f64, offset: DVec3) -> Vec<Ray> {
    let offset = offset - geometry.origin;
    let grid = grid();
    // As the geometry holds it.
    let corner = |index: f64| {
        let corner = grid.positions[(index * grid.positions.len() as f64) as usize] * scale + offset;
        corner.as_vec3().as_dvec3()
    };
    let random = |numbers: &mut Numbers| numbers.direction() * (1.5 * scale * numbers.next()) + offset;
    (0..6000)
        .map(|k| {
            let origin = random(numbers);
            let (origin, direction) = match k % 9 {
                0 => (origin, numbers.direction()),
                1 => (origin, random(numbers) - origin),
                // Along the axes.
                2 => (origin, DVec3::AXES[k / 9 % 3] * if k % 2 == 0 { 1.0 } else { -1.0 }),
                // Nearly along a plane of two axes.
                3 => (origin, numbers.direction() * DVec3::new(1.0, 1e-12, 1.0)),
                // Through corners, and through edges, seen aslant and straight.
                4 => (origin, corner(numbers.next()) - origin),
                5 => (corner(numbers.next()) + DVec3::Z * scale, DVec3::NEG_Z),
                6 => {
                    let (a, b) = (numbers.next(), numbers.next());
                    (origin, corner(a) * b + corner(a) * (1.0 - b) - origin)
                }
                // In the grid's plane.
                7 => {
                    let z = corner(0.0).z;
                    (DVec3::new(origin.x, origin.y, z), DVec3::new(numbers.next() - 0.5, numbers.next() - 0.5, 0.0))
                }
                // From far away.
                _ => {
                    let direction = numbers.direction();
                    (origin - direction * (1e4 * scale), direction)
                }
            };
            // Every other zero negative.
            let sign = if k % 2 == 0 { 0.0 } else { -0.0 };
            let direction = direction.normalize_or(DVec3::X).to_array().map(|x| if x == 0.0 { sign } else { x });
            Ray::new(origin, DVec3::from_array(direction))
        })
        .collect()
}

type Answers = (Vec<Option<Hit>>, Vec<bool>, Vec<Hit>);

/// Everything that a geometry answers along a ray.
fn answers(geometry: &Geometry, ray: &Ray, scale: f64) -> Answers {
    let closest = geometry.closest(ray);
    let mut hits = vec![closest];
    let mut occlusions: Vec<bool> =
        [0.1, 0.5, 2.0, f64::INFINITY].map(|reach| geometry.is_occluded(ray, reach * scale)).to_vec();
    if let Some(hit) = &closest {
        let leaving = Ray::leaving(geometry.surface(ray, hit).position, ray.direction.zxy(), hit.primitive);
        hits.extend([geometry.closest(&ray.beyond(hit)), geometry.closest(&leaving), geometry.closest_of(ray, 3)]);
        occlusions.extend([geometry.is_occluded(ray, hit.t), geometry.is_occluded(&leaving, f64::INFINITY)]);
    }
    (hits, occlusions, geometry.all_hits(ray))
}

/// Of all numbers in the hits: 0 and −0 are equal and have different bits.
fn bits((hits, _, all): &Answers) -> impl Iterator<Item = [u64; 3]> {
    hits.iter().flatten().chain(all).map(|hit| [hit.t, hit.barycentric[0], hit.barycentric[1]].map(f64::to_bits))
}

trait Turned {
    fn zxy(self) -> Self;
}

impl Turned for DVec3 {
    fn zxy(self) -> Self {
        Self::new(self.z, self.x, self.y)
    }
}

/// All kernels find the same at the same bits, whether asked for a ray or for many.
#[test]
fn kernels_agree() {
    let mut numbers = Numbers(1);
    let far = DVec3::new(1e5, -2e5, 3e5);
    for (scale, offset) in
        [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1e6, DVec3::ZERO), (1.0, far), (1.0, DVec3::new(9.0, -2.0, 3.0))]
    {
        for contents in [Contents::Triangles, Contents::Both, Contents::Spheres] {
            let mut geometry = Geometry::build(parts(&mut numbers, scale, offset, contents));
            let rays = rays(&geometry, &mut numbers, scale, offset);
            let mut expected = Vec::new();
            for kernel in KernelChoice::available() {
                geometry.set_kernel(kernel);
                let found: Vec<_> = rays.iter().map(|ray| answers(&geometry, ray, scale)).collect();
                let mut many = vec![None; rays.len()];
                geometry.closest_many(&rays, &mut many);
                let mut occluded = vec![false; rays.len()];
                geometry.is_occluded_many(&rays, &vec![0.5 * scale; rays.len()], &mut occluded);
                for (k, found) in found.iter().enumerate() {
                    assert_eq!(many[k], found.0[0], "{kernel:?}, scale {scale}, offset {offset}, {:?}", rays[k]);
                    assert_eq!(occluded[k], found.1[1], "{kernel:?}, scale {scale}, offset {offset}, {:?}", rays[k]);
                }
                if expected.is_empty() {
                    expected = found;
                    let hits = expected.iter().filter(|(hits, ..)| hits[0].is_some()).count();
                    let fewest = if contents == Contents::Spheres { rays.len() / 20 } else { rays.len() / 4 };
                    assert!(hits > fewest && hits < rays.len(), "the test must test something: {hits}");
                } else {
                    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        assert_eq!(found, expected, "{kernel:?}, scale {scale}, offset {offset}, {:?}", rays[k]);
                        assert!(bits(found).eq(bits(expected)), "{kernel:?}, {:?}", rays[k]);
                    }
                }
            }
        }
    }
}

/// Few rays, none, and searches that pass over a mask, in groups as alone.
#[test]
fn groups_of_any_size() {
    let mut numbers = Numbers(2);
    let mut geometry = Geometry::build(parts(&mut numbers, 1.0, DVec3::ZERO, Contents::Both));
    let rays = rays(&geometry, &mut numbers, 1.0, DVec3::ZERO);
    let mut mask = crate::geometry::Mask::default();
    (0..geometry.triangle_count() as u32 + 20).filter(|k| k % 3 == 0).for_each(|k| mask.insert(k));
    for kernel in KernelChoice::available() {
        geometry.set_kernel(kernel);
        for count in [0, 1, 2, 31, 32, 33, 300] {
            let rays = &rays[..count];
            let mut hits = vec![None; count];
            geometry.closest_many_but(rays, &mask, &mut hits);
            let alone: Vec<Option<Hit>> = rays.iter().map(|ray| geometry.closest_but(ray, &mask)).collect();
            assert_eq!(hits, alone, "{kernel:?}, {count} rays");

            let reaches: Vec<f64> = (0..count).map(|k| [0.3, 1.0, f64::INFINITY][k % 3]).collect();
            let mut occluded = vec![false; count];
            geometry.is_occluded_many(rays, &reaches, &mut occluded);
            assert!(
                occluded.iter().zip(rays.iter().zip(&reaches)).all(|(is, (r, t))| *is == geometry.is_occluded(r, *t))
            );
            geometry.is_occluded_many_but(rays, &reaches, &mask, &mut occluded);
            let alone: Vec<bool> =
                rays.iter().zip(&reaches).map(|(ray, reach)| geometry.is_occluded_but(ray, *reach, &mask)).collect();
            assert_eq!(occluded, alone, "{kernel:?}, {count} rays");
            assert!(count < 300 || (alone.contains(&true) && alone.contains(&false)));
        }
    }
}

/// A tree so deep that what waits does not fit: shells around shells, each half as large again as the last.
#[test]
fn a_degenerate_tree() {
    const COUNT: u32 = 200;
    let triangle = |k: u32| {
        let size = 1.5f64.powi(k as i32 - 100);
        [(2.0, 0.0), (-1.0, 2.0), (-1.0, -2.0)].map(|(x, y)| DVec3::new(x, y, 1.0) * size)
    };
    let positions = (0..COUNT).flat_map(triangle).collect();
    let triangles = (0..COUNT).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let shells =
        Part::Mesh { mesh: Mesh { positions, normals: Vec::new(), triangles, uvs: Vec::new() }, smooth: false };
    // Keeps the local origin next to the smallest of them; the ray leaves it behind.
    let grain = Part::Sphere { center: DVec3::NEG_Z * 1e-24, radius: 1e-25 };
    let mut geometry = Geometry::build(&[shells, grain]);
    let ray = Ray::new(-geometry.origin, DVec3::new(0.1, 0.2, 1.0).normalize());
    for kernel in KernelChoice::available() {
        geometry.set_kernel(kernel);
        assert_eq!(geometry.all_hits(&ray).len(), COUNT as usize, "{kernel:?}");
        let mut closest = [None; 20];
        geometry.closest_many(&[ray; 20], &mut closest);
        assert_eq!(closest, [geometry.closest(&ray); 20]);
        assert_eq!(closest[0].map(|hit| hit.primitive), Some(0));
    }
}

/// Rays that lie close together: bundles of every width about the rays of the other tests, from one point and from several.
#[test]
fn beams_find_what_each_ray_finds() {
    let mut numbers = Numbers(3);
    for (scale, offset) in [(1.0, DVec3::ZERO), (1e-6, DVec3::ZERO), (1.0, DVec3::new(1e5, -2e5, 3e5))] {
        for contents in [Contents::Triangles, Contents::Both] {
            let mut geometry = Geometry::build(parts(&mut numbers, scale, offset, contents));
            let leaders = rays(&geometry, &mut numbers, scale, offset);
            let mut bundled = Vec::new();
            for (k, leader) in leaders.iter().enumerate().step_by(5) {
                let width = [0.0, 1e-9, 1e-4, 3e-3][k / 5 % 4];
                let around = |numbers: &mut Numbers| numbers.direction() * width;
                bundled.extend((0..[4, 7, 32, 40][k / 20 % 4]).map(|_| {
                    let origin = leader.origin + around(&mut numbers) * (if k % 2 == 0 { scale } else { 0.0 });
                    let direction = (leader.direction + around(&mut numbers)).normalize();
                    // Zeros keep their signs where nothing is added to them.
                    Ray::new(origin, if width == 0.0 { leader.direction } else { direction })
                }));
            }
            for kernel in KernelChoice::available() {
                geometry.set_kernel(kernel);
                let mut hits = vec![None; bundled.len()];
                geometry.closest_many(&bundled, &mut hits);
                for (ray, hit) in bundled.iter().zip(&hits) {
                    assert_eq!(*hit, geometry.closest(ray), "{kernel:?}, scale {scale}, offset {offset}, {ray:?}");
                }
                let met = hits.iter().flatten().count();
                assert!(met > bundled.len() / 4 && met < bundled.len(), "the test must test something: {met}");
            }
        }
    }
}
