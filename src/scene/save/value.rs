//! Parts of a scene as TOML values.

use std::path::PathBuf;

use glam::DVec3;
use toml_edit::{Array, InlineTable, Value};

use crate::optics::{Ior, catalog};
use crate::scene::description::{Paint, Shape, Transform};
use crate::scene::shapes::{DEFAULT_RINGS, DEFAULT_SEGMENTS};

/// What can be written after `key =`.
pub(super) trait ToValue {
    fn to_value(&self) -> Value;
}

/// An inline table.
pub(super) fn inline<'a, T: ToValue + 'a>(entries: impl IntoIterator<Item = (&'a str, &'a T)>) -> Value {
    let mut table = InlineTable::new();
    for (key, value) in entries {
        table.insert(key, value.to_value());
    }
    Value::InlineTable(table)
}

/// An inline table of unlike values.
fn mixed<const N: usize>(entries: [(&str, Value); N]) -> Value {
    Value::InlineTable(entries.into_iter().collect())
}

impl ToValue for f64 {
    fn to_value(&self) -> Value {
        (*self).into()
    }
}

impl ToValue for i32 {
    fn to_value(&self) -> Value {
        i64::from(*self).into()
    }
}

impl ToValue for u32 {
    fn to_value(&self) -> Value {
        i64::from(*self).into()
    }
}

impl ToValue for bool {
    fn to_value(&self) -> Value {
        (*self).into()
    }
}

impl ToValue for String {
    fn to_value(&self) -> Value {
        self.as_str().into()
    }
}

/// With `/`, which is understood everywhere.
impl ToValue for PathBuf {
    fn to_value(&self) -> Value {
        self.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/").into()
    }
}

impl<T: ToValue, const N: usize> ToValue for [T; N] {
    fn to_value(&self) -> Value {
        self.as_slice().to_value()
    }
}

impl<T: ToValue> ToValue for Vec<T> {
    fn to_value(&self) -> Value {
        self.as_slice().to_value()
    }
}

impl<T: ToValue> ToValue for [T] {
    fn to_value(&self) -> Value {
        Value::Array(self.iter().map(ToValue::to_value).collect::<Array>())
    }
}

impl ToValue for DVec3 {
    fn to_value(&self) -> Value {
        self.to_array().to_value()
    }
}

impl ToValue for Ior {
    fn to_value(&self) -> Value {
        match self {
            Self::Constant(n) => n.to_value(),
            Self::Cauchy(coefficients) => inline([("cauchy", coefficients)]),
            Self::Sellmeier(terms) => inline([("sellmeier", &terms.to_vec())]),
            // Scene files have no notation for it: it is written by its name in the catalogue.
            Self::Gas(_) => match catalog::ALL.iter().find(|entry| entry.model == *self) {
                Some(entry) => Self::Catalog(entry).to_value(),
                None => self.ior().to_value(),
            },
            Self::Catalog(entry) => inline([("catalog", &entry.name.to_owned())]),
        }
    }
}

/// Without what is as by default, unless its key is to be there.
pub(super) fn transform(transform: &Transform, is_wanted: impl Fn(&str) -> bool) -> Value {
    let Transform { scale, rotate, translate } = *transform;
    let mut table = InlineTable::new();
    if scale != DVec3::ONE || is_wanted("scale") {
        let is_uniform = scale.x == scale.y && scale.y == scale.z;
        table.insert("scale", if is_uniform { scale.x.to_value() } else { scale.to_value() });
    }
    for (key, value) in [("rotate", rotate), ("translate", translate)] {
        if value != DVec3::ZERO || is_wanted(key) {
            table.insert(key, value.to_value());
        }
    }
    Value::InlineTable(table)
}

/// What follows `color =` or `checker =`.
impl ToValue for Paint {
    fn to_value(&self) -> Value {
        match self {
            Self::Color(color) => color.to_value(),
            Self::Checker { a, b, size } => {
                mixed([("a", a.to_value()), ("b", b.to_value()), ("size", size.to_value())])
            }
        }
    }
}

impl ToValue for Shape {
    fn to_value(&self) -> Value {
        let (kind, value) = match self {
            Self::Sphere { center, radius } => {
                ("sphere", mixed([("center", center.to_value()), ("radius", radius.to_value())]))
            }
            Self::Icosphere { center, radius, subdivisions } => {
                let entries = [
                    ("center", center.to_value()),
                    ("radius", radius.to_value()),
                    ("subdivisions", subdivisions.to_value()),
                ];
                ("icosphere", mixed(entries))
            }
            Self::Box { min, max } => ("box", inline([("min", min), ("max", max)])),
            Self::Cylinder { center, radius, height, segments } => {
                let value = mixed([
                    ("center", center.to_value()),
                    ("radius", radius.to_value()),
                    ("height", height.to_value()),
                ]);
                ("cylinder", with_count(value, "segments", *segments, DEFAULT_SEGMENTS))
            }
            Self::Torus { center, major, minor, segments, rings } => {
                let value =
                    mixed([("center", center.to_value()), ("major", major.to_value()), ("minor", minor.to_value())]);
                let value = with_count(value, "segments", *segments, DEFAULT_SEGMENTS);
                ("torus", with_count(value, "rings", *rings, DEFAULT_RINGS))
            }
            Self::Lathe { profile, segments } => {
                let value = mixed([("profile", profile.to_value())]);
                ("lathe", with_count(value, "segments", *segments, DEFAULT_SEGMENTS))
            }
            Self::Quad { center, edge_u, edge_v } => {
                ("quad", inline([("center", center), ("edge_u", edge_u), ("edge_v", edge_v)]))
            }
            Self::Mesh { path, .. } => ("mesh", path.to_value()),
        };
        mixed([(kind, value)])
    }
}

fn with_count(mut value: Value, key: &str, count: u32, default: u32) -> Value {
    if count != default
        && let Some(table) = value.as_inline_table_mut()
    {
        table.insert(key, count.to_value());
    }
    value
}

/// Whether two shapes are written alike; the text alone does not hold a mesh's triangles.
pub(super) fn same_shape(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Mesh { path: a, .. }, Shape::Mesh { path: b, .. }) => a == b,
        _ => a == b,
    }
}
