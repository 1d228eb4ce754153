//! Lists of tables, such as `[[medium]]`.

use std::collections::{HashMap, HashSet};

use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, Value};

use super::merge::update;
use crate::scene::fields::{Entry, Plain};

/// What one table says.
type Fields = Vec<Entry>;

/// Brings the tables of `[[key]]` up to date. Each keeps the table that had its name; one that was renamed in its place keeps its place's.
pub(super) fn sync(root: &mut Table, key: &str, old: &[Fields], new: &[Fields]) {
    let sources = sources(old, new);
    match root.get_mut(key) {
        Some(Item::Value(Value::Array(array))) if !new.is_empty() => sync_inline(array, old, new, &sources),
        _ => sync_tables(root, key, old, new, sources),
    }
}

/// For each new table the old one that it takes over.
fn sources(old: &[Fields], new: &[Fields]) -> Vec<Option<usize>> {
    // Of equal names, which the loader refuses, the first.
    let was_at: HashMap<&str, usize> = old.iter().enumerate().rev().map(|(index, o)| (name(o), index)).collect();
    let kept: HashSet<&str> = new.iter().map(|fields| name(fields)).collect();
    let renamed = |index: usize| old.get(index).filter(|o| !kept.contains(name(o))).map(|_| index);
    new.iter().enumerate().map(|(index, n)| was_at.get(name(n)).copied().or_else(|| renamed(index))).collect()
}

/// Tables of lists begin with their names.
fn name(fields: &[Entry]) -> &str {
    match fields.first() {
        Some(Entry { value: Plain::Text(name), .. }) => name,
        _ => "",
    }
}

/// In an array of inline tables, as `medium = [{ … }, { … }]`.
fn sync_inline(array: &mut Array, old: &[Fields], new: &[Fields], sources: &[Option<usize>]) {
    let mut tables: Vec<Option<Value>> = array.iter().cloned().map(Some).collect();
    tables.resize_with(old.len(), || None);
    // New ones stand on a line of their own where the last one does, without its comment.
    let prefix = array.iter().last().and_then(|last| last.decor().prefix()?.as_str());
    let prefix = prefix.map(|prefix| prefix[prefix.rfind('\n').unwrap_or(0)..].to_owned());
    let mut values = Vec::with_capacity(new.len());
    for (n, source) in new.iter().zip(sources) {
        let found = source.and_then(|j| Some((tables[j].take()?, &old[j][..])));
        let (mut value, o) = found.unwrap_or_else(|| {
            let mut value = Value::InlineTable(InlineTable::new());
            if let Some(prefix) = &prefix {
                value.decor_mut().set_prefix(prefix.as_str());
            }
            (value, &[])
        });
        if let Some(table) = value.as_inline_table_mut() {
            let keys = table.len();
            update(table, o, n);
            if table.len() != keys {
                table.fmt();
            }
        }
        values.push(value);
    }
    array.clear();
    values.into_iter().for_each(|value| array.push_formatted(value));
}

/// In tables of their own, `[[medium]]`.
fn sync_tables(root: &mut Table, key: &str, old: &[Fields], new: &[Fields], sources: Vec<Option<usize>>) {
    let mut tables: Vec<Option<Table>> = match root.get(key).cloned().map(Item::into_array_of_tables) {
        Some(Ok(array)) => array.into_iter().map(Some).collect(),
        _ => Vec::new(),
    };
    // Were they not alike, the file would not have been read.
    tables.resize_with(old.len(), || None);
    let kept: Vec<usize> = sources.iter().flatten().copied().collect();
    if !kept.is_sorted() {
        // A table that moves takes its subtables along only if they are part of it.
        for (_, item) in tables.iter_mut().flatten().flat_map(Table::iter_mut).filter(|(_, item)| item.is_table()) {
            item.make_value();
        }
    }
    // In a file tables of different kinds may alternate: the places stay, whoever takes them.
    let mut positions: Vec<isize> = kept.iter().filter_map(|&j| tables[j].as_ref()?.position()).collect();
    positions.sort_unstable();
    let mut last_position = positions.first().copied();
    let mut positions = positions.into_iter();

    let mut array = ArrayOfTables::new();
    for (n, source) in new.iter().zip(sources) {
        let found = source.and_then(|j| tables[j].take().map(|table| (table, &old[j])));
        let table = match found {
            Some((mut table, o)) => {
                update(&mut table, o, n);
                if table.position().is_some() {
                    table.set_position(positions.next());
                }
                last_position = end_position(&table).or(last_position);
                table
            }
            None => {
                let mut table = Table::new();
                table.decor_mut().set_prefix("\n");
                update(&mut table, &[], n);
                // Tables of equal position stay in the order of the array.
                table.set_position(last_position);
                table
            }
        };
        array.push(table);
    }
    match root.get_mut(key) {
        _ if array.is_empty() => _ = root.remove(key),
        Some(item) => *item = Item::ArrayOfTables(array),
        None => _ = root.insert(key, Item::ArrayOfTables(array)),
    }
}

/// The position of the last of a table and its subtables.
fn end_position(table: &Table) -> Option<isize> {
    table.iter().filter_map(|(_, item)| item.as_table().and_then(end_position)).chain(table.position()).max()
}
