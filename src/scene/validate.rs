//! Whether a scene in memory could come from a file: what readers of scene files demand of it, in the same words.

use super::description::Description;
use super::error::Fault;
use super::fields::{Field, IOR, Limits, Slot, Visitor};
use crate::optics::{Ior, medium};

/// Looks at one table of a scene, which `fields` goes through. `kind` is its key, such as `medium` or `refractor`, and `description` is the
/// scene with the table in it.
///
/// # Errors
/// Names the first key that is to blame.
pub fn table(
    description: &Description,
    kind: &'static str,
    fields: impl FnOnce(&mut dyn Visitor),
) -> Result<(), Fault> {
    let mut checker = Checker { description, kind, fault: None };
    fields(&mut checker);
    checker.fault.map_or(Ok(()), Err)
}

/// Looks at a whole scene.
///
/// # Errors
/// Names the first key that is to blame.
pub fn description(description: &Description) -> Result<(), Fault> {
    let Description { name: _, camera, camera_medium, world, environment, media, objects, source: _ } = description;
    for medium in media {
        table(description, "medium", |v| super::tables::medium_fields(&mut medium.clone(), v))?;
    }
    for object in objects.iter() {
        table(description, object.kind().name(), |v| object.clone().fields(v))?;
    }
    table(description, "camera", |v| { *camera }.fields_in(&mut camera_medium.clone(), v))?;
    table(description, "world", |v| world.clone().fields(v))?;
    table(description, "environment", |v| environment.clone().fields(v))
}

/// Why a name is refused, whatever other names there are; `kind` as for [`table`].
pub fn reserved_name(name: &str, kind: &str) -> Option<String> {
    matches!(name, medium::WORLD | medium::VACUUM)
        .then(|| format!("`{name}` is a reserved name; call the {kind} something else"))
}

/// Why a name is refused that a table of the kind `other` has already.
pub fn duplicate_name(name: &str, kind: &str, other: &str) -> String {
    match kind {
        "medium" => format!("there are two media called `{name}`; names must be unique"),
        _ => format!("there is already a {other} called `{name}`; names of objects must be unique"),
    }
}

struct Checker<'a> {
    description: &'a Description,
    kind: &'static str,
    /// The first.
    fault: Option<Fault>,
}

impl Checker<'_> {
    fn name(&self, name: &str) -> Result<(), String> {
        require_words("name", name)?;
        if let Some(message) = reserved_name(name, self.kind) {
            return Err(message);
        }
        let Description { media, objects, .. } = self.description;
        let (count, other) = if self.kind == "medium" {
            (media.iter().filter(|medium| medium.name == name).count(), self.kind)
        } else {
            let mut same = objects.iter().filter(|object| object.name == name).map(|object| object.kind().name());
            (same.clone().count(), same.next().unwrap_or(self.kind))
        };
        if count > 1 { Err(duplicate_name(name, self.kind, other)) } else { Ok(()) }
    }

    fn medium(&self, name: &str) -> Result<(), String> {
        require_words("medium", name)?;
        match self.description.medium(name) {
            Some(_) => Ok(()),
            None => Err(format!("the scene has no medium `{name}`")),
        }
    }

    fn slot(&mut self, key: &'static str, slot: Slot<'_>) -> Result<(), String> {
        let each = |numbers: &[f64], limits: Limits| {
            let name = |i: usize| format!("element {} of `{key}`", i + 1);
            // As readers: first whether they are numbers.
            (numbers.iter().enumerate()).try_for_each(|(i, &x)| super::fields::ANY.require(&name(i), x))?;
            (numbers.iter().enumerate()).try_for_each(|(i, &x)| limits.require(&name(i), x))
        };
        match slot {
            Slot::Flag(_) | Slot::Integer(_) | Slot::Count(_) => Ok(()),
            Slot::Maybe(None, _) | Slot::PartName(None) | Slot::MaybeMedium(None) => Ok(()),
            Slot::PartName(Some(name)) => require_words(key, name),
            Slot::Number(value, limits) | Slot::Maybe(Some(value), limits) => {
                limits.require(&format!("`{key}`"), *value)
            }
            Slot::Numbers(value, limits) => each(value, limits),
            Slot::Pair(value, limits) | Slot::Both(value, limits) => each(value, limits),
            Slot::Vector(value) | Slot::Scale(value) => each(&value.to_array(), super::fields::ANY),
            Slot::Points(points) => points.iter().flatten().zip(0..).try_for_each(|(&x, i)| {
                let name = format!("element {} of element {} of `{key}`", i % 2 + 1, i / 2 + 1);
                super::fields::ANY.require(&name, x)
            }),
            Slot::Ior(ior) => require_ior(ior),
            Slot::Name(name) => self.name(name),
            Slot::MaybeMedium(Some(name)) if name == medium::WORLD => Ok(()),
            Slot::Medium(name) | Slot::MaybeMedium(Some(name)) => self.medium(name),
            Slot::Mesh { path, .. } | Slot::Image { path, .. } | Slot::Texture { path, .. } => {
                require_words(key, &path.to_string_lossy())
            }
            Slot::Table(fields) => {
                fields(self);
                Ok(())
            }
        }
    }
}

/// A text with something in it.
fn require_words(key: &str, text: &str) -> Result<(), String> {
    if text.trim().is_empty() { Err(format!("`{key}` is empty")) } else { Ok(()) }
}

fn require_ior(ior: &Ior) -> Result<(), String> {
    let numbers: &[f64] = match ior {
        Ior::Constant(n) => return IOR.require("`ior`", *n),
        Ior::Cauchy(coefficients) => coefficients,
        Ior::Sellmeier(terms) => terms.as_flattened(),
        Ior::Gas(_) | Ior::Catalog(_) => &[],
    };
    if numbers.iter().any(|x| !x.is_finite()) {
        return Err("the formula's coefficients must be finite".to_owned());
    }
    if matches!(ior, Ior::Sellmeier(terms) if terms.is_empty()) {
        return Err("`sellmeier` is empty, must be one or more pairs [B, C]".to_owned());
    }
    IOR.require_of_formula(ior.ior())
}

impl Visitor for Checker<'_> {
    fn field(&mut self, Field { key, slot, .. }: Field<'_>) -> bool {
        if self.fault.is_none()
            && let Err(message) = self.slot(key, slot)
        {
            self.fault.get_or_insert(Fault { key, message });
        }
        true
    }

    fn check(&mut self, check: &dyn Fn() -> Result<(), Fault>) {
        if self.fault.is_none() {
            self.fault = check().err();
        }
    }
}
