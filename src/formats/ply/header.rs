//! The header: which elements there are, and of which values they are made.

use super::super::lines::shown;
use super::super::passed_over::{Kind, PassedOver};
use super::super::polygons::Fault;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    /// A word of text files, whatever it is.
    Other,
}

impl Scalar {
    fn named(name: &str) -> Self {
        match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => Self::Other,
        }
    }

    pub fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64 | Self::Other)
    }

    /// In binary files.
    pub fn bytes(self) -> usize {
        match self {
            Self::Other => 0,
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Scalar,
    /// The type of a list's length.
    pub length: Option<Scalar>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// How many lines it has.
    pub lines: usize,
}

impl Header {
    /// The header, and the body.
    pub fn read<'a>(bytes: &'a [u8], passed_over: &mut PassedOver) -> Result<(Self, &'a [u8]), Fault> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        // A property of a type that has no known size, which only text files can have.
        let mut unknown_type = None;
        let mut rest = bytes;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        // Where lines end with CR alone, an LF after the last is the body's.
        let has_cr_alone =
            bytes.iter().position(is_end).is_some_and(|end| bytes[end] == b'\r' && bytes.get(end + 1) != Some(&b'\n'));
        for number in 1.. {
            let bad = |message: String| Err(Fault::at(number, message));
            let Some(end) = rest.iter().position(is_end) else {
                return bad("the header is cut off: there is no `end_header`".into());
            };
            let line = String::from_utf8_lossy(rest[..end].trim_ascii());
            let is_pair = rest[end..].starts_with(b"\r\n") && !has_cr_alone;
            rest = &rest[end + if is_pair { 2 } else { 1 }..];
            if number == 1 {
                if line != "ply" {
                    return bad("is no PLY file: it does not begin with `ply`".into());
                }
                continue;
            }
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, "1.0", ..] => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return bad(format!("the format {} is unknown", shown(name.as_bytes()))),
                    });
                }
                ["element", name, count] => {
                    let Ok(count) = count.parse() else {
                        return bad(format!("{} is not a count", shown(count.as_bytes())));
                    };
                    elements.push(Element { name: name.into(), count, properties: Vec::new() });
                }
                ["property", "list", _, kind, name] | ["property", kind, name] => {
                    let length = (words.len() == 5).then_some(words[2]);
                    let Some(element) = elements.last_mut() else {
                        return bad(format!("{} stands before any element", shown(line.as_bytes())));
                    };
                    let (kind_name, kind, length_kind) = (kind, Scalar::named(kind), length.map(Scalar::named));
                    element.properties.push(Property { name: name.into(), kind, length: length_kind });
                    let mut types = length.into_iter().chain([kind_name]);
                    let of_unknown = types.find(|name| Scalar::named(name) == Scalar::Other);
                    unknown_type = unknown_type.or(of_unknown.map(|name| (number, shown(name.as_bytes()))));
                }
                ["end_header", ..] => {
                    let Some(encoding) = encoding else { return bad("the header names no `format`".into()) };
                    return match unknown_type {
                        Some((line, name)) if encoding != Encoding::Ascii => {
                            Err(Fault::at(line, format!("{name} is no type of PLY, so that the body cannot be read")))
                        }
                        _ => Ok((Self { encoding, elements, lines: number }, rest)),
                    };
                }
                // None of these may be missed; and what begins with no letter is no word of a header but its end passed by.
                ["format" | "element" | "property", ..] => {
                    return bad(format!("{} is no header line that is known", shown(line.as_bytes())));
                }
                [word, ..] if word.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    passed_over.add_named(Kind::UnknownHeaderLine, &line, number);
                }
                _ => return bad(format!("{} is no header line that is known", shown(line.as_bytes()))),
            }
        }
        unreachable!("the loop ends by returning")
    }
}
