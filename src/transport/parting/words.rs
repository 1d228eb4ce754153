//! Partings in plain sentences.

use std::fmt;

use super::{Cause, Claim, Fault, MediumWord, Mistake, Parting};
use crate::tracking::Mode;

impl fmt::Display for MediumWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ior = format!("{:.4}", self.ior);
        let ior = ior.trim_end_matches('0').trim_end_matches('.');
        match &self.name[..] {
            "world" => write!(f, "the world (IOR {ior})"),
            "vacuum" => f.write_str("vacuum (IOR 1)"),
            name => write!(f, "{name} (IOR {ior})"),
        }
    }
}

impl Fault {
    /// What the mode takes and what is so, in one sentence: "stack took the world (IOR 1) outside ball; it is water (IOR 1.333)."
    pub fn what(&self) -> String {
        let Self { mode, surface, .. } = self;
        match &self.mistake {
            Mistake::Outside { took, is } => format!("{mode} took {took} outside {surface}; it is {is}."),
            Mistake::Inside { took, is } => format!("{mode} took {took} inside {surface}; it is {is}."),
            Mistake::Before { took, is } => format!("{mode} took {took} before {surface}; it is {is}."),
            Mistake::Missed { from, to } => {
                format!("{mode} saw no interface at {surface}; it lies between {from} and {to}.")
            }
            Mistake::Invented { from, to, is } => {
                format!("{mode} took {surface} for an interface from {from} to {to}; on both sides is {is}.")
            }
        }
    }

    /// Why, in one sentence.
    pub fn why(&self) -> String {
        self.cause.sentence(self.mode)
    }

    /// Both.
    pub fn sentence(&self) -> String {
        format!("{} {}", self.what(), self.why())
    }
}

impl Parting {
    /// What is wrong at this place, a sentence for each mode that is.
    pub fn heading(&self) -> String {
        let what: Vec<String> = self.faults.iter().flatten().map(Fault::what).collect();
        if what.is_empty() { self.sentence() } else { what.join(" ") }
    }

    /// What is wrong at this place and why, a sentence or two for each mode that is.
    pub fn sentence(&self) -> String {
        let faults: Vec<String> = self.faults.iter().flatten().map(Fault::sentence).collect();
        if faults.is_empty() {
            let [a, b] = &self.claims;
            return format!("At {}, {} sees {a} and {} sees {b}.", self.refractor, a.mode, b.mode);
        }
        faults.join(" ")
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.from, &self.to) {
            (Some(from), Some(to)) => write!(f, "{from} → {to}"),
            _ => f.write_str("no interface"),
        }
    }
}

impl Cause {
    /// What a mode that this misleads does, in a few words: "forgets that water and tumbler overlap".
    pub fn habit(&self) -> String {
        match self {
            Self::StartsInside { within } => match within.first() {
                Some(innermost) => format!("does not know that it starts in {innermost}"),
                None => "does not know where it starts".to_owned(),
            },
            Self::VacuumOutside => "takes everything outside for vacuum".to_owned(),
            Self::WrongDeclaration { refractor, declared } => {
                format!("believes that {} is outside {refractor}", with_article(declared))
            }
            Self::WrongStart { declared } => format!("believes that it starts in {}", with_article(declared)),
            Self::OneAnswerPerObject { refractor, .. } => format!("has one answer for all of {refractor}"),
            Self::Overlap { hidden, filler } => format!("forgets that {hidden} and {filler} overlap"),
            Self::EqualPriorities { a, b } => format!("cannot tell which fills both, {a} or {b}"),
            Self::SurfacesCoincide { a, b } => format!("cannot order {a} and {b}, which coincide"),
            Self::OpenSurface { refractor } => format!("counts wrong where {refractor} is open"),
            Self::Doubtful => "a doubtful place".to_owned(),
            Self::Unexplained => "not what reference finds".to_owned(),
        }
    }

    /// Why `mode` is wrong, in one sentence.
    pub fn sentence(&self, mode: Mode) -> String {
        match self {
            Self::StartsInside { within } => {
                format!("The path starts inside {}, which {mode} does not know.", list(within))
            }
            Self::VacuumOutside => format!("{mode} takes the outside of everything for vacuum."),
            Self::WrongDeclaration { refractor, declared } => {
                let declared = with_article(declared);
                format!("The scene declares {declared} outside {refractor}, or does so by saying nothing.")
            }
            Self::WrongStart { declared } => {
                let declared = with_article(declared);
                format!("The scene declares that the path starts in {declared}, or does so by saying nothing.")
            }
            Self::OneAnswerPerObject { refractor, outsides } => {
                let outsides = list(outsides);
                format!("{refractor} borders on {outsides} in different places; {mode} has one answer for all of it.")
            }
            Self::Overlap { hidden, filler } => {
                let habit = match mode {
                    Mode::Stack => "takes what was entered last",
                    _ => "does not know of overlaps",
                };
                format!("Where {hidden} and {filler} overlap, {filler} fills the volume; {mode} {habit}.")
            }
            Self::EqualPriorities { a, b } => {
                format!("{a} and {b} overlap with equal priorities; {mode} then takes what was entered last.")
            }
            Self::SurfacesCoincide { a, b } => {
                format!(
                    "The surfaces of {a} and {b} coincide here, and {mode} cannot know in which order to cross them."
                )
            }
            Self::OpenSurface { refractor } => {
                format!("The surface of {refractor} is open or crosses itself: entries and exits do not come in pairs.")
            }
            Self::Doubtful => "It is doubtful what contains this place.".to_owned(),
            Self::Unexplained => "The cause is not known.".to_owned(),
        }
    }
}

/// "the world", "water".
fn with_article(medium: &str) -> &str {
    if medium == "world" { "the world" } else { medium }
}

/// "a", "a and b", "a, b and c".
fn list(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
