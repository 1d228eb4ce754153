//! All that a scene's file says.

use toml_edit::{Array, InlineTable, TableLike, Value};

use crate::scene::description::{Description, Environment, Kind, Object, WorldMedium};
use crate::scene::fields::{Entry, Plain, entries};
use crate::scene::tables::medium_fields;

/// A scene as its file has it: without the contents of meshes and images.
#[derive(Debug, PartialEq)]
pub(super) struct Tree {
    pub name: String,
    /// By their keys.
    pub sections: [(&'static str, Vec<Entry>); 3],
    /// By the keys of their tables.
    pub lists: Vec<(&'static str, Vec<Vec<Entry>>)>,
}

impl Tree {
    pub fn of(description: &Description) -> Self {
        let Description { name, camera, camera_medium, world, environment, media, objects, source: _ } = description;
        let objects_of = |kind: Kind| {
            let entries_of = |object: &Object| entries(|v| object.clone().fields(v));
            (kind.name(), objects.of(kind).iter().map(entries_of).collect())
        };
        let media = media.iter().map(|medium| entries(|v| medium_fields(&mut medium.clone(), v))).collect();
        Self {
            name: name.clone(),
            sections: [
                ("camera", entries(|v| { *camera }.fields_in(&mut camera_medium.clone(), v))),
                ("world", entries(|v| world.clone().fields(v))),
                ("environment", entries(|v| environment.clone().fields(v))),
            ],
            lists: std::iter::once(("medium", media)).chain(Kind::ALL.map(objects_of)).collect(),
        }
    }

    /// What a file says that is empty of all that `other` has.
    pub fn empty(other: &Self) -> Self {
        Self {
            name: String::new(),
            sections: [
                ("camera", Vec::new()),
                ("world", entries(|v| { WorldMedium::DEFAULT }.fields(v))),
                ("environment", entries(|v| { Environment::DEFAULT }.fields(v))),
            ],
            lists: other.lists.iter().map(|(key, _)| (*key, Vec::new())).collect(),
        }
    }
}

/// As it is written after `key =`. Of a table, entries are left out that say no more than the default, unless their keys are `there`.
pub(super) fn to_value(plain: &Plain, there: Option<&dyn TableLike>) -> Value {
    match plain {
        Plain::Flag(value) => (*value).into(),
        Plain::Integer(value) => (*value).into(),
        Plain::Number(value) => (*value).into(),
        Plain::Text(value) => value.as_str().into(),
        Plain::List(items) => Value::Array(items.iter().map(|item| to_value(item, None)).collect::<Array>()),
        Plain::Table(entries) => {
            let mut table = InlineTable::new();
            for Entry { key, value, is_default } in entries {
                let there = there.and_then(|table| table.get(key));
                if !is_default || there.is_some() {
                    table.insert(*key, to_value(value, there.and_then(toml_edit::Item::as_table_like)));
                }
            }
            Value::InlineTable(table)
        }
    }
}
