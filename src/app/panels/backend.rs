//! The choice of what renders: the graphics processor or the CPU.

use egui::{RichText, Ui};

use crate::app::command::Command;
use crate::app::state::{State, sentence};
use crate::app::theme::{Palette, WARNING_MARK};
use crate::app::widgets::{note, row_ui, segmented_where_ui};
use crate::render::BackendChoice;
use crate::session::GraphicsStatus;

const NAME: &str = "Backend";
const ABOUT: &str = "What renders the pictures. Mode reference is always rendered by the CPU.";

pub fn show(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let status = state.graphics.as_deref();
    let chosen = state.settings.backend;
    // One that has failed can be tried again.
    let none = status.filter(|status| status.fault.is_none()).and_then(|status| status.adapter.as_ref().err());
    let missing = none.filter(|_| chosen != BackendChoice::Gpu);
    let gpu = missing
        .map_or("Always the graphics processor. It does not split paths, so a sample is quicker but noisier.", |why| {
            why
        });
    let options = [
        (BackendChoice::Auto, "Automatic", "The graphics processor where it is real hardware and faster than the CPU."),
        (BackendChoice::Cpu, "CPU", "Always the CPU."),
        (BackendChoice::Gpu, "GPU", gpu),
    ];
    let clicked = row_ui(ui, NAME, ABOUT, |ui| {
        segmented_where_ui(ui, chosen, &options, |choice| choice != BackendChoice::Gpu || missing.is_none())
    });
    commands.extend(clicked.map(Command::SetBackend));
    let palette = Palette::of(ui);
    let fault = status.and_then(|status| status.fault.as_ref()).filter(|_| chosen != BackendChoice::Cpu);
    let text = match fault {
        Some(fault) => RichText::new(format!("{WARNING_MARK} {}", sentence(fault))).small().color(palette.warning),
        None => note(ui, words(status, chosen)),
    };
    ui.add(egui::Label::new(text).wrap());
}

/// What renders, and why not the graphics processor where it might.
fn words(status: Option<&GraphicsStatus>, chosen: BackendChoice) -> String {
    if chosen == BackendChoice::Cpu {
        return "The CPU renders.".into();
    }
    let Some(status) = status else { return "Looking for a graphics processor…".into() };
    match (&status.adapter, &status.reason) {
        (Ok(adapter), None) if status.is_used => format!("{} renders.", adapter.label),
        (_, Some(reason)) => format!("The CPU renders: {reason}."),
        (Ok(_), None) => "The CPU renders.".into(),
        (Err(why), None) => format!("The CPU renders: {why}."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::choice::KnownAdapter;

    #[test]
    fn it_is_said_what_renders_and_why() {
        let adapter = || KnownAdapter { label: "Card (Vulkan)".into(), is_software: false };
        let status = |is_used, reason: Option<&str>| GraphicsStatus {
            adapter: Ok(adapter()),
            is_used,
            reason: reason.map(str::to_owned),
            fault: None,
        };
        let auto = BackendChoice::Auto;
        assert!(words(None, auto).starts_with("Looking"));
        assert_eq!(words(Some(&status(true, None)), auto), "Card (Vulkan) renders.");
        assert_eq!(words(Some(&status(false, Some("it is slower"))), auto), "The CPU renders: it is slower.");
        assert_eq!(words(Some(&status(true, None)), BackendChoice::Cpu), "The CPU renders.");
        let none = GraphicsStatus { adapter: Err("there is none".into()), ..status(false, None) };
        assert_eq!(words(Some(&none), auto), "The CPU renders: there is none.");
    }
}
