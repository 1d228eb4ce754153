//! Functions that read a scene: the search along a ray, the interface table, lights, the camera.

use glam::{DVec2, DVec3};
use iorect::geometry::Ray;
use iorect::render::gpu::Gpu;
use iorect::scene::ObjectId;
use iorect::scene::lights::Target;
use iorect::tracking::Mode;

use super::{Subject, device, fine, floats, settings, workshop};
use crate::common::{Numbers, add, empty, icosphere, mesh_of};

const SIZE: [u32; 2] = [48, 32];

impl Subject {
    /// Lengths on the device are so many times those of local coordinates: a power of two.
    fn scale(&self) -> f64 {
        1.0 / self.prepared.scene.geometry.step
    }

    fn probe(&self, gpu: &Gpu, body: &str, input: &[u32], count: usize, output: usize) -> Vec<u32> {
        let settings = settings(Mode::Rectified, 1);
        fine(gpu.probe(&self.task(&settings), SIZE, body, input, count as u32, output))
    }
}

fn bits(v: DVec3) -> [u32; 3] {
    v.as_vec3().to_array().map(f32::to_bits)
}

fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// Rays in and around a scene, some along axes, with zeros of both signs.
fn rays(subject: &Subject, seed: u64, count: usize) -> Vec<Ray> {
    let mut numbers = Numbers(seed);
    let middle = -subject.prepared.scene.geometry.origin;
    (0..count)
        .map(|_| {
            let origin = rounded(middle + numbers.direction() * numbers.between(0.0, 2.5));
            let mut direction = numbers.direction();
            if numbers.index(8) == 0 {
                let sign = if numbers.index(2) == 0 { 1.0 } else { -1.0 };
                let zero = -0.0 * sign;
                direction =
                    [DVec3::new(sign, zero, -zero), DVec3::new(zero, sign, zero), DVec3::new(-zero, zero, sign)]
                        [numbers.index(3)];
            }
            Ray::new(origin, rounded(direction))
        })
        .collect()
}

fn words(subject: &Subject, rays: &[Ray]) -> Vec<u32> {
    rays.iter().flat_map(|ray| [bits(ray.origin * subject.scale()), bits(ray.direction)].concat()).collect()
}

/// The first hit: what, where, and from which side.
#[test]
fn the_first_hit_is_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    for subject in [Subject::new(workshop()), Subject::builtin("iced-water")] {
        let rays = rays(&subject, 11, 3000);
        let body = "fn probe(i: u32) {
            let hit = search(ray_leaving(vector(6u * i), vector(6u * i + 3u), NOTHING), FAR, NOTHING, false);
            probe_out[5u * i] = hit.primitive;
            put(5u * i + 1u, hit.t);
            put(5u * i + 2u, hit.weights.x);
            put(5u * i + 3u, hit.weights.y);
            probe_out[5u * i + 4u] = u32(hit.is_front);
        }";
        let found = subject.probe(&gpu, body, &words(&subject, &rays), rays.len(), 5);
        let table = &subject.prepared.table;
        let geometry = &subject.prepared.scene.geometry;
        let (mut others, mut hits) = (0, 0);
        for (ray, found) in rays.iter().zip(found.chunks(5)) {
            let expected = match table.mask() {
                Some(mask) => geometry.closest_but(ray, mask),
                None => geometry.closest(ray),
            };
            let Some(hit) = expected else {
                others += u32::from(found[0] != u32::MAX);
                continue;
            };
            hits += 1;
            if found[0] != hit.primitive || found[4] != u32::from(hit.is_front) {
                others += 1;
                continue;
            }
            let numbers = floats(&found[1..4]);
            let t = numbers[0] / subject.scale();
            let size = ray.origin.abs().max_element() + hit.t;
            // A ray that grazes a surface meets it somewhere.
            let normal = geometry.surface(ray, &hit).normal;
            let grazing = ray.direction.dot(normal).abs().max(1e-3);
            assert!((t - hit.t).abs() < 4e-6 * size / grazing, "{ray:?}: {t} {hit:?}");
            if geometry.sphere(hit.primitive).is_none() {
                let corners = geometry.corners(hit.primitive);
                let [v, w] = [numbers[1], numbers[2]];
                let at = corners[0] * (1.0 - v - w) + corners[1] * v + corners[2] * w;
                assert!((at - ray.at(hit.t)).length() < 8e-6 * size / grazing, "{ray:?}: {at} {hit:?}");
            }
        }
        assert!(hits > 1000 && others <= 6, "{others} of {hits}");
    }
}

/// Through a closed mesh every ray goes in as often as out, also along axes and exactly at corners and edges.
#[test]
fn no_ray_slips_through_a_closed_mesh() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let mut description = empty(1.0);
    add(&mut description, icosphere(1.0, 3), 1.5, 0.0);
    let mesh = mesh_of(&icosphere(1.0, 3));
    let subject = Subject::new(description);
    let mut numbers = Numbers(12);
    let origin = subject.prepared.scene.geometry.origin;
    let mut rays: Vec<Ray> = Vec::new();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| rounded(mesh.positions[index as usize] - origin));
        for target in [corners[0], rounded((corners[0] + corners[1]) / 2.0)] {
            // A start on a grid and a direction of few digits, so that the ray goes exactly through the target more often than not.
            let offset = DVec3::new(4.0, 2.0 * f64::from(numbers.index(5) as u32), 1.0) * [1.0, -1.0][numbers.index(2)];
            rays.push(Ray::new(rounded(target - offset), rounded(offset.normalize())));
            let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z][numbers.index(3)];
            rays.push(Ray::new(target - axis * 3.0, axis));
        }
    }
    let body = "fn probe(i: u32) {
        var ray = ray_leaving(vector(6u * i), vector(6u * i + 3u), NOTHING);
        probe_out[2u * i] = 0u;
        probe_out[2u * i + 1u] = 0u;
        for (var k = 0u; k < 16u; k += 1u) {
            let hit = search(ray, FAR, NOTHING, false);
            if hit.primitive == NOTHING { return; }
            probe_out[2u * i + u32(hit.is_front)] += 1u;
            ray = ray_beyond(ray, hit);
        }
    }";
    let found = subject.probe(&gpu, body, &words(&subject, &rays), rays.len(), 2);
    let wrong: Vec<_> = rays.iter().zip(found.chunks(2)).filter(|(_, hits)| hits[0] != hits[1]).collect();
    assert!(wrong.is_empty(), "{} of {}: {:?}", wrong.len(), rays.len(), wrong[0]);
    assert!(found.chunks(2).filter(|hits| hits[0] == 1).count() > rays.len() / 2);
}

/// How often answers about what rays meet first were compared, of those how many in divided faces, and how many differ.
#[derive(Debug, Default)]
pub struct Answers {
    pub compared: u32,
    pub in_divided_faces: u32,
    pub others: u32,
}

/// The media on both sides of what `rays` meet first.
pub fn compare_answers(gpu: &Gpu, subject: &Subject, rays: &[Ray]) -> Answers {
    let body = "fn probe(i: u32) {
        let ray = ray_leaving(vector(6u * i), vector(6u * i + 3u), NOTHING);
        let hit = search(ray, FAR, NOTHING, false);
        probe_out[4u * i] = hit.primitive;
        if hit.primitive == NOTHING || objects[faces[hit.primitive].object].kind != REFRACTOR { return; }
        let crossing = crossing_of(ray, hit);
        var is_known = tracker_ask(PATH, crossing, false);
        while !is_known {
            let found = search(member_ray(crossing), FAR, member_object(), false);
            tracker_hear(found.primitive != NOTHING && !found.is_front);
            is_known = tracker_go_on(crossing);
        }
        probe_out[4u * i + 1u] = told.before;
        probe_out[4u * i + 2u] = told.behind;
        probe_out[4u * i + 3u] = u32(told.is_interface);
    }";
    let found = subject.probe(gpu, body, &words(subject, rays), rays.len(), 4);
    let (scene, table) = (&*subject.prepared.scene, &*subject.prepared.table);
    let mut answers = Answers::default();
    for (ray, found) in rays.iter().zip(found.chunks(4)) {
        let hit = match table.mask() {
            Some(mask) => scene.geometry.closest_but(ray, mask),
            None => scene.geometry.closest(ray),
        };
        let Some(hit) = hit.filter(|hit| hit.primitive == found[0]) else { continue };
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        if !scene.is_refractor(object) {
            continue;
        }
        let answer = table.look(scene, object, &scene.geometry.surface(ray, &hit), hit.barycentric);
        let (before, behind) =
            if hit.is_front { (answer.outside, answer.inside) } else { (answer.inside, answer.outside) };
        let expected = [before.0, behind.0, u32::from(!answer.is_masked())];
        answers.compared += 1;
        answers.in_divided_faces += u32::from(table.is_mixed(object, hit.primitive));
        answers.others += u32::from(found[1..] != expected);
    }
    answers
}

/// In faces that are divided, and cells that are asked about.
#[test]
fn the_interface_table_says_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    for subject in [Subject::new(workshop()), Subject::builtin("half-submerged"), Subject::builtin("iced-water")] {
        let answers = compare_answers(&gpu, &subject, &rays(&subject, 13, 4000));
        assert!(answers.compared > 1000 && answers.in_divided_faces > 100 && answers.others <= 4, "{answers:?}");
    }
    let answers = compare_answers(&gpu, &Subject::new(workshop()), &rays_at_the_rim(&Subject::new(workshop())));
    assert!(answers.in_divided_faces > 1000 && answers.others <= 4, "{answers:?}");
}

/// From inside the pool of the workshop up to where the block stands on its surface, most of them to the block's rim.
pub fn rays_at_the_rim(subject: &Subject) -> Vec<Ray> {
    let mut numbers = Numbers(16);
    (0..4000)
        .map(|_| {
            let mut at = DVec3::new(numbers.between(-0.2, 0.5), 0.0, numbers.between(-0.7, -0.1));
            let off = numbers.between(-0.03, 0.03);
            match numbers.index(4) {
                0 => at.x = -0.2 + off,
                1 => at.x = 0.5 + off,
                2 => at.z = -0.7 + off,
                _ => at.z = -0.1 + off,
            }
            let direction = DVec3::new(numbers.between(-0.2, 0.2), 1.0, numbers.between(-0.2, 0.2)).normalize();
            let origin = subject.prepared.scene.geometry.origin;
            Ray::new(rounded(at - direction * 0.2 - origin), rounded(direction))
        })
        .collect()
}

/// Radiance, density and samples of the environment, and of emitters of all kinds.
#[test]
fn lights_are_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::new(workshop());
    let (scene, scale) = (&*subject.prepared.scene, subject.scale());
    let mut numbers = Numbers(14);
    let cases: Vec<(DVec3, DVec3, [f64; 3])> = (0..3000)
        .map(|_| {
            let u = [(); 3].map(|()| f64::from(numbers.next() as f32).min(0.999_999));
            (rounded(numbers.direction() * 1.5 - scene.geometry.origin), rounded(numbers.direction()), u)
        })
        .collect();
    let input: Vec<u32> = (cases.iter())
        .flat_map(|(position, direction, u)| {
            [bits(*position * scale), bits(*direction), u.map(|u| (u as f32).to_bits())].concat()
        })
        .collect();
    let body = "fn probe(i: u32) {
        let at = 22u * i;
        let direction = vector(9u * i + 3u);
        let u = vector(9u * i + 6u);
        put_vector(at, environment_radiance(direction));
        put(at + 3u, environment_pdf(direction));
        let sky = environment_sample(u.yz);
        put_vector(at + 4u, sky.direction);
        put(at + 7u, sky.pdf);
        let lamp = emitters_sample(vector(9u * i), u.x, u.yz);
        put_vector(at + 8u, lamp.direction);
        put(at + 11u, lamp.pdf);
        probe_out[at + 12u] = lamp.object;
        // The density of where the ray of that sample arrives.
        let ray = ray_leaving(vector(9u * i), lamp.direction, NOTHING);
        let hit = search(ray, FAR, lamp.object, false);
        var pdf = 0.0;
        if lamp.pdf > 0.0 && lamp.object != NOTHING && hit.primitive != NOTHING {
            pdf = emitter_density_of(ray.origin, ray.direction, lamp.object, surface_at(ray, hit));
        }
        put(at + 13u, pdf);
        put_vector(at + 14u, lamp.radiance);
        put(at + 17u, lamp.distance);
        probe_out[at + 18u] = u32(lamp.is_delta);
        put_vector(at + 19u, suns_radiance(direction, 0.3));
    }";
    let words = subject.probe(&gpu, body, &input, cases.len(), 22);
    let mut others = 0;
    let mut lamps = [0; 4];
    for ((position, direction, u), words) in cases.iter().zip(words.chunks(22)) {
        let found = floats(words);
        let case = format!("{position} {direction} {u:?}: {found:?}");
        let near = |a: f64, b: f64, share: f64| (a - b).abs() <= share * (a.abs().max(b.abs()) + 1e-6);
        let radiance = scene.environment.radiance(*direction).to_rgb();
        // A texel is a thousandth of the image's width, and its brightness may be quite another than its neighbour's.
        assert!((0..3).all(|k| near(found[k], radiance[k], 2e-2)), "{radiance:?} {case}");
        others += u32::from(!near(found[3], scene.environment.pdf(*direction), 1e-3));
        let sky = scene.environment.sample([u[1], u[2]]).unwrap();
        let is_near =
            (DVec3::from_slice(&found[4..7]) - sky.direction).length() < 1e-3 && near(found[7], sky.pdf, 2e-3);
        others += u32::from(!is_near);
        let mut suns = DVec3::ZERO;
        for (sun, probability) in scene.emitters.suns() {
            let sampled = probability * sun.pdf_direct(*direction);
            suns += DVec3::from(sun.radiance(*direction).to_rgb()) / (1.0 + (sampled / 0.3).powi(2));
        }
        others += u32::from(!(0..3).all(|k| near(found[19 + k], suns[k], 1e-3)));
        match scene.emitters.sample_direct(&scene.geometry, *position, u[0], [u[1], u[2]]) {
            None => others += u32::from(found[11] != 0.0),
            Some(lamp) => {
                let (kind, object, distance) = match lamp.target {
                    Target::Surface { object, .. } => {
                        (usize::from(scene.geometry.sphere_of(object.0).is_some()), object.0, 3e38)
                    }
                    Target::Point { distance } => (2, u32::MAX, distance * scale),
                    Target::Environment => (3, u32::MAX, 3e38),
                };
                lamps[kind] += 1;
                let radiance = lamp.radiance.to_rgb();
                let is_near = (DVec3::from_slice(&found[8..11]) - lamp.direction).length() < 1e-4
                    && near(found[11], lamp.pdf, 1e-3)
                    && words[12] == object
                    && (0..3).all(|k| near(found[14 + k], radiance[k], 1e-3))
                    && near(found[17], distance, 1e-5)
                    && words[18] == u32::from(lamp.is_delta);
                others += u32::from(!is_near);
                // Both ways to the density agree.
                others += u32::from(found[13] > 0.0 && !near(found[13], found[11], 2e-3));
            }
        }
    }
    assert!(lamps.iter().all(|count| *count > 100) && others <= 12, "{lamps:?} {others}");
}

/// Images on solids: where they are looked up, and what is found there.
#[test]
fn images_on_solids_are_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let text = r#"
        camera = { position = [0.0, 0.0, 9.0], target = [0.0, 0.0, 0.0] }
        [[solid]]
        name = "globe"
        texture = "assets/thumbnails/iced-water.png"
        tint = [0.9, 0.5, 1.0]
        shape = { sphere = { center = [-1.0, 0.2, 0.3], radius = 0.7 } }
        transform = { rotate = [20.0, 50.0, -70.0], scale = 1.3 }
        [[solid]]
        name = "crate"
        texture = "assets/thumbnails/wine-glass.png"
        shape = { box = { min = [0.1, -1.0, -0.8], max = [1.5, 0.7, 0.6] } }
        transform = { rotate = [0.0, 20.0, 5.0], scale = [1.0, -1.0, 1.1] }
        [[solid]]
        name = "ring"
        texture = "assets/thumbnails/iced-water.png"
        shape = { torus = { center = [0.0, 0.0, 0.0], major = 1.4, minor = 0.2, segments = 24, rings = 12 } }
        [[solid]]
        name = "grey"
        shape = { sphere = { center = [0.0, 1.5, 0.0], radius = 0.3 } }
    "#;
    let path = std::path::Path::new("images.toml");
    let subject = Subject::new(iorect::formats::parse(text, path, &iorect::formats::Disk).unwrap());
    let scene = &*subject.prepared.scene;
    let rays = rays(&subject, 31, 3000);
    let body = "fn probe(i: u32) {
        let ray = ray_leaving(vector(6u * i), vector(6u * i + 3u), NOTHING);
        let hit = search(ray, FAR, NOTHING, false);
        probe_out[4u * i] = hit.primitive;
        if hit.primitive != NOTHING {
            put_vector(4u * i + 1u, albedo_at(faces[hit.primitive].object, hit, surface_at(ray, hit)));
        }
    }";
    let found = subject.probe(&gpu, body, &words(&subject, &rays), rays.len(), 4);
    let (mut seen, mut errors) = ([0; 4], Vec::new());
    for (ray, found) in rays.iter().zip(found.chunks(4)) {
        let Some(hit) = scene.geometry.closest(ray).filter(|hit| found[0] == hit.primitive) else { continue };
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        let albedo = scene.albedo(object).unwrap().at(&hit, &scene.geometry.surface(ray, &hit)).to_rgb();
        seen[object.0 as usize] += 1;
        errors.push((DVec3::from(albedo) - DVec3::from_slice(&floats(&found[1..]))).abs().max_element());
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
    // A rounding of f32 in a coordinate is less than a thousandth of a texel, and neighbours may be black and white.
    errors.sort_by(f64::total_cmp);
    let (middle, most) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
    assert!(middle < 2e-5 && most < 3e-3, "{middle:e} {most:e}");
}

/// Rays through pixels and lens.
#[test]
fn the_camera_is_the_same() {
    let Some(device) = device() else { return };
    let gpu = Gpu::new(device);
    let subject = Subject::new(workshop());
    let mut numbers = Numbers(15);
    let cases: Vec<([u32; 2], [f64; 4])> = (0..1000)
        .map(|_| {
            let pixel = SIZE.map(|side| numbers.index(side as usize) as u32);
            (pixel, [(); 4].map(|()| f64::from(numbers.next() as f32)))
        })
        .collect();
    let input: Vec<u32> =
        (cases.iter()).flat_map(|(pixel, u)| [&pixel[..], &u.map(|u| (u as f32).to_bits())[..]].concat()).collect();
    let body = "fn probe(i: u32) {
        let lens = lens_point(vec2f(number(6u * i + 4u), number(6u * i + 5u)));
        let ray = camera_ray(vec2u(probe_in[6u * i], probe_in[6u * i + 1u]), vec2f(number(6u * i + 2u), number(6u * i + 3u)), lens);
        put_vector(8u * i, ray.origin);
        put_vector(8u * i + 3u, ray.direction);
        put(8u * i + 6u, lens.x);
        put(8u * i + 7u, lens.y);
    }";
    let found = floats(&subject.probe(&gpu, body, &input, cases.len(), 8));
    let size = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
    for ((pixel, u), found) in cases.iter().zip(found.chunks(8)) {
        let lens = DVec2::from_slice(&found[6..8]);
        assert!(lens.length() <= 1.0 + 1e-6);
        let at = DVec2::new(f64::from(pixel[0]) + u[0], f64::from(pixel[1]) + u[1]);
        let ray = subject.camera.ray(at, size, lens);
        let origin = DVec3::from_slice(&found[..3]) / subject.scale() + subject.prepared.scene.geometry.origin;
        assert!((origin - ray.origin).length() < 2e-6, "{origin} {ray:?}");
        assert!((DVec3::from_slice(&found[3..6]) - ray.direction).length() < 5e-7, "{found:?} {ray:?}");
    }
    // The disc is covered evenly: a quarter of the points lies within half its radius.
    let inner = found.chunks(8).filter(|found| DVec2::from_slice(&found[6..8]).length() < 0.5).count();
    assert!((200..300).contains(&inner), "{inner}");
}
