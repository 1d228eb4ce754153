//! Every text that is painted: none is cut off, none runs into another, and messages come and go.

use egui::{Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use iorect::app::{App, Command, MediumRef, Preset, Settings, Tab, Theme};

use crate::harness::{apply, choose, every_pane_has_an_image, painted, quick, until, window, window_of};

/// Texts that are shortened, or that reach out of what may be seen of them to the left or to the right. Upwards and downwards they scroll.
fn cut_off(harness: &Harness<'_, App>) -> Vec<String> {
    let screen = harness.ctx.content_rect();
    painted(harness)
        .into_iter()
        .filter(|(text, clip)| {
            let seen = clip.intersect(screen);
            let rect = text.visual_bounding_rect();
            let is_seen = rect.intersects(seen) && rect.center().y > seen.top() && rect.center().y < seen.bottom();
            let is_cut = rect.left() < seen.left() - 1.0 || rect.right() > seen.right() + 1.0;
            is_seen && (text.galley.elided || is_cut)
        })
        .map(|(text, _)| text.galley.text().to_owned())
        .collect()
}

#[test]
fn no_text_is_cut_off_in_any_tab_at_any_size() {
    for (index, size) in [[800.0, 600.0], [1280.0, 720.0], [1920.0, 1080.0], [3840.0, 2160.0]].into_iter().enumerate() {
        let theme = if index % 2 == 0 { Theme::Dark } else { Theme::Light };
        let settings = Settings { theme, resolution_scale: 0.1, ..Settings::default() };
        let mut harness = window_of("iced-water", settings, size);
        until(&mut harness, "there are images", every_pane_has_an_image);
        apply(&mut harness, Command::TogglePause);
        apply(&mut harness, Command::SelectObject(Some("ice cube 1".into())));
        apply(&mut harness, Command::Inspect(Some([0.5, 0.5])));
        harness.run_steps(10);
        let mut faults = Vec::new();
        let mut look = |harness: &Harness<'_, App>, place: &str| {
            faults.extend(cut_off(harness).into_iter().map(|text| format!("{place}: {text}")));
        };
        look(&harness, "scene");
        for tab in [Tab::Render, Tab::Rectification, Tab::Inspector, Tab::Measure] {
            apply(&mut harness, Command::ShowTab(tab));
            harness.run_steps(6);
            look(&harness, &format!("{tab:?}"));
        }
        for command in [Command::ShowGallery(true), Command::ShowShortcuts(true), Command::ShowMessages(true)] {
            apply(&mut harness, command.clone());
            harness.run_steps(6);
            look(&harness, &format!("{command:?}"));
        }
        apply(&mut harness, Command::ShowMessages(false));
        // Legends of many patches shorten names where there is little room.
        for preset in Preset::ALL.into_iter().filter(|preset| *preset != Preset::Surfaces) {
            apply(&mut harness, Command::SetPreset(preset));
            apply(&mut harness, Command::ShowTab(Tab::Render));
            harness.run_steps(6);
            look(&harness, &format!("{preset:?}"));
        }
        faults.sort();
        faults.dedup();
        assert!(faults.is_empty(), "cut off at {size:?}: {faults:#?}");
    }
}

#[test]
fn what_the_status_line_says_does_not_run_together() {
    for width in [480.0, 560.0, 640.0, 800.0, 1000.0, 1280.0, 1600.0] {
        let mut harness = window_of("plain-glass", quick(), [width, 480.0]);
        until(&mut harness, "there are images", every_pane_has_an_image);
        // Over a picture, so that the pixel is named.
        let picture = crate::harness::picture_of(&harness);
        harness.hover_at(picture.center());
        harness.run_steps(4);
        let line = 480.0 - 14.0;
        let mut texts: Vec<Rect> = (painted(&harness).into_iter())
            .map(|(text, _)| text.visual_bounding_rect())
            .filter(|rect| (rect.center().y - line).abs() < 10.0)
            .collect();
        texts.sort_by(|a, b| a.left().total_cmp(&b.left()));
        assert!(!texts.is_empty(), "{width}");
        for pair in texts.windows(2) {
            assert!(pair[1].left() - pair[0].right() >= 8.0, "{width}: {pair:?}");
        }
        let says = |word: &str| painted(&harness).iter().any(|(text, _)| text.galley.text().contains(word));
        assert!(says("rendering") || says("done") || says("paused"), "{width}: how it goes is always said");
        assert!(width < 640.0 || says("pixel "), "{width}: there is room for the pixel");
    }
}

/// Lets time pass in steps that are longer than a frame.
fn wait(harness: &mut Harness<'_, App>, seconds: f64) {
    let end = harness.input().time.unwrap_or(0.0) + seconds;
    let mut now = end - seconds;
    while now < end {
        now += 0.5;
        harness.input_mut().time = Some(now);
        harness.step();
    }
}

#[test]
fn messages_go_by_themselves_stay_under_the_pointer_and_can_be_read_again() {
    let mut harness = window("plain-glass");
    until(&mut harness, "there are images", every_pane_has_an_image);
    let refused = Command::set_ior(MediumRef::World, iorect::optics::Ior::Constant(-1.0));
    apply(&mut harness, refused.clone());
    let text = harness.state().state().notices[0].text.clone();
    let has_notice = |harness: &Harness<'_, App>| !harness.state().state().notices.is_empty();

    // Under the pointer it stays.
    let label = harness.get_by_label(&text);
    assert!(label.accesskit_node().live() != egui::accesskit::Live::Off, "screen readers say it");
    let place: Pos2 = label.rect().center();
    harness.hover_at(place);
    wait(&mut harness, 120.0);
    assert!(has_notice(&harness), "nothing goes while it is read");
    // Away from it, it goes.
    harness.hover_at(Pos2::new(2.0, 2.0));
    wait(&mut harness, 70.0);
    assert!(!has_notice(&harness), "it has gone by itself");

    choose(&mut harness, &["Help", "Messages"]);
    harness.run_steps(2);
    assert!(harness.query_by_label(&text).is_some(), "it can be read again");
}

#[test]
fn many_messages_leave_the_labels_of_the_panes_free() {
    for size in [[1280.0, 720.0], [800.0, 600.0], [640.0, 480.0]] {
        let mut harness = window_of("plain-glass", quick(), size);
        until(&mut harness, "there are images", every_pane_has_an_image);
        for number in 0..8 {
            apply(&mut harness, Command::Open(format!("no-such-scene-{number}").into()));
            until(&mut harness, "it is refused", move |app| {
                app.state().messages.iter().any(|m| m.text.contains(&format!("no-such-scene-{number}")))
            });
        }
        harness.run_steps(6);
        let area =
            harness.ctx.memory(|memory| memory.area_rect(egui::Id::unique("notices"))).expect("there are notices");
        for pane in 1..=4 {
            let label = harness.get_by_label_contains(&format!("Pane {pane}: ")).rect();
            assert!(!area.intersects(label), "{area:?} covers {label:?} at {size:?}");
        }
    }
}
