//! The line below a pane's label: whether its picture is right, and if not, why. A click shows the place.

use egui::{Button, RichText, Stroke, TextStyle, Ui, Vec2};

use crate::app::command::Command;
use crate::app::settings::{PaneContent, Tab};
use crate::app::state::{PathOption, State};
use crate::app::theme::over_pictures::{ALERT, FINE, GROUND, WEAK};
use crate::app::theme::{CHECK_MARK, WARNING_MARK};
use crate::check::verdict::Verdict;
use crate::tracking::Mode;

/// What is said of a pane.
struct Sentence {
    text: String,
    /// Where there is no room for that.
    brief: &'static str,
    /// In whole sentences, for the pointer.
    tip: String,
    kind: Kind,
    /// What a click does.
    commands: Vec<Command>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Right,
    Wrong,
    Neutral,
}

pub(super) fn show(ui: &mut Ui, state: &State, index: usize, commands: &mut Vec<Command>) {
    let Some(sentence) = sentence(state, index) else { return };
    let (mark, color) = match sentence.kind {
        Kind::Right => (CHECK_MARK, FINE),
        Kind::Wrong => (WARNING_MARK, ALERT),
        Kind::Neutral => ("", WEAK),
    };
    let room = ui.available_width() - 2.0 * ui.spacing().button_padding.x;
    let font = TextStyle::Small.resolve(ui.style());
    let fits = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), color).size().x <= room;
    let [full, brief] =
        [&sentence.text[..], sentence.brief].map(|text| format!("{mark} {text}").trim_start().to_owned());
    let text = if fits(&full) { full } else { brief };
    let text = RichText::new(text).text_style(TextStyle::Small).color(color);
    let chip = Button::new(text).fill(GROUND).stroke(Stroke::NONE).corner_radius(5).min_size(Vec2::ZERO).truncate();
    let leads = if sentence.commands.is_empty() { "" } else { "\nClick to see where." };
    let response = ui.add(chip).on_hover_text(format!("{}{leads}", sentence.tip));
    if response.accessible_name(format!("Verdict of pane {}: {}", index + 1, sentence.text)).clicked() {
        commands.extend(sentence.commands);
    }
}

fn sentence(state: &State, index: usize) -> Option<Sentence> {
    let verdict = |mode| state.verdicts.of.get(&mode);
    match state.settings.panes[index] {
        PaneContent::Mode(mode) => {
            let verdict = verdict(mode)?;
            Some(Sentence {
                text: verdict.headline(),
                brief: if verdict.is_right() { "right" } else { "wrong here" },
                tip: verdict.explanation(),
                kind: if verdict.is_right() { Kind::Right } else { Kind::Wrong },
                commands: show_finding(verdict, index),
            })
        }
        PaneContent::Difference(a, b) => {
            let [of_a, of_b] = [verdict(a)?, verdict(b)?];
            let [is_right_a, is_right_b] = [of_a.is_right(), of_b.is_right()];
            let [a, b] = [a, b].map(Mode::name);
            let text = match (is_right_a, is_right_b) {
                (true, true) => "both are right: nothing but noise differs".to_owned(),
                (false, true) => format!("bright where {a} is wrong"),
                (true, false) => format!("bright where {b} is wrong"),
                (false, false) => "both are wrong somewhere".to_owned(),
            };
            let wrong = if is_right_a { of_b } else { of_a };
            let commands = show_finding(wrong, index);
            Some(Sentence { text, brief: "where?", tip: wrong.explanation(), kind: Kind::Neutral, commands })
        }
        PaneContent::Error(mode) => {
            let verdict = verdict(mode)?;
            let title = mode.name();
            let text = if verdict.is_right() {
                "right: what is left is noise".to_owned()
            } else {
                format!("bright where {title} is wrong, and where noise is left")
            };
            let commands = show_finding(verdict, index);
            Some(Sentence { text, brief: "where?", tip: verdict.explanation(), kind: Kind::Neutral, commands })
        }
        // Pictures that are no mode's.
        _ => None,
    }
}

/// Shows in pane `index` the place where most goes wrong.
pub(super) fn show_finding(verdict: &Verdict, index: usize) -> Vec<Command> {
    let Some(finding) = verdict.findings.first() else { return Vec::new() };
    vec![
        Command::SetActivePane(index),
        Command::Inspect(Some(finding.place)),
        Command::SetFollow(finding.follow),
        Command::SetPathOption(PathOption::Seed(finding.seed)),
        Command::SetPathOption(PathOption::Against(Some(Mode::Reference))),
        Command::ShowTab(Tab::Inspector),
    ]
}

/// Shows the first pane that is wrong, where it is so; nothing where none is.
pub fn show_first_wrong(state: &State) -> Vec<Command> {
    let mut wrong = state.settings.shown_panes().iter().enumerate().filter_map(|(index, content)| {
        let PaneContent::Mode(mode) = content else { return None };
        state.verdicts.of.get(mode).filter(|verdict| !verdict.is_right()).map(|verdict| (index, verdict))
    });
    wrong.next().map(|(index, verdict)| show_finding(verdict, index)).unwrap_or_default()
}
