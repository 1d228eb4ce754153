//! What panes can show.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::MAX_PANES;
use crate::app::snapshots::SnapshotId;
use crate::render::surfaces::SurfaceQuantity;
use crate::tracking::Mode;

/// Panes that answer one question together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    StackAgainstRectified,
    BothRectified,
    AgainstReference,
    Surfaces,
    Slices,
}

impl Preset {
    pub const ALL: [Self; 5] =
        [Self::StackAgainstRectified, Self::BothRectified, Self::AgainstReference, Self::Surfaces, Self::Slices];

    pub fn name(self) -> &'static str {
        match self {
            Self::StackAgainstRectified => "Stack against rectified",
            Self::BothRectified => "Both rectified modes",
            Self::AgainstReference => "Against the reference",
            Self::Surfaces => "Surfaces",
            Self::Slices => "Slices",
        }
    }

    /// One sentence for tooltips.
    pub fn about(self) -> &'static str {
        match self {
            Self::StackAgainstRectified => {
                "What most renderers do, rectification, naive, and how far the first two are apart."
            }
            Self::BothRectified => {
                "One exterior for each object, one for each place on it, how far they are apart, and the surfaces by the medium outside."
            }
            Self::AgainstReference => {
                "Rectification and the slow truth, and how far rectification and priority are from it."
            }
            Self::Surfaces => "Everything that rectification found out about surfaces.",
            Self::Slices => "A plane through the scene, filled with the medium that each mode finds at each place.",
        }
    }

    pub fn panes(self) -> [PaneContent; MAX_PANES] {
        use PaneContent::{Difference, Mode as Film, Surfaces};
        match self {
            Self::StackAgainstRectified => {
                [Film(Mode::Stack), Film(Mode::Rectified), Film(Mode::Naive), Difference(Mode::Stack, Mode::Rectified)]
            }
            Self::BothRectified => [
                Film(Mode::RectifiedObject),
                Film(Mode::Rectified),
                Surfaces(SurfaceQuantity::Outside),
                Difference(Mode::RectifiedObject, Mode::Rectified),
            ],
            Self::AgainstReference => [
                Film(Mode::Rectified),
                Film(Mode::Reference),
                Difference(Mode::Priority, Mode::Reference),
                Difference(Mode::Rectified, Mode::Reference),
            ],
            Self::Surfaces => SurfaceQuantity::ALL.map(Surfaces),
            Self::Slices => [
                Film(Mode::Rectified),
                PaneContent::Slice(Mode::Rectified),
                PaneContent::Slice(Mode::RectifiedObject),
                PaneContent::Slice(Mode::Naive),
            ],
        }
    }
}

/// What a pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum PaneContent {
    Mode(Mode),
    /// The first less the second, in false colour.
    Difference(Mode, Mode),
    /// The mode less the ground truth, in false colour.
    Error(Mode),
    /// Surfaces in the colours of what rectification found about them.
    Surfaces(SurfaceQuantity),
    /// A picture that was kept.
    Snapshot(SnapshotId),
    /// The mode as it is now less a picture that was kept, in false colour.
    Change(Mode, SnapshotId),
    /// Snapshot A less snapshot B, in false colour.
    SnapshotDifference,
    /// A plane through the scene, filled with the medium that a mode finds at each place: one of [`SLICED_MODES`](crate::render::slice::SLICED_MODES).
    Slice(Mode),
}

impl PaneContent {
    /// The modes that must be rendered for it.
    pub fn modes(self) -> impl Iterator<Item = Mode> {
        let modes = match self {
            Self::Mode(mode) | Self::Error(mode) | Self::Change(mode, _) => [Some(mode), None],
            Self::Difference(a, b) => [Some(a), Some(b)],
            Self::Surfaces(_) | Self::Snapshot(_) | Self::SnapshotDifference | Self::Slice(_) => [None, None],
        };
        modes.into_iter().flatten()
    }

    /// The kept pictures that it shows.
    pub fn snapshots(self) -> impl Iterator<Item = SnapshotId> {
        let shown = match self {
            Self::Snapshot(id) | Self::Change(_, id) => [Some(id), None],
            Self::SnapshotDifference => SnapshotId::ALL.map(Some),
            Self::Mode(_) | Self::Difference(..) | Self::Error(_) | Self::Surfaces(_) | Self::Slice(_) => [None, None],
        };
        shown.into_iter().flatten()
    }

    /// What a pane shows instead where no pictures are kept.
    #[must_use]
    pub fn without_snapshots(self) -> Self {
        match self {
            Self::Change(mode, _) => Self::Mode(mode),
            Self::Snapshot(_) | Self::SnapshotDifference => Self::Mode(Mode::Rectified),
            other => other,
        }
    }

    /// The mode whose paths the inspector shows.
    pub fn inspected_mode(self) -> Mode {
        match self {
            Self::Mode(mode)
            | Self::Difference(mode, _)
            | Self::Error(mode)
            | Self::Change(mode, _)
            | Self::Slice(mode) => mode,
            // What is painted is what this mode looks up.
            Self::Surfaces(_) | Self::Snapshot(_) | Self::SnapshotDifference => Mode::Rectified,
        }
    }

    /// Whether it is a difference in false colour.
    pub fn is_difference(self) -> bool {
        matches!(self, Self::Difference(..) | Self::Error(_) | Self::Change(..) | Self::SnapshotDifference)
    }

    /// Every difference that can be shown, each pair once: the doubtful less the better.
    pub fn differences() -> impl Iterator<Item = Self> {
        let all = Mode::ALL;
        (0..all.len()).flat_map(move |a| (a + 1..all.len()).map(move |b| Self::Difference(all[a], all[b])))
    }
}

impl fmt::Display for PaneContent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mode(mode) => f.write_str(mode.name()),
            Self::Difference(a, b) => write!(f, "{} − {}", a.name(), b.name()),
            Self::Error(mode) => write!(f, "error of {}", mode.name()),
            Self::Surfaces(quantity) => write!(f, "{}", quantity.name()),
            Self::Snapshot(id) => write!(f, "snapshot {id}"),
            Self::Change(mode, id) => write!(f, "{mode} − snapshot {id}"),
            Self::SnapshotDifference => f.write_str("snapshot A − snapshot B"),
            Self::Slice(mode) => write!(f, "slice: {}", mode.name()),
        }
    }
}

/// How differences are coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum DifferenceKind {
    /// How far apart luminances are.
    #[default]
    Absolute,
    /// Which is brighter, too.
    Signed,
    /// What an eye sees when it flips between the displayed pictures.
    Flip,
}

impl DifferenceKind {
    pub const ALL: [Self; 3] = [Self::Absolute, Self::Signed, Self::Flip];

    pub fn name(self) -> &'static str {
        match self {
            Self::Absolute => "Absolute",
            Self::Signed => "Signed",
            Self::Flip => "FLIP",
        }
    }

    /// One sentence for tooltips.
    pub fn about(self) -> &'static str {
        match self {
            Self::Absolute => "How far apart luminances are, in one colour scale.",
            Self::Signed => "Blue where the first is darker, orange where it is brighter.",
            Self::Flip => {
                "What an eye sees when it flips between both pictures as they are displayed: 0 nothing, 1 all."
            }
        }
    }
}
