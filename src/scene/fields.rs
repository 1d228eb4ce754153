//! The fields of a scene's tables, each said once: what reads scenes, writes them and takes their fingerprint goes through the same
//! lists, in [`super::tables`].

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use super::description::MeshPart;
use super::environment::EnvironmentImage;
use super::error::Fault;
use super::note::LoadNote;
use super::texture::TextureImage;
use crate::geometry::Mesh;
use crate::optics::{Ior, catalog};

/// Goes through the fields of a table in their order. A reader replaces the values by those that it finds, others look at them. Faults
/// are kept by the reader, so that a list of fields need not stop at the first.
pub trait Visitor {
    /// Says whether the field is there, which only a reader can deny: then the value is as before.
    fn field(&mut self, field: Field<'_>) -> bool;

    /// Which of several forms the table has, each known by its key: that of the value, for all but readers. `default` is taken where
    /// there is none.
    fn form(&mut self, _forms: &[&'static str], current: &'static str, _default: Option<&'static str>) -> &'static str {
        current
    }

    /// A key that other forms of the table have, and `why` this one must not.
    fn refuse(&mut self, _key: &'static str, _why: &str) {}

    /// What only several fields together show.
    fn check(&mut self, _check: &dyn Fn() -> Result<(), Fault>) {}
}

/// A field by its key.
pub struct Field<'a> {
    pub key: &'static str,
    pub slot: Slot<'a>,
    /// Whether it has the value that it has where the key is left out; `None` where the key must be there.
    pub is_default: Option<bool>,
}

/// Where a field's value stands, by its kind.
pub enum Slot<'a> {
    Flag(&'a mut bool),
    Integer(&'a mut i32),
    Count(&'a mut u32),
    Number(&'a mut f64, Limits),
    /// A number that may be left out.
    Maybe(&'a mut Option<f64>, Limits),
    Numbers(&'a mut [f64; 3], Limits),
    /// One number for both, or two.
    Both(&'a mut [f64; 2], Limits),
    Pair(&'a mut [f64; 2], Limits),
    Vector(&'a mut DVec3),
    /// One number for all axes, or three.
    Scale(&'a mut DVec3),
    /// (r, y) points.
    Points(&'a mut Vec<[f64; 2]>),
    Ior(&'a mut Ior),
    /// The name of the thing itself, unique among its kind.
    Name(&'a mut String),
    /// The name of a medium of the scene.
    Medium(&'a mut String),
    /// The name of a part of a mesh's file, which may be left out.
    PartName(&'a mut Option<String>),
    /// The name of a medium of the scene or `world`, which may be left out.
    MaybeMedium(&'a mut Option<String>),
    Mesh {
        path: &'a mut PathBuf,
        /// Keys beside this one name it.
        part: &'a mut MeshPart,
        mesh: &'a mut Arc<Mesh>,
        notes: &'a mut Vec<LoadNote>,
    },
    Image {
        path: &'a mut PathBuf,
        image: &'a mut Arc<EnvironmentImage>,
    },
    Texture {
        path: &'a mut PathBuf,
        image: &'a mut Arc<TextureImage>,
    },
    /// A table of its own.
    Table(&'a mut dyn FnMut(&mut dyn Visitor)),
}

/// The numbers that a field may have.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// How a number must be, in words that follow "must be".
    pub must: &'static str,
    pub is_fine: fn(f64) -> bool,
}

/// Any finite number.
pub const ANY: Limits = Limits { must: "finite", is_fine: f64::is_finite };
pub const NON_NEGATIVE: Limits = Limits { must: "0 or more", is_fine: |x| x >= 0.0 };
pub const POSITIVE: Limits = Limits { must: "greater than 0", is_fine: |x| x > 0.0 };
/// Shares, such as an albedo.
pub const SHARE: Limits = Limits { must: "between 0 and 1", is_fine: |x| (0.0..=1.0).contains(&x) };

/// Indices of refraction.
pub const IOR: Limits =
    Limits { must: "greater than 0 (from 1e-6 to 1e6)", is_fine: |n| crate::optics::ior::IOR_RANGE.contains(&n) };

impl Limits {
    /// # Errors
    /// When the number is not finite, or not as it must be. `name` is that of the value, in backticks where it is a key.
    pub fn require(&self, name: &str, number: f64) -> Result<(), String> {
        if !number.is_finite() {
            Err(format!("{name} is {number}, must be finite"))
        } else if !(self.is_fine)(number) {
            Err(format!("{name} is {number}, must be {}", self.must))
        } else {
            Ok(())
        }
    }

    /// [`Self::require`] of an index of refraction that a formula gives.
    ///
    /// # Errors
    /// When the index is not as it must be.
    pub fn require_of_formula(&self, n: f64) -> Result<(), String> {
        match (self.is_fine)(n) {
            true => Ok(()),
            false => Err(format!("the formula gives an IOR of {n} at 587.56 nm, must be {}", self.must)),
        }
    }
}

/// What a field can hold, other than names, files and tables.
pub trait Value: PartialEq {
    fn slot(&mut self, limits: Limits) -> Slot<'_>;
}

macro_rules! values {
    ($($type:ty: |$value:ident, $limits:pat_param| $slot:expr;)*) => {
        $(impl Value for $type {
            fn slot(&mut self, $limits: Limits) -> Slot<'_> {
                let $value = self;
                $slot
            }
        })*
    };
}

values! {
    bool: |value, _| Slot::Flag(value);
    i32: |value, _| Slot::Integer(value);
    u32: |value, _| Slot::Count(value);
    f64: |value, limits| Slot::Number(value, limits);
    Option<f64>: |value, limits| Slot::Maybe(value, limits);
    [f64; 3]: |value, limits| Slot::Numbers(value, limits);
    [f64; 2]: |value, limits| Slot::Pair(value, limits);
    DVec3: |value, _| Slot::Vector(value);
    Vec<[f64; 2]>: |value, _| Slot::Points(value);
    Ior: |value, _| Slot::Ior(value);
    Option<String>: |value, _| Slot::PartName(value);
}

impl dyn Visitor + '_ {
    /// A field that must be there.
    pub fn need(&mut self, key: &'static str, value: &mut impl Value, limits: Limits) -> &mut Self {
        self.slot(key, value.slot(limits))
    }

    /// A field that must be there, given by its slot.
    pub fn slot(&mut self, key: &'static str, slot: Slot<'_>) -> &mut Self {
        self.field(Field { key, slot, is_default: None });
        self
    }

    /// A field that is `default` where it is left out.
    pub fn optional<T: Value>(&mut self, key: &'static str, value: &mut T, default: T, limits: Limits) -> &mut Self {
        let is_default = Some(*value == default);
        if !self.field(Field { key, slot: value.slot(limits), is_default }) {
            *value = default;
        }
        self
    }

    /// GGX's α, one number for both ways along a surface or two, which is 0 where it is left out.
    pub fn roughness(&mut self, value: &mut [f64; 2]) -> &mut Self {
        let is_default = Some(*value == [0.0; 2]);
        if !self.field(Field { key: "roughness", slot: Slot::Both(value, SHARE), is_default }) {
            *value = [0.0; 2];
        }
        self
    }

    /// The name of a medium that may be left out.
    pub fn maybe_medium(&mut self, key: &'static str, value: &mut Option<String>) -> &mut Self {
        let is_default = Some(value.is_none());
        if !self.field(Field { key, slot: Slot::MaybeMedium(value), is_default }) {
            *value = None;
        }
        self
    }

    /// A table that must be there.
    pub fn table(&mut self, key: &'static str, mut fields: impl FnMut(&mut dyn Visitor)) -> &mut Self {
        self.slot(key, Slot::Table(&mut fields))
    }
}

/// A value as text files have it.
#[derive(Debug, Clone, PartialEq)]
pub enum Plain {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<Plain>),
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub key: &'static str,
    pub value: Plain,
    /// Whether it says no more than leaving out the key would.
    pub is_default: bool,
}

/// The entries of a table.
pub fn entries(fields: impl FnOnce(&mut dyn Visitor)) -> Vec<Entry> {
    struct Collector(Vec<Entry>);
    impl Visitor for Collector {
        fn field(&mut self, Field { key, slot, is_default }: Field<'_>) -> bool {
            if let Some(value) = slot.plain() {
                self.0.push(Entry { key, value, is_default: is_default == Some(true) });
            }
            true
        }
    }
    let mut collector = Collector(Vec::new());
    fields(&mut collector);
    collector.0
}

impl Slot<'_> {
    /// The value as text files have it; `None` where it is left out.
    pub fn plain(self) -> Option<Plain> {
        let numbers = |numbers: &[f64]| Plain::List(numbers.iter().copied().map(Plain::Number).collect());
        // With `/`, which is understood everywhere.
        let path = |path: &PathBuf| Plain::Text(path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/"));
        Some(match self {
            Self::Flag(value) => Plain::Flag(*value),
            Self::Integer(value) => Plain::Integer((*value).into()),
            Self::Count(value) => Plain::Integer((*value).into()),
            Self::Number(value, _) => Plain::Number(*value),
            Self::Maybe(value, _) => Plain::Number((*value)?),
            Self::Numbers(value, _) => numbers(&*value),
            Self::Both(value, _) if value[0] == value[1] => Plain::Number(value[0]),
            Self::Both(value, _) => numbers(&*value),
            Self::Pair(value, _) => numbers(&*value),
            Self::Scale(value) if value.x == value.y && value.y == value.z => Plain::Number(value.x),
            Self::Vector(value) | Self::Scale(value) => numbers(&value.to_array()),
            Self::Points(value) => Plain::List(value.iter().map(|point| numbers(point)).collect()),
            Self::Ior(value) => plain_ior(value),
            Self::PartName(value) => Plain::Text((*value).clone()?),
            Self::Name(value) | Self::Medium(value) => Plain::Text(value.clone()),
            Self::MaybeMedium(value) => Plain::Text(value.clone()?),
            Self::Mesh { path: value, .. } | Self::Image { path: value, .. } | Self::Texture { path: value, .. } => {
                path(value)
            }
            Self::Table(fields) => Plain::Table(entries(fields)),
        })
    }
}

fn plain_ior(ior: &Ior) -> Plain {
    let numbers = |numbers: &[f64]| Plain::List(numbers.iter().copied().map(Plain::Number).collect());
    let table = |key, value| Plain::Table(vec![Entry { key, value, is_default: false }]);
    let by_name = |entry: &catalog::Entry| table("catalog", Plain::Text(entry.name.to_owned()));
    match ior {
        Ior::Constant(n) => Plain::Number(*n),
        Ior::Cauchy(coefficients) => table("cauchy", numbers(coefficients)),
        Ior::Sellmeier(terms) => table("sellmeier", Plain::List(terms.iter().map(|term| numbers(term)).collect())),
        // Scene files have no notation for it: it is written by its name in the catalogue.
        Ior::Gas(_) => match catalog::ALL.iter().find(|entry| entry.model == *ior) {
            Some(entry) => by_name(entry),
            None => Plain::Number(ior.ior()),
        },
        Ior::Catalog(entry) => by_name(entry),
    }
}
