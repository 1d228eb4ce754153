//! What holds for any input, tried with random ones; where it does not, the input is made as small as it can be.
//!
//! The inputs are the same in every run. Others: `PROPTEST_RNG_SEED=1 PROPTEST_CASES=10000 cargo test --test library properties`.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;
use image::{ImageFormat, Rgb, RgbImage};
use iorect::export::{read_sums, write_sums};
use iorect::formats::{Disk, image_from_bytes, mesh_from_bytes, parse, to_text};
use iorect::optics::Interface;
use iorect::optics::fresnel::Refraction;
use iorect::render::exact::ExactSums;
use iorect::render::{Display, ImageSettings, Partial, Recipe, SampleRange, ToneCurve};
use iorect::scene::fingerprint::Hasher;
use iorect::tracking::Events;
use iorect::tracking::Mode;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::common::random_scene;

/// Inputs of each property: all of them together take a few seconds.
const CASES: u32 = 64;

fn config() -> ProptestConfig {
    let default = ProptestConfig::default();
    let is_asked_for = std::env::var_os("PROPTEST_CASES").is_some();
    ProptestConfig {
        cases: if is_asked_for { default.cases } else { CASES },
        rng_seed: if default.rng_seed == RngSeed::Random { RngSeed::Fixed(12) } else { default.rng_seed },
        failure_persistence: None,
        ..default
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_scene_that_is_saved_is_the_same_scene(scene in random_scene::description()) {
        let path = Path::new("scene.toml");
        let text = to_text(&scene);
        let mut read = parse(&text, path, &Disk).map_err(|error| TestCaseError::fail(format!("{error}\n{text}")))?;
        prop_assert_eq!(to_text(&read), text.clone(), "an unedited scene is saved as it was");
        read.source = None;
        prop_assert_eq!(&read, &scene, "{}", text);
        prop_assert_eq!(read.fingerprint(), scene.fingerprint());
    }

    #[test]
    fn a_transform_scales_then_turns_then_moves(transform in random_scene::transform(), p in random_scene::vector()) {
        let matrix = transform.matrix();
        // Each step by hand, with rotations about fixed axes.
        let turned = |[a, b]: [f64; 2], degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [a * cos - b * sin, a * sin + b * cos]
        };
        let scaled = p * transform.scale;
        let [y, z] = turned([scaled.y, scaled.z], transform.rotate.x);
        let [z, x] = turned([z, scaled.x], transform.rotate.y);
        let [x, y] = turned([x, y], transform.rotate.z);
        let expected = DVec3::new(x, y, z) + transform.translate;
        let size = scaled.length() + transform.translate.length();
        prop_assert!(matrix.transform_point3(p).distance(expected) <= 1e-14 * size, "{expected}");
        let volume = transform.scale.x * transform.scale.y * transform.scale.z;
        prop_assert!((matrix.matrix3.determinant() / volume - 1.0).abs() < 1e-13);
        let back = matrix.inverse().transform_point3(expected);
        prop_assert!(back.distance(p) <= 1e-13 * size / transform.scale.abs().min_element());
    }

    #[test]
    fn a_mesh_that_is_written_is_read(
        positions in prop::collection::vec(random_scene::vector(), 3..20),
        faces in prop::collection::vec(any::<[prop::sample::Index; 3]>(), 1..30),
    ) {
        let count = positions.len();
        let faces: Vec<[usize; 3]> = faces.iter().map(|face| face.map(|corner| corner.index(count))).collect();
        let corners = |face: [usize; 3]| face.map(|corner| positions[corner]);
        let has_area = |face: &[usize; 3]| {
            let [a, b, c] = corners(*face);
            let (u, v) = (b - a, c - a);
            let longest = u.abs().max(v.abs()).max_element();
            longest > 0.0 && (u / longest).cross(v / longest) != DVec3::ZERO
        };
        let expected: Vec<[DVec3; 3]> = faces.iter().copied().filter(has_area).map(corners).collect();
        let vertices: String = positions.iter().map(|p| format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z)).collect();
        let forwards = faces.iter().map(|f| format!("f {} {}/1 {}//2\n", f[0] + 1, f[1] + 1, f[2] + 1));
        // As before, counted from the end.
        let backwards = faces.iter().map(|f| format!("f {} {} {}\n", back(f[0], count), back(f[1], count), back(f[2], count)));
        let extra = "vt 0 0\nvn 0 1 0\nvn 1 0 0\n";
        let obj = vertices.clone() + extra + &forwards.collect::<String>();
        let from_the_end = vertices + &backwards.collect::<String>();
        let ply = binary_ply(&positions, &faces);
        for (name, bytes) in [("a.obj", obj.into_bytes()), ("b.obj", from_the_end.into_bytes()), ("c.ply", ply)] {
            let read = mesh_from_bytes(&bytes, Path::new(name));
            if expected.is_empty() {
                prop_assert!(read.is_err(), "{}", name);
                continue;
            }
            let mesh = read.map_err(|error| TestCaseError::fail(format!("{name}: {error}")))?;
            let found: Vec<[DVec3; 3]> =
                mesh.triangles.iter().map(|t| t.map(|corner| mesh.positions[corner as usize])).collect();
            prop_assert_eq!(&found, &expected, "{}", name);
        }
    }

    /// Radiance keeps eight bits of the largest component.
    #[test]
    fn radiance_is_kept_to_a_128th(
        pixels in prop::collection::vec((prop::array::uniform3(0.0..1.0_f64), -30..30_i32), 1..40),
    ) {
        let colors: Vec<[f64; 3]> =
            pixels.iter().map(|(color, exponent)| color.map(|x| x * 2.0_f64.powi(*exponent))).collect();
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X 1\n", colors.len()).into_bytes();
        colors.iter().for_each(|color| bytes.extend(rgbe(*color)));
        let image = image_from_bytes(&bytes, Path::new("a.hdr")).map_err(TestCaseError::fail)?;
        prop_assert_eq!((image.width, image.height), (1, colors.len()));
        for (read, color) in image.pixels.iter().zip(&colors) {
            let most = color.iter().fold(0.0, |most: f64, x| most.max(*x));
            for (read, x) in read.iter().zip(color) {
                prop_assert!((f64::from(*read) - x).abs() <= most / 128.0 + 1e-38, "{read} is not {x} of {most}");
            }
        }
    }

    #[test]
    fn srgb_there_and_back_is_the_same(pixels in prop::collection::vec(any::<[u8; 3]>(), 1..64)) {
        let image = RgbImage::from_fn(pixels.len() as u32, 1, |x, _| Rgb(pixels[x as usize]));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let read = image_from_bytes(bytes.get_ref(), Path::new("a.png")).map_err(TestCaseError::fail)?;
        let display = Display { exposure: 0.0, curve: ToneCurve::Clip };
        let shown: Vec<[u8; 3]> = read.pixels.iter().map(|rgb| display.encode(*rgb)).collect();
        prop_assert_eq!(shown, pixels);
    }

    #[test]
    fn parts_may_be_added_in_any_order(
        parts in prop::collection::vec(prop::collection::vec((any::<[i64; 3]>(), 0..3_u32), 4), 2..8),
        order in any::<[prop::sample::Index; 8]>(),
    ) {
        let parts: Vec<Partial> = parts.iter().enumerate().map(|(index, pixels)| part(index as u32, pixels)).collect();
        let together = |parts: &[Partial]| {
            let mut sum = parts[0].clone();
            parts[1..].iter().for_each(|part| sum.add(part).unwrap());
            sum
        };
        let whole = together(&parts);
        let mut shuffled = parts.clone();
        for (at, index) in (1..shuffled.len()).zip(order) {
            shuffled.swap(at, index.index(at + 1));
        }
        prop_assert_eq!(&together(&shuffled), &whole);
        let (left, right) = shuffled.split_at(1 + order[0].index(shuffled.len() - 1));
        prop_assert_eq!(&together(&[together(right), together(left)]), &whole);
        // A sample counts once.
        prop_assert!(whole.clone().add(&parts[0]).is_err());
        if parts.len() > 2 {
            return Ok(());
        }
        // Files take longest, by far: the disk is waited for.
        let file = tempfile::Builder::new().suffix(".exr").tempfile().unwrap();
        write_sums(file.path(), &whole).unwrap();
        prop_assert_eq!(read_sums(file.path()).unwrap(), whole);
    }

    #[test]
    fn light_is_reflected_or_transmitted(from in index(), to in index(), c in cosine()) {
        let interface = Interface::new(from - 1.0, to - 1.0);
        if let Refraction::Partial { reflectance, b } = interface.refraction(c) {
            let transmittance = interface.transmittance(c, b);
            prop_assert!((0.0..=1.0).contains(&reflectance) && transmittance >= 0.0);
            prop_assert!((reflectance + transmittance - 1.0).abs() < 1e-12, "{reflectance} + {transmittance}");
        } else {
            // Beyond the critical angle, by Snell: sin θt would be more than 1.
            let sine = (1.0 - c * c).sqrt() * from / to;
            prop_assert!(sine > 1.0 - 1e-12, "{sine}");
        }
    }

    #[test]
    fn reflectance_is_the_same_from_both_sides(from in index(), to in index(), c in cosine()) {
        let there = Interface::new(from - 1.0, to - 1.0);
        let Refraction::Partial { reflectance, b } = there.refraction(c) else { return Ok(()) };
        let c_behind = b * from / to;
        // Nearer to the critical angle the cosine has lost its digits.
        prop_assume!(c.min(c_behind) > 1e-3);
        let back = Interface::new(to - 1.0, from - 1.0);
        match back.refraction(c_behind.min(1.0)) {
            Refraction::Partial { reflectance: behind, b: b_behind } => {
                prop_assert!((reflectance - behind).abs() < 1e-9, "{reflectance} there, {behind} back");
                prop_assert!((b_behind * to / from - c).abs() < 1e-9, "the ray comes back at another angle");
            }
            Refraction::TotalReflection => prop_assert!(false, "no way back from {c_behind}"),
        }
    }
}

/// From 1 to `count`, as OBJ counts from the end.
fn back(corner: usize, count: usize) -> i64 {
    corner as i64 - count as i64
}

fn binary_ply(positions: &[DVec3], faces: &[[usize; 3]]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        positions.len(),
        faces.len()
    );
    let mut bytes = header.into_bytes();
    positions.iter().flat_map(DVec3::to_array).for_each(|x| bytes.extend(x.to_be_bytes()));
    for face in faces {
        bytes.push(3);
        face.iter().for_each(|corner| bytes.extend((*corner as u32).to_be_bytes()));
    }
    bytes
}

/// As Ward (1991) writes a colour: mantissas and a common exponent.
fn rgbe(color: [f64; 3]) -> [u8; 4] {
    let most = color.iter().fold(0.0, |most: f64, x| most.max(*x));
    if most < 1e-32 {
        return [0; 4];
    }
    let exponent = most.log2().floor() as i32 + 1;
    let [r, g, b] = color.map(|x| (x * 2.0_f64.powi(8 - exponent)) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Sample `index` of an image of 2 by 2 pixels; each pixel has a sum and a count.
fn part(index: u32, pixels: &[([i64; 3], u32)]) -> Partial {
    let nothing = Hasher::new("nothing").finish();
    // So many samples at once, since a pixel may have up to two.
    let range = SampleRange(2 * index, 2 * index + 2);
    Partial {
        recipe: Recipe {
            version: "1".to_owned(),
            scene: "a scene".to_owned(),
            content: nothing,
            camera: nothing,
            adapter: None,
            width: 2,
            height: 2,
            settings: ImageSettings { splits: 0, ..ImageSettings::new(Mode::Rectified, 0) },
            unit_exponent: -64,
        },
        ranges: vec![range],
        events: Events { crossings: u64::from(index) * 3, ..Events::default() },
        sums: ExactSums {
            unit_exponent: -64,
            // A pixel without samples has no sum.
            sums: pixels
                .iter()
                .map(|(sum, count)| sum.map(|x| if *count == 0 { 0 } else { i128::from(x) << 20 }))
                .collect(),
        },
        counts: pixels.iter().map(|(_, count)| *count).collect(),
    }
}

/// An index of refraction, from far below to far above those of materials.
fn index() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-2.0..2.0_f64).prop_map(f64::exp),
        // Almost the same on both sides.
        (-1e-9..1e-9_f64).prop_map(|x| 1.5 + x),
    ]
}

/// Of the angle of incidence.
fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![1e-3..=1.0_f64, (-6.0..0.0_f64).prop_map(|x| 10.0_f64.powf(x))]
}
