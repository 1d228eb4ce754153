//! The range of the colours of differences.

use egui::{DragValue, Ui};

use crate::app::command::Command;
use crate::app::range::{DECADES, DifferenceRange, ENDS, RangeCurve, RangeEnd};
use crate::app::settings::DifferenceKind;
use crate::app::state::State;
use crate::app::viewport::Viewport;
use crate::app::widgets::{note, number_within_ui, row_ui, segmented_row_ui};

pub fn show(ui: &mut Ui, state: &State, viewport: &Viewport, commands: &mut Vec<Command>) {
    let settings = &state.settings;
    if settings.difference == DifferenceKind::Flip {
        row_ui(ui, "Range", "FLIP has a range of its own.", |ui| ui.label(note(ui, "from 0 to 1, always")));
        return;
    }
    let range = settings.difference_range;
    let shown = settings.shown_panes().iter().filter_map(|content| viewport.scale(*content)).next();
    // What a fixed range begins with is what is shown.
    let end = match range.end {
        RangeEnd::Fixed(end) => end,
        _ => shown.map_or(1.0, |scale| scale.end),
    };
    let ends = [
        (RangeEnd::Exposure, "Exposure", "Up to the luminance that the exposure brings to white."),
        (RangeEnd::Automatic, "Auto", "Up to where nearly all pixels lie within it."),
        (RangeEnd::Fixed(end), "Fixed", "Up to the number below."),
    ];
    let about = "Where the colours of differences end.";
    let chosen = segmented_row_ui(ui, "Range", about, range.end, &ends);
    let mut wanted = DifferenceRange { end: chosen.unwrap_or(range.end), ..range };
    let about =
        "The difference in linear luminance that has the last colour. The legend in the picture can be dragged, too.";
    row_ui(ui, "Ends at", about, |ui| {
        let mut typed = end;
        let drag = DragValue::new(&mut typed)
            .speed(f64::from(end) * 0.01)
            .custom_formatter(|x, _| crate::export::words::brief(x));
        let width = ui.available_width() - 58.0;
        if number_within_ui(ui, width, ENDS, drag, "End of the range", about) {
            wanted.end = RangeEnd::Fixed(typed);
        }
        let reset = ui.add_enabled(range != DifferenceRange::default(), egui::Button::new("Reset"));
        if reset.accessible_name("Reset the range").on_hover_text("As at first: by the exposure, root.").clicked() {
            wanted = DifferenceRange::default();
        }
    });
    let log = format!("By the logarithm, over {DECADES} decades.");
    let curves = [
        (RangeCurve::Root, "Root", "By the square root: small differences are seen beside large ones."),
        (RangeCurve::Linear, "Linear", "Twice the difference, twice as far along the colours."),
        (RangeCurve::Logarithmic, "Log", &log),
    ];
    let about = "How the range is divided among the colours.";
    wanted.curve = segmented_row_ui(ui, "Steps", about, wanted.curve, &curves).unwrap_or(wanted.curve);
    let differences = settings.shown_panes().iter().filter(|content| content.is_difference()).count();
    if range.end == RangeEnd::Automatic && differences > 1 {
        row_ui(ui, "", "", |ui| {
            let text = "Same in all panes";
            ui.checkbox(&mut wanted.is_shared, text)
                .on_hover_text("One range for every difference, so that panes compare.");
        });
    }
    if wanted != range {
        commands.push(Command::SetDifferenceRange(wanted));
    }
}
