//! New values in the place of old ones, with as much of the old notation as says the same.

use toml_edit::{Item, TableLike, Value};

use super::tree::to_value;
use crate::scene::fields::{Entry, Plain};

/// Makes a table, which says `old`, say `new`. Keys that are there stay, also where they say the default.
pub(super) fn update(table: &mut dyn TableLike, old: &[Entry], new: &[Entry]) {
    for Entry { key, value, is_default } in new {
        let was = old.iter().find(|entry| entry.key == *key).map(|entry| &entry.value);
        let there = table.get(key);
        if was == Some(value) || (*is_default && there.is_none()) {
            continue;
        }
        if *is_default && matches!(value, Plain::Flag(_)) {
            // A flag is written only where it is not as by default: an object that is shown again loses the key.
            table.remove(key);
            continue;
        }
        let value = to_value(value, there.and_then(Item::as_table_like));
        set(table, key, value);
    }
    for entry in old.iter().filter(|entry| new.iter().all(|other| other.key != entry.key)) {
        table.remove(entry.key);
    }
}

/// Puts a value in the place of an old one, whose notation stays as far as it says the same.
pub(super) fn set(table: &mut dyn TableLike, key: &str, new: Value) {
    match table.get_mut(key) {
        Some(old) => merge(old, new),
        None => {
            table.insert(key, Item::Value(new));
        }
    }
}

/// Makes `old` say what `new` says. Numbers that stay keep their digits, tables and arrays of the same shape their lines and comments.
fn merge(old: &mut Item, new: Value) {
    match old {
        Item::Value(value) => merge_value(value, new),
        _ => match (old.as_table_like_mut(), &new) {
            (Some(table), Value::InlineTable(entries)) if has_same_keys(table, entries) => merge_table(table, new),
            _ => *old = Item::Value(new),
        },
    }
}

fn merge_value(old: &mut Value, mut new: Value) {
    match (&mut *old, &mut new) {
        (Value::InlineTable(table), Value::InlineTable(entries)) if has_same_keys(table, entries) => {
            return merge_table(table, new);
        }
        (Value::Array(array), Value::Array(elements)) if array.len() == elements.len() => {
            for (old, new) in array.iter_mut().zip(std::mem::take(elements)) {
                merge_value(old, new);
            }
            return;
        }
        (old, new) if says_the_same(old, new) => return,
        _ => {}
    }
    *new.decor_mut() = old.decor().clone();
    *old = new;
}

fn has_same_keys(table: &dyn TableLike, entries: &dyn TableLike) -> bool {
    table.len() == entries.len() && entries.iter().all(|(key, _)| table.contains_key(key))
}

fn merge_table(table: &mut dyn TableLike, new: Value) {
    let Value::InlineTable(entries) = new else { return };
    for (key, value) in entries {
        if let Some(item) = table.get_mut(&key) {
            merge(item, value);
        }
    }
}

/// Of values that are neither tables nor arrays. Whole numbers may be written without a point.
fn says_the_same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64));
    match (number(a), number(b)) {
        (Some(a), Some(b)) => a.to_bits() == b.to_bits() || (a == 0.0 && b == 0.0),
        _ => match (a.as_str(), b.as_str()) {
            (Some(a), Some(b)) => a == b,
            _ => a.as_bool().is_some() && a.as_bool() == b.as_bool(),
        },
    }
}
