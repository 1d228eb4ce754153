//! Paths as a vector drawing: the lines over a pane, the outlines of the objects, and a legend of media.

use std::fmt::Write as _;

use egui::{Pos2, Rect, Vec2, pos2, vec2};
use glam::DVec3;

use super::Traced;
use super::strokes::{Label, Stroke, Weight, label, place_labels, strokes};
use crate::app::viewport::sight::Sight;
use crate::render::surfaces::medium_color;
use crate::scene::MediumId;
use crate::tracking::Mode;
use crate::transport::inspect::VertexEvent;

/// Of the drawing without the text below.
const WIDTH: f32 = 1200.0;
const LINE: f32 = 18.0;
const MARGIN: f32 = 14.0;
/// Width of a letter of 11 px in a monospaced font.
const LETTER: f32 = 6.7;
/// Characters of a line of text.
const MOST_IN_LINE: usize = 165;

/// The paths of `modes` as `sight` sees them: the first in whole lines, the others dashed. Widths of lines tell the share of light, and
/// their opacity what absorption has left.
pub fn drawing(traced: &Traced, modes: &[Mode], sight: &Sight) -> String {
    let scene = &traced.question.report.prepared.scene;
    let size = vec2(WIDTH, WIDTH / sight.aspect as f32);
    let screen = |place: DVec3| {
        let film = sight.film(place)?;
        let pos = pos2(film.x * size.x, film.y * size.y);
        (pos.x.abs() < 1e5 && pos.y.abs() < 1e5).then_some(pos)
    };
    let mut body = String::new();
    let mut media: Vec<MediumId> = Vec::new();

    body += "<g fill=\"none\" stroke=\"#ffffff\" stroke-opacity=\"0.28\" stroke-width=\"1\">\n";
    for [from, to] in traced.outlines.seen_from(sight.camera.position) {
        if let (Some(from), Some(to)) = (screen(from), screen(to)) {
            let _ = writeln!(body, "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>", from.x, from.y, to.x, to.y);
        }
    }
    body += "</g>\n";
    for (rank, mode) in modes.iter().enumerate().rev() {
        let lines = traced.lines.get(mode).map(Vec::as_slice).unwrap_or_default();
        let _ = writeln!(body, "<g class=\"path\" fill=\"none\" stroke-linecap=\"round\"{}>", dash(rank > 0));
        let _ = writeln!(body, "<title>{}</title>", escaped(mode.name()));
        for (index, line) in lines.iter().enumerate().rev() {
            let weight = if index == 0 { Weight::Main } else { Weight::Bundle };
            strokes(line, weight, screen).iter().for_each(|stroke| add_stroke(&mut body, stroke));
            media.extend(line.legs.iter().map(|leg| leg.medium));
        }
        body += "</g>\n";
    }
    add_vertices(&mut body, traced, modes, size, &screen);
    media.sort_unstable();
    media.dedup();
    let height = size.y + add_text(&mut body, traced, modes, &media, size.y);
    let name = escaped(&traced.question.report.prepared.description.name);
    let background = "<rect width=\"100%\" height=\"100%\" fill=\"#16181b\"/>";
    let head = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\" \
         font-family=\"monospace\" font-size=\"11\">\n<title>{name}</title>\n{background}\n"
    );
    // Media that were named by an earlier state of the scene are not there any more.
    debug_assert!(media.iter().all(|medium| (medium.0 as usize) < scene.media.len()));
    let clip = format!("<clipPath id=\"picture\"><rect width=\"{WIDTH}\" height=\"{:.1}\"/></clipPath>\n", size.y);
    head + &clip + &body + "</svg>\n"
}

fn dash(is_dashed: bool) -> &'static str {
    if is_dashed { " clip-path=\"url(#picture)\" stroke-dasharray=\"7 5\"" } else { " clip-path=\"url(#picture)\"" }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn add_stroke(body: &mut String, stroke: &Stroke) {
    let Stroke { from, to, width, color, opacity, .. } = stroke;
    let _ = writeln!(
        body,
        "<path d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"{}\" stroke-width=\"{width:.2}\" stroke-opacity=\"{opacity:.3}\"/>",
        from.x,
        from.y,
        to.x,
        to.y,
        hex(*color)
    );
}

/// Dots and labels of the first mode's path, and the ring where the paths part.
fn add_vertices(
    body: &mut String,
    traced: &Traced,
    modes: &[Mode],
    size: Vec2,
    screen: &impl Fn(DVec3) -> Option<Pos2>,
) {
    let Some(path) = modes.first().and_then(|mode| traced.path(*mode)) else { return };
    let picture = Rect::from_min_size(Pos2::ZERO, size);
    let mut texts: Vec<(Pos2, String)> = Vec::new();
    for vertex in path.vertices.iter().filter(|vertex| vertex.event != VertexEvent::Skip) {
        let Some(at) = screen(vertex.position.into()).filter(|at| picture.contains(*at)) else { continue };
        let fill = if vertex.is_consistent { "#ffffff" } else { "#f5c04a" };
        let _ = writeln!(body, "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"3\" fill=\"{fill}\"/>", at.x, at.y);
        texts.extend(label(vertex).map(|text| (at, text)));
    }
    let parting = traced.parting.as_ref().and_then(|parting| screen(parting.position.into()));
    if let Some(at) = parting.filter(|at| picture.contains(*at)) {
        let ring = "r=\"9\" fill=\"none\" stroke=\"#f5c04a\" stroke-width=\"2\"";
        let _ = writeln!(body, "<circle class=\"parting\" cx=\"{:.2}\" cy=\"{:.2}\" {ring}/>", at.x, at.y);
    }
    let labels: Vec<Label> = (texts.iter())
        .map(|(at, text)| {
            let size = vec2(text.chars().count() as f32 * LETTER + 8.0, 16.0);
            Label { anchor: *at, size, goes_far: false }
        })
        .collect();
    for ((_, text), rect) in texts.iter().zip(place_labels(&labels, picture.shrink(4.0), &[])) {
        let Some(rect) = rect else { continue };
        let (x, y) = (rect.left() + 4.0, rect.bottom() - 4.0);
        let _ = writeln!(body, "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"#f0f1f3\">{}</text>", escaped(text));
    }
}

/// The legend and the sentences below the picture. Returns their height.
fn add_text(body: &mut String, traced: &Traced, modes: &[Mode], media: &[MediumId], top: f32) -> f32 {
    let scene = &traced.question.report.prepared.scene;
    let mut y = top + LINE + 4.0;
    let mut x = MARGIN;
    for medium in media.iter().filter_map(|id| Some((id, scene.media.get(id.0 as usize)?))) {
        let text = format!("{} {:.4}", medium.1.name, medium.1.ior());
        let width = 18.0 + text.chars().count() as f32 * LETTER + 22.0;
        if x > MARGIN && x + width > WIDTH {
            (x, y) = (MARGIN, y + LINE);
        }
        let fill = hex(medium_color(*medium.0));
        let _ = writeln!(body, "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"10\" height=\"10\" fill=\"{fill}\"/>", y - 9.0);
        let _ = writeln!(body, "<text x=\"{:.1}\" y=\"{y:.1}\" fill=\"#f0f1f3\">{}</text>", x + 16.0, escaped(&text));
        x += width;
    }
    let mut add_line = |text: &str, fill: &str| {
        y += LINE;
        let _ = writeln!(body, "<text x=\"{MARGIN}\" y=\"{y:.1}\" fill=\"{fill}\">{}</text>", escaped(text));
    };
    let styles = ["solid", "dashed", "dashed"];
    let names: Vec<String> = modes.iter().zip(styles).map(|(mode, style)| format!("{mode} {style}")).collect();
    add_line(&names.join(", "), "#b4b9c0");
    for fault in traced.parting.iter().flat_map(|parting| parting.faults.iter().flatten()) {
        for sentence in [fault.what(), fault.why()] {
            let letters: Vec<char> = sentence.chars().collect();
            letters.chunks(MOST_IN_LINE).for_each(|part| add_line(&part.iter().collect::<String>(), "#f5c04a"));
        }
    }
    y + LINE - top
}

/// Text as XML takes it: marks escaped, and control characters, which XML cannot hold, replaced.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::app::paths::outline::Outlines;
    use crate::app::paths::tracer::{Question, Viewpoint, answer};
    use crate::formats;
    use crate::scene::camera::Camera;
    use crate::session::SceneReport;
    use crate::tracking::prepare;
    use crate::transport::inspect::Follow;

    /// Names of elements in the order in which they close. Panics where the text is not well-formed.
    fn elements(xml: &str) -> Vec<String> {
        let (mut open, mut closed) = (Vec::new(), Vec::new());
        let mut rest = xml;
        while let Some(start) = rest.find('<') {
            let text = &rest[..start];
            assert!(
                !text.contains('>') && !text.replace("&amp;", "").replace("&lt;", "").contains('&')
                    || text.contains("&gt;")
            );
            assert!(text.chars().all(|c| c == '\n' || !c.is_control()), "{text:?}");
            let end = start + rest[start..].find('>').expect("a tag ends");
            let tag = &rest[start + 1..end];
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            let name = tag.trim_matches('/').split_whitespace().next().expect("a tag has a name").to_owned();
            if tag.starts_with('/') {
                assert_eq!(open.pop().as_ref(), Some(&name));
                closed.push(name);
            } else if tag.ends_with('/') {
                closed.push(name);
            } else {
                open.push(name);
            }
            rest = &rest[end + 1..];
        }
        assert!(open.is_empty(), "{open:?}");
        closed
    }

    #[test]
    fn a_drawing_is_well_formed_and_has_both_paths_the_ring_and_the_legend() {
        let hostile = "a & b <i> \\\"q\\\" \\u0001";
        let text = format!(
            "name = \"{hostile}\"\n[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nvertical_fov = 30\n\
            [[medium]]\nname = \"{hostile}\"\nior = 1.3\n[[medium]]\nname = \"glass\"\nior = 1.5\n\
            [[refractor]]\nname = \"pool\"\nmedium = \"{hostile}\"\nshape = {{ sphere = {{ center = [0, 0, 0], radius = 20 }} }}\n\
            [[refractor]]\nname = \"ball\"\nmedium = \"glass\"\nshape = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}\n"
        );
        let description = Arc::new(formats::parse(&text, Path::new("test.toml"), &formats::Disk).unwrap());
        let prepared = prepare(Arc::clone(&description), None).unwrap();
        let camera = description.camera;
        let sight = Sight { camera: Camera::new(&camera).unwrap(), aspect: 1.5 };
        let question = Question {
            light: None,
            report: Arc::new(SceneReport { epoch: 1, prepared, problems: None }),
            viewpoint: Viewpoint { camera, film_size: [300, 200], point: [0.55, 0.45] },
            follow: Follow::Transmit,
            seed: 0,
            has_bundle: true,
            modes: vec![Mode::Stack, Mode::Rectified],
            pair: Some([Mode::Stack, Mode::Rectified]),
            max_depth: 20,
            eye: camera.position,
            has_outlines: true,
        };
        let traced = answer(question, None);
        assert_ne!(traced.outlines, Arc::new(Outlines::default()));
        let svg = drawing(&traced, &[Mode::Stack, Mode::Rectified], &sight);
        let elements = elements(&svg);
        let count = |name: &str| elements.iter().filter(|element| *element == name).count();
        assert!(svg.starts_with("<svg ") && count("svg") == 1 && count("clipPath") == 1);
        assert_eq!(svg.matches("class=\"path\"").count(), 2);
        assert_eq!((svg.matches("class=\"parting\"").count(), svg.matches("stroke-dasharray").count()), (1, 1));
        assert!(svg.contains("The path starts inside pool, which stack does not know."), "{svg}");
        // The legend has the medium of every leg, by its colour.
        for (medium, name) in [(2, "a &amp; b &lt;i&gt;"), (3, "glass 1.5000")] {
            assert!(svg.contains(&hex(medium_color(MediumId(medium)))) && svg.contains(name), "{name}");
        }
    }
}
