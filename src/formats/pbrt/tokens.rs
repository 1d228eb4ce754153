//! The words of a pbrt file, and the parameters of its directives.

use std::path::Path;

use crate::formats::importing::at;
use crate::scene::Place;
use crate::scene::SceneError;

/// Most numbers of one parameter.
const MOST_VALUES: usize = 1 << 28;

/// A word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'t> {
    /// A directive's name, a number, or `true` and `false`.
    Word(&'t str),
    /// In quotes, which are taken off.
    Quoted(&'t str),
    Open,
    Close,
}

/// Reads words one after the other.
#[derive(Debug, Clone)]
pub(super) struct Tokens<'t> {
    text: &'t str,
    path: &'t Path,
    next: usize,
    /// Where the last word began.
    last: usize,
    /// The line that is counted up to, from 1, and where it begins.
    line: (usize, usize),
    counted: usize,
}

impl<'t> Tokens<'t> {
    pub fn new(text: &'t str, path: &'t Path) -> Self {
        Self { text, path, next: 0, last: 0, line: (1, 0), counted: 0 }
    }

    /// The place of the last word.
    pub fn place(&mut self) -> Place {
        if self.last < self.counted {
            (self.line, self.counted) = ((1, 0), 0);
        }
        for (index, _) in self.text[self.counted..self.last].match_indices('\n') {
            self.line = (self.line.0 + 1, self.counted + index + 1);
        }
        self.counted = self.last;
        Place { file: self.path.to_owned(), line_column: Some((self.line.0, self.last - self.line.1 + 1)) }
    }

    pub fn error(&mut self, message: impl Into<String>) -> SceneError {
        at(&self.place(), message)
    }

    fn skip(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(&byte) = bytes.get(self.next) {
            match byte {
                b'#' => self.next += self.text[self.next..].find('\n').unwrap_or(self.text.len() - self.next),
                _ if byte.is_ascii_whitespace() => self.next += 1,
                _ => break,
            }
        }
    }

    /// The next word without taking it.
    pub fn peek(&mut self) -> Result<Option<Token<'t>>, SceneError> {
        let before = self.next;
        let token = self.take();
        self.next = before;
        token
    }

    pub fn take(&mut self) -> Result<Option<Token<'t>>, SceneError> {
        self.skip();
        self.last = self.next;
        let rest = &self.text[self.next..];
        let Some(&first) = rest.as_bytes().first() else { return Ok(None) };
        let token = match first {
            b'[' => Token::Open,
            b']' => Token::Close,
            b'"' => {
                let end = rest[1..].find(['"', '\n']).filter(|end| rest.as_bytes()[end + 1] == b'"');
                let end = end.ok_or_else(|| self.error("a text has no closing quote on its line"))?;
                self.next += end + 2;
                return Ok(Some(Token::Quoted(&rest[1..=end])));
            }
            _ => {
                let is_end = |c: char| c.is_ascii_whitespace() || matches!(c, '[' | ']' | '"' | '#');
                let end = rest.find(is_end).unwrap_or(rest.len());
                self.next += end;
                return Ok(Some(Token::Word(&rest[..end])));
            }
        };
        self.next += 1;
        Ok(Some(token))
    }

    /// A text in quotes, which `what` follows "needs" in an error.
    pub fn quoted(&mut self, what: &str) -> Result<&'t str, SceneError> {
        match self.take()? {
            Some(Token::Quoted(text)) => Ok(text),
            _ => Err(self.error(format!("a text in quotes is needed here: {what}"))),
        }
    }

    pub fn number(&mut self) -> Result<f64, SceneError> {
        match self.take()? {
            Some(Token::Word(word)) => self.finite(word),
            _ => Err(self.error("a number is needed here")),
        }
    }

    fn finite(&mut self, word: &str) -> Result<f64, SceneError> {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(format!("`{word}` is no number"))),
        }
    }

    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], SceneError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    /// Sixteen numbers, in brackets or not.
    pub fn matrix(&mut self) -> Result<[f64; 16], SceneError> {
        let has_brackets = self.peek()? == Some(Token::Open);
        if has_brackets {
            self.take()?;
        }
        let numbers = self.numbers()?;
        if has_brackets && self.take()? != Some(Token::Close) {
            return Err(self.error("a matrix has 16 numbers"));
        }
        Ok(numbers)
    }

    /// All parameters that follow.
    pub fn parameters(&mut self) -> Result<Parameters, SceneError> {
        let mut list = Vec::new();
        while let Some(Token::Quoted(declaration)) = self.peek()? {
            self.take()?;
            let place = self.place();
            let mut words = declaration.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(at(&place, format!("`{declaration}` is no type and name of a parameter")));
            };
            let mut parameter = Parameter {
                kind: kind.to_owned(),
                name: name.to_owned(),
                numbers: Vec::new(),
                texts: Vec::new(),
                place,
            };
            match self.take()? {
                Some(Token::Open) => loop {
                    match self.take()? {
                        Some(Token::Close) => break,
                        Some(token @ (Token::Word(_) | Token::Quoted(_))) => self.value(token, &mut parameter)?,
                        _ => return Err(self.error("a list has no end")),
                    }
                },
                Some(token @ (Token::Word(_) | Token::Quoted(_))) => self.value(token, &mut parameter)?,
                _ => return Err(self.error("a value is needed here")),
            }
            list.push(parameter);
        }
        Ok(Parameters(list))
    }

    fn value(&mut self, token: Token<'t>, parameter: &mut Parameter) -> Result<(), SceneError> {
        if parameter.numbers.len().max(parameter.texts.len()) >= MOST_VALUES {
            return Err(self.error("a list is too long"));
        }
        match token {
            Token::Quoted(text) => parameter.texts.push(text.to_owned()),
            Token::Word(word @ ("true" | "false")) => parameter.texts.push(word.to_owned()),
            Token::Word(word) => {
                let number = self.finite(word)?;
                parameter.numbers.push(number);
            }
            Token::Open | Token::Close => {}
        }
        Ok(())
    }
}

/// A parameter of a directive.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    /// Its type, such as `rgb`.
    pub kind: String,
    pub name: String,
    pub numbers: Vec<f64>,
    pub texts: Vec<String>,
    pub place: Place,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Parameters(pub Vec<Parameter>);

impl Parameters {
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.0.iter().find(|parameter| parameter.name == name)
    }

    pub fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.numbers.first().copied()
    }

    pub fn text(&self, name: &str) -> Option<&str> {
        self.get(name)?.texts.first().map(String::as_str)
    }

    pub fn flag(&self, name: &str) -> bool {
        self.text(name) == Some("true")
    }

    /// Three numbers.
    pub fn point(&self, name: &str) -> Option<glam::DVec3> {
        match self.get(name)?.numbers[..] {
            [x, y, z] => Some(glam::DVec3::new(x, y, z)),
            _ => None,
        }
    }

    /// All points of a list.
    pub fn points(&self, name: &str) -> Result<Vec<glam::DVec3>, SceneError> {
        let Some(parameter) = self.get(name) else { return Ok(Vec::new()) };
        if !parameter.numbers.len().is_multiple_of(3) {
            return Err(at(&parameter.place, format!("`{name}` needs three numbers for each point")));
        }
        Ok(parameter.numbers.chunks_exact(3).map(|p| glam::DVec3::new(p[0], p[1], p[2])).collect())
    }
}
