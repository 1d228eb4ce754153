//! Changes to media.

use super::EditKey;
use crate::app::command::MediumRef;
use crate::app::objects::replaced;
use crate::optics::{Ior, Medium};
use crate::scene::description::WorldMedium;
use crate::scene::tables::medium_fields;
use crate::scene::{Description, Fault, validate};

/// A change to one medium.
#[derive(Debug, Clone, PartialEq)]
pub enum MediumEdit {
    Ior(Ior),
    /// σ per scene unit for red, green and blue.
    Absorption([f64; 3]),
}

impl MediumEdit {
    pub(super) fn key(&self, medium: &MediumRef) -> EditKey {
        let name = medium.name();
        EditKey::continuous(match self {
            Self::Ior(_) => format!("IOR of {name}"),
            Self::Absorption(_) => format!("absorption of {name}"),
        })
    }

    /// Whether something changed.
    pub(super) fn apply(&self, medium: &MediumRef, edited: &mut Description) -> Result<bool, Fault> {
        let Some((ior, absorption)) = optics_of(edited, medium) else { return Ok(false) };
        let is_changed = match self {
            Self::Ior(new) => replaced(ior, new.clone()),
            Self::Absorption(new) => replaced(absorption, *new),
        };
        match medium {
            MediumRef::World => validate::table(edited, "world", |v| edited.world.clone().fields(v))?,
            MediumRef::Named(name) => {
                let mut medium = edited.medium(name).cloned().unwrap_or_else(crate::scene::tables::blank_medium);
                validate::table(edited, "medium", |v| medium_fields(&mut medium, v))?;
            }
        }
        Ok(is_changed)
    }
}

/// `None` if there is no such medium.
pub fn ior_of<'a>(description: &'a Description, medium: &MediumRef) -> Option<&'a Ior> {
    match medium {
        MediumRef::World => Some(&description.world.ior),
        MediumRef::Named(name) => description.medium(name).map(|m| &m.ior),
    }
}

fn optics_of<'a>(description: &'a mut Description, medium: &MediumRef) -> Option<(&'a mut Ior, &'a mut [f64; 3])> {
    match medium {
        MediumRef::World => {
            let WorldMedium { ior, absorption } = &mut description.world;
            Some((ior, absorption))
        }
        MediumRef::Named(name) => {
            let Medium { ior, absorption, .. } = description.media.iter_mut().find(|m| m.name == *name)?;
            Some((ior, absorption))
        }
    }
}
