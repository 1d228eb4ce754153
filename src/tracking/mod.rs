//! The modes: ways to know, at a crossing of a refractor's surface, which medium is left and which is entered.
//!
//! A mode is a file with its [`Tracker`], which is declared and registered here.

pub mod declared;
pub mod events;
pub mod naive;
pub mod prepare;
pub mod priority;
pub mod rectified;
pub mod rectified_object;
pub mod reference;
pub mod stack;
pub mod tracker;

use std::fmt;
use std::str::FromStr;

pub use events::Events;
pub use prepare::{PrepareError, PrepareSeconds, Prepared, prepare, prepare_watched};
pub use tracker::{Crossing, Sides, Tracker, TrackingMode, WithTracker};

/// Declares [`Mode`], and which tracker stands for each.
macro_rules! modes {
    ($($(#[$doc:meta])* $mode:ident: $tracker:ty,)*) => {
        /// A way of tracking media. Declared in the order in which they deserve trust.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Mode {
            $($(#[$doc])* $mode,)*
        }

        impl Mode {
            pub const ALL: [Self; [$(Self::$mode),*].len()] = [$(Self::$mode),*];

            /// The name used on the command line, in JSON and on labels.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$mode => <$tracker as TrackingMode<'_>>::NAME,)*
                }
            }

            /// Whether it looks up what rectification found, whose time then counts as the mode's own.
            pub fn is_rectified(self) -> bool {
                match self {
                    $(Self::$mode => <$tracker as TrackingMode<'_>>::IS_RECTIFIED,)*
                }
            }

            /// All names, for help and errors.
            pub fn list() -> String {
                Self::ALL.map(Self::name).join(", ")
            }

            /// One sentence for tooltips and help.
            pub fn about(self) -> &'static str {
                match self {
                    $(Self::$mode => <$tracker as TrackingMode<'_>>::ABOUT,)*
                }
            }
        }

        impl Prepared {
            /// Does `task` with the tracker of `mode`.
            pub fn with_tracker<W: WithTracker>(&self, mode: Mode, task: W) -> W::Output {
                match mode {
                    $(Mode::$mode => task.run(&<$tracker as TrackingMode<'_>>::of(self)),)*
                }
            }
        }
    };
}

modes! {
    /// The exterior is always vacuum.
    Naive: naive::Naive,
    /// Both sides as the scene declares them; no state per path.
    Declared: declared::Declared,
    /// A stack of the media entered so far.
    Stack: stack::Stack,
    /// A list of the refractors entered so far, ordered by their priorities.
    Priority: priority::Priority<'_>,
    /// IOR rectification with one stored exterior per object; no state per path.
    RectifiedObject: rectified_object::RectifiedObject,
    /// The stored answer of IOR rectification; no state per path.
    Rectified: rectified::Rectified<'_>,
    /// Containment asked anew on both sides of every hit: slow, the truth that the others are measured against.
    Reference: reference::Reference<'_>,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|mode| mode.name() == text)
            .ok_or_else(|| format!("unknown mode `{text}`; valid modes: {}", Self::list()))
    }
}
