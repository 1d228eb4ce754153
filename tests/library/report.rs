//! `iorect report`: the page says what the tables say, the tables say what was measured, and nothing that was finished is done again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use crate::common::{add, empty, nest, sphere};
use glam::DVec3;
use iorect::formats;
use iorect::report::csv::tables;
use iorect::report::data::Report;
use iorect::report::extent::Extent;
use iorect::report::frame_times::{FrameTimes, Spread};
use iorect::report::machine::Machine;
use iorect::report::make::{Part, ReportError, Request, Subject, make};
use iorect::report::page;
use iorect::report::progress::Progress;
use iorect::report::stability::{Map, Outcome};
use iorect::report::store::Store;
use iorect::report::write::write;
use iorect::scene::Description;
use serde_json::Value;

/// What a page may not be made to say by a scene's name.
const HOSTILE: &str = "<b>&\"nest\"</b> & ']]> --><script>";

/// A nest that all modes but `naive` get right, of an awkward name.
fn hostile_nest() -> Description {
    let mut description = nest(1.0, &[(1.0, 1.5), (0.6, 1.333)]);
    description.name = HOSTILE.to_owned();
    description.camera.position = DVec3::new(0.0, 0.0, 4.0);
    description.environment = iorect::scene::description::Environment::Gradient {
        zenith: [0.2, 0.4, 1.0],
        horizon: [1.0, 1.0, 1.0],
        nadir: [0.1, 0.05, 0.02],
    };
    description
}

fn subject(name: &str, description: Description) -> Subject {
    Subject { name: name.to_owned(), description: Arc::new(description) }
}

fn request(subjects: Vec<Subject>, parts: &[Part]) -> Request {
    let spread = Spread { median_ms: 1.34, percentile_95_ms: 2.5, most_ms: 5.0 };
    let frames = FrameTimes {
        machine: Machine::here(),
        version: String::new(),
        is_optimized: true,
        date: String::new(),
        scene: HOSTILE.to_owned(),
        window: [1920, 1080],
        panes: 4,
        pane: [600, 400],
        frames: 100,
        samples: 7,
        interface: spread,
        whole: None,
        interval: Some(spread),
        drawn_by: Some(HOSTILE.to_owned()),
    };
    Request {
        frames: Some(frames),
        subjects,
        parts: parts.to_vec(),
        extent: Extent::tiny(5, 2),
        seed: 5,
        command: "iorect report '<&>'".into(),
        adapter: None,
    }
}

fn quiet(cancel: &AtomicBool) -> Progress<'_> {
    Progress { cancel, tell: &|_, _| () }
}

/// A folder with a report of everything, made once for all tests.
struct Made {
    folder: tempfile::TempDir,
    report: Report,
    page: String,
}

static MADE: LazyLock<Made> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(&folder.path().join("cache")).unwrap();
    let subjects =
        vec![subject("nest", hostile_nest()), subject("camera-in-water", formats::open("camera-in-water").unwrap())];
    let report = make(&request(subjects, &Part::ALL), &store, &quiet(&AtomicBool::new(false))).unwrap();
    write(&report, folder.path()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    Made { folder, report, page }
});

impl Made {
    /// A table of the report's, as rows of fields by their columns' names.
    fn table(&self, file: &str) -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(self.folder.path().join(file)).unwrap();
        reader.deserialize().map(|row| row.unwrap()).collect()
    }
}

/// A tag, or text between tags.
enum Piece<'a> {
    Open(&'a str, BTreeMap<&'a str, &'a str>),
    Close(&'a str),
    Text(&'a str),
}

/// The pieces of a page, or what is wrong with it: tags that are not closed, nor in the right order; attributes without quotation
/// marks; `&` and `<` that stand for themselves.
fn pieces(page: &str) -> Result<Vec<Piece<'_>>, String> {
    const VOID: [&str; 5] = ["meta", "img", "br", "hr", "link"];
    let mut open: Vec<&str> = Vec::new();
    let mut found = Vec::new();
    let mut rest = page.strip_prefix("<!DOCTYPE html>").ok_or("no document type")?;
    while !rest.is_empty() {
        let end = rest.find('<').unwrap_or(rest.len());
        if end > 0 {
            // Style sheets are no text.
            if open.last() != Some(&"style") {
                entities(&rest[..end])?;
            }
            found.push(Piece::Text(&rest[..end]));
            rest = &rest[end..];
            continue;
        }
        let end = tag_end(rest).ok_or_else(|| format!("a tag does not end: {rest:.60}"))?;
        let tag = &rest[1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Err(format!("</{name}> closes nothing"));
            }
            found.push(Piece::Close(name));
            continue;
        }
        let name = &tag[..tag.find(char::is_whitespace).unwrap_or(tag.len())];
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric()) {
            return Err(format!("<{name}> is no tag"));
        }
        let attributes = attributes(&tag[name.len()..]).map_err(|why| format!("<{name}>: {why}"))?;
        if !VOID.contains(&name) {
            open.push(name);
        }
        found.push(Piece::Open(name, attributes));
    }
    if open.is_empty() { Ok(found) } else { Err(format!("not closed: {open:?}")) }
}

/// Where the tag that `text` begins with ends: a `>` outside quotation marks.
fn tag_end(text: &str) -> Option<usize> {
    let mut is_quoted = false;
    text.char_indices().find_map(|(at, c)| {
        is_quoted ^= c == '"';
        (c == '>' && !is_quoted).then_some(at)
    })
}

fn attributes(text: &str) -> Result<BTreeMap<&str, &str>, String> {
    let (mut found, mut rest) = (BTreeMap::new(), text.trim_start());
    while !rest.is_empty() {
        let end = rest.find(|c: char| c == '=' || c.is_whitespace()).unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        let value = match after.strip_prefix("=\"") {
            Some(after) => {
                let end = after.find('"').ok_or("a value does not end")?;
                entities(&after[..end])?;
                rest = after[end + 1..].trim_start();
                &after[..end]
            }
            None if after.starts_with('=') => return Err(format!("{name} has no quotation marks")),
            None => {
                rest = after.trim_start();
                ""
            }
        };
        if found.insert(name, value).is_some() {
            return Err(format!("{name} twice"));
        }
    }
    Ok(found)
}

/// Every `&` begins an entity, and nothing looks like a tag.
fn entities(text: &str) -> Result<(), String> {
    for (at, _) in text.match_indices('&') {
        let name = text[at + 1..].split(';').next().unwrap_or_default();
        if !["amp", "lt", "gt", "quot", "#39"].contains(&name) {
            return Err(format!("`&` that stands for itself: {:.40}", &text[at..]));
        }
    }
    if text.contains('>') { Err(format!("`>` that stands for itself: {text:.60}")) } else { Ok(()) }
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    let pieces = pieces(&MADE.page).unwrap();
    let mut ids = BTreeSet::new();
    let mut links = Vec::new();
    for piece in &pieces {
        let Piece::Open(name, attributes) = piece else { continue };
        assert_ne!(*name, "script");
        assert_ne!(*name, "b", "a scene's name is no markup");
        for (key, value) in attributes {
            assert!(!key.starts_with("on"), "{name} {key}");
            match *key {
                "id" => assert!(ids.insert(*value), "{value} twice"),
                "src" => assert!(value.starts_with("data:image/png;base64,"), "{value:.40}"),
                "href" => links.push(*value),
                _ => assert!(!value.contains("url(") && !value.contains("://"), "{name} {key}={value}"),
            }
        }
    }
    for link in links {
        match link.strip_prefix('#') {
            Some(id) => assert!(ids.contains(id), "{link} leads nowhere"),
            None => assert!(MADE.folder.path().join(link).is_file(), "{link} is not beside the page"),
        }
    }
    let style = MADE.page.split("<style>").nth(1).unwrap().split("</style>").next().unwrap();
    assert!(!style.contains("url(") && !style.contains("@import") && style.contains("prefers-color-scheme: dark"));
    assert!(MADE.page.contains("&lt;b&gt;&amp;") && MADE.page.contains("iorect report '&lt;&amp;&gt;'"));
}

/// The twin: pages with one fault each.
#[test]
fn faults_of_a_page_are_found() {
    let fine = "<!DOCTYPE html><p class=\"a\" hidden>x &amp; y<br>z <em title=\"a > b\">w</em></p>";
    assert!(pieces(&fine.replace(" > ", " &gt; ")).is_ok());
    for (wrong, right) in [
        ("</em>", ""),
        ("</p>", "</em>"),
        ("&amp;", "&"),
        ("\"a\"", "a"),
        ("hidden", "class=\"b\""),
        ("z", ">"),
        ("<em", "<"),
        ("<!DOCTYPE html>", ""),
    ] {
        let page = fine.replace(" > ", " &gt; ").replace(wrong, right);
        assert!(pieces(&page).is_err(), "{page}");
    }
}

/// Texts of the cells of every table with that class, row by row, headings left out.
fn rows_of(class: &str) -> Vec<Vec<String>> {
    let (mut rows, mut inside, mut in_cell) = (Vec::new(), false, false);
    for piece in pieces(&MADE.page).unwrap() {
        match piece {
            Piece::Open("table", attributes) => inside = attributes.get("class") == Some(&class),
            Piece::Close("table") => inside = false,
            Piece::Open("tr", _) if inside => rows.push(Vec::new()),
            Piece::Open("td" | "th", _) if inside => {
                in_cell = true;
                rows.last_mut().unwrap().push(String::new());
            }
            Piece::Close("td" | "th") => in_cell = false,
            Piece::Text(text) if inside && in_cell => *rows.last_mut().unwrap().last_mut().unwrap() += text,
            _ => {}
        }
    }
    rows
}

/// A number as the page writes it, with what is behind it left out: `−1.5·10⁻³ (…)`.
fn shown(text: &str) -> f64 {
    let text = text.split_whitespace().next().unwrap_or_default().replace('−', "-");
    let lowered: String = (text.chars())
        .map(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|raised| raised == c).map_or(c, |digit| char::from(b'0' + digit as u8)))
        .map(|c| if c == '⁻' { '-' } else { c })
        .collect();
    let has_power = text != lowered;
    let number = match (lowered.split_once("·10"), has_power) {
        (Some((digits, power)), _) => format!("{digits}e{power}"),
        (None, true) => format!("1e{}", &lowered[2..]),
        (None, false) => lowered.clone(),
    };
    number.parse().unwrap_or_else(|_| panic!("not a number: {text}"))
}

fn field(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {:?}", row[name]))
}

/// Slope of the least-squares line through the logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / count, logs.iter().map(|p| p.1).sum::<f64>() / count);
    let above: f64 = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    above / logs.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// Exponents on the page are those of the sizes and times in the table.
#[test]
fn exponents_follow_from_the_table() {
    let points = MADE.table("growth.csv");
    let exponents = MADE.table("exponents.csv");
    assert!(exponents.len() >= 4, "{exponents:?}");
    let mut on_page: Vec<f64> = Vec::new();
    for row in rows_of("growth").iter().filter(|row| row[0].starts_with("exponent")) {
        on_page.extend(row[1..].iter().filter(|cell| !cell.is_empty() && *cell != "–").map(|cell| shown(cell)));
    }
    assert_eq!(on_page.len(), exponents.len());
    for (row, on_page) in exponents.iter().zip(on_page) {
        let column =
            if row["measure"] == "memory" { "memory_bytes".into() } else { format!("{}_secs", row["measure"]) };
        let counted: Vec<(f64, f64)> = (points.iter())
            .filter(|point| point["quantity"] == row["quantity"] && field(point, "size") >= field(row, "from_size"))
            .filter(|point| !point[&column].is_empty())
            .map(|point| (field(point, "size"), field(point, &column)))
            .collect();
        assert_eq!(counted.len() as f64, field(row, "points"));
        let fitted = slope(&counted);
        assert!((fitted - field(row, "exponent")).abs() < 1e-9, "{row:?}: {fitted}");
        assert!((fitted - on_page).abs() <= 0.005 + 1e-9, "{row:?}: {on_page} on the page");
        // The twin: without the last point it is another line.
        let other = slope(&counted[..counted.len() - 1]);
        assert!((other - field(row, "exponent")).abs() > 1e-9, "{row:?}");
    }
}

/// Slopes on the page are those of the runs in the table: of each seed for itself, then their mean.
#[test]
fn slopes_follow_from_the_runs() {
    let (runs, curves) = (MADE.table("error-runs.csv"), MADE.table("error-curves.csv"));
    let mut on_page = rows_of("curves").into_iter().filter(|row| row[0] != "mode");
    let mut checked = 0;
    for row in &curves {
        let shown_row = on_page.next().unwrap();
        let name = if row["technique"] == "shipped" { "as shipped" } else { &row["mode"] };
        assert_eq!(shown_row[0], name);
        if !row["equal_to"].is_empty() {
            assert!(shown_row[1].contains(&row["equal_to"]));
            continue;
        }
        assert_eq!(row["slope"].is_empty(), shown_row[1] == "–", "{shown_row:?}");
        if row["slope"].is_empty() {
            continue;
        }
        let mut by_seed: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
        let is_of_curve = |run: &&BTreeMap<String, String>| {
            let spp = field(run, "spp");
            ["scene", "mode", "technique"].iter().all(|key| run[*key] == row[*key])
                && (field(row, "slope_from_spp")..=field(row, "slope_to_spp")).contains(&spp)
        };
        for run in runs.iter().filter(is_of_curve) {
            by_seed.entry(&run["seed"]).or_default().push((field(run, "spp"), field(run, "relmse_steady")));
        }
        let slopes: Vec<f64> = by_seed.values().map(|points| slope(points)).collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        assert!(slopes.len() == 4 && (mean - field(row, "slope")).abs() < 1e-9, "{row:?}: {mean}");
        assert!((mean - shown(&shown_row[1])).abs() <= 0.005 + 1e-9, "{shown_row:?}");
        // The twin: one seed alone has another slope.
        assert!((slopes[0] - mean).abs() > 1e-9);
        checked += 1;
    }
    assert!(checked >= 4 && on_page.next().is_none(), "{checked} slopes");
}

/// The camera is under water: what starts with an empty stack, or takes the outside for vacuum, is wrong there, and the page says so.
#[test]
fn wrong_modes_show_as_biased() {
    let verdicts: Vec<Vec<String>> = rows_of("curves").into_iter().filter(|row| row[0] != "mode").collect();
    let curves = MADE.table("error-curves.csv");
    assert_eq!(verdicts.len(), curves.len());
    let verdict = |scene: &str, mode: &str| {
        let place = |mode: &str| {
            curves
                .iter()
                .position(|row| row["scene"] == scene && row["mode"] == mode && row["technique"] == "independent")
        };
        let own = place(mode).unwrap();
        // What gives the same images is not judged twice.
        let judged = &curves[own]["equal_to"];
        verdicts[if judged.is_empty() { own } else { place(judged).unwrap() }][5].clone()
    };
    for (scene, mode) in [("camera-in-water", "naive"), ("camera-in-water", "stack"), ("nest", "naive")] {
        let verdict = verdict(scene, mode);
        assert!(verdict.starts_with("✗ biased"), "{scene}, {mode}: {verdict}");
    }
    for scene in ["camera-in-water", "nest"] {
        let verdict = verdict(scene, "rectified");
        assert!(verdict.starts_with("✓ none seen"), "{scene}: {verdict}");
    }
    assert!(
        MADE.page.contains("rectified shows no bias in 2 of 2 scenes") && MADE.page.contains("Other modes are wrong")
    );
}

/// What passed and what did not is on the page as it came out, and no case is missing.
#[test]
fn stability_is_shown_as_it_came_out() {
    let found = MADE.report.stability.as_ref().unwrap();
    let rows: Vec<_> = rows_of("cases").into_iter().filter(|row| row[0] != "case").collect();
    assert_eq!(rows.len(), found.cases.len());
    for (row, case) in rows.iter().zip(&found.cases) {
        assert_eq!(row[0], case.number.map_or("+".to_owned(), |number| number.to_string()));
        assert!(row[2].ends_with(case.outcome.name()), "{row:?}");
        if let Some(worst) = case.worst() {
            assert!((shown(&row[5]) - worst.error).abs() <= 0.01 * worst.error, "{row:?}: {worst:?}");
        }
    }
    let table = MADE.table("stability.csv");
    let measurements: usize = found.cases.iter().map(|case| case.measurements.len().max(1)).sum();
    assert_eq!(table.iter().filter(|row| row["check"] == "case").count(), measurements);
    assert_eq!(table.iter().filter(|row| row["outcome"] == "not run").count(), found.counts()[2]);
    assert!(table.iter().all(
        |row| row["outcome"] != "passed" || field(row, "error") <= field(row, "bound") + 4.0 * field(row, "noise")
    ));
    // The twin: a failure that is planted shows as one, with its reason.
    let mut report = MADE.report.clone();
    let planted = report.stability.as_mut().unwrap();
    planted.maps = vec![Map {
        quantity: "reflectance".into(),
        formula: "by hand".into(),
        etas: vec![0.5, 2.0],
        row_parameter: "cos θi".into(),
        rows: vec![0.25, 1.0],
        relative_errors: vec![vec![None, Some(1e-16)], vec![Some(0.0), Some(2e-16)]],
        wrong_decisions: 0,
        worst: 2e-16,
        worst_well_conditioned: 2e-16,
    }];
    let case = &mut planted.cases[3];
    case.outcome = Outcome::Failed { reason: "a <planted> fault".into() };
    let page = page::html(&report, &[]);
    assert!(pieces(&page).is_ok() && page.contains("a &lt;planted&gt; fault") && page.contains("1 failed"));
    // Maps have a line for each place with an error.
    let table = tables(&report).into_iter().find(|table| table.file == "fresnel-maps.csv").unwrap();
    assert!(table.text.ends_with("by hand,reflectance,2.0,cos θi,1.0,2e-16\r\n"), "{}", table.text);
    assert_eq!(table.text.lines().count(), 1 + 3);
}

/// Ratios of what was left out, likewise.
#[test]
fn what_was_left_out_is_on_the_page_as_in_the_table() {
    let rows = MADE.table("left-out.csv");
    let on_page = rows_of("left-out");
    for scene in &MADE.report.scenes {
        // The first is of all that is left out together.
        let row = rows.iter().find(|row| row["scene"] == scene.name).unwrap();
        let shown_row = on_page.iter().find(|cells| cells[0] == scene.name).unwrap();
        assert!((shown(&shown_row[1]) - field(row, "ratio")).abs() <= 0.0005 + 1e-12, "{shown_row:?}");
        assert_eq!(shown_row[4], "✓ equal");
        assert_eq!(row["equal"], "true");
        let [low, ratio, high] = ["ratio_low", "ratio", "ratio_high"].map(|name| field(row, name));
        assert!(low <= ratio && ratio <= high && low > 0.0);
        let names = row["left_out"].split(' ').collect::<Vec<_>>().join(", ");
        assert_eq!(shown_row[5], if names.is_empty() { "nothing" } else { &names });
    }
}

/// Times until pictures look clean, and those of frames, likewise.
#[test]
fn the_first_look_is_on_the_page_as_in_the_table() {
    let rows = MADE.table("first-look.csv");
    let on_page = rows_of("first-look");
    for scene in &MADE.report.scenes {
        let shown_row = on_page.iter().find(|cells| cells[0] == scene.name).unwrap();
        for (mode, cell) in ["naive", "stack", "rectified"].into_iter().zip(&shown_row[2..]) {
            let of_mode: Vec<_> = rows.iter().filter(|row| row["scene"] == scene.name && row["mode"] == mode).collect();
            let doublings = of_mode.iter().enumerate().all(|(k, row)| field(row, "samples") == 2.0_f64.powi(k as i32));
            assert!(!of_mode.is_empty() && doublings, "{mode}");
            let last = of_mode[of_mode.len() - 1];
            let is_clean = field(last, "flip") < 0.05;
            assert_eq!(last["clean_secs"].is_empty(), !is_clean, "{cell}");
            assert_eq!(cell.starts_with("more than"), !is_clean, "{cell}");
        }
    }
    let frames = rows_of("frames");
    assert_eq!(
        frames.iter().find(|cells| cells[0].starts_with("panels")).unwrap()[1..],
        ["1.3 ms", "2.5 ms", "5.0 ms"]
    );
    assert_eq!(field(&MADE.table("frames.csv")[0], "percentile_95_ms"), 2.5);
}

/// Times from an edit to the picture, likewise.
#[test]
fn edits_are_on_the_page_as_in_the_table() {
    let rows = MADE.table("editing.csv");
    let on_page = rows_of("editing");
    let digits = |text: &str| text.split(' ').next().unwrap().to_owned();
    for scene in &MADE.report.scenes {
        let shown_row = on_page.iter().find(|cells| cells[0] == scene.name).unwrap();
        for (kind, column) in [("ior", 1), ("transform", 4), ("camera", 7)] {
            let row = rows.iter().find(|row| row["scene"] == scene.name && row["edit"] == kind).unwrap();
            let (median, longest) = (field(row, "image_secs"), field(row, "worst_secs"));
            assert!(0.0 < median && median <= longest && field(row, "first_width") <= field(row, "pane_width"));
            assert_eq!(row["rectify_secs"].is_empty(), kind == "camera");
            // The camera has no column for rectification.
            let at = if kind == "camera" { column } else { column + 1 };
            // Three digits, in microseconds, milliseconds or seconds.
            let unit = [(" µs", 1e-6), (" ms", 1e-3)].into_iter().find(|(unit, _)| shown_row[at].contains(unit));
            let secs = shown(&digits(&shown_row[at])) * unit.map_or(1.0, |(_, secs)| secs);
            assert!((secs - median).abs() <= 0.006 * median, "{shown_row:?} for {median}");
        }
    }
}

/// What a finding begins with in every report: before its first number.
fn stem(what: &str) -> &str {
    what.split(|c: char| c.is_ascii_digit()).next().unwrap()
}

/// The README's figures are a report's summary, of this version of it: the same findings in the same order.
#[test]
fn the_readme_quotes_a_summary_as_it_is_made() {
    let readme = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let (_, quoted) = readme.split_once("<!-- summary.md -->\n").expect("the mark where the quotation begins");
    let (quoted, _) = quoted.split_once("<!-- end -->").expect("the mark where it ends");
    let made = std::fs::read_to_string(MADE.folder.path().join("summary.md")).unwrap();
    let stems = |text: &str| -> Vec<String> {
        text.lines().filter_map(|line| Some(stem(line.strip_prefix("- **")?).to_owned())).collect()
    };
    assert_eq!(stems(quoted), stems(&made), "made:\n{made}");
    assert!(quoted.starts_with("`iorect report") && quoted.contains(env!("CARGO_PKG_VERSION")));
    assert!(stems(&made).len() > 10);
}

/// JSON holds what the tables hold, and no pictures.
#[test]
fn json_is_complete_without_pixels() {
    let text = std::fs::read_to_string(MADE.folder.path().join("report.json")).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["scenes"][0]["title"], HOSTILE);
    assert_eq!(json["origin"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["origin"]["seed"], 5);
    assert!(json["origin"]["machine"]["cores"].as_u64().unwrap() >= 1);
    assert_eq!(json["scenes"][0]["pictures"]["rectified_png"], "");
    assert!(text.len() < 2_000_000);
    let events = &json["scenes"][0]["pictures"]["rectified_events"];
    assert!(events["crossings"].as_u64().unwrap() > 0 && events["mixed"].is_u64(), "{events}");
    let growth = MADE.table("growth.csv");
    let first = &json["growth"][0]["points"][0];
    assert_eq!(first["build_secs"].as_f64().unwrap(), field(&growth[0], "build_secs"));
    assert_eq!(json["scenes"][1]["camera_medium"], "water");
}

/// A report that is interrupted after each piece in turn ends as the one that was not, and nothing is done twice.
#[test]
fn an_interrupted_report_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let mut small = empty(1.0);
    add(&mut small, sphere(DVec3::ZERO, 1.0), 1.5, 0.0);
    small.camera.position = DVec3::new(0.0, 0.0, 4.0);
    let request = request(vec![subject("ball", small), subject("nest", hostile_nest())], &[Part::LeftOut]);
    let (mut runs, mut kept) = (0, 0);
    let report = loop {
        let (cancel, told) = (AtomicBool::new(false), AtomicUsize::new(0));
        // The piece that is begun after one was made is cancelled.
        let tell = |_: &str, _: f64| {
            if told.fetch_add(1, Ordering::Relaxed) > kept {
                cancel.store(true, Ordering::Relaxed);
            }
        };
        runs += 1;
        match make(&request, &store, &Progress { cancel: &cancel, tell: &tell }) {
            Ok(report) => break report,
            Err(error) => assert!(matches!(error, ReportError::Interrupted), "{error}"),
        }
        let now = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(now, kept + 1, "one piece more is finished");
        kept = now;
    };
    assert!(runs >= 4, "{runs} runs");
    assert_eq!(report.origin.pieces_reused, kept);
    // What does not depend on time is what it is without interruptions.
    let fresh = tempfile::tempdir().unwrap();
    let never = AtomicBool::new(false);
    let other = make(&request, &Store::open(fresh.path()).unwrap(), &quiet(&never)).unwrap();
    assert_eq!(other.origin.pieces_reused, 0);
    for (a, b) in report.scenes.iter().zip(&other.scenes) {
        assert_eq!(a.pictures, b.pictures);
        // What is equal is something, also of the pieces that were kept.
        assert!(a.pictures.as_ref().unwrap().rectified_events.crossings > 0);
    }
    // Times, too, are taken over to the last digit.
    let again = make(&request, &store, &quiet(&never)).unwrap();
    assert_eq!(again.origin.pieces_made, 0);
    assert!(again.scenes.iter().zip(&report.scenes).all(|(a, b)| a.left_out == b.left_out));
    // The twin: another seed, another scene.
    let other_seed = Request { extent: Extent::tiny(6, 2), ..request.clone() };
    assert_eq!(make(&other_seed, &store, &quiet(&never)).unwrap().origin.pieces_reused, 0);
    let mut edited = request.clone();
    let mut description = (*edited.subjects[0].description).clone();
    description.media[0].ior = iorect::optics::Ior::Constant(1.5000001);
    edited.subjects[0].description = Arc::new(description);
    assert_eq!(make(&edited, &store, &quiet(&never)).unwrap().origin.pieces_made, 2);
}

/// Parts that were not asked for are neither measured nor shown.
#[test]
fn only_what_is_asked_for_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let request = request(vec![subject("nest", hostile_nest())], &[Part::LeftOut]);
    let report = make(&request, &store, &quiet(&AtomicBool::new(false))).unwrap();
    assert!(report.growth.is_empty() && report.stability.is_none());
    let page = page::html(&report, &[]);
    assert!(page.contains("id=\"left-out\"") && !page.contains("id=\"growth\"") && !page.contains("id=\"stability\""));
    assert!(pieces(&page).is_ok());
    assert!(!Path::new("report.html").exists());
}

/// The program itself: what it writes and says, and that a second run takes everything over.
#[test]
fn the_command_writes_a_report_and_goes_on_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n[environment]\ncolor = [1.0, 1.0, 1.0]\n\
        [[medium]]\nname = \"glass\"\nior = 1.5\n\
        [[refractor]]\nname = \"ball\"\nmedium = \"glass\"\nshape = { sphere = { center = [0, 0, 0], radius = 1.0 } }\n";
    std::fs::write(folder.path().join("ball & chain.toml"), scene).unwrap();
    let run = |further: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_iorect"))
            .current_dir(folder.path())
            .args(["report", "ball & chain.toml", "-o", "a/report", "--tiny", "--only", "left-out", "--threads", "2"])
            .args(further)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stderr.is_empty(), "no progress without a terminal");
        String::from_utf8(output.stdout).unwrap()
    };
    let said = run(&[]);
    assert!(said.contains("report.html") && said.contains("left-out.csv"), "{said}");
    let page = std::fs::read_to_string(folder.path().join("a/report/report.html")).unwrap();
    assert!(pieces(&page).is_ok() && page.contains("'ball &amp; chain.toml'"));
    let json: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert_eq!((&json["origin"]["pieces_made"], &json["origin"]["pieces_reused"]), (&0.into(), &2.into()));
    assert_eq!(json["scenes"][0]["name"], "ball & chain");
    let left: Vec<String> = std::fs::read_dir(folder.path().join("a/report"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(
        left.iter().cloned().collect::<BTreeSet<_>>(),
        ["cache", "left-out.csv", "report.html", "report.json", "summary.md"].map(String::from).into()
    );
}
