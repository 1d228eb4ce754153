//! Environment maps of pbrt and Mitsuba, however they are laid out and turned: what shines from where.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use iorect::formats::{self, Memory};
use iorect::report::stability::scenes as made;
use iorect::scene::description::{Description, Environment, Shape};
use iorect::scene::lights::EnvironmentLight;
use iorect::tracking::Mode;

use crate::common::{Numbers, ready};

fn exr(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let image = image::Rgb32FImage::from_fn(width, height, |x, y| image::Rgb(pixel(x, y)));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

fn read(name: &str, text: &str, sky: Vec<u8>) -> Description {
    let files: HashMap<PathBuf, Vec<u8>> = [("sky.exr".into(), sky)].into();
    formats::read(text.as_bytes(), Path::new(name), &Memory(files)).unwrap()
}

/// The pixel of a direction in an equal-area square, case by case as in Clarberg's figure: of the upper half-space the diamond in the middle, of
/// the lower one the corners.
fn pixel_of(d: DVec3, side: u32) -> [u32; 2] {
    let radius = (1.0 - d.z.abs()).sqrt();
    // By eighths of a turn: along each side of the diamond the place runs with the angle.
    let angle = d.y.atan2(d.x).rem_euclid(std::f64::consts::TAU);
    let quarter = (angle / std::f64::consts::FRAC_PI_2).floor();
    let share = angle / std::f64::consts::FRAC_PI_2 - quarter;
    let [from, to] = match quarter as u32 {
        0 => [[1.0, 0.0], [0.0, 1.0]],
        1 => [[0.0, 1.0], [-1.0, 0.0]],
        2 => [[-1.0, 0.0], [0.0, -1.0]],
        _ => [[0.0, -1.0], [1.0, 0.0]],
    };
    let on_diamond: [f64; 2] = [0, 1].map(|k| radius * (from[k] + (to[k] - from[k]) * share));
    let place = match d.z >= 0.0 {
        true => on_diamond,
        // Mirrored in the diamond's side.
        false => [0, 1].map(|k| (1.0 - on_diamond[1 - k].abs()) * (from[k] + to[k])),
    };
    place.map(|x| ((0.5 * (x + 1.0) * f64::from(side)) as u32).min(side - 1))
}

/// What a scene's environment sends from a direction.
fn from(description: &Description, direction: DVec3) -> f64 {
    EnvironmentLight::new(&description.environment).radiance(direction).to_rgb()[0]
}

#[test]
fn spots_of_pbrt_shine_from_where_they_stand() {
    const SIDE: u32 = 64;
    let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(1.1) * DMat3::from_rotation_y(-2.0);
    let columns = turn.to_cols_array_2d().map(|[x, y, z]| format!("{x} {y} {z} 0")).join(" ");
    let mut numbers = Numbers(5);
    for round in 0..12 {
        let local = numbers.direction();
        let spot = pixel_of(local, SIDE);
        let sky = exr(SIDE, SIDE, |x, y| [if [x, y] == spot { 1.0 } else { 0.0 }; 3]);
        // With and without a camera of left-handed coordinates, in which x is turned round.
        let camera = if round % 2 == 0 { "Scale -1 1 1\n" } else { "" };
        let text = format!(
            "{camera}LookAt 0 0 -9  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nConcatTransform [ {columns} 0 0 0 1 ]\n\
             LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 3\n"
        );
        let description = read("s.pbrt", &text, sky);
        let world = turn * local;
        let expected = if camera.is_empty() { DVec3::new(-world.x, world.y, world.z) } else { world };
        assert!(from(&description, expected) > 0.3, "{round}: {}", from(&description, expected));
        let size = 4.0 / f64::from(SIDE);
        for _ in 0..200 {
            let other = numbers.direction();
            assert!(other.distance(expected) < 2.5 * size || from(&description, other) == 0.0, "{round}");
        }
        // All of it: one pixel of the square, and the scale.
        let mean = mean(&description);
        assert!((mean * f64::from(SIDE * SIDE) / 3.0 - 1.0).abs() < 0.02, "{round}: {mean}");
    }
}

/// The mean over all directions.
fn mean(description: &Description) -> f64 {
    let Environment::Image { image, scale, .. } = &description.environment else { panic!("no image") };
    let cosine = |row: usize| (std::f64::consts::PI * row as f64 / image.height as f64).cos();
    let rows = image.pixels.chunks(image.width).enumerate();
    let sum: f64 = rows
        .map(|(y, row)| (cosine(y) - cosine(y + 1)) * row.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>())
        .sum();
    scale * sum / (2.0 * image.width as f64)
}

#[test]
fn spots_of_mitsuba_shine_from_where_they_stand() {
    const SIZE: [u32; 2] = [128, 64];
    let mut numbers = Numbers(7);
    for (steps, turn) in [
        ("<rotate y=\"1\" angle=\"40\"/>", DMat3::from_rotation_y(40_f64.to_radians())),
        (
            "<rotate x=\"1\" angle=\"90\"/><rotate y=\"1\" angle=\"30\"/>",
            DMat3::from_rotation_y(30_f64.to_radians()) * DMat3::from_rotation_x(90_f64.to_radians()),
        ),
        ("<scale x=\"-1\"/>", DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))),
    ] {
        for _ in 0..6 {
            let local = numbers.direction();
            // As Mitsuba's documentation has it: a row begins at −z and goes on to +x.
            let column = (local.x.atan2(-local.z) / std::f64::consts::TAU).rem_euclid(1.0);
            let row = local.y.acos() / std::f64::consts::PI;
            let spot = [0, 1].map(|k| (([column, row][k] * f64::from(SIZE[k])) as u32).min(SIZE[k] - 1));
            let sky = exr(SIZE[0], SIZE[1], |x, y| [if [x, y] == spot { 1.0 } else { 0.0 }; 3]);
            let text = format!(
                "<scene version=\"3.0.0\"><emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/>\
                 <transform name=\"to_world\">{steps}</transform></emitter></scene>"
            );
            let description = read("s.xml", &text, sky);
            let expected = turn * local;
            assert!(from(&description, expected) > 0.2, "{steps}: {}", from(&description, expected));
            for _ in 0..200 {
                let other = numbers.direction();
                assert!(other.distance(expected) < 0.2 || from(&description, other) == 0.0, "{steps}");
            }
        }
    }
}

/// A grey ball in the light of half of the sky, which is tilted: the irradiance of a normal at an angle t from its axis is π(1 + cos t)/2 of its
/// radiance.
#[test]
fn a_ball_in_half_a_sky_has_its_irradiance() {
    const SIDE: u32 = 64;
    const ALBEDO: f64 = 0.8;
    const SIZE: (u32, u32) = (24, 24);
    let tilt = DMat3::from_rotation_x(0.9) * DMat3::from_rotation_y(0.5);
    let columns = tilt.to_cols_array_2d().map(|[x, y, z]| format!("{x} {y} {z} 0")).join(" ");
    // The diamond in the middle is the half of +z; its sides cut pixels in two.
    let light = |x: u32, y: u32| {
        let from_middle = |k: u32| (f64::from(k) + 0.5 - f64::from(SIDE) / 2.0).abs();
        match from_middle(x) + from_middle(y) - f64::from(SIDE) / 2.0 {
            beyond if beyond < 0.0 => 2.0,
            0.0 => 1.0,
            _ => 0.0,
        }
    };
    let sky = exr(SIDE, SIDE, |x, y| [light(x, y); 3]);
    let text = format!(
        "Scale -1 1 1\nLookAt 0 0 9  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 14\nWorldBegin\nAttributeBegin\n\
         ConcatTransform [ {columns} 0 0 0 1 ]\nLightSource \"infinite\" \"string filename\" \"sky.exr\"\nAttributeEnd\n\
         Material \"diffuse\" \"rgb reflectance\" [ {ALBEDO} {ALBEDO} {ALBEDO} ]\nShape \"sphere\"\n"
    );
    let description = read("s.pbrt", &text, sky);
    assert!(matches!(description.objects[0].shape, Shape::Sphere { radius: 1.0, .. }));
    let camera = iorect::scene::camera::Camera::new(&description.camera).unwrap();
    let axis = tilt * DVec3::Z;
    let film = made::render(&ready(description), Mode::Rectified, SIZE, 400, 3, None).unwrap().to_rgb();
    let (mut off, mut count) = (0.0, 0);
    for (index, pixel) in film.iter().enumerate() {
        let [x, y] = [index as u32 % SIZE.0, index as u32 / SIZE.0].map(|k| 2.0 * (f64::from(k) + 0.5) / 24.0 - 1.0);
        let direction = (camera.forward + (camera.right * x - camera.up * y) * camera.tan_half_fov).normalize();
        let (b, c) = (camera.position.dot(direction), camera.position.length_squared() - 1.0);
        let root = b * b - c;
        // Away from the edge, where a pixel sees more than the ball.
        if root < 0.1 {
            continue;
        }
        let normal = camera.position + direction * (-b - root.sqrt());
        let expected = ALBEDO * 2.0 * (1.0 + normal.dot(axis)) / 2.0;
        assert!((f64::from(pixel[0]) - expected).abs() < 0.1, "pixel {index}: {} and not {expected}", pixel[0]);
        off += f64::from(pixel[0]) - expected;
        count += 1;
    }
    assert!(count > 200 && (off / f64::from(count)).abs() < 0.01, "{off} over {count}");
}

/// What is in no file gets one beside the scene file, and is the same then.
#[test]
fn an_environment_is_saved_with_its_scene() {
    let sky = exr(32, 32, |x, y| [x as f32, y as f32, 1.0]);
    let text = "LookAt 0 0 -9  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nRotate 20 1 2 3\n\
                LightSource \"infinite\" \"string filename\" \"sky.exr\"\nShape \"sphere\"\n";
    let description = read("s.pbrt", text, sky);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.toml");
    formats::save(&description, &path).unwrap();
    formats::save(&description, &path).unwrap();
    assert!(folder.path().join("made-environment.exr").is_file());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let again = formats::file(&path).unwrap();
    assert_eq!(again.fingerprint(), description.fingerprint());
}
