//! The measure panel, differences and values under the pointer, in the whole application without a display.

use std::collections::BTreeMap;

use crate::harness::{
    apply, click_at, every_pane_has_an_image, has_notice, picture_of, quick, type_over, until, window_of,
};
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{
    App, Command, DifferenceKind, ErrorAxis, ErrorMetric, ExportKind, MediumRef, PaneContent, Settings, Tab,
};
use iorect::optics::Ior;
use iorect::session::GroundTruthDemand;
use iorect::tracking::Mode;

/// A camera inside water, where the stack is wrong, and the measure panel.
fn window(panes: [PaneContent; 2]) -> Harness<'static, App> {
    let mut settings =
        Settings { pane_count: 2, tab: Tab::Measure, max_depth: Some(12), resolution_scale: 0.15, ..quick() };
    settings.panes[..2].copy_from_slice(&panes);
    window_of("camera-in-water", settings, [1280.0, 720.0])
}

const STACK_AND_RECTIFIED: [PaneContent; 2] = [PaneContent::Mode(Mode::Stack), PaneContent::Mode(Mode::Rectified)];

fn truth_samples(app: &App) -> u32 {
    app.state().measurement.truth.as_ref().map_or(0, |truth| truth.samples)
}

fn points(app: &App, mode: Mode) -> usize {
    let results = &app.state().measurement.results;
    let is_current = results.epoch == app.state().epoch();
    results.curves.get(&mode).filter(|_| is_current).map_or(0, |curve| curve.points.len())
}

#[test]
fn errors_are_measured_told_apart_from_bias_and_exported() {
    let mut harness = window(STACK_AND_RECTIFIED);
    assert!(harness.query_by_label("Export as CSV…").is_none(), "nothing has been measured");
    harness.get_by_label("Make a reference image").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state().measurement.demand, GroundTruthDemand::On);
    until(&mut harness, "a bias shows", |app| {
        let results = &app.state().measurement.results;
        let is_biased = |curve: &iorect::app::Curve| curve.trend(ErrorMetric::RelMse).bias.is_some();
        truth_samples(app) >= 8
            && points(app, Mode::Rectified) >= 5
            && results.curves.get(&Mode::Stack).is_some_and(is_biased)
    });
    let results = harness.state().state().measurement.results.clone();
    let [stack, rectified] = [Mode::Stack, Mode::Rectified].map(|mode| &results.curves[&mode]);
    // What is right goes on falling, and what is wrong is far above it.
    let trend = rectified.trend(ErrorMetric::RelMse);
    assert!(trend.bias.is_none() && trend.slope.unwrap() < -0.5, "{trend:?}");
    let relmse = |curve: &iorect::app::Curve| curve.latest().unwrap().error(ErrorMetric::RelMse).unwrap();
    assert!(relmse(stack) > 3.0 * relmse(rectified), "{} and {}", relmse(stack), relmse(rectified));
    assert!(stack.points.windows(2).all(|pair| pair[1].samples > pair[0].samples));
    assert!(rectified.rectification_seconds > 0.0 && stack.rectification_seconds == 0.0);
    assert!(results.truth_noise.is_some_and(|noise| noise > 0.0 && noise < relmse(stack)));
    // The panel says so in words.
    assert!(harness.query_by_label_contains("stack is biased").is_some());
    assert!(harness.query_by_label_contains("rectified is biased").is_none());

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("errors.csv");
    let shown = harness.state().state().measurement.results.clone();
    apply(&mut harness, Command::Export(ExportKind::ErrorsCsv, path.clone()));
    until(&mut harness, "the export is reported", |app| {
        app.state().notices.iter().any(|notice| notice.text.contains("errors.csv"))
    });
    let text = std::fs::read_to_string(&path).expect("the table is there");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<BTreeMap<&str, &str>> =
        lines.map(|line| names.iter().copied().zip(line.split(',')).collect()).collect();
    let all: Vec<_> =
        shown.curves.iter().flat_map(|(mode, curve)| curve.points.iter().map(move |point| (mode, point))).collect();
    assert_eq!(rows.len(), all.len());
    for (row, (mode, point)) in rows.iter().zip(all) {
        let number = |name: &str| row[name].parse::<f64>().expect("a number");
        assert_eq!((row["scene"], row["mode"]), ("Camera in water", mode.name()));
        assert_eq!(number("samples"), f64::from(point.samples));
        assert_eq!(number("seconds"), point.seconds);
        assert_eq!(number("relmse"), point.error(ErrorMetric::RelMse).unwrap());
        assert_eq!(number("mse"), point.error(ErrorMetric::Mse).unwrap());
        assert_eq!(number("smape"), point.error(ErrorMetric::Smape).unwrap());
        assert_eq!(row["flip"], "", "FLIP was not asked for");
    }

    // FLIP takes longer and is measured when it is looked at.
    apply(&mut harness, Command::SetErrorAxis(ErrorAxis::Samples));
    apply(&mut harness, Command::SetErrorMetric(ErrorMetric::Flip));
    until(&mut harness, "FLIP is measured", |app| {
        let curves = &app.state().measurement.results.curves;
        curves.len() == 2 && curves.values().all(|curve| curve.points.iter().all(|point| point.flip.is_some()))
    });
}

#[test]
fn an_edit_drops_the_errors_and_a_pane_does_not() {
    let mut harness = window(STACK_AND_RECTIFIED);
    apply(&mut harness, Command::SetGroundTruth(GroundTruthDemand::On));
    until(&mut harness, "there are errors", |app| truth_samples(app) >= 4 && points(app, Mode::Stack) >= 2);

    harness.get_by_label("Pause").click();
    until(&mut harness, "it pauses", |app| app.state().measurement.demand == GroundTruthDemand::Paused);
    // Another mode in a pane is the same picture: what there is stays, and the newcomer is measured against it.
    let samples = truth_samples(harness.state());
    apply(&mut harness, Command::SetPaneContent(0, PaneContent::Mode(Mode::Naive)));
    until(&mut harness, "the other mode is measured", |app| points(app, Mode::Naive) >= 2);
    assert!(truth_samples(harness.state()) >= samples);
    assert!(!harness.state().state().measurement.has_begun_anew);

    // The button, not the panes' own pause.
    harness.get_by_label("Go on").click();
    until(&mut harness, "it goes on", |app| truth_samples(app) > samples);
    let halves = harness.state().state().measurement.truth.as_ref().and_then(|truth| truth.halves.clone()).unwrap();
    let ior = Ior::Constant(1.2);
    apply(&mut harness, Command::set_ior(MediumRef::World, ior));
    until(&mut harness, "that it begins anew is said", |app| app.state().measurement.has_begun_anew);
    assert!(harness.query_by_label_contains("begins anew").is_some());
    until(&mut harness, "there are errors again", |app| points(app, Mode::Naive) >= 1);
    let anew = harness.state().state().measurement.truth.as_ref().and_then(|truth| truth.halves.clone()).unwrap();
    assert!(anew.mean != halves.mean);

    harness.get_by_label("Drop").click();
    until(&mut harness, "it is gone", |app| app.state().measurement.truth.is_none());
    assert!(harness.query_by_label("Make a reference image").is_some());
    assert!(harness.query_by_label("Export as CSV…").is_none());
}

/// What was rendered elsewhere: panes are measured against it at its size, until it is let go.
#[test]
fn an_image_from_a_file_is_a_reference_image() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let mut harness = window([PaneContent::Mode(Mode::Stack), PaneContent::Error(Mode::Rectified)]);
    apply(&mut harness, Command::SetGroundTruth(GroundTruthDemand::Off));
    let panes = harness.state().state().film_size();

    // The scene as another program would render it, in another shape; with a broken pixel and a negative one.
    let (size, modes) = ([96_u32, 80], [Mode::Rectified]);
    let prepared = iorect::tracking::prepare(harness.state().state().document.description().clone(), None).unwrap();
    let camera = iorect::scene::camera::Camera::new(&prepared.description.camera).unwrap();
    let settings =
        iorect::render::ImageSettings { max_depth: Some(12), ..iorect::render::ImageSettings::new(modes[0], 7) };
    let task = iorect::render::RenderTask { prepared: &prepared, camera: &camera, settings: &settings };
    let mut film = iorect::render::Film::new(size[0], size[1]);
    assert!(task.pass(&mut film, 256, &Default::default()));
    let mut rgb = film.to_rgb();
    rgb[5] = [f32::NAN; 3];
    rgb[100] = [-1e-4; 3];
    let picture = iorect::export::Picture { width: size[0], height: size[1], rgb: rgb.clone() };
    iorect::export::exr(&path("mitsuba.exr"), &picture, &[]).expect("it can be written");

    harness.state_mut().prompt_in(folder.path().to_owned());
    harness.get_by_label("Open an image…").click();
    while harness.query_by_role_and_label(Role::TextInput, "Path").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
        harness.step();
    }
    harness.run_steps(2);
    type_over(&mut harness, path("mitsuba.exr").to_str().expect("a plain path"));
    until(&mut harness, "films have its size", move |app| app.state().film_size() == size);
    assert!(has_notice(&harness, "1 pixel of the image had components that are no finite numbers"));
    until(&mut harness, "errors are measured", |app| {
        points(app, Mode::Stack) >= 5 && points(app, Mode::Rectified) >= 5 && every_pane_has_an_image(app)
    });
    let results = harness.state().state().measurement.results.clone();
    assert_eq!((results.size, results.truth_noise), (size, None), "nobody knows its noise");
    let latest = |mode: Mode| *results.curves[&mode].latest().unwrap();
    let relmse = |mode: Mode| latest(mode).error(ErrorMetric::RelMse).unwrap();
    assert!(relmse(Mode::Stack) > 3.0 * relmse(Mode::Rectified), "{results:?}");
    // The figure is that of the film that is shown and the image in the file.
    let film = harness.state().film(Mode::Rectified).expect("it is shown").clone();
    let point = results.curves[&Mode::Rectified].points.iter().find(|point| point.samples == film.samples);
    if let Some(point) = point {
        let squares = film.rgb.iter().zip(&rgb).enumerate().filter(|(index, _)| *index != 5);
        let sum: f64 = squares.map(|(_, (a, b))| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>()).sum();
        let mse = sum / (3 * rgb.len()) as f64;
        assert!((point.error(ErrorMetric::Mse).unwrap() / mse - 1.0).abs() < 0.05, "{point:?} and {mse}");
    }
    assert!(harness.query_by_label("mitsuba.exr").is_some(), "the panel names it");
    // All of it is seen, in its own shape.
    let place = picture_of(&harness);
    assert!((place.width() / place.height() - 1.2).abs() < 0.02, "{place:?}");

    // Beside the picture there is nothing to be looked at.
    let beside = harness.state().pane_place(Some(0));
    let corner = egui::pos2(beside.center().x, beside.bottom() - 2.0);
    assert!(beside.contains(corner) && !place.contains(corner), "{beside:?} and {place:?}");
    click_at(&mut harness, corner);
    assert!(harness.state().state().inspection.is_none() && harness.state().values_under_pointer(0).is_empty());
    click_at(&mut harness, place.center());
    assert!(harness.state().state().inspection.is_some());

    // What cannot be used leaves what there is.
    std::fs::write(path("broken.exr"), b"no image").expect("it can be written");
    apply(&mut harness, Command::ReadReferenceImage(path("broken.exr")));
    until(&mut harness, "it is said", |app| {
        app.state().notices.iter().any(|notice| notice.text.contains("broken.exr"))
    });
    apply(&mut harness, Command::ReadReferenceImage(path("display.png")));
    until(&mut harness, "it is said", |app| {
        app.state().notices.iter().any(|notice| notice.text.contains("display.png"))
    });
    assert_eq!(harness.state().state().film_size(), size);

    harness.get_by_label("Drop").click();
    until(&mut harness, "films fit the panes again", move |app| {
        let [wide, high] = [0, 1].map(|side| app.state().film_size()[side].abs_diff(panes[side]));
        !app.state().has_fixed_film_size() && wide.max(high) <= panes[0] / 4
    });
    assert!(!harness.state().state().measurement.is_on());
    // It belongs to its scene.
    apply(&mut harness, Command::ReadReferenceImage(path("mitsuba.exr")));
    until(&mut harness, "films have its size", move |app| app.state().film_size() == size);
    apply(&mut harness, Command::Open("nested-spheres".into()));
    until(&mut harness, "the other scene is there", |app| {
        app.state().document.description().name != "Camera in water" && !app.state().measurement.is_on()
    });
    until(&mut harness, "films fit the panes", move |app| app.state().film_size() != size);
}

#[test]
fn differences_are_signed_absolute_or_flip_also_against_the_reference_image() {
    let mut harness = window([PaneContent::Difference(Mode::Stack, Mode::Rectified), PaneContent::Mode(Mode::Stack)]);
    assert!(!harness.state().state().measurement.is_on());
    // The error of a mode brings the reference image with it.
    harness.get_by_label("Pane 2: stack").click();
    harness.run_steps(3);
    harness.get_by_label("error").hover();
    harness.run_steps(10);
    harness.get_by_label("error of rectified").click();
    harness.run_steps(3);
    assert_eq!(harness.state().state().settings.panes[1], PaneContent::Error(Mode::Rectified));
    assert!(harness.state().state().measurement.is_on());
    until(&mut harness, "both panes have images", every_pane_has_an_image);

    apply(&mut harness, Command::ShowTab(Tab::Render));
    let mut means = Vec::new();
    for kind in DifferenceKind::ALL {
        harness.get_by_label(kind.name()).click();
        harness.run_steps(3);
        assert_eq!(harness.state().state().settings.difference, kind);
        until(&mut harness, "it is coloured so", |app| {
            (0..2).all(|pane| app.difference_shown(pane).is_some_and(|(shown, _)| shown == kind))
        });
        means.push([0, 1].map(|pane| harness.state().difference_shown(pane).unwrap().1));
    }
    // A stack that begins inside is far off everywhere, rectification only by noise.
    assert!(means.iter().all(|[difference, error]| difference > &0.0 && error > &0.0), "{means:?}");
    let [absolute, signed, flip] = [means[0], means[1], means[2]];
    assert!(signed[0] > 0.5 * absolute[0] && signed[0] < 2.0 * absolute[0], "the same mean: {means:?}");
    assert!(flip[0] > 0.02 && flip[0] <= 1.0 && flip[0] != signed[0], "{means:?}");
}

#[test]
fn values_under_the_pointer_are_those_of_the_films() {
    let settings = Settings { sample_limit: Some(4), ..quick() };
    let mut harness = window_of("camera-in-water", settings, [1280.0, 720.0]);
    until(&mut harness, "the images are done", |app| (0..4).all(|pane| app.samples_shown(pane) == 4));
    assert!(harness.query_by_label_contains("pixel ").is_none(), "the pointer is not there");
    let [width, height] = harness.state().state().film_size();
    let picture = picture_of(&harness);
    // On the ball, where the stack is wrong.
    let pixel = [width / 2 + 3, height / 2 + 2];
    let share = |pixel: u32, side: u32| (pixel as f32 + 0.5) / side as f32;
    harness.hover_at(picture.lerp_inside(egui::vec2(share(pixel[0], width), share(pixel[1], height))));
    harness.run_steps(3);
    assert!(harness.query_by_label(&format!("pixel {}, {}", pixel[0], pixel[1])).is_some());
    let index = (pixel[1] * width + pixel[0]) as usize;
    let rgb = |mode: Mode| harness.state().film(mode).expect("it is shown").rgb[index];
    let (stack, rectified) = (rgb(Mode::Stack), rgb(Mode::Rectified));
    assert_ne!(stack, rectified);
    let numbers = |pane: usize| -> Vec<f32> {
        let text = harness.state().values_under_pointer(pane).join(" ").replace('−', "-");
        text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    };
    let close = |shown: &[f32], expected: [f32; 3]| {
        shown.len() == 4 && shown.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 6e-5 + 6e-3 * b.abs().min(1e-3))
    };
    assert!(close(&numbers(0), stack), "{:?} and {stack:?}", numbers(0));
    assert!(close(&numbers(1), rectified), "{:?} and {rectified:?}", numbers(1));
    assert!(!close(&numbers(0), rectified), "panes differ here");
    let difference = std::array::from_fn(|channel| stack[channel] - rectified[channel]);
    assert!(close(&numbers(3), difference), "{:?} and {difference:?}", numbers(3));

    harness.key_press(Key::P);
    harness.run_steps(3);
    assert!(!harness.state().state().settings.show_values);
}
