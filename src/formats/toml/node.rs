//! Typed access to a TOML document in which every value knows its place.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::Path;

use toml_edit::{Item, TableLike, Value};

use crate::formats::suggest::suggestion;
use crate::scene::SceneError;
use crate::scene::fields::{ANY, Limits};

/// The text of a scene file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Text<'_> {
    /// 1-based line and column, in characters, of a byte.
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(byte)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        // A byte-order mark is no character of the first line.
        let line = before[line_start..].trim_start_matches('\u{feff}');
        (before.matches('\n').count() + 1, line.chars().count() + 1)
    }

    pub fn error(&self, byte: usize, message: impl Into<String>) -> SceneError {
        let (line, column) = self.line_column(byte);
        SceneError::at(self.path, line, column, message)
    }
}

/// A table, with the name by which errors call it.
#[derive(Clone)]
pub(super) struct Table<'a> {
    pub text: &'a Text<'a>,
    table: &'a dyn TableLike,
    /// Where it begins.
    start: usize,
    pub name: String,
}

/// A value, with the name by which errors call it.
#[derive(Clone)]
pub(super) struct Node<'a> {
    pub text: &'a Text<'a>,
    kind: Kind<'a>,
    /// Where it begins.
    start: usize,
    pub name: String,
}

#[derive(Clone, Copy)]
enum Kind<'a> {
    Item(&'a Item),
    Value(&'a Value),
}

impl<'a> Table<'a> {
    pub fn root(text: &'a Text<'a>, table: &'a toml_edit::Table) -> Self {
        Self { text, table, start: 0, name: "the scene".into() }
    }

    pub fn renamed(mut self, name: String) -> Self {
        self.name = name;
        self
    }

    /// An error about the table as a whole.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        self.text.error(self.start, message)
    }

    /// An error for each key that is not in `valid`, which lists those that are.
    pub fn unknown(&self, valid: &[&str]) -> impl Iterator<Item = SceneError> {
        let unknown = self.table.iter().filter(|(key, item)| !item.is_none() && !valid.contains(key));
        unknown.map(|(key, item)| {
            let start = self.key_start(key).or_else(|| item.span().map(|span| span.start)).unwrap_or(self.start);
            let hint = suggestion(key, valid.iter().copied());
            let message = format!("unknown key `{key}` in {}{hint}; valid keys: {}", self.name, valid.join(", "));
            self.text.error(start, message)
        })
    }

    pub fn get(&self, key: &str) -> Option<Node<'a>> {
        let item = self.table.get(key).filter(|item| !item.is_none())?;
        // Tables of dotted keys have no place of their own; their key has.
        let start = item.span().map(|span| span.start).or_else(|| self.key_start(key)).unwrap_or(self.start);
        Some(Node { text: self.text, kind: Kind::Item(item), start, name: format!("`{key}`") })
    }

    pub fn need(&self, key: &str) -> Result<Node<'a>, SceneError> {
        self.get(key).ok_or_else(|| self.error(format!("{} lacks `{key}`", self.name)))
    }

    /// Those of `keys` that are there.
    pub fn present(&self, keys: &[&'static str]) -> Vec<&'static str> {
        keys.iter().copied().filter(|key| self.table.get(key).is_some_and(|item| !item.is_none())).collect()
    }

    /// Reads a key that may be left out.
    pub fn read<T>(
        &self,
        key: &str,
        default: T,
        read: impl Fn(&Node<'a>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        self.get(key).map_or(Ok(default), |node| read(&node))
    }

    fn key_start(&self, key: &str) -> Option<usize> {
        self.table.key(key).and_then(toml_edit::Key::span).map(|span| span.start)
    }
}

impl<'a> Node<'a> {
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        self.text.error(self.start, message)
    }

    fn wrong_type(&self, expected: &str) -> SceneError {
        let found = match self.kind {
            Kind::Item(item) => item.type_name(),
            Kind::Value(value) => value.type_name(),
        };
        let article = if found.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        self.error(format!("{} must be {expected}, found {article} {found}", self.name))
    }

    fn value(&self) -> Option<&'a Value> {
        match self.kind {
            Kind::Item(item) => item.as_value(),
            Kind::Value(value) => Some(value),
        }
    }

    /// A finite number, whole or not.
    pub fn number(&self) -> Result<f64, SceneError> {
        let number = match self.value() {
            Some(Value::Float(x)) => *x.value(),
            Some(Value::Integer(x)) => *x.value() as f64,
            _ => return Err(self.wrong_type("a number")),
        };
        ANY.require(&self.name, number).map_err(|message| self.error(message))?;
        Ok(number)
    }

    pub fn number_within(&self, limits: Limits) -> Result<f64, SceneError> {
        let number = self.number()?;
        limits.require(&self.name, number).map_err(|message| self.error(message))?;
        Ok(number)
    }

    /// A whole number in a range.
    pub fn integer<T>(&self, range: RangeInclusive<T>) -> Result<T, SceneError>
    where
        T: TryFrom<i64> + PartialOrd + Display,
    {
        let Some(Value::Integer(x)) = self.value() else { return Err(self.wrong_type("a whole number")) };
        T::try_from(*x.value()).ok().filter(|x| range.contains(x)).ok_or_else(|| {
            self.error(format!("{} is {}, must be {} to {}", self.name, x.value(), range.start(), range.end()))
        })
    }

    pub fn boolean(&self) -> Result<bool, SceneError> {
        self.value().and_then(Value::as_bool).ok_or_else(|| self.wrong_type("true or false"))
    }

    pub fn string(&self) -> Result<&'a str, SceneError> {
        self.value().and_then(Value::as_str).ok_or_else(|| self.wrong_type("a string"))
    }

    /// A string with something in it.
    pub fn words(&self) -> Result<&'a str, SceneError> {
        let text = self.string()?;
        if text.trim().is_empty() { Err(self.error(format!("{} is empty", self.name))) } else { Ok(text) }
    }

    pub fn is_table(&self) -> bool {
        match self.kind {
            Kind::Item(item) => item.is_table_like(),
            Kind::Value(value) => value.is_inline_table(),
        }
    }

    pub fn is_number(&self) -> bool {
        matches!(self.value(), Some(Value::Float(_) | Value::Integer(_)))
    }

    pub fn table(&self) -> Result<Table<'a>, SceneError> {
        let table: Option<&'a dyn TableLike> = match self.kind {
            Kind::Item(item) => item.as_table_like(),
            Kind::Value(value) => value.as_inline_table().map(|table| table as &dyn TableLike),
        };
        let table = table.ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Table { text: self.text, table, start: self.start, name: self.name.clone() })
    }

    /// The tables of `[[name]]`, or of an array of inline tables.
    pub fn tables(&self) -> Result<Vec<Table<'a>>, SceneError> {
        if let Kind::Item(Item::ArrayOfTables(tables)) = self.kind {
            let table = |t: &'a toml_edit::Table| Table {
                text: self.text,
                table: t,
                start: t.span().map_or(self.start, |span| span.start),
                name: self.name.clone(),
            };
            return Ok(tables.iter().map(table).collect());
        }
        let plain = self.name.trim_matches('`');
        let expected = format!("an array of tables, written [[{plain}]]");
        self.items().map_err(|_| self.wrong_type(&expected))?.iter().map(Self::table).collect()
    }

    /// The elements of an array.
    pub fn items(&self) -> Result<Vec<Node<'a>>, SceneError> {
        let array = self.value().and_then(Value::as_array).ok_or_else(|| self.wrong_type("an array"))?;
        let node = |(i, value): (usize, &'a Value)| Node {
            text: self.text,
            kind: Kind::Value(value),
            start: value.span().map_or(self.start, |span| span.start),
            name: format!("element {} of {}", i + 1, self.name),
        };
        Ok(array.iter().enumerate().map(node).collect())
    }

    /// As many finite numbers as N.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N], SceneError> {
        let expected = format!("an array of {N} numbers");
        let items = self.items().map_err(|_| self.wrong_type(&expected))?;
        if items.len() != N {
            return Err(self.error(format!("{} must be {expected}, found {}", self.name, items.len())));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(&items) {
            *number = item.number()?;
        }
        Ok(numbers)
    }

    /// As many numbers as N, each within limits.
    pub fn numbers_within<const N: usize>(&self, limits: Limits) -> Result<[f64; N], SceneError> {
        let numbers = self.numbers()?;
        for (&number, i) in numbers.iter().zip(1..) {
            let name = format!("element {i} of {}", self.name);
            limits.require(&name, number).map_err(|message| self.error(message))?;
        }
        Ok(numbers)
    }
}
