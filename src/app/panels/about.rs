//! What this is, and its icon.

use egui::Context;

use crate::app::command::Command;
use crate::app::modal;
use crate::app::state::State;

pub fn show(ctx: &Context, state: &State, commands: &mut Vec<Command>) {
    let answer = modal::titled(ctx, "About iorect", state.windows.about, 380.0, |ui, _| {
        ui.label(format!("Version {}", env!("CARGO_PKG_VERSION")));
        ui.add_space(6.0);
        ui.label(
                "Renders scenes in which dielectrics sit inside dielectrics. Every object has the index of refraction of its \
                 own interior; what lies on the other side of each surface is found by tracing rays outward before rendering, \
                 and the ways of keeping track of media are shown side by side.",
            );
        ui.add_space(6.0);
        ui.weak("Licensed under MIT or Apache-2.0, at your option.");
    });
    if answer.is_closed {
        commands.push(Command::ShowAbout(false));
    }
}

/// The window's icon: a ball in a ball, the inner one refracting.
pub fn icon() -> egui::IconData {
    const SIDE: u32 = 64;
    let mut rgba = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let at = |c: u32| (f64::from(c) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
            let distance = |cx: f64, cy: f64| ((at(x) - cx).powi(2) + (at(y) - cy).powi(2)).sqrt();
            let (outer, inner) = (distance(0.0, 0.0), distance(0.18, 0.18));
            let coverage = ((0.95 - outer) * 32.0).clamp(0.0, 1.0);
            let color: [f64; 3] = if inner < 0.5 { [47.0, 192.0, 144.0] } else { [86.0, 180.0, 233.0] };
            let shade = 0.72 + 0.28 * (-(at(x) + at(y)) / 2.0);
            rgba.extend(color.map(|c| (c * shade) as u8));
            rgba.push((coverage * 255.0) as u8);
        }
    }
    egui::IconData { rgba, width: SIDE, height: SIDE }
}
