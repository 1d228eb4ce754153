//! The tour: five steps, each about one part of the window, which is framed while the step is shown.

use egui::{
    Align, Align2, Area, Button, Color32, Context, Frame, Id, Label, Layout, Margin, Order, Rect, RichText, Stroke,
    vec2,
};

use crate::app::command::Command;
use crate::app::state::State;
use crate::app::theme::{CLOSE_MARK, Palette};
use crate::app::widgets::note;

const WIDTH: f32 = 380.0;

/// A part of the window that a step is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    Pictures,
    ScenePanel,
    RenderPanel,
    Menus,
}

/// Says where a part of the window is in this frame.
pub fn mark(ctx: &Context, part: Part, rect: Rect) {
    let pass = ctx.cumulative_pass_nr();
    ctx.data_mut(|data| data.insert_temp(Id::unique(("tour", part)), (pass, rect)));
}

/// Where a part is; `None` while it is not shown.
fn place(ctx: &Context, part: Part) -> Option<Rect> {
    let (pass, rect) = ctx.data(|data| data.get_temp::<(u64, Rect)>(Id::unique(("tour", part))))?;
    (pass == ctx.cumulative_pass_nr()).then_some(rect)
}

struct Step {
    title: &'static str,
    text: &'static str,
    part: Part,
    action: Option<Action>,
}

/// A step's button: what it says, and what it does; disabled where that is nothing.
type Action = (&'static str, fn(&State) -> Vec<Command>);

const STEPS: [Step; 5] = [
    Step {
        title: "One scene, several answers",
        text: "Each picture shows the same scene from the same place. They differ in how they find out what lies on the other \
               side of a surface. The label names the way; the line below it says whether the picture is right.",
        part: Part::Pictures,
        action: None,
    },
    Step {
        title: "Why a picture is wrong",
        text: "Click a line that says “wrong here”, or any place in a picture. The path of the light through that pixel is \
               listed at the right, surface by surface, with the place where it goes wrong.",
        part: Part::Pictures,
        action: Some(("Show me", crate::app::viewport::show_first_wrong)),
    },
    Step {
        title: "Change an index of refraction",
        text: "The list at the left shows what was found to contain what. Drag a number, or type one: what lies outside each \
               surface is found again at once.",
        part: Part::ScenePanel,
        action: None,
    },
    Step {
        title: "Compare",
        text: "The panel at the right chooses what each picture shows, and how many there are. Wipe lays them over each other \
               with a divider to drag. Measure plots the error of each against time.",
        part: Part::RenderPanel,
        action: Some(("Wipe", |_| {
            vec![Command::SetPaneCount(2), Command::SetArrangement(crate::app::settings::Arrangement::Wipe)]
        })),
    },
    Step {
        title: "Your own scene",
        text: "File opens scenes, begins new ones and shows the built-in ones. Every edit can be undone, and pictures can be \
               saved as you see them. A question mark lists all keys.",
        part: Part::Menus,
        action: Some(("Built-in scenes", |_| vec![Command::ShowGallery(true)])),
    },
];

/// Steps of the tour.
pub const COUNT: usize = STEPS.len();

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let Some(index) = state.tour.filter(|index| *index < COUNT && state.has_scene) else { return };
    let step = &STEPS[index];
    let target = place(ctx, step.part);
    if let Some(rect) = target {
        paint_frame(ctx, rect);
    }
    let room = ctx.content_rect().shrink(12.0);
    let palette = Palette::of_context(ctx);
    let stroke = Stroke::new(1.0, palette.accent);
    Area::new(Id::unique("tour"))
        .order(Order::Foreground)
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(anchor(room))
        .constrain_to(room)
        .show(ctx, |ui| {
            Frame::window(ui.style()).inner_margin(Margin::symmetric(16, 12)).stroke(stroke).show(ui, |ui| {
                ui.set_width(WIDTH.min(room.width() - 34.0));
                ui.horizontal(|ui| {
                    ui.label(RichText::new(step.title).heading());
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let close = ui.button(CLOSE_MARK).on_hover_text("Close the tour; Help > Tour shows it again");
                        if close.accessible_name("Close the tour").clicked() {
                            commands.push(Command::ShowTour(None));
                        }
                    });
                });
                ui.add(Label::new(step.text).wrap());
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    ui.label(note(ui, format!("{} of {COUNT}", index + 1)));
                    if let Some((text, action)) = step.action {
                        let all = action(state);
                        if ui.add_enabled(!all.is_empty(), Button::new(text)).clicked() {
                            commands.extend(all);
                        }
                    }
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let is_last = index + 1 == COUNT;
                        let next = ui.button(if is_last { "Done" } else { "Next" });
                        if next.clicked() {
                            commands.push(Command::ShowTour((!is_last).then_some(index + 1)));
                        }
                        if ui.add_enabled(index > 0, Button::new("Back")).clicked() {
                            commands.push(Command::ShowTour(index.checked_sub(1)));
                        }
                    });
                });
            });
        });
}

/// The middle of the card's lower edge.
fn anchor(room: Rect) -> egui::Pos2 {
    room.center_bottom() - vec2(0.0, 30.0)
}

/// A frame around the part that the step is about.
fn paint_frame(ctx: &Context, rect: Rect) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Middle, Id::unique("tour frame")));
    let rect = rect.shrink(2.0);
    painter.rect_stroke(rect, 4.0, Stroke::new(4.0, Color32::from_black_alpha(110)), egui::StrokeKind::Inside);
    painter.rect_stroke(
        rect.shrink(1.0),
        4.0,
        Stroke::new(2.0, Palette::of_context(ctx).accent),
        egui::StrokeKind::Inside,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_short_plain_sentences() {
        for step in &STEPS {
            assert!(step.text.ends_with('.') && step.text.len() < 300, "{}", step.text);
            assert!(!step.title.ends_with('.') && step.title.len() < 40, "{}", step.title);
        }
    }
}
