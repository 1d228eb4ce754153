//! Faults planted in the shaders, one in each module at least: images at equal seeds must show them.

use std::sync::atomic::AtomicBool;

use iorect::render::cpu::Cpu;
use iorect::render::gpu::{Gpu, Replacement};
use iorect::render::{Film, Renderer};
use iorect::tracking::Mode;

use super::lookups::{compare_answers, rays_at_the_rim};
use super::{Difference, Subject, device, settings, workshop};

/// The module, the mode, what is replaced and by what.
type Fault = (&'static str, Mode, &'static str, &'static str);

const FAULTS: &[Fault] = &[
    (
        "numbers",
        Mode::Rectified,
        "case 2u: { return vec2f(-sine, -cosine); }",
        "case 2u: { return vec2f(sine, -cosine); }",
    ),
    ("sampler", Mode::Rectified, "x ^= (x >> 4u) & 0x0f0f0f0fu;", "x ^= (x >> 4u) & 0x0f0f0f0eu;"),
    ("fresnel", Mode::Rectified, "return Refraction(false, 0.5 * rs * rs", "return Refraction(false, 0.9 * rs * rs"),
    ("frame", Mode::Rectified, "let a = -1.0 / (sign + normal.z);", "let a = 1.0 / (sign + normal.z);"),
    ("normals", Mode::Rectified, "all(normals.face == normals.shading)", "all(abs(normals.face) >= vec3f(0.0))"),
    (
        "mirror",
        Mode::Rectified,
        "clamp(-dot(direction, normals.shading), 0.0, 1.0);\n    let mirrored",
        "clamp(-0.9 * dot(direction, normals.shading), 0.0, 1.0);\n    let mirrored",
    ),
    ("lambert", Mode::Rectified, "let r = sqrt(u.x);", "let r = u.x;"),
    (
        "dielectric",
        Mode::Rectified,
        "bent.is_total || u < bent.reflectance",
        "bent.is_total || u > 1.0 - bent.reflectance",
    ),
    (
        "ray",
        Mode::Rectified,
        "Ray(origin, direction, primitive, 0.0, NOTHING)",
        "Ray(origin, direction, primitive, 0.1, NOTHING)",
    ),
    (
        "triangle",
        Mode::Rectified,
        "let t = dot(weights, vec3f(a.z, b.z, c.z));",
        "let t = dot(weights, vec3f(a.z, c.z, b.z));",
    ),
    ("sphere", Mode::Rectified, "let leave = -b + root;", "let leave = -b + 1.01 * root;"),
    (
        "search",
        Mode::Rectified,
        "stack[open] = select(nodes[node].child0, nodes[node].child1, is_first_nearer);",
        "stack[open] = select(nodes[node].child1, nodes[node].child1, is_first_nearer);",
    ),
    (
        "surface",
        Mode::Rectified,
        "return select(normal, shading, dot(shading, normal) > 0.0);",
        "return select(normal, shading, dot(shading, normal) > 2.0);",
    ),
    ("camera", Mode::Rectified, "turns = 0.125 * p.y / p.x;", "turns = 0.126 * p.x / p.y;"),
    ("scene", Mode::Rectified, "return exp(-absorption * length);", "return exp(-absorption * 1.2 * length);"),
    ("texture", Mode::Rectified, "between_texels(1.0 - uv.y,", "between_texels(uv.y,"),
    (
        "environment",
        Mode::Rectified,
        "return share * light_number(scene.row_shares + row)",
        "return 1.1 * share * light_number(scene.row_shares + row)",
    ),
    ("bodiless: spot", Mode::Rectified, "return share * share;", "return share;"),
    ("bodiless: suns", Mode::Rectified, "radiance += sun.color * weight;", "radiance += 5.0 * sun.color * weight;"),
    ("area", Mode::Rectified, "return sin_squared / (1.0 + sqrt(", "return sin_squared / (2.0 + sqrt("),
    (
        "tracker",
        Mode::Rectified,
        "select(inside, outside, crossing.is_entering)",
        "select(outside, inside, crossing.is_entering)",
    ),
    ("flat: cells", Mode::Rectified, "let is_first = turned.x >= turned.y;", "let is_first = turned.x < turned.y;"),
    (
        "flat: members",
        Mode::Rectified,
        "add_digit(u32(is_inside), select(4u, 2u, coincident_count == 0u));\n}\n\nfn member_object",
        "add_digit(u32(!is_inside), select(4u, 2u, coincident_count == 0u));\n}\n\nfn member_object",
    ),
    (
        "naive",
        Mode::Naive,
        "tell_sides(crossing, VACUUM, crossing.interior);",
        "tell_sides(crossing, crossing.interior, VACUUM);",
    ),
    (
        "rectified_object",
        Mode::RectifiedObject,
        "objects[crossing.refractor].outside, crossing.interior",
        "VACUUM + 1u, crossing.interior",
    ),
    (
        "stack",
        Mode::Stack,
        "told = Sides(stack_below(walker, 1u), stack_below(walker, 2u), true);",
        "told = Sides(stack_below(walker, 1u), stack_below(walker, 1u), true);",
    ),
    ("priority", Mode::Priority, ".x].priority > priority {", ".x].priority < priority {"),
    (
        "interaction",
        Mode::Rectified,
        "let outward = select(-1.0, 1.0, hit.is_front);",
        "let outward = select(1.0, 1.0, hit.is_front);",
    ),
    ("direct", Mode::Rectified, "return 1.0 / (1.0 + ratio * ratio);", "return 1.0 / (1.0 + ratio);"),
    ("path", Mode::Rectified, "last_pdf = sampled.pdf;", "last_pdf = 2.0 * sampled.pdf;"),
    ("film", Mode::Rectified, "sum.count += 1u;", "sum.count += 2u;"),
];

#[test]
fn faults_in_every_module_are_found() {
    let Some(device) = device() else { return };
    let subject = Subject::new(workshop());
    let never = AtomicBool::new(false);
    let parted = |fault: Option<Replacement>, mode: Mode| {
        let settings = settings(mode, 9);
        let task = subject.task(&settings);
        let [mut cpu, mut on_gpu] = [Film::new(32, 22), Film::new(32, 22)];
        assert!(Cpu.pass(&task, &mut cpu, 2, &never));
        let gpu = Gpu::with_replacement(std::sync::Arc::clone(&device), fault);
        assert!(gpu.pass(&task, &mut on_gpu, 2, &never), "{fault:?}: {:?}", gpu.fault());
        Difference::between(&cpu, &on_gpu).parted
    };
    let without = super::MODES.map(|mode| (mode, parted(None, mode)));
    let mut problems = Vec::new();
    for &(module, mode, from, to) in FAULTS {
        let share = parted(Some(Replacement { from, to }), mode);
        eprintln!("{module}: {:.1} % parted", 100.0 * share);
        // As many as rounding alone parts are not enough.
        if without.iter().any(|(other, without)| *other == mode && share < 3.0 * without + 0.01) {
            problems.push(format!("{module}: {share}, without a fault {without:?}"));
        }
    }
    assert_eq!(problems, Vec::<String>::new());
}

/// Where coincident faces end is told by few pixels of an image; the table itself is asked.
#[test]
fn faults_where_faces_coincide_are_found() {
    let Some(device) = device() else { return };
    let subject = Subject::new(workshop());
    let rays = rays_at_the_rim(&subject);
    for (from, to) in [
        ("bitcast<f32>(table[k + 3u]) < 0.0", "bitcast<f32>(table[k + 3u]) < 1e9"),
        ("bitcast<f32>(table[k + 3u]) < 0.0", "bitcast<f32>(table[k + 3u]) < -1e9"),
    ] {
        let gpu = Gpu::with_replacement(std::sync::Arc::clone(&device), Some(Replacement { from, to }));
        let answers = compare_answers(&gpu, &subject, &rays);
        assert!(answers.others > 20, "{to}: {answers:?}");
    }
}
