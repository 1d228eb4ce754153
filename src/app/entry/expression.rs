//! Arithmetic in a text field: `4/3`, `1,5`, `sqrt(2) + 0.1`, `2^-3`.

use super::{Refusal, quoted};

/// Parentheses, signs and powers inside each other; deeper ones are refused rather than followed.
const DEEPEST: usize = 40;
/// Longest text that is read.
const LONGEST: usize = 400;

/// The value of a calculation. Words other than functions and constants are given to `lookup`.
///
/// # Errors
/// When the text is no calculation, or its value is not a finite number.
pub fn evaluate(text: &str, lookup: &dyn Fn(&str) -> Result<f64, Refusal>) -> Result<f64, Refusal> {
    if text.chars().count() > LONGEST {
        return Err(Refusal::new("That is too long for a number."));
    }
    if text.trim().is_empty() {
        return Err(Refusal::new("Nothing was typed."));
    }
    let mut parser = Parser { tokens: tokens(text, lookup)?, at: 0, depth: 0 };
    let value = parser.sum()?;
    match parser.peek() {
        None => finite(value, text),
        Some(Token::Close) => Err(Refusal::new("There is a closing parenthesis too many.")),
        Some(token) => Err(Refusal::new(format!("A sign is missing before {}.", token.text()))),
    }
}

/// Whether a text begins as a number or a calculation does, not as a name.
pub fn begins_as_number(text: &str) -> bool {
    text.trim_start().starts_with(|c: char| c.is_ascii_digit() || ".,(+√".contains(c) || is_minus(c))
}

fn finite(value: f64, text: &str) -> Result<f64, Refusal> {
    if value.is_finite() {
        // −0 reads badly.
        Ok(value + 0.0)
    } else {
        Err(Refusal::new(format!("{} is too large to calculate.", quoted(text))))
    }
}

fn is_minus(c: char) -> bool {
    matches!(c, '-' | '−' | '–' | '‒' | '﹣' | '\u{ff0d}')
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    /// A value, and how it was written.
    Value(f64, String),
    Sqrt,
    Plus,
    Minus,
    Times,
    Over,
    Power,
    Open,
    Close,
}

impl Token {
    fn text(&self) -> String {
        match self {
            Self::Value(_, text) => quoted(text),
            Self::Sqrt => quoted("sqrt"),
            Self::Plus => quoted("+"),
            Self::Minus => quoted("−"),
            Self::Times => quoted("×"),
            Self::Over => quoted("/"),
            Self::Power => quoted("^"),
            Self::Open => quoted("("),
            Self::Close => quoted(")"),
        }
    }
}

fn tokens(text: &str, lookup: &dyn Fn(&str) -> Result<f64, Refusal>) -> Result<Vec<Token>, Refusal> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = match c {
            '0'..='9' | '.' | ',' => {
                let length = number_length(rest);
                let written = &rest[..length];
                found.push(Token::Value(number(written)?, written.to_owned()));
                length
            }
            '*' if rest[1..].starts_with('*') => {
                found.push(Token::Power);
                2
            }
            '²' | '³' => {
                let exponent = if c == '²' { "2" } else { "3" };
                found.push(Token::Power);
                found.push(Token::Value(if c == '²' { 2.0 } else { 3.0 }, exponent.to_owned()));
                c.len_utf8()
            }
            _ if c.is_alphabetic() => {
                let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
                let word = &rest[..length];
                found.push(match word.to_lowercase().as_str() {
                    "sqrt" => Token::Sqrt,
                    "pi" | "π" => Token::Value(std::f64::consts::PI, word.to_owned()),
                    _ => Token::Value(lookup(word)?, word.to_owned()),
                });
                length
            }
            _ => {
                match c {
                    '+' => found.push(Token::Plus),
                    '*' | '×' | '·' | '⋅' => found.push(Token::Times),
                    '/' | '÷' | '∕' | ':' => found.push(Token::Over),
                    '^' => found.push(Token::Power),
                    '√' => found.push(Token::Sqrt),
                    '(' | '[' => found.push(Token::Open),
                    ')' | ']' => found.push(Token::Close),
                    _ if is_minus(c) => found.push(Token::Minus),
                    _ if c.is_whitespace() => {}
                    '=' => return Err(Refusal::new("An equals sign does not belong here.")),
                    _ => {
                        return Err(Refusal::new(format!("{} is not understood in a number.", quoted(&c.to_string()))));
                    }
                }
                c.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    Ok(found)
}

/// Bytes of the number that a text begins with, with an exponent if it has one.
fn number_length(text: &str) -> usize {
    let digits = text.find(|c: char| !c.is_ascii_digit() && !matches!(c, '.' | ',')).unwrap_or(text.len());
    let mut chars = text[digits..].chars();
    if !matches!(chars.next(), Some('e' | 'E')) {
        return digits;
    }
    let sign = match chars.next() {
        Some(c) if c == '+' || is_minus(c) => c.len_utf8(),
        _ => 0,
    };
    let begin = digits + 1 + sign;
    let exponent = text[begin..].find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len() - begin);
    if exponent == 0 { digits } else { begin + exponent }
}

/// A number as it is written, with a point or a comma.
fn number(written: &str) -> Result<f64, Refusal> {
    let (points, commas) = (written.matches('.').count(), written.matches(',').count());
    let count = |count: usize| match count {
        2 => "two".to_owned(),
        3 => "three".to_owned(),
        more => more.to_string(),
    };
    if points > 0 && commas > 0 {
        let advice = "write one of them, before the decimals, and nothing between thousands";
        return Err(Refusal::new(format!("{} has both a point and a comma: {advice}.", quoted(written))));
    }
    for (marks, name) in [(points, "decimal points"), (commas, "decimal commas")] {
        if marks > 1 {
            return Err(Refusal::new(format!("{} has {} {name}.", quoted(written), count(marks))));
        }
    }
    let plain: String = written.chars().map(|c| if is_minus(c) { '-' } else { c }).collect();
    let value = plain.replace(',', ".").parse().map_err(|_| {
        // A point alone.
        Refusal::new(format!("{} is no number.", quoted(written)))
    })?;
    finite(value, written)
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
}

impl Parser {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn take(&mut self, token: &Token) -> bool {
        let is_there = self.peek() == Some(token);
        self.at += usize::from(is_there);
        is_there
    }

    fn sum(&mut self) -> Result<f64, Refusal> {
        let mut value = self.product()?;
        loop {
            if self.take(&Token::Plus) {
                value += self.product()?;
            } else if self.take(&Token::Minus) {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Result<f64, Refusal> {
        let mut value = self.signed()?;
        loop {
            if self.take(&Token::Times) {
                value *= self.signed()?;
            } else if self.take(&Token::Over) {
                let divisor = self.signed()?;
                if divisor == 0.0 {
                    return Err(Refusal::new("Nothing can be divided by 0."));
                }
                value /= divisor;
            } else {
                return Ok(value);
            }
        }
    }

    /// −2^2 is −4, and 2^−2 is ¼.
    fn signed(&mut self) -> Result<f64, Refusal> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Refusal::new("There are too many parentheses and signs inside each other."));
        }
        let value = if self.take(&Token::Minus) {
            -self.signed()?
        } else if self.take(&Token::Plus) {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(value)
    }

    fn power(&mut self) -> Result<f64, Refusal> {
        let base = self.atom()?;
        if !self.take(&Token::Power) {
            return Ok(base);
        }
        let exponent = self.signed()?;
        if base == 0.0 && exponent < 0.0 {
            return Err(Refusal::new("Nothing can be divided by 0."));
        }
        let value = base.powf(exponent);
        if value.is_nan() && !base.is_nan() && !exponent.is_nan() {
            return Err(Refusal::new(format!("{base} to the power of {exponent} is not a real number.")));
        }
        Ok(value)
    }

    fn atom(&mut self) -> Result<f64, Refusal> {
        let Some(token) = self.tokens.get(self.at).cloned() else {
            return Err(Refusal::new("The calculation stops in the middle."));
        };
        self.at += 1;
        match token {
            Token::Value(value, _) => Ok(value),
            Token::Open => {
                let value = self.signed_sum()?;
                if self.take(&Token::Close) {
                    Ok(value)
                } else {
                    Err(Refusal::new("A closing parenthesis is missing."))
                }
            }
            Token::Sqrt => {
                self.depth += 1;
                if self.depth > DEEPEST {
                    return Err(Refusal::new("There are too many roots inside each other."));
                }
                let value = self.atom()?;
                self.depth -= 1;
                if value < 0.0 {
                    return Err(Refusal::new(format!("The square root of {value} is not a real number.")));
                }
                Ok(value.sqrt())
            }
            Token::Close => Err(Refusal::new("There is nothing before a closing parenthesis.")),
            sign => Err(Refusal::new(format!("A number is missing before {}.", sign.text()))),
        }
    }

    /// What stands between parentheses.
    fn signed_sum(&mut self) -> Result<f64, Refusal> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Refusal::new("There are too many parentheses and signs inside each other."));
        }
        let value = self.sum()?;
        self.depth -= 1;
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, Refusal> {
        evaluate(text, &|word| Err(Refusal::new(format!("no {word}"))))
    }

    #[test]
    fn calculations_by_hand() {
        for (text, expected) in [
            ("1.333", 1.333),
            ("4/3", 4.0 / 3.0),
            ("1,5", 1.5),
            (" 1.5168 ", 1.5168),
            (",5", 0.5),
            ("1.", 1.0),
            ("2+3*4", 14.0),
            ("(2+3)*4", 20.0),
            ("10-4-3", 3.0),
            ("16/4/2", 2.0),
            ("2^3^2", 512.0),
            ("-2^2", -4.0),
            ("2^-2", 0.25),
            ("−1 + 3", 2.0),
            ("3 × 2 ÷ 4", 1.5),
            ("sqrt(2)^2", 2.0_f64.sqrt().powf(2.0)),
            ("√9", 3.0),
            ("1,2²", 1.44),
            ("1e-3", 1e-3),
            ("2.5E+2", 250.0),
            ("1,5e−1", 0.15),
            ("pi", std::f64::consts::PI),
            ("- -3", 3.0),
        ] {
            let got = value(text).unwrap_or_else(|refusal| panic!("{text}: {refusal}"));
            assert!((got - expected).abs() <= 1e-12 * expected.abs(), "{text}: {got}, not {expected}");
        }
        assert_eq!(value("-0").unwrap().to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn what_is_refused_says_why() {
        for (text, reason) in [
            ("", "Nothing was typed"),
            ("1,5,2", "“1,5,2” has two decimal commas"),
            ("1.2.3.4", "three decimal points"),
            ("1.234,5", "both a point and a comma"),
            ("1 333", "A sign is missing before “333”"),
            ("2(3)", "A sign is missing before “(”"),
            ("4/", "stops in the middle"),
            ("*2", "A number is missing before “×”"),
            ("(1+2", "closing parenthesis is missing"),
            ("1)", "parenthesis too many"),
            ("()", "nothing before a closing parenthesis"),
            ("1/0", "divided by 0"),
            ("0^-1", "divided by 0"),
            ("1/(2-2)", "divided by 0"),
            ("sqrt(-2)", "The square root of -2 is not a real number"),
            ("(-8)^0.5", "not a real number"),
            ("9e999", "too large"),
            ("1e300*1e300", "too large"),
            (".", "is no number"),
            ("1.5 $", "“$” is not understood"),
            ("soup", "no soup"),
            ("x=3", "no x"),
        ] {
            let refusal = value(text).expect_err(text);
            assert!(refusal.0.contains(reason), "{text}: {refusal}");
        }
        assert!(value(&"(".repeat(390)).is_err());
        assert!(value(&"-".repeat(390)).is_err());
        assert!(value(&"√".repeat(390)).is_err());
        assert!(value(&"1+".repeat(10_000)).is_err());
    }

    proptest::proptest! {
        /// Any text is read or refused; what is read is finite.
        #[test]
        fn no_text_is_too_much(text in "[-0-9.,()+*/^√²eE a-zπ−×:=°%µ😀]{0,60}") {
            if let Ok(value) = value(&text) {
                assert!(value.is_finite(), "{text}");
            }
        }

        /// A number that is printed is read as itself, with a point and with a comma.
        #[test]
        fn numbers_come_back(number in -1e9..1e9_f64) {
            let text = number.to_string();
            assert_eq!(value(&text), Ok(number));
            assert_eq!(value(&text.replace('.', ",")), Ok(number));
        }
    }
}
