//! The list of the modes.

use std::fmt;
use std::str::FromStr;

use super::naive::Naive;
use super::prepare::Prepared;
use super::priority::Priority;
use super::rectified::Rectified;
use super::rectified_object::RectifiedObject;
use super::reference::Reference;
use super::stack::Stack;
use super::tracker::{TrackingMode, WithTracker};

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
    Naive: Naive,
    /// A stack of the media entered so far.
    Stack: Stack,
    /// A list of the refractors entered so far, ordered by their priorities.
    Priority: Priority<'_>,
    /// IOR rectification with one stored exterior per object; no state per path.
    RectifiedObject: RectifiedObject,
    /// The stored answer of IOR rectification; no state per path.
    Rectified: Rectified<'_>,
    /// Containment asked anew on both sides of every hit: slow, the truth that the others are measured against.
    Reference: Reference<'_>,
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
            .ok_or_else(|| format!("unknown mode `{text}`; valid modes: {}", Self::ALL.map(Self::name).join(", ")))
    }
}
