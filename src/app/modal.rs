//! Windows over everything else: they take the focus when they open, keep it, and give it back when they are closed.

use egui::{Align, Context, Id, Layout, Margin, Modal, Response, RichText, ScrollArea, Ui};

use super::theme::CLOSE_MARK;

/// Where the focus was before a modal opened, and where in it the focus was last.
#[derive(Debug, Clone, Copy, Default)]
struct Focus {
    before: Option<Id>,
    inside: Option<Id>,
}

/// What became of a modal in this frame.
pub struct Answer<T> {
    /// What its contents returned; `None` while it is closed.
    pub inner: Option<T>,
    /// Whether the user has just closed it by clicking beside it or on its mark.
    pub is_closed: bool,
}

fn lasting_id() -> Id {
    Id::unique("lasting focus")
}

/// Remembers where the focus is, unless it is in a menu, which will be gone when a modal opened from it is closed. To be called at the
/// beginning of every frame, before modals are shown.
pub fn remember_focus(ctx: &Context) {
    let focused = ctx.memory(egui::Memory::focused);
    let layer = focused.and_then(|id| ctx.read_response(id)).map(|response| response.layer_id);
    let is_lasting = match layer {
        Some(layer) => layer.order == egui::Order::Background,
        // In a menu the focus may be nowhere.
        None => focused.is_none() && !egui::Popup::is_any_open(ctx),
    };
    if is_lasting {
        ctx.data_mut(|data| data.insert_temp(lasting_id(), focused));
    }
}

/// Shows `add` in a modal frame. To be called in every frame, also while `is_open` is false. `add` is told whether the modal has just
/// opened: then it gives the focus to what should have it.
pub fn show<T>(ctx: &Context, name: &str, is_open: bool, add: impl FnOnce(&mut Ui, bool) -> T) -> Answer<T> {
    let id = Id::unique(("modal", name));
    let known: Option<Focus> = ctx.data(|data| data.get_temp(id));
    if !is_open {
        if let Some(focus) = known {
            ctx.data_mut(|data| data.remove::<Focus>(id));
            ctx.memory_mut(|memory| match (focus.before, memory.focused()) {
                (Some(before), _) => memory.request_focus(before),
                (None, Some(focused)) => memory.surrender_focus(focused),
                (None, None) => {}
            });
        }
        return Answer { inner: None, is_closed: false };
    }
    let mut focus = known.unwrap_or_else(|| Focus {
        before: ctx.data(|data| data.get_temp::<Option<Id>>(lasting_id())).flatten(),
        inside: None,
    });
    let frame = egui::Frame::window(&ctx.style_of(ctx.theme())).inner_margin(Margin::same(16));
    let area = Modal::default_area(id).accessible_name(name);
    let shown = Modal::new(id).area(area).frame(frame).show(ctx, |ui| add(ui, known.is_none()));
    // Arrow keys look for the nearest control anywhere: those behind the modal are not for them.
    let focused = ctx.memory(egui::Memory::focused);
    let is_inside = |id: Id| {
        let response = ctx.read_response(id);
        response.is_some_and(|response| ctx.memory(|memory| memory.is_above_modal_layer(response.layer_id)))
    };
    if let Some(focused) = focused {
        if known.is_none() || is_inside(focused) {
            focus.inside = Some(focused);
        } else if let Some(inside) = focus.inside {
            ctx.memory_mut(|memory| memory.request_focus(inside));
        }
    }
    ctx.data_mut(|data| data.insert_temp(id, focus));
    Answer { inner: Some(shown.inner), is_closed: shown.backdrop_response.clicked() }
}

/// A modal with a title and a mark that closes it, `width` points wide where there is room; contents that are too high scroll.
pub fn titled<T>(
    ctx: &Context,
    title: &str,
    is_open: bool,
    width: f32,
    add: impl FnOnce(&mut Ui, bool) -> T,
) -> Answer<T> {
    let room = ctx.content_rect().size();
    let answer = show(ctx, title, is_open, |ui, is_opening| {
        ui.set_width((room.x - 60.0).min(width));
        let close = ui
            .horizontal(|ui| {
                ui.heading(title);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    ui.button(RichText::new(CLOSE_MARK).size(15.0))
                        .on_hover_text("Close (Esc)")
                        .accessible_name("Close")
                })
                .inner
            })
            .inner;
        if is_opening {
            close.request_focus();
        }
        ui.add_space(6.0);
        let height = room.y - 130.0;
        let area = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        let inner = scroll_ui(ui, area, |ui| add(ui, is_opening));
        (inner, close.clicked())
    });
    let (inner, is_clicked) = answer.inner.map_or((None, false), |(inner, is_clicked)| (Some(inner), is_clicked));
    Answer { inner, is_closed: answer.is_closed || is_clicked }
}

/// A scroll area that brings what gets the focus into view.
pub fn scroll_ui<T>(ui: &mut Ui, area: ScrollArea, add: impl FnOnce(&mut Ui) -> T) -> T {
    area.show(ui, |ui| {
        let inner = add(ui);
        scroll_to_focus(ui);
        inner
    })
    .inner
}

/// Scrolls to the control in `ui` that has just got the focus.
pub fn scroll_to_focus(ui: &Ui) {
    let focused: Option<Response> = ui.memory(egui::Memory::focused).and_then(|id| ui.ctx().read_response(id));
    let seen = ui.scope_id().with("focus");
    let before: Option<Id> = ui.data(|data| data.get_temp(seen)).flatten();
    ui.data_mut(|data| data.insert_temp(seen, focused.as_ref().map(|response| response.id)));
    if let Some(focused) = focused.filter(|focused| focused.layer_id == ui.layer_id() && before != Some(focused.id))
        && ui.min_rect().contains(focused.rect.center())
    {
        ui.scroll_to_rect(focused.rect.expand(4.0), None);
    }
}
