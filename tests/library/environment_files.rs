//! Environment images as people have them: what each shows, what is said of it, and what is refused.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::common::exr_bytes::{self, Channel, Part, channel, value_of};
use exr::compression::Compression;
use exr::meta::attribute::SampleType::{F16, F32, U32};
use glam::DVec3;
use iorect::check::{Severity, check};
use iorect::formats;
use iorect::scene::description::Environment;
use iorect::scene::environment::EnvironmentImage;
use iorect::scene::lights::EnvironmentLight;
use rayon::prelude::*;

/// Reads an image through a scene that names it.
fn read(name: &str, bytes: &[u8]) -> Result<Arc<EnvironmentImage>, String> {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\n[environment]\nimage = \"{name}\"\n");
    std::fs::write(folder.path().join(name), bytes).unwrap();
    match formats::parse(&scene, &folder.path().join("s.toml"), &formats::Disk) {
        Ok(description) => match description.environment {
            Environment::Image { image, .. } => Ok(image),
            other => panic!("{other:?}"),
        },
        Err(error) => {
            assert_eq!(error.place.as_ref().unwrap().file, folder.path().join(name), "{error}");
            Err(error.message)
        }
    }
}

fn kinds(image: &EnvironmentImage) -> Vec<(&'static str, u64)> {
    image.notes.iter().map(|note| (note.kind, note.count)).collect()
}

/// Asserts that all pixels are near one colour.
fn all_near(image: &EnvironmentImage, color: [f64; 3], tolerance: f64) {
    for pixel in &image.pixels {
        let error = (DVec3::from(pixel.map(f64::from)) - DVec3::from(color)).abs().max_element();
        assert!(error <= tolerance, "{pixel:?} is not {color:?}");
    }
}

/// Each case, by what is seen of it in a scene, and by what `check` says.
#[test]
fn cases_have_their_right_values() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases/environment-files");
    for (scene, right, said) in [
        ("exposure4_hdr", [0.25, 0.125, 0.0625], &["exposure_undone"][..]),
        ("flipped_hdr", [1.0, 0.5, 0.25], &[]),
        ("magic_rgbe_hdr", [1.0, 0.5, 0.25], &[]),
        ("luminance_only_exr", [0.5; 3], &[]),
        ("one_inf_pixel_exr", [0.5; 3], &["replaced_pixels"]),
    ] {
        let description = formats::file(&folder.join(format!("{scene}.toml"))).unwrap();
        let light = EnvironmentLight::new(&description.environment);
        for direction in [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, -0.64, 0.48)] {
            assert!((DVec3::from(light.radiance(direction).to_rgb()) - DVec3::from(right)).length() < 1e-12, "{scene}");
        }
        let problems = check(&iorect::tracking::prepare(Arc::new(description), None).unwrap());
        let kinds: Vec<_> = problems.iter().map(|problem| problem.kind).collect();
        assert_eq!(kinds, said, "{scene}");
        if let Some(problem) = problems.iter().find(|problem| problem.kind == "replaced_pixels") {
            assert_eq!(problem.severity, Severity::Warning);
            assert!(problem.message.starts_with("1 pixel of"), "{}", problem.message);
        }
    }
}

/// The images that come with the program, as the `image` crate decodes them.
#[test]
fn shipped_environments_read_to_the_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "exr") {
            let bytes = std::fs::read(&path).unwrap();
            let image = read("e.exr", &bytes).unwrap();
            same_as_the_image_crate(&image, &bytes);
            count += 1;
        }
    }
    assert_eq!(count, 5);
}

fn same_as_the_image_crate(image: &EnvironmentImage, bytes: &[u8]) {
    let expected = image::load_from_memory(bytes).unwrap().into_rgb32f();
    assert_eq!((image.width as u32, image.height as u32), expected.dimensions());
    for (pixel, expected) in image.pixels.iter().zip(expected.pixels()) {
        // −0 is not negative, and stays.
        let expected = expected.0.map(|x| if x < 0.0 { 0.0 } else { x });
        assert_eq!(pixel.map(f32::to_bits), expected.map(f32::to_bits));
    }
}

// Radiance.

/// A picture with every scanline in the newer encoding, of one pixel throughout.
fn radiance(header: &str, width: usize, height: usize, pixel: [u8; 4]) -> Vec<u8> {
    let mut bytes = format!("{header}\n\n-Y {height} +X {width}\n").into_bytes();
    for _ in 0..height {
        bytes.extend([2, 2, (width >> 8) as u8, width as u8]);
        for byte in pixel {
            for run in vec![127; width / 127].into_iter().chain([width % 127]).filter(|run| *run > 0) {
                bytes.extend([128 + run as u8, byte]);
            }
        }
    }
    bytes
}

#[test]
fn radiance_headers() {
    let plain = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";
    // (1, 0.5, 0.25).
    let pixel = [128, 64, 32, 129];
    for (header, right) in [
        (plain.to_owned(), [1.0, 0.5, 0.25]),
        (format!("{plain}\nEXPOSURE=2\nEXPOSURE=4"), [0.125, 0.0625, 0.03125]),
        (format!("{plain}\nCOLORCORR=2 1 0.5\nCOLORCORR=2 1 1\nEXPOSURE=0.5"), [0.5, 1.0, 1.0]),
        (format!("{plain}\nGAMMA=2"), [1.0, 0.25, 0.0625]),
        ("#?RGBE".to_owned(), [1.0, 0.5, 0.25]),
        ("#?AUTOPANO\nSOFTWARE=somebody's".to_owned(), [1.0, 0.5, 0.25]),
        // Rec. 709, rounded, is left as it is.
        (format!("{plain}\nPRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329"), [1.0, 0.5, 0.25]),
        // Rec. 2020: ITU-R BT.2087-0, inverted.
        (
            format!("{plain}\nPRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.329"),
            [1.6605 - 0.2938 - 0.0182, -0.1246 + 0.566_45 - 0.0021, (-0.0182 - 0.0503 + 0.2797)],
        ),
        // XYZ: IEC 61966-2-1.
        ("#?RADIANCE\nFORMAT=32-bit_rle_xyze".to_owned(), [3.2406 - 0.7686 - 0.12465, 0.0, 0.0557 - 0.1020 + 0.26425]),
    ] {
        let image = read("e.hdr", &radiance(&header, 300, 2, pixel)).unwrap();
        assert_eq!((image.width, image.height), (300, 2));
        all_near(&image, right, 1e-3);
    }
    let white = read("e.hdr", &radiance("#?RADIANCE\nFORMAT=32-bit_rle_xyze", 8, 4, [122, 128, 139, 129])).unwrap();
    // D65, as near as its three bytes come.
    all_near(&white, [1.0; 3], 0.02);
    assert_eq!(kinds(&white), [("converted_colors", 1)]);
}

#[test]
fn radiance_pictures_read_as_before() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = image::Rgb32FImage::from_fn(64, 32, |x, y| {
        image::Rgb([(x as f32 / 8.0).exp2(), y as f32 * 0.01, 1.0 / (1.0 + (x * y) as f32)])
    });
    picture.write_to(&mut bytes, image::ImageFormat::Hdr).unwrap();
    let bytes = bytes.into_inner();
    let image = read("e.hdr", &bytes).unwrap();
    same_as_the_image_crate(&image, &bytes);
    assert_eq!(image.notes, []);
}

// OpenEXR.

/// Channels of (0.5, 0.25 + row / 8, column), told apart everywhere.
fn rgb(sample_type: exr::meta::attribute::SampleType) -> Vec<Channel> {
    vec![
        channel("B", sample_type, |x, _| x as f32),
        channel("G", sample_type, |_, y| 2.0 + y as f32),
        channel("R", sample_type, |_, _| 7.0),
    ]
}

fn is_rgb(image: &EnvironmentImage) {
    for (at, pixel) in image.pixels.iter().enumerate() {
        assert_eq!(*pixel, [7.0, 2.0 + (at / image.width) as f32, (at % image.width) as f32]);
    }
}

fn constant(name: &'static str, value: f32) -> Channel {
    channel(name, F32, move |_, _| value)
}

#[test]
fn exr_of_every_compression_and_type() {
    for sample_type in [F16, F32, U32] {
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::ZIP16,
            Compression::PIZ,
            Compression::PXR24,
        ] {
            for tiles in [None, Some((16, 0)), Some((100, 0)), Some((8, 1))] {
                let bytes = exr_bytes::file(&[Part { compression, tiles, ..Part::new((80, 40), rgb(sample_type)) }]);
                let image =
                    read("e.exr", &bytes).unwrap_or_else(|e| panic!("{sample_type:?} {compression} {tiles:?}: {e}"));
                is_rgb(&image);
                assert_eq!(image.notes, []);
                if tiles.is_none_or(|(_, mode)| mode == 0) {
                    same_as_the_image_crate(&image, &bytes);
                }
            }
        }
    }
}

#[test]
fn exr_of_one_row_and_of_lossy_blocks() {
    is_rgb(&read("e.exr", &exr_bytes::file(&[Part::new((2, 1), rgb(F32))])).unwrap());
    let channels = ["B", "G", "R"].map(|name| channel(name, F16, |x, y| 1.0 + 0.01 * (x + y) as f32));
    let part = Part { compression: Compression::B44, ..Part::new((64, 32), channels.into()) };
    let bytes = exr_bytes::file(&[part]);
    let image = read("e.exr", &bytes).unwrap();
    same_as_the_image_crate(&image, &bytes);
    assert!((image.pixels[0][0] - 1.0).abs() < 0.02);
}

#[test]
fn exr_luminance_and_xyz() {
    let grey = read("e.exr", &exr_bytes::file(&[Part::new((4, 2), vec![constant("Y", 0.75)])])).unwrap();
    all_near(&grey, [0.75; 3], 0.0);
    let xyz = vec![constant("X", 0.9505), constant("Y", 1.0), constant("Z", 1.0888)];
    let white = read("e.exr", &exr_bytes::file(&[Part::new((4, 2), xyz)])).unwrap();
    all_near(&white, [1.0; 3], 1e-3);
    assert_eq!(kinds(&white), [("converted_colors", 1)]);
}

/// Y, RY and BY of a colour (Rec. 709), each as it varies.
fn luminance_chroma(sampling: i32, sample_type: exr::meta::attribute::SampleType) -> Vec<Channel> {
    let y = |x: i32, y: i32| DVec3::new(0.2126, 0.7152, 0.0722).dot(soft(x, y));
    let mut channels = vec![
        channel("BY", sample_type, move |x, row| ((soft(x, row).z - y(x, row)) / y(x, row)) as f32),
        channel("RY", sample_type, move |x, row| ((soft(x, row).x - y(x, row)) / y(x, row)) as f32),
        channel("Y", sample_type, move |x, row| y(x, row) as f32),
    ];
    channels[..2].iter_mut().for_each(|channel| channel.sampling = sampling);
    channels
}

/// A colour that changes slowly, such as can be subsampled.
fn soft(x: i32, y: i32) -> DVec3 {
    let wave = |phase: f64| 1.0 + 0.5 * (0.05 * f64::from(x) + 0.04 * f64::from(y) + phase).sin();
    DVec3::new(wave(0.0), wave(1.0), wave(2.5))
}

#[test]
fn exr_luminance_chroma() {
    for (sampling, compression, sample_type, tolerance) in [
        (1, Compression::ZIP16, F32, 1e-4),
        (2, Compression::Uncompressed, F32, 1e-3),
        (2, Compression::RLE, F32, 1e-3),
        (2, Compression::ZIP1, F16, 3e-3),
        (2, Compression::ZIP16, F16, 3e-3),
        (2, Compression::ZIP16, F32, 1e-3),
        (2, Compression::PIZ, F16, 3e-3),
        (2, Compression::PIZ, F32, 1e-3),
    ] {
        let part = Part { compression, ..Part::new((120, 62), luminance_chroma(sampling, sample_type)) };
        let image = read("e.exr", &exr_bytes::file(&[part])).unwrap_or_else(|e| panic!("{compression}: {e}"));
        for (at, pixel) in image.pixels.iter().enumerate() {
            let (x, y) = ((at % 120) as i32, (at / 120) as i32);
            // Beyond the edges there is nothing to filter from.
            let is_edge = sampling == 2 && (!(14..106).contains(&x) || !(14..48).contains(&y));
            let error = (DVec3::from(pixel.map(f64::from)) - soft(x, y)).abs().max_element();
            let tolerance = if is_edge { 0.05 } else { tolerance };
            assert!(error < tolerance, "{compression} {sample_type:?}: {x}, {y}: {pixel:?}, not {}", soft(x, y));
        }
    }
}

#[test]
fn exr_subsampling_that_is_refused() {
    let mut part = Part::new((64, 32), luminance_chroma(4, F32));
    assert!(read("e.exr", &exr_bytes::file(&[part])).unwrap_err().contains("4×4"));
    part = Part::new((64, 32), rgb(F32));
    part.channels[0].sampling = 2;
    assert!(read("e.exr", &exr_bytes::file(&[part])).unwrap_err().contains("subsampled colours"));
    part = Part::new((63, 31), luminance_chroma(2, F32));
    assert!(read("e.exr", &exr_bytes::file(&[part])).unwrap_err().contains("sampling"));
}

#[test]
fn exr_chromaticities() {
    let with = |numbers: [f32; 8]| {
        let value = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let channels = vec![constant("B", 0.25), constant("G", 0.5), constant("R", 1.0)];
        let part =
            Part { attributes: vec![("chromaticities", "chromaticities", value)], ..Part::new((4, 2), channels) };
        read("e.exr", &exr_bytes::file(&[part])).unwrap()
    };
    let rec_709 = with([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    all_near(&rec_709, [1.0, 0.5, 0.25], 0.0);
    assert_eq!(rec_709.notes, []);
    // Display P3 to Rec. 709; the matrix as in CSS Color 4, section 18.
    let p3 = with([0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329]);
    let right = [1.2249 - 0.11245, -0.04205 + 0.52105, -0.01965 - 0.0393 + 0.2745];
    all_near(&p3, right, 1e-3);
    assert_eq!(kinds(&p3), [("converted_colors", 1)]);
    let none = with([0.0; 8]);
    all_near(&none, [1.0, 0.5, 0.25], 0.0);
    assert_eq!(kinds(&none), [("ignored_header", 1)]);
}

#[test]
fn exr_windows() {
    // The display window from (10, 20), 8×4 pixels; columns and rows as they are numbered in the file.
    let channels = || {
        vec![
            channel("B", F32, |_, _| 1.0),
            channel("G", F32, |_, y| y as f32 + 200.0),
            channel("R", F32, |x, _| x as f32 + 100.0),
        ]
    };
    let display = [10, 20, 17, 23];
    for (data, said) in [
        (display, None),
        ([12, 21, 15, 22], Some(32 - 8)),
        ([8, 18, 19, 25], Some(12 * 8 - 32)),
        ([-30, 22, 13, 90], Some((32 - 8) + (44 * 69 - 8))),
        ([17, 23, 17, 23], Some(31)),
    ] {
        for tiles in [None, Some((3, 0))] {
            for compression in [Compression::Uncompressed, Compression::PIZ] {
                let part = Part { data, display, tiles, compression, ..Part::new((1, 1), channels()) };
                let image = read("e.exr", &exr_bytes::file(&[part])).unwrap();
                assert_eq!((image.width, image.height), (8, 4));
                for (at, pixel) in image.pixels.iter().enumerate() {
                    let (x, y) = (10 + (at % 8) as i32, 20 + (at / 8) as i32);
                    let has_data = (data[0]..=data[2]).contains(&x) && (data[1]..=data[3]).contains(&y);
                    let right = if has_data { [x as f32 + 100.0, y as f32 + 200.0, 1.0] } else { [0.0; 3] };
                    assert_eq!(*pixel, right, "{data:?} {tiles:?} at {x}, {y}");
                }
                let notes: Vec<_> = said.map(|count| ("data_window", count)).into_iter().collect();
                assert_eq!(kinds(&image), notes, "{data:?}");
            }
        }
    }
    let apart = Part { data: [100, 100, 107, 103], display, ..Part::new((1, 1), channels()) };
    assert!(read("e.exr", &exr_bytes::file(&[apart])).unwrap_err().contains("windows must overlap"));
    // Chroma lies on the data window's grid, wherever the display window is.
    let shifted =
        Part { data: [-20, -10, 99, 51], display: [-3, -5, 80, 30], ..Part::new((1, 1), luminance_chroma(2, F32)) };
    let image = read("e.exr", &exr_bytes::file(&[shifted])).unwrap();
    for (at, pixel) in image.pixels.iter().enumerate() {
        let (x, y) = ((at % 84) as i32 - 3, (at / 84) as i32 - 5);
        let error = (DVec3::from(pixel.map(f64::from)) - soft(x, y)).abs().max_element();
        assert!(error < 0.01, "{x}, {y}");
    }
}

#[test]
fn exr_parts_and_layers() {
    let depth = || Part { name: "depth", ..Part::new((4, 2), vec![constant("Z", 9.0)]) };
    let picture = |name, value| Part {
        name,
        ..Part::new((4, 2), ["B", "G", "R"].map(|channel| constant(channel, value)).into())
    };
    let image = read("e.exr", &exr_bytes::file(&[depth(), picture("left", 1.0), picture("right", 2.0)])).unwrap();
    all_near(&image, [1.0; 3], 0.0);
    assert_eq!(kinds(&image), [("chosen_layer", 1)]);
    assert!(image.notes[0].message.contains("read `left`, passed over `right`"), "{}", image.notes[0].message);
    // Tiles in one part, scan lines in the other.
    let tiled = Part { tiles: Some((2, 0)), ..picture("a", 3.0) };
    let image = read("e.exr", &exr_bytes::file(&[tiled, depth()])).unwrap();
    all_near(&image, [3.0; 3], 0.0);
    assert_eq!(image.notes, []);

    let layered = ["B", "G", "R", "diffuse.B", "diffuse.G", "diffuse.R"].iter().zip([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let image = read("e.exr", &exr_bytes::file(&[Part::new((4, 2), layered.map(|(n, v)| constant(n, v)).collect())]));
    let image = image.unwrap();
    all_near(&image, [1.0; 3], 0.0);
    assert!(image.notes[0].message.contains("passed over `diffuse`"), "{}", image.notes[0].message);
    // Only a named layer; another holds places, not colours.
    let names = ["View.Position.X", "View.Position.Y", "View.Position.Z", "View.b", "View.g", "View.r"];
    let values = [5.0, 5.0, 5.0, 0.25, 0.5, 1.0];
    let part = Part::new((4, 2), names.into_iter().zip(values).map(|(n, v)| constant(n, v)).collect());
    let image = read("e.exr", &exr_bytes::file(&[part])).unwrap();
    all_near(&image, [1.0, 0.5, 0.25], 0.0);
    assert_eq!(image.notes, []);

    let message = read("e.exr", &exr_bytes::file(&[Part::new((4, 2), vec![constant("A", 1.0), constant("Z", 2.0)])]));
    let message = message.unwrap_err();
    assert!(message.contains("has no picture") && message.contains("`A`, `Z`"), "{message}");
}

#[test]
fn exr_kinds_that_are_refused_by_name() {
    let deep = Part { is_deep: true, name: "deep", ..Part::new((4, 2), rgb(F32)) };
    assert!(read("e.exr", &exr_bytes::file(&[deep])).unwrap_err().contains("deep data"));
    let cube = Part { attributes: vec![("envmap", "envmap", vec![1])], ..Part::new((2, 12), rgb(F32)) };
    assert!(read("e.exr", &exr_bytes::file(&[cube])).unwrap_err().contains("cube map"));
}

#[test]
fn exr_blocks_that_are_missing_or_come_twice() {
    let bytes = exr_bytes::file(&[Part::new((4, 3), rgb(F32))]);
    let second = bytes.len() - 2 * (8 + 4 * 3 * 4);
    let mut twice = bytes.clone();
    twice[second..second + 4].copy_from_slice(&0_i32.to_le_bytes());
    assert!(read("e.exr", &twice).unwrap_err().contains("comes twice"));
    let mut outside = bytes;
    outside[second..second + 4].copy_from_slice(&77_i32.to_le_bytes());
    assert!(read("e.exr", &outside).is_err());
}

// Pixels and shapes.

#[test]
fn pixels_that_are_no_light() {
    let value = |x: i32, y: i32| match (x, y) {
        (2, 2) => f32::NAN,
        (5, 1) => f32::INFINITY,
        (0, 0) => -0.5,
        _ => 3.0,
    };
    let channels = ["B", "G", "R"].map(|name| channel(name, F16, value));
    let image = read("e.exr", &exr_bytes::file(&[Part::new((8, 4), channels.into())])).unwrap();
    assert_eq!(kinds(&image), [("replaced_pixels", 2), ("clipped_pixels", 3)]);
    for (at, pixel) in image.pixels.iter().enumerate() {
        assert_eq!(*pixel, if at == 0 { [0.0; 3] } else { [3.0; 3] });
    }
}

#[test]
fn shapes_are_told() {
    let square = read("e.exr", &exr_bytes::file(&[Part::new((8, 8), rgb(F32))])).unwrap();
    assert_eq!((square.width, kinds(&square)), (8, vec![("unusual_aspect", 1)]));
    // A cross in which each face has a colour of its own, and a strip of the same.
    let faces = |x: i32, y: i32| match (x / 8, y / 8) {
        (1, 0) => 1.0,
        (column, 1) => 2.0 + column as f32,
        (1, 2) => 6.0,
        _ => 0.0,
    };
    let of = |value: fn(i32, i32) -> f32| ["B", "G", "R"].map(|name| channel(name, F16, value)).into();
    let cross = read("e.exr", &exr_bytes::file(&[Part::new((32, 24), of(faces))])).unwrap();
    assert_eq!((cross.width, cross.height, kinds(&cross)), (32, 16, vec![("converted_cross", 1)]));
    let light =
        EnvironmentLight::new(&Environment::Image { image: cross, path: "e.exr".into(), rotation: 0.0, scale: 1.0 });
    let directions = [DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z, DVec3::X, DVec3::Z, DVec3::NEG_Y];
    for (direction, face) in directions.into_iter().zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) {
        assert!((light.radiance(direction).to_rgb()[0] - face).abs() < 1e-9, "{direction}");
    }
    for size in [(48, 8), (8, 48)] {
        let strip = exr_bytes::file(&[Part::new(size, of(|x, y| 1.0 + (x.max(y) / 8) as f32))]);
        assert!(read("e.exr", &strip).unwrap_err().contains("six faces of a cube map"));
    }
}

// Attacks.

/// Every format, small; the ending first.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let encoded = |format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([x as u8 * 9, y as u8 * 20, 7]));
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    let file = |part: Part| exr_bytes::file(&[part]);
    let flat = b"#?RADIANCE\nEXPOSURE=2\n\n+X 2 -Y 2\n\x05\x05\x05\x80\x01\x01\x01\x01\x09\x08\x07\x81\x06\x06\x06\x80"
        .to_vec();
    let compressed = |compression, part: Part| file(Part { compression, ..part });
    vec![
        ("hdr", radiance("#?RADIANCE\nFORMAT=32-bit_rle_xyze\nCOLORCORR=1 2 3", 12, 3, [128, 64, 32, 129])),
        ("hdr", flat),
        ("exr", file(Part::new((4, 2), rgb(F16)))),
        ("exr", file(Part { tiles: Some((2, 1)), ..Part::new((5, 3), rgb(F32)) })),
        ("exr", compressed(Compression::ZIP16, Part::new((8, 4), luminance_chroma(2, F16)))),
        ("exr", compressed(Compression::PIZ, Part::new((8, 4), luminance_chroma(2, F16)))),
        ("exr", compressed(Compression::PXR24, Part::new((8, 4), luminance_chroma(1, F32)))),
        ("exr", compressed(Compression::B44, Part::new((8, 4), rgb(F16)))),
        ("exr", compressed(Compression::RLE, Part { data: [-2, 1, 5, 4], ..Part::new((4, 4), rgb(F32)) })),
        ("exr", exr_bytes::file(&[Part::new((2, 1), vec![constant("Z", 1.0)]), Part::new((2, 1), rgb(U32))])),
        ("png", encoded(image::ImageFormat::Png)),
        ("jpg", encoded(image::ImageFormat::Jpeg)),
    ]
}

/// What [`read`] comes to, without a file.
fn decode(ending: &str, bytes: &[u8]) -> Result<EnvironmentImage, String> {
    formats::image_from_bytes(bytes, &Path::new("e").with_extension(ending))
}

/// Any answer will do that is no panic, and that is an image if it is one.
fn survives(ending: &str, bytes: &[u8]) {
    if let Ok(image) = decode(ending, bytes) {
        assert_eq!(image.pixels.len(), image.width * image.height);
        // Damage can make an image of millions of pixels: many components are compared at once.
        let are_fine = |some: &[f32]| some.iter().fold(true, |fine, x| fine & (*x >= 0.0) & (*x <= f32::MAX));
        assert!(image.pixels.as_flattened().chunks(4096).all(are_fine));
    }
}

#[test]
fn no_damage_makes_it_panic() {
    for (ending, bytes) in samples() {
        assert!(decode(ending, &bytes).is_ok(), "{ending}");
        (0..bytes.len()).into_par_iter().for_each(|place| {
            for flip in [0x01, 0x80] {
                let mut damaged = bytes.clone();
                damaged[place] ^= flip;
                survives(ending, &damaged);
            }
            // Numbers at their ends.
            for value in [[0xff; 4], [0, 0, 0, 0x40]] {
                let mut damaged = bytes.clone();
                let end = bytes.len().min(place + 4);
                damaged[place..end].copy_from_slice(&value[..end - place]);
                survives(ending, &damaged);
            }
        });
    }
}

#[test]
fn files_that_are_cut_off_are_errors() {
    for (ending, bytes) in samples() {
        for length in 0..bytes.len() {
            // The end of a PNG holds no pixels.
            let is_pixels = ending != "png" || length < bytes.len() - 12;
            let result = decode(ending, &bytes[..length]);
            assert!(result.is_err() || !is_pixels, "{ending} cut at {length} of {}", bytes.len());
        }
    }
}

/// A small EXR whose window, tile or part is said to be huge.
fn huge_exr(attribute: &str, ints: &[i32]) -> Vec<u8> {
    let tiles = (attribute == "tiles").then_some((4, 0));
    let mut bytes = exr_bytes::file(&[Part { tiles, ..Part::new((4, 2), rgb(F32)) }]);
    let at = value_of(&bytes, attribute);
    for (index, value) in ints.iter().enumerate() {
        bytes[at + 4 * index..][..4].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// Headers that ask for terabytes: refused at once, with less memory than a small image takes.
#[test]
fn headers_that_ask_for_too_much() {
    // Not behind what other tests put into the pool that all share.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let far = 999_999_999;
    let mut jpeg = samples().pop().unwrap().1;
    let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0xff; 4]);
    let png_of = |width: u32, height: u32| {
        let mut bytes = Vec::new();
        png::Encoder::new(&mut bytes, width, height).write_header().unwrap();
        bytes
    };
    for (what, name, bytes, words) in [
        (
            "both windows",
            "e.exr",
            {
                let mut bytes = huge_exr("dataWindow", &[0, 0, far, far]);
                let at = value_of(&bytes, "displayWindow");
                bytes[at + 8..at + 16].copy_from_slice(&[far.to_le_bytes(); 2].concat());
                bytes
            },
            "scale it down",
        ),
        ("data window", "e.exr", huge_exr("dataWindow", &[0, 0, far, 1]), "scale it down"),
        ("data window to the left", "e.exr", huge_exr("dataWindow", &[-far, -far, 3, 1]), "scale it down"),
        ("data window turned round", "e.exr", huge_exr("dataWindow", &[far, far, 0, 0]), "scale it down"),
        ("display window", "e.exr", huge_exr("displayWindow", &[0, 0, far, far]), "scale it down"),
        ("display window alone", "e.exr", huge_exr("displayWindow", &[0, 0, 1 << 29, 0]), "scale it down"),
        ("windows beyond the format", "e.exr", huge_exr("dataWindow", &[i32::MIN, 0, i32::MAX, 1]), ""),
        ("tiles", "e.exr", huge_exr("tiles", &[1 << 29, 1 << 29]), "smaller tiles"),
        ("no tiles", "e.exr", huge_exr("tiles", &[0, 0]), ""),
        ("rows, of which there are none", "e.exr", huge_exr("dataWindow", &[0, 0, 9, 20_000_000]), "cut off"),
        ("scanlines", "e.hdr", b"#?RADIANCE\n\n-Y 2000000000 +X 2000000000\n".to_vec(), "scale it down"),
        ("sideways", "e.hdr", b"#?RADIANCE\n\n+X 4000000000 -Y 4000000000\n".to_vec(), "scale it down"),
        ("PNG", "e.png", png_of(23_000, 23_000), "scale it down"),
        ("PNG of the largest size", "e.png", png_of(i32::MAX as u32, i32::MAX as u32), "scale it down"),
        ("JPEG", "e.jpg", jpeg, "scale it down"),
    ] {
        let start = Instant::now();
        let message = pool.install(|| read(name, &bytes)).expect_err(what);
        assert!(message.contains(words), "{what}: {message}");
        assert!(start.elapsed() < Duration::from_secs(1), "{what} took {:?}", start.elapsed());
    }
}

/// An attribute that says that it is larger than the file.
#[test]
fn attributes_of_absurd_sizes() {
    for name in ["channels", "compression", "pixelAspectRatio", "chromaticities"] {
        let part =
            Part { attributes: vec![("chromaticities", "chromaticities", vec![0; 32])], ..Part::new((4, 2), rgb(F32)) };
        let mut bytes = exr_bytes::file(&[part]);
        let at = value_of(&bytes, name);
        for size in [i32::MAX, i32::MIN, -1, 1 << 30] {
            bytes[at - 4..at].copy_from_slice(&size.to_le_bytes());
            assert!(read("e.exr", &bytes).is_err(), "{name} of {size} bytes");
        }
    }
}

/// Images at the largest size that is read, of which there is next to nothing: errors that cost neither their room nor time.
#[test]
#[cfg(target_os = "linux")]
fn empty_files_do_not_take_the_room_of_whole_ones() {
    let folder = tempfile::tempdir().unwrap();
    let mut jpeg = samples().pop().unwrap().1;
    let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x3f, 0xff, 0x3f, 0xff]);
    let mut png = Vec::new();
    png::Encoder::new(&mut png, 16_384, 16_384).write_header().unwrap();
    // The signature and the header, without the end that follows.
    png.truncate(8 + 25);
    png.extend(b"\0\0\0\x08IDAT\x78\x01\x01\xff\xff\0\0\0");
    // One scanline of all.
    let one = radiance("#?RADIANCE", 16_384, 1, [9; 4]);
    let data = one.iter().rposition(|byte| *byte == b'\n').unwrap() + 1;
    let hdr = [b"#?RADIANCE\n\n-Y 16384 +X 16384\n", &one[data..]].concat();
    for (name, bytes) in [
        ("e.exr", huge_exr("dataWindow", &[0, 0, 16_383, 16_383])),
        ("f.exr", {
            let mut bytes = huge_exr("dataWindow", &[0, 0, 16_383, 8_191]);
            let at = value_of(&bytes, "displayWindow");
            bytes[at + 8..at + 16].copy_from_slice(&[16_383_i32.to_le_bytes(), 8_191_i32.to_le_bytes()].concat());
            bytes.resize(bytes.len() + 8 * 8_192, 0);
            bytes
        }),
        ("e.hdr", hdr),
        ("e.png", png),
        ("e.jpg", jpeg),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let start = Instant::now();
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "environment_files::reads_what_it_is_told_to", "--nocapture"])
            .env("IORECT_TEST_READ", folder.path().join(name))
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{name}: {text}");
        let kilobytes = text.lines().find_map(|line| line.strip_prefix("peak of an error: ")?.parse::<u64>().ok());
        let kilobytes = kilobytes.unwrap_or_else(|| panic!("{name}: {text}"));
        assert!(kilobytes < 200_000, "{name} took {kilobytes} kB");
        assert!(start.elapsed() < Duration::from_secs(5), "{name} took {:?}", start.elapsed());
    }
}

/// The other end of the test above, in a process of its own, whose memory is its own.
#[test]
#[cfg(target_os = "linux")]
#[allow(clippy::print_stdout, reason = "the other process reads it")]
fn reads_what_it_is_told_to() {
    let Some(path) = std::env::var_os("IORECT_TEST_READ") else { return };
    let path = Path::new(&path);
    let result = read(path.file_name().unwrap().to_str().unwrap(), &std::fs::read(path).unwrap());
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak = peak.trim().trim_end_matches(" kB");
    match result {
        Err(_) => println!("\npeak of an error: {peak}"),
        Ok(image) => println!("\nan image of {}×{}, peak {peak}", image.width, image.height),
    }
}
