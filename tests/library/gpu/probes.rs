//! Functions that need no scene: random numbers, Fresnel, scattering, intersection.

use glam::DVec3;
use iorect::geometry::Ray;
use iorect::geometry::sphere::Sphere;
use iorect::optics::Interface;
use iorect::optics::fresnel::Refraction;
use iorect::render::gpu::Gpu;
use iorect::scatter::{Choice, Normals, dielectric, lambert, mirror};
use iorect::tracking::Mode;
use iorect::transport::sampler::{Sampler, Sequence};

use super::{Subject, device, fine, floats, settings, workshop};
use crate::common::Numbers;

/// A number that f32 holds.
fn f32_of(x: f64) -> f64 {
    f64::from(x as f32)
}

fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

fn bits(v: DVec3) -> [u32; 3] {
    v.as_vec3().to_array().map(f32::to_bits)
}

fn one(x: f64) -> u32 {
    (x as f32).to_bits()
}

/// Runs a probe with the shader of the workshop.
fn probe(gpu: &Gpu, body: &str, input: &[u32], count: usize, output: usize) -> Vec<u32> {
    let subject = Subject::new(workshop());
    let settings = settings(Mode::Rectified, 1);
    fine(gpu.probe(&subject.task(&settings), [48, 32], body, input, count as u32, output))
}

/// Bit by bit.
#[test]
fn random_numbers_are_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::new(workshop());
    let mut numbers = Numbers(1);
    let cases: Vec<[u32; 3]> = (0..2000)
        .map(|k| {
            let any = |numbers: &mut Numbers| (numbers.next() * 4_294_967_296.0) as u32;
            let [pixel, sample] = [0; 2].map(|_: u32| any(&mut numbers));
            [pixel, if k % 2 == 0 { k } else { sample }, k % 600]
        })
        .collect();
    for (sequence, seed) in [(Sequence::Sobol, 7), (Sequence::Independent, u64::MAX - 5)] {
        let settings = iorect::render::ImageSettings { sampler: sequence, seed, ..settings(Mode::Rectified, seed) };
        let body = "fn probe(i: u32) {
            let s = sampler_of(image.seed_hash, probe_in[3u * i], probe_in[3u * i + 1u]);
            let pair = bits_2d(s, probe_in[3u * i + 2u]);
            probe_out[3u * i] = bits_1d(s, probe_in[3u * i + 2u]);
            probe_out[3u * i + 1u] = pair.x;
            probe_out[3u * i + 2u] = pair.y;
        }";
        let input = cases.concat();
        let found = fine(gpu.probe(&subject.task(&settings), [48, 32], body, &input, cases.len() as u32, 3));
        for ([pixel, sample, dimension], found) in cases.iter().zip(found.chunks(3)) {
            let sampler = Sampler::of(sequence, seed, *pixel, *sample);
            let [x, y] = sampler.get_2d(*dimension);
            let expected = [sampler.get_1d(*dimension), x, y].map(|u| (u * 4_294_967_296.0) as u32);
            assert_eq!(found, expected, "{sequence:?} {pixel} {sample} {dimension}");
        }
    }
}

/// Sines, cosines and angles to a few roundings, which WGSL does not promise of its own.
#[test]
fn elementary_functions() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let mut numbers = Numbers(2);
    let cases: Vec<[f64; 3]> = (0..4000_u32)
        .map(|k| match k {
            0..16 => [f64::from(k) / 16.0, [0.0, 1.0, -1.0][k as usize % 3], [1.0, 0.0, -1.0][k as usize / 3 % 3]],
            _ => [numbers.next(), numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0)].map(f32_of),
        })
        .collect();
    let input: Vec<u32> = cases.iter().flatten().map(|x| one(*x)).collect();
    let body = "fn probe(i: u32) {
        let sin_cos = sin_cos_of_turns(number(3u * i));
        put(3u * i, sin_cos.x);
        put(3u * i + 1u, sin_cos.y);
        put(3u * i + 2u, angle_of(number(3u * i + 1u), number(3u * i + 2u)));
    }";
    let found = floats(&probe(&gpu, body, &input, cases.len(), 3));
    for ([turns, y, x], found) in cases.iter().zip(found.chunks(3)) {
        let (sine, cosine) = (std::f64::consts::TAU * turns).sin_cos();
        let expected = [sine, cosine, if [*y, *x] == [0.0; 2] { 0.0 } else { y.atan2(*x) }];
        for (found, expected) in found.iter().zip(expected) {
            // Four roundings of the largest value that can occur.
            assert!((found - expected).abs() < 4e-7 * expected.abs().max(0.5), "{turns} {y} {x}: {found} {expected}");
        }
    }
}

/// From 1e-7 of grazing to normal incidence, near the critical angle, and for indices that differ by 1e-6 and by 1e4. Tolerances are those of the physics
/// in f32: errors grow as 1 + c²/b².
#[test]
fn reflectance_and_refraction() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let mut numbers = Numbers(3);
    let mut cases: Vec<(Interface, f64)> = Vec::new();
    for (from, to) in
        [(0.0, 0.5), (0.5, 0.0), (0.333, 0.5), (0.5, 0.500_001), (0.500_001, 0.5), (0.0, 9e3), (1.4, 0.0), (0.0, -0.5)]
    {
        for _ in 0..250 {
            let c = match numbers.index(3) {
                0 => 10_f64.powf(-7.0 * numbers.next()),
                1 => 1.0 - 10_f64.powf(-7.0 * numbers.next()),
                _ => numbers.next(),
            };
            cases.push((Interface::new(from, to), f32_of(c.clamp(1e-7, 1.0))));
        }
    }
    let input: Vec<u32> = (cases.iter())
        .flat_map(|(interface, c)| {
            let [eta, inverse, e] = interface.numbers();
            [eta, inverse, e, interface.radiance_factor(), *c].map(one)
        })
        .collect();
    let body = "fn probe(i: u32) {
        let s = Interface(number(5u * i), number(5u * i + 1u), number(5u * i + 2u), number(5u * i + 3u));
        let c = number(5u * i + 4u);
        let found = refraction(s, c);
        put(3u * i, found.reflectance);
        let sine = sqrt((1.0 - c) * (1.0 + c));
        let direction = transmitted(s, vec3f(sine, -c, 0.0), vec3f(0.0, 1.0, 0.0), c, found.b);
        put(3u * i + 1u, select(found.b, -1.0, found.is_total));
        put(3u * i + 2u, select(direction.x, 0.0, found.is_total));
    }";
    let found = floats(&probe(&gpu, body, &input, cases.len(), 3));
    let mut totals = 0;
    for ((interface, c), found) in cases.iter().zip(found.chunks(3)) {
        let [_, inverse, e] = interface.numbers();
        match interface.refraction(*c) {
            Refraction::TotalReflection => {
                totals += 1;
                // Undecided within rounding of the critical angle.
                assert!(
                    found[1] == -1.0 || found[1].powi(2) < 4e-7 * (e.abs() + c * c),
                    "{interface:?} {c}: {found:?}"
                );
            }
            Refraction::Partial { reflectance, b } => {
                let tolerance = 4e-6 * (1.0 + c * c / (b * b)) + 4e-6 * (1.0 + e.abs() / (b * b));
                let is_near = (found[0] - reflectance).abs() <= tolerance * reflectance.max(1e-12);
                let undecided = b * b < 4e-7 * (e.abs() + c * c);
                assert!(is_near || undecided, "{interface:?} {c}: {found:?} is not {reflectance}, {b}");
                let sine = ((1.0 - c) * (1.0 + c)).sqrt();
                assert!(undecided || (found[2] - sine * inverse).abs() < 1e-5, "{interface:?} {c}: {found:?}");
            }
        }
    }
    assert!(totals > 100, "{totals}");
}

/// Two normals of a hit: equal, nearly equal, and as far apart as coarse meshes have them.
fn normals(numbers: &mut Numbers) -> Normals {
    let face = rounded(numbers.direction());
    let tilt = match numbers.index(3) {
        0 => 0.0,
        1 => 1e-3,
        _ => 0.4,
    };
    let shading = rounded((face + numbers.direction() * tilt).normalize());
    if tilt == 0.0 { Normals::flat(face) } else { Normals { face, shading } }
}

#[test]
fn scattering() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let mut numbers = Numbers(4);
    let cases: Vec<(Normals, DVec3, [f64; 2], u32, Interface)> = (0..2000)
        .map(|_| {
            let normals = normals(&mut numbers);
            let direction = rounded(numbers.direction());
            let direction = if direction.dot(normals.face) > 0.0 { -direction } else { direction };
            let u = [f32_of(numbers.next()), f32_of(numbers.next())];
            let (from, to) = [(0.0, 0.5), (0.5, 0.0), (0.333, 0.5)][numbers.index(3)];
            (normals, direction, u, 1 + numbers.index(30) as u32, Interface::new(from, to))
        })
        .collect();
    let input: Vec<u32> = (cases.iter())
        .flat_map(|(normals, direction, u, segment, interface)| {
            let [eta, inverse, e] = interface.numbers();
            let media = [eta, inverse, e, interface.radiance_factor()].map(one);
            let vectors = [normals.face, normals.shading, *direction].map(bits).concat();
            [vectors, vec![one(u[0]), one(u[1]), *segment], media.to_vec()].concat()
        })
        .collect();
    let body = "fn probe(i: u32) {
        let at = 16u * i;
        let n = Normals(vector(at), vector(at + 3u));
        let d = vector(at + 6u);
        let u = vec2f(number(at + 9u), number(at + 10u));
        let s = Interface(number(at + 12u), number(at + 13u), number(at + 14u), number(at + 15u));
        let diffuse = lambert_sample(n, u);
        put_vector(12u * i, diffuse.direction);
        put(12u * i + 3u, diffuse.pdf);
        put(12u * i + 4u, lambert_pdf(n, diffuse.direction));
        put_vector(12u * i + 5u, mirror_reflect(d, n));
        let through = dielectric_scatter(s, d, n, probe_in[at + 11u], u.x);
        put_vector(12u * i + 8u, through.direction);
        put(12u * i + 11u, select(0.0, 1.0, through.is_transmitted));
    }";
    let found = floats(&probe(&gpu, body, &input, cases.len(), 12));
    let vector = |found: &[f64]| DVec3::from_slice(&found[..3]);
    let mut others = 0;
    for ((normals, direction, u, segment, interface), found) in cases.iter().zip(found.chunks(12)) {
        let case = format!("{normals:?} {direction} {u:?} {segment} {interface:?}: {found:?}");
        // Rounded to f32 they have not quite unit length, which a tilt of 1e-4 does not bear in f64.
        let normals = &Normals { face: normals.face.normalize(), shading: normals.shading.normalize() };
        let (diffuse, pdf) = lambert::sample(normals, *u);
        // The direction in which one normal is tilted against the other is known as well as rounding leaves it.
        let tilt = (normals.face - normals.shading).length();
        let near = if tilt == 0.0 { 2e-6 } else { 1e-5 + 4e-7 / tilt };
        assert!((vector(found) - diffuse).length() < near && (found[3] - pdf).abs() < near, "diffuse {diffuse} {case}");
        let told = lambert::pdf(normals, diffuse);
        assert!((found[4] - told).abs() < 1e-4, "pdf {told} {case}");
        let mirrored = mirror::reflect(*direction, normals);
        assert!((vector(&found[5..]) - mirrored).length() < 2e-5, "mirror {mirrored} {case}");
        let expected = dielectric::scatter(interface, *direction, normals, *segment, Choice::Sample(u[0]));
        let is_same = (found[11] == 1.0) == expected.is_transmitted;
        let is_near = (vector(&found[8..]) - expected.direction).length() < 2e-3;
        others += u32::from(!(is_same && is_near));
    }
    // A random number next to the reflectance, and angles next to the critical one, may go either way.
    assert!(others <= 4, "{others}");
}

/// Spheres: near and far, large and small, hit and missed.
#[test]
fn spheres_are_met_where_they_are() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let mut numbers = Numbers(5);
    let cases: Vec<(Sphere, Ray)> = (0..2000)
        .map(|_| {
            let (center, radius) =
                (rounded(numbers.direction() * 3.0), f32_of(10_f64.powf(numbers.between(-2.0, 1.0))));
            let origin = rounded(numbers.direction() * numbers.between(0.0, 6.0));
            let towards = center + numbers.direction() * (radius * numbers.between(0.0, 1.3)) - origin;
            (Sphere { center, radius }, Ray::new(origin, rounded(towards.normalize())))
        })
        .collect();
    let input: Vec<u32> = (cases.iter())
        .flat_map(|(sphere, ray)| {
            let vectors = [sphere.center, ray.origin, ray.direction].map(bits).concat();
            [vectors, vec![one(sphere.radius)]].concat()
        })
        .collect();
    let body = "fn probe(i: u32) {
        let sphere = Sphere(vector(10u * i), number(10u * i + 9u));
        let hits = meet_sphere(sphere, vector(10u * i + 3u), vector(10u * i + 6u), false);
        put(2u * i, select(-1e9, hits.enter, hits.has_enter));
        put(2u * i + 1u, select(-1e9, hits.leave, hits.has_leave));
    }";
    let found = floats(&probe(&gpu, body, &input, cases.len(), 2));
    for ((sphere, ray), found) in cases.iter().zip(found.chunks(2)) {
        let from_center = ray.origin - sphere.center;
        let distance = (from_center - ray.direction * from_center.dot(ray.direction)).length();
        // Next to its edge a sphere is hit or missed, and deep by the root of the rounding.
        let scale = from_center.length() + sphere.radius;
        let depth = (sphere.radius - distance) / scale;
        if depth.abs() < 1e-6 {
            continue;
        }
        for (found, expected) in found.iter().zip(sphere.intersect(ray, false)) {
            let expected = expected.unwrap_or(-1e9);
            let near = 3e-6 * scale * (1.0 + (sphere.radius / (depth.abs() * scale)).sqrt());
            assert!((found - expected).abs() < near || found == &expected, "{sphere:?} {ray:?}: {found} {expected}");
        }
    }
}
