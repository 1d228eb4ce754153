//! Rays a second on one core, beside Embree's.
//!
//! `cargo bench --bench traversal` (options after `--`; `--help` lists them) builds meshes of about 60 thousand and a million triangles, asks the
//! same incoherent rays of iorect's geometry and of Embree, in turns within one run, and prints millions of rays a second, their ratio,
//! and the share of rays for which both found the same triangle. Rays are of two kinds: `pairs` run from one random point in the bounds towards
//! another (as far as there, where only occlusion is asked), `bounces` leave random points of the surfaces, spread as by a diffuse reflection.
//! `closest` and `any` ask a ray at a time; `many` and `any many` ask for all at once, beside Embree's single rays as well.
//!
//! Then come the kernels: the same questions of meshes, of analytic spheres and of both, to every kernel that the processor can run, with its time
//! over that of the portable one. All must find the same.
//!
//! Times are those in which the thread had its core, where the system tells (Linux), so that other programs disturb little.
//!
//! Embree is opened at run time if a library of version 3 or 4 is installed (on Debian: `libembree-dev`); without it iorect's own figures are
//! printed. Embree gets what a program that cares about speed gives it: static scenes of medium quality, one geometry, single rays in f32, no
//! filter, `RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT`. Its hits differ where f32 rounds a ray past an edge.

// Reason: calls into a C library.
#![allow(unsafe_code)]
// Reason: printing is what it is for.
#![allow(clippy::print_stdout)]

mod embree;

use std::time::Instant;

use embree::{Embree, Scene};
use glam::{DQuat, DVec3};
use iorect::geometry::{Geometry, Hit, KernelChoice, Mesh, Part, Ray, uniform_direction};
use iorect::scene::description::Shape;
use iorect::scene::shapes::tessellate;

const HELP: &str = "\
Rays a second on one core, beside Embree where it is installed.

Usage: cargo bench --bench traversal -- [OPTIONS]

  --quick        fewer rays, and no mesh of a million triangles
  --mesh NAME    only scenes whose name contains NAME
  --rays N       rays of each kind [1000000]
  --rounds N     turns; the fastest of each counts [5]
  --alone        do not look for Embree
  --help         this text
";

struct Options {
    quick: bool,
    mesh: String,
    rays: usize,
    rounds: usize,
    alone: bool,
}

fn main() {
    let mut options = Options { quick: false, mesh: String::new(), rays: 1_000_000, rounds: 5, alone: false };
    // Run among the tests, it only shows that it runs.
    if !std::env::args().any(|word| word == "--bench") {
        options = Options { quick: true, mesh: "nest-60k".into(), rays: 1000, rounds: 1, alone: true };
    }
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| stop(&format!("{argument} needs a value")));
        match argument.as_str() {
            "--quick" => (options.quick, options.rays) = (true, 200_000),
            "--mesh" => options.mesh = value(),
            "--rays" => options.rays = number(&value()),
            "--rounds" => options.rounds = number(&value()),
            "--alone" => options.alone = true,
            // Cargo adds this one.
            "--bench" => {}
            "--help" => {
                print!("{HELP}");
                return;
            }
            other => stop(&format!("unknown option {other}; --help lists them")),
        }
    }

    let embree = if options.alone {
        None
    } else {
        Embree::open()
            .inspect_err(|error| {
                println!("Embree is not there ({error}): iorect alone. On Debian it is in libembree-dev.")
            })
            .ok()
    };
    if let Some(embree) = &embree {
        println!("beside Embree {}", embree.version());
    }
    println!(
        "{:<10}{:>10}  {:<8}{:<9}{:>9}{:>9}{:>8}{:>10}",
        "mesh", "triangles", "rays", "question", "iorect", "Embree", "ratio", "agree"
    );
    for (name, make) in MESHES {
        if !name.contains(options.mesh.as_str()) || options.quick && *name == "nest-1M" {
            continue;
        }
        run(name, &make(), embree.as_ref(), &options);
    }
    kernels(&options);
}

fn number(text: &str) -> usize {
    match text.parse() {
        Ok(number) if number > 0 => number,
        _ => stop(&format!("{text} is not a number above 0")),
    }
}

fn stop(message: &str) -> ! {
    println!("{message}");
    std::process::exit(2);
}

type MakeMesh = fn() -> Mesh;

/// Names, and how to make them.
const MESHES: &[(&str, MakeMesh)] = &[("nest-60k", || nest(5)), ("heap-80k", || heap(1000)), ("nest-1M", || nest(7))];

/// Three dented spheres, one in another, of 20·4^`subdivisions` triangles each.
fn nest(subdivisions: u32) -> Mesh {
    let shells = [1.0, 0.9, 0.6].map(|radius| {
        let mut mesh = icosphere(subdivisions);
        for p in &mut mesh.positions {
            let dent = 0.02 * ((9.0 * p.x).sin() + (11.0 * p.y).sin() + (7.0 * p.z).sin());
            *p *= radius * (1.0 + dent);
        }
        mesh
    });
    joined(shells)
}

/// Many small stretched spheres of 80 triangles, in no order.
fn heap(count: usize) -> Mesh {
    let mut numbers = Numbers(7);
    let small = icosphere(1);
    joined((0..count).map(|_| {
        let place = numbers.point() - 0.5;
        let (axis, angle) = (numbers.direction(), 6.3 * numbers.next());
        let turn = DQuat::from_axis_angle(axis, angle);
        let stretch = DVec3::new(0.2, 1.0, 0.5) * (0.02 + 0.1 * numbers.next());
        let mut mesh = small.clone();
        mesh.positions.iter_mut().for_each(|p| *p = turn * (*p * stretch) + place);
        mesh
    }))
}

fn icosphere(subdivisions: u32) -> Mesh {
    match tessellate(&Shape::Icosphere { center: DVec3::ZERO, radius: 1.0, subdivisions }) {
        Ok(Some(mesh)) => mesh,
        _ => stop("an icosphere cannot be made"),
    }
}

fn joined(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    meshes.into_iter().fold(Mesh::default(), |mut all, mesh| {
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
        all
    })
}

/// A ray, and how far it goes where only occlusion is asked.
struct Question {
    ray: Ray,
    reach: f64,
}

fn run(name: &str, mesh: &Mesh, embree: Option<&Embree>, options: &Options) {
    let start = Instant::now();
    let geometry = Geometry::build(&[Part::Mesh { mesh: mesh.clone(), smooth: false }]);
    let seconds = start.elapsed().as_secs_f64();
    let scene = embree.map(|embree| {
        let start = Instant::now();
        let scene = embree.build(mesh);
        (scene, start.elapsed().as_secs_f64())
    });
    print!("{name:<10}{:>10}  built in {seconds:.2} s", mesh.triangles.len());
    match &scene {
        Some((_, seconds)) => println!(", Embree's in {seconds:.2} s (on all cores)"),
        None => println!(),
    }
    let scene = scene.map(|(scene, _)| scene);
    for (kind, questions) in [("pairs", pairs(&geometry, options.rays)), ("bounces", bounces(&geometry, options.rays))]
    {
        compare(kind, &geometry, scene.as_ref(), &questions, options.rounds);
    }
}

fn pairs(geometry: &Geometry, count: usize) -> Vec<Question> {
    let (min, max) = geometry.bounds_of(0);
    let mut numbers = Numbers(1);
    let question = |_| {
        let [from, to] = [numbers.point(), numbers.point()].map(|p| min + p * (max - min));
        let reach = from.distance(to);
        Question { ray: Ray::new(from, (to - from) / reach), reach }
    };
    (0..count).map(question).collect()
}

fn bounces(geometry: &Geometry, count: usize) -> Vec<Question> {
    let mut numbers = Numbers(2);
    let question = |_| {
        let u = [numbers.next(), numbers.next(), numbers.next()];
        let Some(point) = geometry.sample_surface(0, u) else { stop("the mesh has no area") };
        let side = if numbers.next() < 0.5 { point.normal } else { -point.normal };
        let direction = (side + numbers.direction()).normalize_or(side);
        Question { ray: Ray::leaving(point.position, direction, point.primitive), reach: f64::INFINITY }
    };
    (0..count).map(question).collect()
}

fn compare(kind: &str, geometry: &Geometry, scene: Option<&Scene>, questions: &[Question], rounds: usize) {
    let rays: Vec<Ray> = questions.iter().map(|q| q.ray).collect();
    let theirs: Vec<embree::Ray> = questions.iter().map(|q| embree::Ray::new(&q.ray, q.reach)).collect();
    let mut ours_closest: Vec<Option<Hit>> = vec![None; rays.len()];
    let mut ours_many = ours_closest.clone();
    let mut ours_any = vec![false; rays.len()];
    let mut theirs_closest = vec![u32::MAX; rays.len()];
    let mut theirs_any = ours_any.clone();
    let reaches: Vec<f64> = questions.iter().map(|q| q.reach).collect();
    let mut ours_any_many = ours_any.clone();
    let [mut closest, mut many, mut any, mut any_many, mut their_closest, mut their_any] = [f64::INFINITY; 6];
    for _ in 0..rounds {
        time(&mut closest, || ours_closest.iter_mut().zip(&rays).for_each(|(hit, ray)| *hit = geometry.closest(ray)));
        if let Some(scene) = scene {
            time(&mut their_closest, || {
                theirs_closest.iter_mut().zip(&theirs).for_each(|(hit, ray)| *hit = scene.closest(ray));
            });
        }
        time(&mut many, || geometry.closest_many(&rays, &mut ours_many));
        time(&mut any_many, || geometry.is_occluded_many(&rays, &reaches, &mut ours_any_many));
        time(&mut any, || {
            ours_any.iter_mut().zip(questions).for_each(|(any, q)| *any = geometry.is_occluded(&q.ray, q.reach));
        });
        if let Some(scene) = scene {
            time(&mut their_any, || {
                theirs_any.iter_mut().zip(&theirs).for_each(|(any, ray)| *any = scene.is_occluded(ray));
            });
        }
    }
    assert!(ours_many == ours_closest && ours_any_many == ours_any, "many rays find the same as each alone");
    let equal = |same: &dyn Fn(usize) -> bool| (0..rays.len()).filter(|k| same(*k)).count() as f64 / rays.len() as f64;
    let same_closest = equal(&|k| ours_closest[k].map_or(u32::MAX, |hit| hit.primitive) == theirs_closest[k]);
    let same_any = equal(&|k| ours_any[k] == theirs_any[k]);
    let rate = |seconds: f64| rays.len() as f64 / seconds / 1e6;
    for (question, seconds, their_seconds, same) in [
        ("closest", closest, their_closest, same_closest),
        ("many", many, their_closest, same_closest),
        ("any", any, their_any, same_any),
        ("any many", any_many, their_any, same_any),
    ] {
        print!("{:<10}{:>10}  {kind:<8}{question:<9}{:>9.2}", "", "", rate(seconds));
        if scene.is_some() {
            println!("{:>9.2}{:>8.2}{:>9.3}%", rate(their_seconds), their_seconds / seconds, 100.0 * same);
        } else {
            println!();
        }
    }
}

/// Every kernel's time for each question, over that of the portable one.
fn kernels(options: &Options) {
    println!(
        "\n{:<10}{:<10}{:>9}{:>9}{:>9}{:>9}  time over the portable kernel's",
        "scene", "kernel", "closest", "many", "any", "any many"
    );
    let mesh = || Part::Mesh { mesh: nest(5), smooth: false };
    let sphere = |radius: f64| Part::Sphere { center: DVec3::X * 0.1 * radius, radius };
    let spheres = [1.1, 0.8, 0.5].map(sphere);
    let both = [vec![mesh()], spheres.to_vec()].concat();
    for (name, parts) in [("nest-60k", vec![mesh()]), ("spheres", spheres.to_vec()), ("both", both)] {
        if !name.contains(options.mesh.as_str()) {
            continue;
        }
        let mut geometry = Geometry::build(parts);
        let questions = pairs(&geometry, options.rays);
        let (rays, reaches): (Vec<Ray>, Vec<f64>) = questions.iter().map(|q| (q.ray, q.reach)).unzip();
        let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
        let mut occluded = vec![false; rays.len()];
        let kernels = KernelChoice::available();
        let mut seconds = vec![[f64::INFINITY; 4]; kernels.len()];
        let mut expected = None;
        for _ in 0..options.rounds {
            for (kernel, [closest, many, any, any_many]) in kernels.iter().zip(&mut seconds) {
                geometry.set_kernel(*kernel);
                time(closest, || hits.iter_mut().zip(&rays).for_each(|(hit, ray)| *hit = geometry.closest(ray)));
                time(any, || {
                    occluded
                        .iter_mut()
                        .zip(&questions)
                        .for_each(|(any, q)| *any = geometry.is_occluded(&q.ray, q.reach));
                });
                let alone = (hits.clone(), occluded.clone());
                time(many, || geometry.closest_many(&rays, &mut hits));
                time(any_many, || geometry.is_occluded_many(&rays, &reaches, &mut occluded));
                let many = (hits.clone(), occluded.clone());
                let expected = expected.get_or_insert_with(|| alone.clone());
                assert!(
                    alone == *expected && many == *expected,
                    "{name}: {kernel:?} finds what the portable kernel does"
                );
            }
        }
        for (kernel, times) in kernels.iter().zip(&seconds) {
            print!("{name:<10}{:<10}", format!("{kernel:?}"));
            times.iter().zip(&seconds[0]).for_each(|(time, portable)| print!("{:>9.3}", time / portable));
            println!();
        }
    }
}

/// Runs `work` and keeps its seconds if they are the fewest so far.
fn time(fewest: &mut f64, work: impl FnOnce()) {
    let (start, on_core) = (Instant::now(), seconds_on_core());
    work();
    let seconds = match (on_core, seconds_on_core()) {
        (Some(start), Some(end)) => end - start,
        _ => start.elapsed().as_secs_f64(),
    };
    *fewest = fewest.min(seconds);
}

/// What this thread has run so far, without the time in which other programs had its core: Linux tells.
fn seconds_on_core() -> Option<f64> {
    let nanoseconds: u64 =
        std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()?;
    Some(nanoseconds as f64 * 1e-9)
}

/// A small generator: the same numbers everywhere.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In the unit cube.
    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> DVec3 {
        uniform_direction([self.next(), self.next()])
    }
}
