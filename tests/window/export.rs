//! What the window shows comes out of it as it is: files, the clipboard, and questions before something is lost.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::RgbImage;
use iorect::app::{
    App, Arrangement, Command, DifferenceRange, ExportKind, MediumRef, PaneContent, RangeCurve, RangeEnd, Settings,
    SnapshotId, Theme,
};
use iorect::optics::Ior;
use iorect::tracking::Mode;

use crate::harness::{apply, every_pane_has_an_image, quick, until, window_of};
use crate::tev_listener::{Image, Listener};

const DIFFERENCE: PaneContent = PaneContent::Difference(Mode::Naive, Mode::Rectified);

/// A window with so many panes, whose images stand still.
fn still_window(pane_count: usize, contents: &[PaneContent], arrangement: Arrangement) -> Harness<'static, App> {
    let mut settings = Settings { pane_count, arrangement, sample_limit: Some(1), ..quick() };
    settings.panes[..contents.len()].copy_from_slice(contents);
    let mut harness = window_of("camera-in-water", settings, [1280.0, 720.0]);
    // The harness would draw a cursor of its own.
    harness.set_render_cursor(false);
    until(&mut harness, "there are images", every_pane_has_an_image);
    until(&mut harness, "they are judged", |app| {
        let mut modes = app.state().settings.modes().into_iter();
        modes.all(|mode| app.state().verdicts.of.get(&mode).is_some_and(|verdict| verdict.paths >= 1024))
    });
    // Previews fade away.
    harness.run_steps(60);
    harness
}

fn export(harness: &mut Harness<'_, App>, kind: ExportKind, path: &Path) -> RgbImage {
    apply(harness, Command::Export(kind, path.to_owned()));
    until(harness, "the export is reported", |app| !app.state().notices.is_empty());
    let notice = harness.state().state().notices[0].clone();
    assert!(!notice.is_error, "{}", notice.text);
    apply(harness, Command::DismissNotice(notice.id));
    image::open(path).expect("a picture that can be read").to_rgb8()
}

/// The part of the window that lies in `area`, in points.
fn screen(harness: &mut Harness<'_, App>, area: egui::Rect) -> RgbImage {
    let window = harness.render().expect("the window can be drawn");
    let scale = harness.ctx.pixels_per_point();
    let [x, y, right, bottom] =
        [area.left(), area.top(), area.right(), area.bottom()].map(|points| (points * scale).round() as u32);
    let part = image::imageops::crop_imm(&window, x, y, right - x, bottom - y).to_image();
    image::DynamicImage::ImageRgba8(part).to_rgb8()
}

/// Leaves a picture of the window in `target/ui-screenshots`, to be looked at.
fn leave_picture(harness: &mut Harness<'_, App>, name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/ui-screenshots");
    std::fs::create_dir_all(&folder).expect("the build folder is writable");
    let window = harness.render().expect("the window can be drawn");
    window.save(folder.join(format!("{name}.png"))).expect("a picture can be written");
}

fn pixels_apart(a: &RgbImage, b: &RgbImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn a_pane_is_exported_as_it_is_on_the_screen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("pane.png");
    let mut harness = still_window(1, &[DIFFERENCE], Arrangement::Tiles);
    let area = harness.state().pane_place(Some(0));
    let mut seen = Vec::new();
    for zoom in [1.0, 3.0] {
        apply(&mut harness, Command::SetZoom(zoom, [0.4, 0.6]));
        let shown = screen(&mut harness, area);
        let exported = export(&mut harness, ExportKind::ShownPane, &path);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(pixels_apart(&shown, &exported), 0, "at zoom {zoom}");
        seen.push(exported);
    }
    assert!(pixels_apart(&seen[0], &seen[1]) > 1000, "the zoom is in the picture");
}

#[test]
fn all_panes_are_exported_with_their_divider() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("panes.png");
    let mut harness = still_window(2, &[PaneContent::Mode(Mode::Naive), DIFFERENCE], Arrangement::Wipe);
    apply(&mut harness, Command::SetDivider([0.3, 0.5]));
    let area = harness.state().pane_place(None);
    let shown = screen(&mut harness, area);
    let exported = export(&mut harness, ExportKind::ShownPanes, &path);
    // The frame of the active pane belongs to editing: that is all that is missing.
    let cut = harness.state().pane_place(Some(0)).width().round() as u32;
    let (width, height) = exported.dimensions();
    for (x, y, pixel) in exported.enumerate_pixels() {
        let is_frame = x <= cut + 2 && (x < 3 || y < 3 || y + 3 >= height || x + 3 >= cut);
        assert!(is_frame || shown.get_pixel(x, y) == pixel, "at {x}, {y} of {width} × {height}");
    }
    let [line, beside] = [cut, cut + 40].map(|x| exported.get_pixel(x, height / 5).0);
    assert!(line.iter().all(|channel| *channel > 180) && line != beside, "the divider: {line:?}");
    // The active pane alone is what the divider leaves of it.
    let active = export(&mut harness, ExportKind::ShownPane, &folder.path().join("left.png"));
    assert_eq!(active.dimensions(), (cut, height));
}

#[test]
fn what_belongs_to_the_pointer_and_what_floats_is_not_exported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut harness = still_window(1, &[PaneContent::Mode(Mode::Rectified)], Arrangement::Tiles);
    let area = harness.state().pane_place(Some(0));
    let plain = export(&mut harness, ExportKind::ShownPane, &folder.path().join("plain.png"));
    apply(&mut harness, Command::SelectObject(Some("water".into())));
    harness.hover_at(area.left_top() + egui::vec2(30.0, 20.0));
    harness.run_steps(60);
    apply(&mut harness, Command::ShowShortcuts(true));
    let shown = screen(&mut harness, area);
    assert!(pixels_apart(&shown, &plain) > 1000, "there is something over the picture");
    let exported = export(&mut harness, ExportKind::ShownPane, &folder.path().join("again.png"));
    assert_eq!(pixels_apart(&exported, &plain), 0);
    assert!(harness.state().state().windows.shortcuts, "what was open stays open");
    apply(&mut harness, Command::ShowShortcuts(false));
    let shown = screen(&mut harness, area);
    assert!(pixels_apart(&shown, &plain) > 100, "handles and tools are back");
}

/// The picture that was put on the clipboard in the last frame.
fn copied(harness: &Harness<'_, App>) -> Option<egui::ColorImage> {
    harness.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyImage(image) => Some(image.clone()),
        _ => None,
    })
}

fn step_until_copied(harness: &mut Harness<'_, App>) -> egui::ColorImage {
    for _ in 0..40 {
        harness.step();
        if let Some(image) = copied(harness) {
            return image;
        }
    }
    panic!("nothing was copied");
}

#[test]
fn pictures_and_values_are_copied() {
    let contents = [PaneContent::Mode(Mode::Naive), PaneContent::Mode(Mode::Rectified)];
    let mut harness = still_window(2, &contents, Arrangement::Tiles);
    let area = harness.state().pane_place(Some(0));
    // As systems with a clipboard tell it.
    harness.event(egui::Event::Copy);
    let image = step_until_copied(&mut harness);
    assert_eq!(image.size, [area.width() as usize, area.height() as usize]);
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::C);
    let image = step_until_copied(&mut harness);
    assert!(image.size[0] > 2 * area.width() as usize && image.size[1] == area.height() as usize);

    harness.hover_at(area.center());
    harness.run_steps(3);
    // In one frame: what is copied is told by that frame alone.
    let press =
        egui::Event::Key { key: Key::C, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::SHIFT };
    harness.input_mut().events.push(press);
    harness.step();
    let text = harness.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let text = text.expect("the values were copied");
    assert!(text.contains("naive\nRGB ") && text.contains("rectified\nRGB "), "{text}");
}

#[test]
fn copying_in_a_text_field_copies_no_picture() {
    let mut harness = still_window(1, &[PaneContent::Mode(Mode::Naive)], Arrangement::Tiles);
    harness.get_by_role_and_label(Role::SpinButton, "Exposure").click();
    harness.run_steps(3);
    harness.event(egui::Event::Copy);
    for _ in 0..5 {
        harness.step();
        assert!(copied(&harness).is_none());
    }
}

#[test]
fn a_file_is_replaced_only_after_a_question() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut harness = still_window(1, &[PaneContent::Mode(Mode::Naive)], Arrangement::Tiles);
    let paths = ["a.png", "b.png", "c.exr", "d.toml"].map(|name| folder.path().join(name));
    let commands = [
        Command::Export(ExportKind::ShownPane, paths[0].clone()),
        Command::Export(ExportKind::AllPanesPng, paths[1].clone()),
        Command::Export(ExportKind::PaneExr, paths[2].clone()),
        Command::SaveAs(paths[3].clone()),
    ];
    for (path, command) in paths.iter().zip(commands) {
        let old = || std::fs::read(path).unwrap() == b"old";
        std::fs::write(path, "old").unwrap();
        for refuse in ["Cancel", "Esc"] {
            apply(&mut harness, command.clone());
            for _ in 0..2000 {
                if harness.query_by_label("Replace").is_some() {
                    break;
                }
                std::thread::sleep(std::time::Duration::from_millis(2));
                harness.step();
            }
            match refuse {
                "Esc" => harness.key_press(Key::Escape),
                _ => harness.get_by_label("Cancel").click(),
            }
            harness.run_steps(4);
            assert!(harness.query_by_label("Replace").is_none(), "{refuse}");
            assert!(old() && harness.state().state().notices.is_empty(), "{refuse} leaves {}", path.display());
        }
        apply(&mut harness, command);
        while harness.query_by_label("Replace").is_none() {
            std::thread::sleep(std::time::Duration::from_millis(2));
            harness.step();
        }
        leave_picture(&mut harness, "replace");
        harness.get_by_label("Replace").click();
        until(&mut harness, "it is written", |app| !app.state().notices.is_empty());
        let notice = harness.state().state().notices[0].clone();
        assert!(!notice.is_error && !old(), "{}", notice.text);
        apply(&mut harness, Command::DismissNotice(notice.id));
    }
}

#[test]
fn the_range_of_differences_is_dragged_typed_and_reset() {
    let mut harness = still_window(2, &[PaneContent::Mode(Mode::Naive), DIFFERENCE], Arrangement::Tiles);
    let end = |harness: &Harness<'_, App>| harness.state().scale_shown(1).expect("a difference").end;
    assert_eq!(end(&harness), 1.0);
    let legend = harness.get_by_role_and_label(Role::Slider, "Range of the difference in pane 2").rect().center();
    harness.drag_at(legend);
    harness.run_steps(2);
    harness.hover_at(legend + egui::vec2(-20.0, 0.0));
    harness.run_steps(2);
    harness.hover_at(legend + egui::vec2(-80.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(legend + egui::vec2(-80.0, 0.0));
    until(&mut harness, "the range is smaller", |app| app.scale_shown(1).is_some_and(|scale| scale.end < 0.5));
    let RangeEnd::Fixed(fixed) = harness.state().state().settings.difference_range.end else { panic!("not fixed") };
    until(&mut harness, "the picture follows", move |app| app.scale_shown(1).is_some_and(|scale| scale.end == fixed));

    harness.get_by_label("Reset the range").click();
    until(&mut harness, "it is as at first", |app| app.scale_shown(1).is_some_and(|scale| scale.end == 1.0));
    assert_eq!(harness.state().state().settings.difference_range, DifferenceRange::default());
    for (label, curve) in [("Linear", RangeCurve::Linear), ("Log", RangeCurve::Logarithmic), ("Root", RangeCurve::Root)]
    {
        harness.get_by_label(label).click();
        until(&mut harness, label, move |app| app.scale_shown(1).is_some_and(|scale| scale.curve == curve));
    }
    harness.get_by_label("Auto").click();
    let is_round =
        |x: f32| [1.0, 2.0, 5.0].iter().any(|digit| (x.log10() - f32::log10(*digit)).rem_euclid(1.0) % 1.0 < 1e-3);
    until(&mut harness, "the range is automatic", move |app| {
        app.state().settings.difference_range.end == RangeEnd::Automatic
            && app.scale_shown(1).is_some_and(|scale| is_round(scale.end * 1.0001))
    });
    leave_picture(&mut harness, "range");
}

#[test]
fn a_snapshot_is_kept_over_an_edit_and_compared() {
    let mut harness = still_window(2, &[PaneContent::Mode(Mode::Naive), DIFFERENCE], Arrangement::Tiles);
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Change(Mode::Naive, SnapshotId::A)));
    assert!(harness.state().scale_shown(1).is_none(), "nothing is kept yet");
    until(&mut harness, "there is an image to keep", |app| app.samples_shown(0) > 0);
    harness.key_press(Key::K);
    until(&mut harness, "the difference to it is shown", |app| {
        app.samples_shown(1) > 0 && app.difference_shown(1).is_some()
    });
    let kept = harness.state().state().snapshots.get(SnapshotId::A).expect("it was kept").film.clone();
    assert_eq!(harness.state().difference_shown(1).unwrap().1, 0.0, "nothing has changed yet");

    let medium = MediumRef::Named("water".into());
    apply(&mut harness, Command::set_ior(medium, Ior::Constant(1.6)));
    until(&mut harness, "the change is shown", |app| app.difference_shown(1).is_some_and(|(_, mean)| mean > 1e-4));
    // By hand, from the films themselves.
    let film = harness.state().film(Mode::Naive).unwrap();
    let luminance = |rgb: [f32; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let by_hand = film.rgb.iter().zip(&kept.rgb).map(|(a, b)| f64::from((luminance(*a) - luminance(*b)).abs()));
    let by_hand = by_hand.sum::<f64>() / film.rgb.len() as f64;
    let (_, shown) = harness.state().difference_shown(1).unwrap();
    assert!((shown - by_hand).abs() < 1e-3 * by_hand, "{shown} and {by_hand}");
    let title = {
        let state = harness.state().state();
        let kept = state.snapshots.get(SnapshotId::A).unwrap();
        kept.title(state.document.description(), &state.view.camera)
    };
    assert!(title.starts_with("naive, water 1.33") && title.contains("→ 1.6"), "{title}");

    leave_picture(&mut harness, "snapshots");
    // B is after the edit; A less B is the change the other way round.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::K);
    harness.run_steps(3);
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::SnapshotDifference));
    until(&mut harness, "A − B is shown", |app| app.scale_shown(1).is_some());
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Snapshot(SnapshotId::A)));
    until(&mut harness, "A is shown", |app| app.samples_shown(1) == 1);
    // Another size of the film: a difference would be none, and that is said.
    apply(&mut harness, Command::SetPaneContent(1, PaneContent::Change(Mode::Naive, SnapshotId::A)));
    apply(&mut harness, Command::SetResolutionScale(0.5));
    until(&mut harness, "there is no difference", |app| app.scale_shown(1).is_none());
    leave_picture(&mut harness, "snapshots-of-two-sizes");
    apply(&mut harness, Command::DropSnapshot(SnapshotId::A));
    assert_eq!(harness.state().state().settings.panes[1], PaneContent::Mode(Mode::Naive));
}

#[test]
fn only_pictures_of_modes_are_kept() {
    let surfaces = PaneContent::Surfaces(iorect::render::surfaces::SurfaceQuantity::Outside);
    let mut harness = still_window(1, &[surfaces], Arrangement::Tiles);
    harness.key_press(Key::K);
    harness.run_steps(3);
    let state = harness.state().state();
    assert!(state.snapshots.get(SnapshotId::A).is_none());
    assert!(state.notices.iter().any(|notice| notice.is_error && notice.text.contains("mode")));
}

#[test]
fn the_histogram_follows_the_active_pane() {
    let mut harness = still_window(2, &[PaneContent::Mode(Mode::Naive), DIFFERENCE], Arrangement::Tiles);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    let seen = |harness: &mut Harness<'_, App>, text: &str| {
        for _ in 0..400 {
            harness.step();
            if harness.query_by_label_contains(text).is_some() {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("“{text}” is not there");
    };
    seen(&mut harness, "Histogram of naive: ");
    // What is clipped, by hand; the exposure is a multiple of a quarter.
    apply(&mut harness, Command::SetExposure(1.5));
    let film = harness.state().film(Mode::Naive).unwrap();
    let white = 1.5_f32.exp2().recip();
    let clipped = film.rgb.iter().filter(|rgb| rgb.iter().any(|x| *x >= white)).count() as f64;
    let share = iorect::export::words::brief(100.0 * clipped / film.rgb.len() as f64);
    seen(&mut harness, &format!("Histogram of naive: {share} % of the pixels above white"));
    leave_picture(&mut harness, "histogram");
    apply(&mut harness, Command::SetActivePane(1));
    seen(&mut harness, "Histogram of naive − rectified: ");
    apply(&mut harness, Command::SetTheme(Theme::Light));
    leave_picture(&mut harness, "histogram-light");
}

#[test]
fn films_go_to_tev_once_and_live() {
    let listener = Listener::open();
    let mut settings = Settings { pane_count: 2, sample_limit: Some(2), ..quick() };
    settings.panes[..2].copy_from_slice(&[PaneContent::Mode(Mode::Naive), DIFFERENCE]);
    settings.tev_address = listener.address.clone();
    let mut harness = window_of("camera-in-water", settings, [1280.0, 720.0]);
    let is_done =
        |app: &App| [Mode::Naive, Mode::Rectified].iter().all(|mode| app.film(*mode).is_some_and(|f| f.is_done));
    until(&mut harness, "the films are done", move |app| is_done(app) && app.samples_shown(1) == 2);
    apply(&mut harness, Command::SendToTev);
    until(&mut harness, "it is sent", |app| app.state().notices.iter().any(|n| n.text == "Sent 2 images to tev"));
    let name = harness.state().state().document.description().name.clone();
    let films = |harness: &Harness<'_, App>| [Mode::Naive, Mode::Rectified].map(|m| harness.state().film(m).unwrap());
    let holds = |image: &Image, expected: &dyn Fn(usize, usize) -> f32| {
        (["R", "G", "B"].iter().enumerate())
            .all(|(c, channel)| image.channels[*channel].iter().enumerate().all(|(pixel, x)| *x == expected(pixel, c)))
    };
    let [naive, rectified] = films(&harness);
    let images =
        listener.wait_for("both images", |images| images.values().filter(|image| image.updates > 0).count() == 2);
    let image = &images[&format!("naive – {name}")];
    assert_eq!(image.size, naive.size.map(|side| side as usize));
    assert!(holds(image, &|pixel, c| naive.rgb[pixel][c]));
    let difference = &images[&format!("naive − rectified – {name}")];
    assert!(holds(difference, &|pixel, c| naive.rgb[pixel][c] - rectified.rgb[pixel][c]));

    apply(&mut harness, Command::ToggleTevLive);
    apply(&mut harness, Command::set_ior(MediumRef::Named("water".into()), Ior::Constant(1.5)));
    until(&mut harness, "the new films are done", move |app| is_done(app) && app.samples_shown(1) == 2);
    let [naive, _] = films(&harness);
    harness.run_steps(3);
    listener.wait_for("the edited scene", |images| {
        images.get(&format!("naive – {name}")).is_some_and(|image| holds(image, &|pixel, c| naive.rgb[pixel][c]))
    });
    // Nobody at the address: an error in words, and it is not tried again and again.
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    apply(&mut harness, Command::SetTevAddress(free.to_string()));
    until(&mut harness, "the error is told", |app| {
        app.state().notices.iter().any(|n| n.is_error && n.text.contains("tev"))
    });
    assert!(!harness.state().state().is_live_in_tev);
}
