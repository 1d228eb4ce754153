//! The elements of a scene's XML, with what it includes in its place and its `$variables` filled in.

use std::collections::HashMap;
use std::path::Path;

use roxmltree::Document;

use crate::formats::importing::{Importer, at};
use crate::scene::Place;
use crate::scene::SceneError;

/// Most bytes of all of a scene's XML files.
const MOST_BYTES: usize = 64 << 20;
/// How deep elements may stand in each other, and files include each other.
const MOST_DEPTH: usize = 64;
const MOST_INCLUDES: usize = 16;
/// Most bytes of a text with its variables filled in, which could double with every one of them.
const MOST_FILLED: usize = 1 << 16;

/// An element.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub tag: String,
    /// Its attribute `type`.
    pub kind: String,
    /// By which its parent knows it, in lower case with `_`.
    pub name: String,
    pub id: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Node>,
    pub place: Place,
}

impl Node {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The attribute `value`.
    pub fn value(&self) -> Result<&str, SceneError> {
        self.attribute("value").ok_or_else(|| at(&self.place, format!("<{}> has no value", self.tag)))
    }

    /// The property of a name, which is no object of its own.
    pub fn property(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// Reads the scene's element with all in it.
pub(super) fn read(importer: &mut Importer<'_>) -> Result<Node, SceneError> {
    let (bytes, path) = (importer.input.bytes, importer.input.path);
    let mut source = Source { importer, variables: HashMap::new(), bytes: 0 };
    let mut nodes = source.file(bytes, path, 0)?;
    match nodes.pop() {
        Some(root) if root.tag == "scene" => Ok(root),
        _ => Err(SceneError::in_file(path, "is no Mitsuba scene: its outermost element is not <scene>")),
    }
}

/// The elements that have ids, which are no references; of equal ones the first.
pub(super) fn ids(root: &Node) -> HashMap<&str, &Node> {
    let mut ids = HashMap::new();
    let mut waiting = vec![root];
    while let Some(node) = waiting.pop() {
        if !node.id.is_empty() && node.tag != "ref" {
            ids.entry(node.id.as_str()).or_insert(node);
        }
        waiting.extend(node.children.iter().rev());
    }
    ids
}

struct Source<'i, 'a> {
    importer: &'i mut Importer<'a>,
    /// By `<default>`.
    variables: HashMap<String, String>,
    /// Of all files so far.
    bytes: usize,
}

impl Source<'_, '_> {
    /// The outermost element of a file.
    fn file(&mut self, bytes: &[u8], path: &Path, includes: usize) -> Result<Vec<Node>, SceneError> {
        self.bytes += bytes.len();
        if self.bytes > MOST_BYTES {
            return Err(SceneError::in_file(
                path,
                format!("with this file the scene has more than {MOST_BYTES} bytes of XML"),
            ));
        }
        let text = str::from_utf8(bytes).map_err(|_| SceneError::in_file(path, "is not text in UTF-8"))?;
        let text = text.trim_start_matches('\u{feff}');
        let document = Document::parse(text).map_err(|error| {
            let place = error.pos();
            // The message ends with the place.
            let message = error.to_string();
            let message = message.split(" at ").next().unwrap_or_default().to_owned();
            SceneError::at(path, place.row as usize, place.col as usize, format!("is not XML: {message}"))
        })?;
        let lines = Lines::of(text);
        let mut nodes = Vec::new();
        self.element(document.root_element(), &File { path, lines: &lines, includes }, 0, &mut nodes)?;
        Ok(nodes)
    }

    /// Adds an element to `nodes`, or what stands for it.
    fn element(
        &mut self,
        element: roxmltree::Node<'_, '_>,
        file: &File<'_>,
        depth: usize,
        nodes: &mut Vec<Node>,
    ) -> Result<(), SceneError> {
        let (line, column) = file.lines.place(element.range().start);
        let place = Place { file: file.path.to_owned(), line_column: Some((line, column)) };
        if depth > MOST_DEPTH {
            return Err(at(&place, format!("elements stand more than {MOST_DEPTH} deep in each other")));
        }
        // How to render is not the scene's affair here, and may hang on variables that are set elsewhere. It may be referred to.
        if ["integrator", "sampler", "rfilter"].contains(&element.tag_name().name()) {
            nodes.push(Node {
                tag: element.tag_name().name().to_owned(),
                kind: String::new(),
                name: String::new(),
                id: element.attribute("id").unwrap_or_default().to_owned(),
                attributes: Vec::new(),
                children: Vec::new(),
                place,
            });
            return Ok(());
        }
        let mut attributes = Vec::new();
        for attribute in element.attributes() {
            attributes.push((attribute.name().to_owned(), self.filled(attribute.value(), &place)?));
        }
        let mut take = |name: &str| {
            let index = attributes.iter().position(|(known, _)| known == name);
            index.map(|index| attributes.remove(index).1)
        };
        let kind = take("type").unwrap_or_default();
        let name = snake_case(&take("name").unwrap_or_default());
        let id = take("id").unwrap_or_default();
        let mut node = Node {
            tag: snake_case(element.tag_name().name()),
            kind: kind.to_lowercase(),
            name,
            id,
            attributes,
            children: Vec::new(),
            place,
        };
        match node.tag.as_str() {
            // Whoever starts Mitsuba may set another; a file alone means this one.
            "default" => {
                let value = node.value()?.to_owned();
                let name = element.attribute("name").unwrap_or_default();
                self.variables.entry(name.to_owned()).or_insert(value);
                return Ok(());
            }
            "include" => return self.include(&node, file, depth, nodes),
            "path" => {
                self.importer.look_in(node.value()?, &node.place);
                return Ok(());
            }
            _ => {}
        }
        for child in element.children().filter(roxmltree::Node::is_element) {
            self.element(child, file, depth + 1, &mut node.children)?;
        }
        nodes.push(node);
        Ok(())
    }

    /// What the scene of another file holds.
    fn include(&mut self, node: &Node, file: &File<'_>, depth: usize, nodes: &mut Vec<Node>) -> Result<(), SceneError> {
        let named = node.attribute("filename").ok_or_else(|| at(&node.place, "<include> has no filename"))?;
        if file.includes >= MOST_INCLUDES {
            return Err(at(&node.place, format!("files include each other more than {MOST_INCLUDES} deep")));
        }
        let (bytes, path) = self.importer.part_of_scene(named, &node.place)?;
        for included in self.file(&bytes, &path, file.includes + 1)? {
            if depth + 1 > MOST_DEPTH {
                return Err(at(&node.place, format!("elements stand more than {MOST_DEPTH} deep in each other")));
            }
            if included.tag == "scene" { nodes.extend(included.children) } else { nodes.push(included) }
        }
        Ok(())
    }

    /// A text with its `$name`s replaced.
    fn filled(&self, text: &str, place: &Place) -> Result<String, SceneError> {
        if !text.contains('$') {
            return Ok(text.to_owned());
        }
        let mut filled = String::new();
        let mut rest = text;
        while let Some(start) = rest.find('$') {
            filled += &rest[..start];
            rest = &rest[start + 1..];
            // The longest name that is known, as the text may go on with letters.
            let known = self.variables.keys().filter(|name| !name.is_empty() && rest.starts_with(name.as_str()));
            let Some(name) = known.max_by_key(|name| name.len()) else {
                return Err(at(place, format!("`${rest}` has no value: add a <default> for it")));
            };
            filled += &self.variables[name];
            rest = &rest[name.len()..];
            if filled.len() > MOST_FILLED {
                return Err(at(
                    place,
                    format!("a text with its variables filled in has more than {MOST_FILLED} bytes"),
                ));
            }
        }
        Ok(filled + rest)
    }
}

struct File<'a> {
    path: &'a Path,
    lines: &'a Lines,
    /// Files that it is included through.
    includes: usize,
}

/// Where the lines of a text begin.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// 1-based line and column, in bytes, of a byte.
    fn place(&self, byte: usize) -> (usize, usize) {
        let line = self.0.partition_point(|start| *start <= byte);
        (line, byte - self.0[line - 1] + 1)
    }
}

/// `toWorld` as `to_world`: older scenes write names so.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    let mut last = None;
    for c in name.chars() {
        let follows = last.is_some_and(|last: char| last.is_ascii_lowercase() || last.is_ascii_digit());
        if c.is_ascii_uppercase() && follows {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
        last = Some(c);
    }
    if snake == "look_at" { "lookat".into() } else { snake }
}
