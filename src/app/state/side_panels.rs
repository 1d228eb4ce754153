//! Which of the side panels are shown. A window that is too narrow for both shows one at a time, and a rail at either side to reach
//! each of them.

use super::State;
use crate::app::settings::{SidePanel, Tab};

/// What room the window has for side panels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Room {
    /// Both stand beside the pictures.
    #[default]
    Both,
    /// One stands beside them.
    One,
    /// One lies over them.
    Over,
}

impl State {
    pub fn room(&self) -> Room {
        self.room
    }

    /// Says what room the window has now.
    pub fn set_room(&mut self, room: Room) {
        if room != self.room && room == Room::Over {
            // A panel that comes to lie over the pictures has not been asked for.
            self.settings.has_narrow_panel = false;
        }
        self.room = room;
    }

    /// Whether a panel is to be seen.
    pub fn has_panel(&self, panel: SidePanel) -> bool {
        let settings = &self.settings;
        match (self.room, panel) {
            (Room::Both, SidePanel::Scene) => settings.show_scene_panel,
            (Room::Both, SidePanel::Render) => settings.show_render_panel,
            (Room::One | Room::Over, _) => settings.has_narrow_panel && settings.narrow_panel == panel,
        }
    }

    pub(super) fn toggle_panel(&mut self, panel: SidePanel) {
        self.set_panel(panel, !self.has_panel(panel));
    }

    pub(super) fn toggle_panels(&mut self) {
        if self.room == Room::Both {
            let show = !(self.settings.show_scene_panel || self.settings.show_render_panel);
            self.settings.show_scene_panel = show;
            self.settings.show_render_panel = show;
        } else {
            self.settings.has_narrow_panel ^= true;
        }
    }

    pub(super) fn show_tab(&mut self, tab: Tab) {
        self.settings.tab = tab;
        self.set_panel(SidePanel::Render, true);
    }

    fn set_panel(&mut self, panel: SidePanel, is_shown: bool) {
        match (self.room, panel) {
            (Room::Both, SidePanel::Scene) => self.settings.show_scene_panel = is_shown,
            (Room::Both, SidePanel::Render) => self.settings.show_render_panel = is_shown,
            (Room::One | Room::Over, _) => {
                self.settings.narrow_panel = panel;
                self.settings.has_narrow_panel = is_shown;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::command::Command;
    use crate::app::settings::Settings;

    fn shown(state: &State) -> [bool; 2] {
        [SidePanel::Scene, SidePanel::Render].map(|panel| state.has_panel(panel))
    }

    #[test]
    fn every_panel_can_be_brought_up_and_put_away_in_every_room() {
        for room in [Room::Both, Room::One, Room::Over] {
            let scene = crate::formats::open(crate::formats::builtin::DEFAULT).expect("a built-in scene");
            let mut state = State::new(Arc::new(scene), Settings::default());
            state.set_room(room);
            for (command, index) in [(Command::ToggleScenePanel, 0), (Command::ToggleRenderPanel, 1)] {
                let before = shown(&state)[index];
                state.apply(command.clone(), 0.0);
                assert_eq!(shown(&state)[index], !before, "{room:?}");
                state.apply(command, 0.0);
                assert_eq!(shown(&state)[index], before, "{room:?}");
            }
            state.apply(Command::ShowTab(Tab::Measure), 0.0);
            assert!(state.has_panel(SidePanel::Render), "a tab brings its panel: {room:?}");
            if room != Room::Both {
                assert_eq!(shown(&state), [false, true], "one at a time");
            }
            state.apply(Command::ToggleBothPanels, 0.0);
            assert_eq!(shown(&state), [false; 2], "{room:?}");
            state.apply(Command::ToggleBothPanels, 0.0);
            assert!(shown(&state)[1], "{room:?}");
        }
    }
}
