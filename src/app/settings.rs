//! What is remembered from one session to the next.

mod content;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use self::content::{DifferenceKind, PaneContent, Preset};
use super::first_panes;
use super::measurement::{ErrorAxis, ErrorMetric};
use super::objects::Manipulation;
use super::range::DifferenceRange;
use crate::render::slice::SLICED_MODES;
use crate::render::surfaces::SurfaceQuantity;
use crate::render::{BackendChoice, Display, EstimatorChoice};
use crate::scene::Description;
use crate::tracking::Mode;

/// Most panes that can be shown.
pub const MAX_PANES: usize = 4;
/// Mean relative error of a pixel at which rendering stops, unless told otherwise.
pub const DEFAULT_NOISE_TARGET: f64 = 0.01;
/// Recent files that are remembered.
const MAX_RECENT: usize = 10;

/// How panes share the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arrangement {
    /// Side by side.
    Tiles,
    /// Over each other, parted by a divider that can be dragged.
    Wipe,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    System,
    Dark,
    Light,
}

/// The tabs of the right panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tab {
    Render,
    Rectification,
    Inspector,
    Measure,
}

/// The panels at the sides of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SidePanel {
    Scene,
    Render,
}

/// Size of text and controls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum InterfaceScale {
    /// From the size of the screen and of the window.
    Automatic,
    Factor(f32),
}

impl InterfaceScale {
    /// The factors to choose from.
    pub const FACTORS: [f32; 9] = [0.75, 0.875, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0];
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    pub pane_count: usize,
    pub panes: [PaneContent; MAX_PANES],
    pub arrangement: Arrangement,
    pub display: Display,
    pub difference: DifferenceKind,
    /// How differences in luminance are mapped to colours.
    pub difference_range: DifferenceRange,
    /// What the measure panel plots.
    pub error_metric: ErrorMetric,
    pub error_axis: ErrorAxis,
    /// Whether the values of the pixel under the pointer are shown.
    pub show_values: bool,
    /// Whether the panel has the histogram of the active pane.
    pub show_histogram: bool,
    /// Film pixels per screen pixel, each way.
    pub resolution_scale: f32,
    pub max_depth: Option<u32>,
    pub sample_limit: Option<u32>,
    /// Mean relative error of a pixel at which rendering stops; `None`: only the limit of samples counts.
    pub noise_target: Option<f64>,
    /// How light is transported.
    pub estimator: EstimatorChoice,
    /// What renders.
    pub backend: BackendChoice,
    /// Whether noise is smoothed away in what is displayed.
    pub denoise: bool,
    pub theme: Theme,
    pub interface_scale: InterfaceScale,
    pub show_scene_panel: bool,
    pub show_render_panel: bool,
    /// The panel that a window which has no room for both shows, or showed last, and whether it does.
    pub narrow_panel: SidePanel,
    pub has_narrow_panel: bool,
    pub show_problems: bool,
    pub tab: Tab,
    /// What can be dragged on the selected object in the picture.
    pub handles: Option<Manipulation>,
    /// Where tev listens: `HOST:PORT`; empty for its usual address.
    pub tev_address: String,
    /// Whether built-in scenes choose what the panes show.
    pub has_first_panes: bool,
    /// Whether the next start shows the tour.
    pub show_tour: bool,
    /// Paths, latest first.
    pub recent: Vec<String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            pane_count: 4,
            panes: Preset::StackAgainstRectified.panes(),
            arrangement: Arrangement::Tiles,
            display: Display::default(),
            difference: DifferenceKind::default(),
            difference_range: DifferenceRange::default(),
            error_metric: ErrorMetric::default(),
            error_axis: ErrorAxis::default(),
            show_values: true,
            show_histogram: false,
            resolution_scale: 1.0,
            max_depth: None,
            sample_limit: Some(4096),
            noise_target: Some(DEFAULT_NOISE_TARGET),
            estimator: EstimatorChoice::default(),
            backend: BackendChoice::default(),
            denoise: false,
            theme: Theme::Dark,
            interface_scale: InterfaceScale::Automatic,
            show_scene_panel: true,
            show_render_panel: true,
            narrow_panel: SidePanel::Scene,
            has_narrow_panel: true,
            show_problems: true,
            tab: Tab::Render,
            handles: Some(Manipulation::Move),
            tev_address: String::new(),
            has_first_panes: true,
            show_tour: false,
            recent: Vec::new(),
        }
    }
}

impl Settings {
    /// Those of the very first start: with the tour.
    pub fn of_first_start() -> Self {
        Self { show_tour: true, ..Self::default() }
    }

    /// Brings what came from an older or damaged file back into range.
    #[must_use]
    pub fn repaired(mut self) -> Self {
        if ![1, 2, 4].contains(&self.pane_count) {
            self.pane_count = 4;
        }
        if !self.display.exposure.is_finite() {
            self.display.exposure = 0.0;
        }
        if !(self.resolution_scale > 0.05 && self.resolution_scale <= 4.0) {
            self.resolution_scale = 1.0;
        }
        if let InterfaceScale::Factor(factor) = self.interface_scale
            && !(0.5..=4.0).contains(&factor)
        {
            self.interface_scale = InterfaceScale::Automatic;
        }
        // Pictures are kept for one session.
        self.panes = self.panes.map(PaneContent::without_snapshots);
        self.difference_range = self.difference_range.repaired();
        self.max_depth = self.max_depth.map(|depth| depth.max(1));
        self.sample_limit = self.sample_limit.map(|limit| limit.max(1));
        self.noise_target = self.noise_target.filter(|target| (1e-6..=1.0).contains(target));
        self.recent.truncate(MAX_RECENT);
        self
    }

    /// Shows what a built-in scene is about, unless the user wants to choose the panes.
    pub fn take_first_panes(&mut self, description: &Description) {
        if let Some(first) = first_panes::of(description).filter(|_| self.has_first_panes) {
            (self.pane_count, self.panes) = (first.len(), first);
        }
    }

    pub fn shown_panes(&self) -> &[PaneContent] {
        &self.panes[..self.pane_count]
    }

    /// The distinct modes that the panes need, in the order of [`Mode::ALL`].
    pub fn modes(&self) -> Vec<Mode> {
        let needed: Vec<Mode> = self.shown_panes().iter().flat_map(|content| content.modes()).collect();
        Mode::ALL.into_iter().filter(|mode| needed.contains(mode)).collect()
    }

    /// The distinct quantities by which the panes need surfaces painted.
    pub fn surfaces(&self) -> Vec<SurfaceQuantity> {
        let is_shown = |quantity| self.shown_panes().contains(&PaneContent::Surfaces(quantity));
        SurfaceQuantity::ALL.into_iter().filter(|quantity| is_shown(*quantity)).collect()
    }

    /// The distinct modes by which the panes need slices cut.
    pub fn slices(&self) -> Vec<Mode> {
        let is_shown = |mode| self.shown_panes().contains(&PaneContent::Slice(mode));
        SLICED_MODES.into_iter().filter(|mode| is_shown(*mode)).collect()
    }

    /// Puts a file at the head of the recent ones. Settings are text: a path that is none is not remembered.
    pub fn remember(&mut self, path: &Path) {
        let Some(path) = path.to_str() else { return };
        self.recent.retain(|known| known != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(MAX_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::range::RangeEnd;
    use crate::app::snapshots::SnapshotId;

    #[test]
    fn modes_are_distinct_and_ordered() {
        let mut settings = Settings { pane_count: 4, ..Settings::default() };
        settings.panes = [
            PaneContent::Mode(Mode::Rectified),
            PaneContent::Difference(Mode::Naive, Mode::Rectified),
            PaneContent::Mode(Mode::Naive),
            PaneContent::Mode(Mode::Rectified),
        ];
        assert_eq!(settings.modes(), [Mode::Naive, Mode::Rectified]);
        let modes = Mode::ALL.len();
        assert_eq!(PaneContent::differences().count(), modes * (modes - 1) / 2);
    }

    #[test]
    fn recent_files_are_distinct_and_few() {
        let mut settings = Settings::default();
        (0..20).for_each(|i| settings.remember(Path::new(&format!("{i}.toml"))));
        settings.remember(Path::new("15.toml"));
        assert_eq!(settings.recent.len(), MAX_RECENT);
        assert_eq!(&settings.recent[..2], ["15.toml", "19.toml"]);
        assert_eq!(settings.recent.iter().filter(|path| *path == "15.toml").count(), 1);
    }

    #[test]
    fn impossible_settings_are_repaired() {
        let broken = Settings {
            pane_count: 3,
            resolution_scale: f32::NAN,
            max_depth: Some(0),
            interface_scale: InterfaceScale::Factor(90.0),
            panes: [PaneContent::Change(Mode::Naive, SnapshotId::B); MAX_PANES],
            difference_range: DifferenceRange { end: RangeEnd::Fixed(f32::NAN), ..DifferenceRange::default() },
            ..Settings::default()
        }
        .repaired();
        assert_eq!((broken.pane_count, broken.resolution_scale, broken.max_depth), (4, 1.0, Some(1)));
        assert_eq!(broken.panes, [PaneContent::Mode(Mode::Naive); MAX_PANES]);
        assert_eq!(broken.difference_range, DifferenceRange::default());
        assert_eq!(broken.interface_scale, InterfaceScale::Automatic);
    }
}
