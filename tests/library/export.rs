//! Pictures: what is written can be read back, and what cannot be written leaves nothing behind.

use std::fs;
use std::path::Path;

use iorect::export::{self, Comparison, ExportError, Format, LabelledPane, Picture};
use iorect::optics::Ior;
use iorect::render::{Display, ToneCurve};
use iorect::scene::SceneMedium;
use iorect::spectrum::Spectrum;
use iorect::tracking::Events;
use iorect::tracking::Mode;
use iorect::writing::{WriteError, require_writable, write_atomically};

/// A ramp with values below 0, above 1 and tiny, so that nothing is clamped on the way to an EXR unnoticed.
fn picture(width: u32, height: u32) -> Picture {
    let rgb = (0..width * height).map(|i| [i as f32 * 0.01, 1e-6 * i as f32, 40.0 - i as f32]).collect();
    Picture { width, height, rgb }
}

fn files_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn exr_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("linear.exr");
    let original = picture(7, 5);
    export::exr(&path, &original, &[]).unwrap();
    let read = image::open(&path).unwrap().into_rgb32f();
    assert_eq!(read.dimensions(), (7, 5));
    let expected: Vec<u32> = original.rgb.iter().flatten().map(|x| x.to_bits()).collect();
    assert_eq!(read.as_raw().iter().map(|x| x.to_bits()).collect::<Vec<_>>(), expected);
    assert_eq!(files_in(folder.path()), ["linear.exr"]);
}

#[test]
fn png_shows_what_the_display_makes_of_it_and_says_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shown.PNG");
    let original = Picture { width: 2, height: 1, rgb: vec![[0.0, 1.0, 0.214_041_14], [f32::NAN, 0.0, 0.0]] };
    let display = Display { exposure: 0.0, curve: ToneCurve::Clip };
    let text = [("Title".to_owned(), "plain".to_owned()), ("Scene".to_owned(), "Wasserglas – näher".to_owned())];
    export::save(&path, &original, &display, &text).unwrap();

    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    // sRGB of 0.21404114 is 128; NaN is shown in magenta, never as black.
    assert_eq!(pixels, [0, 255, 128, 255, 0, 255]);
    let info = reader.info();
    assert_eq!(info.uncompressed_latin1_text[0].keyword, "Title");
    assert_eq!(info.uncompressed_latin1_text[0].text, "plain");
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "Wasserglas – näher");
}

#[test]
fn metadata_names_scene_modes_iors_samples_seed_and_version() {
    let medium = |name: &str, ior: f64| SceneMedium {
        name: name.into(),
        model: Ior::Constant(ior),
        ior_minus_one: ior - 1.0,
        absorption: Spectrum::ZERO,
    };
    let media = [medium("world", 1.0), medium("vacuum", 1.0), medium("water", 1.333), medium("air", 1.000277)];
    let text = export::metadata_for_media("Pool", &media, &[Mode::Naive, Mode::Rectified], 64, 7);
    let get = |keyword: &str| text.iter().find(|(k, _)| k == keyword).unwrap().1.as_str();
    assert_eq!(get("Title"), "Pool");
    assert_eq!(get("Mode"), "naive, rectified");
    assert_eq!(get("IOR"), "world = 1; water = 1.333; air = 1.000277");
    assert_eq!(get("Samples per pixel"), "64");
    assert_eq!(get("Seed"), "7");
    assert!(get("Software").starts_with("iorect "));
    // Every keyword fits a PNG.
    assert!(text.iter().all(|(keyword, _)| (1..80).contains(&keyword.len()) && keyword.is_ascii()));
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let display = Display::default();
    let at = |name: &str| folder.path().join(name);
    let save = |name: &str, picture: &Picture| export::save(&at(name), picture, &display, &[]);

    assert!(matches!(save("missing/a.png", &picture(2, 2)), Err(ExportError::Write(WriteError::NoFolder { .. }))));
    assert!(matches!(save("a.jpg", &picture(2, 2)), Err(ExportError::UnknownExtension { .. })));
    assert!(matches!(save("a", &picture(2, 2)), Err(ExportError::UnknownExtension { .. })));
    let empty = Picture { width: 0, height: 0, rgb: vec![] };
    assert!(matches!(save("a.png", &empty), Err(ExportError::BadPicture { .. })));
    assert!(matches!(save("a.exr", &empty), Err(ExportError::BadPicture { .. })));
    let torn = Picture { width: 3, height: 3, rgb: vec![[0.0; 3]; 8] };
    assert!(matches!(save("a.png", &torn), Err(ExportError::BadPicture { pixels: 8, .. })));
    fs::create_dir(at("folder.png")).unwrap();
    assert!(matches!(save("folder.png", &picture(2, 2)), Err(ExportError::Write(WriteError::IsFolder { .. }))));
    assert_eq!(files_in(folder.path()), ["folder.png"]);
}

#[test]
fn a_writer_that_fails_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kept.png");
    fs::write(&path, "old").unwrap();
    let result = write_atomically(&path, |writer| {
        writer.write_all(b"half of the new")?;
        Err(std::io::Error::other("the disk is full"))
    });
    assert!(result.unwrap_err().to_string().contains("the disk is full"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(files_in(folder.path()), ["kept.png"]);

    write_atomically(&path, |writer| writer.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(files_in(folder.path()), ["kept.png"]);
}

#[test]
fn writability_is_known_beforehand() {
    let folder = tempfile::tempdir().unwrap();
    require_writable(&folder.path().join("a.png")).unwrap();
    assert!(files_in(folder.path()).is_empty(), "asking leaves nothing behind");
    assert!(matches!(require_writable(&folder.path().join("b/a.png")), Err(WriteError::NoFolder { .. })));
    assert!(matches!(require_writable(folder.path()), Err(WriteError::IsFolder { .. })));
    #[cfg(target_os = "linux")]
    assert!(matches!(require_writable(Path::new("/proc/a.png")), Err(WriteError::System { .. })));
}

#[cfg(unix)]
#[test]
fn files_are_as_readable_as_the_umask_says_and_links_survive() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (plain, written) = (folder.path().join("plain"), folder.path().join("written.png"));
    fs::write(&plain, "").unwrap();
    export::png(&written, &picture(2, 2), &Display::default(), &[]).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&written), mode(&plain));

    let link = folder.path().join("link.png");
    std::os::unix::fs::symlink(&written, &link).unwrap();
    export::png(&link, &picture(4, 4), &Display::default(), &[]).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(image::image_dimensions(&written).unwrap(), (4, 4));
}

#[test]
fn formats_go_by_extension() {
    assert_eq!(Format::of(Path::new("a/b.PNG")).unwrap(), Format::Png);
    assert_eq!(Format::of(Path::new("b.exr")).unwrap(), Format::Exr);
    assert!(Format::of(Path::new("png")).is_err());
}

fn pane<'a>(title: &str, picture: &'a Picture, events: Events) -> LabelledPane<'a> {
    LabelledPane { title: title.into(), details: "64 spp · 2.1 s".into(), events, picture }
}

fn smooth(width: u32, height: u32, brighter: f32) -> Picture {
    let pixel = |x: u32, y: u32| {
        let (u, v) = (x as f32 / width as f32 - 0.5, y as f32 / height as f32 - 0.5);
        let inside = u * u + v * v < 0.1;
        let base = if inside { 0.5 + brighter * u } else { 0.2 + 0.3 * v };
        [base, base * 0.9, base * 0.8]
    };
    let rgb = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
    Picture { width, height, rgb }
}

#[test]
fn comparisons_hold_the_panes_as_they_are_and_black_where_nothing_differs() {
    let (naive, truth) = (smooth(300, 200, 1.5), smooth(300, 200, 0.0));
    let events = Events { stack_underflow: 12_345, inconsistent: 67, ..Events::default() };
    let panes = [pane("naive", &naive, events), pane("rectified", &truth, Events::default())];
    let display = Display::default();
    let about = Comparison {
        title: "A ball in a pool".into(),
        details: "300×200 · seed 0 · iorect".into(),
        display,
        baseline: Some(1),
    };
    let sheet = export::comparison(&panes, &about).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let keep = std::env::var_os("IORECT_KEEP").map(std::path::PathBuf::from);
    let path = keep.unwrap_or_else(|| folder.path().to_path_buf()).join("comparison.png");
    export::image_png(&path, &sheet, &[]).unwrap();

    // Find the first pane by its first pixel: it must stand there whole, as its display makes it.
    let first = display.encode(naive.rgb[0]);
    let (x0, y0) = (0..sheet.height())
        .flat_map(|y| (0..sheet.width() / 4).map(move |x| (x, y)))
        .find(|&(x, y)| {
            (0..300).step_by(37).all(|dx| {
                x + dx < sheet.width() && sheet.get_pixel(x + dx, y).0 == display.encode(naive.rgb[dx as usize])
            })
        })
        .expect("the pane stands in the picture");
    assert_eq!(sheet.get_pixel(x0, y0).0, first);
    for (x, y) in [(150, 100), (299, 199), (10, 190)] {
        assert_eq!(sheet.get_pixel(x0 + x, y0 + y).0, display.encode(naive.rgb[(y * 300 + x) as usize]));
    }
    // Below it, same column: the difference, black in the corners, blue left of the centre (darker), orange right of it.
    let below = (y0 + 200..sheet.height())
        .find(|&y| (0..300).all(|x| sheet.get_pixel(x0 + x, y).0 == export::color_map::diverging(0.0)))
        .expect("the difference stands below its pane");
    let left = sheet.get_pixel(x0 + 80, below + 100).0;
    let right = sheet.get_pixel(x0 + 220, below + 100).0;
    assert!(left[2] > left[0] + 50 && right[0] > right[2] + 50, "{left:?} {right:?}");
}

#[test]
fn small_panes_are_enlarged_and_impossible_comparisons_refused() {
    let tiny = smooth(8, 8, 1.0);
    let sheet = export::comparison(&[pane("stack", &tiny, Events::default())], &Comparison::default()).unwrap();
    assert!(sheet.width() >= 280);

    let other = smooth(9, 8, 1.0);
    let refused = |panes: &[LabelledPane<'_>], baseline| {
        let result = export::comparison(panes, &Comparison { baseline, ..Comparison::default() });
        result.unwrap_err().to_string()
    };
    assert!(refused(&[], None).contains("no panes"));
    let two = [pane("a", &tiny, Events::default()), pane("b", &other, Events::default())];
    assert!(refused(&two, None).contains("9×8"));
    assert!(refused(&two[..1], Some(1)).contains("no pane 1"));
    let mut broken = tiny.clone();
    broken.rgb[3][1] = f32::NAN;
    let panes = [pane("a", &tiny, Events::default()), pane("b", &broken, Events::default())];
    assert!(refused(&panes, Some(0)).contains("pixel 3"));
    let narrow = Picture { width: 1, height: 1 << 20, rgb: vec![[0.0; 3]; 1 << 20] };
    assert!(refused(&[pane("a", &narrow, Events::default())], None).contains("smaller panes"));
}
