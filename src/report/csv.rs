//! The report's tables as CSV (RFC 4180), each with words about its columns.

use super::data::Report;
use super::growth::Measure;
use super::stability::Map;

mod errors;

/// A file of comma-separated values.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the file, beside the page.
    pub file: &'static str,
    pub about: &'static str,
    /// Each column's name and what it holds.
    pub columns: Vec<(&'static str, &'static str)>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The file's contents.
    pub fn text(&self) -> String {
        let head: Vec<String> = self.columns.iter().map(|(name, _)| (*name).to_owned()).collect();
        let line = |row: &Vec<String>| row.iter().map(|field| quoted(field)).collect::<Vec<_>>().join(",") + "\r\n";
        std::iter::once(&head).chain(&self.rows).map(line).collect()
    }
}

/// In quotation marks where it has to be.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// All digits; empty for what is not known.
fn number(x: impl Into<Option<f64>>) -> String {
    x.into().map_or(String::new(), |x| format!("{x}"))
}

/// Every table that the report has something for.
pub fn tables(report: &Report) -> Vec<Table> {
    let all = [
        errors::runs(report),
        errors::points(report),
        errors::curves(report),
        errors::pairs(report),
        stability(report),
        maps(report),
        left_out(report),
        editing(report),
        growth(report),
        exponents(report),
    ];
    all.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn stability(report: &Report) -> Table {
    let rows = report.stability.as_ref().map_or(Vec::new(), |found| found.csv_rows().split_off(1));
    Table {
        file: "stability.csv",
        about: "Every measurement of the stiff and extreme cases and of the sweeps",
        columns: vec![
            ("check", "case or sweep"),
            ("number", "number of the case; empty for those beyond the forty, and for sweeps"),
            ("name", "name of the case or sweep"),
            ("at", "where in the sweep"),
            ("what", "what was measured"),
            ("expected", "the closed form's value"),
            ("measured", "what the program gave"),
            ("error", "how far apart the two are"),
            ("error_kind", "absolute or relative"),
            ("bound", "the largest error allowed, next to four times the noise"),
            ("noise", "standard error of what is random"),
            ("unit", "unit of the values"),
            ("outcome", "passed, failed or not run"),
            ("reason", "why not passed, where that is known"),
        ],
        rows,
    }
}

fn maps(report: &Report) -> Table {
    let maps = report.stability.iter().flat_map(|found| &found.maps);
    let rows_of = |map: &Map| {
        let rows = map.csv_rows().split_off(1);
        let parameter = map.row_parameter.clone();
        rows.into_iter().map(move |mut row| {
            row.insert(3, parameter.clone());
            row
        })
    };
    Table {
        file: "fresnel-maps.csv",
        about: "Relative errors of Fresnel's equations over index and angle",
        columns: vec![
            ("formula", "how it was computed"),
            ("quantity", "reflectance or transmittance"),
            ("eta", "index behind the interface over that before it"),
            ("row_parameter", "what the next column is"),
            ("row", "the angle, as the column before says"),
            ("relative_error", "against an evaluation with twice the digits"),
        ],
        rows: maps.flat_map(rows_of).collect(),
    }
}

fn left_out(report: &Report) -> Table {
    let mut rows = Vec::new();
    for scene in &report.scenes {
        let Some(found) = &scene.left_out else { continue };
        let mut row = |what: &str, task: &str, ratio: &super::timing::Ratio, is_equal: bool| {
            let times = [ratio.median, ratio.low, ratio.high, ratio.confidence, ratio.above_secs, ratio.below_secs];
            let start = [scene.name.clone(), what.to_owned(), task.to_owned()];
            let end = [ratio.pairs.to_string(), is_equal.to_string()];
            rows.push(start.into_iter().chain(times.map(number)).chain(end).collect());
        };
        row(&found.left_out.join(" "), "render", &found.render, found.images_are_equal);
        if let (Some(ratio), Some(is_equal)) = (&found.rectify, found.tables_are_equal) {
            row("nesting", "rectify", ratio, is_equal);
        }
        for one in &found.each {
            row(&one.need, "render", &one.ratio, one.images_are_equal);
        }
    }
    Table {
        file: "left-out.csv",
        about: "What a scene does not need, and the time with it over the time without",
        columns: vec![
            ("scene", "name of the scene"),
            (
                "left_out",
                "what is put back, in names separated by spaces: all that the scene does not need, or one of it",
            ),
            ("task", "render or rectify"),
            ("ratio", "time with what is left out over time without: median of the pairs' ratios"),
            ("ratio_low", "lower end of an interval for the true median, which supposes no distribution"),
            ("ratio_high", "its upper end"),
            ("confidence", "probability that the interval holds it"),
            ("with_secs", "median seconds of a slice of work with it"),
            ("without_secs", "median seconds of the same slice without"),
            ("pairs", "pairs of slices, taken by turns"),
            ("equal", "whether both ways gave the same image, or the same answers, to the last bit"),
        ],
        rows,
    }
}

fn editing(report: &Report) -> Table {
    let measured = report.scenes.iter().filter_map(|scene| Some((&scene.name, scene.editing.as_ref()?)));
    let rows = measured.flat_map(|(name, found)| {
        let [width, height] = found.size;
        found.times.iter().map(move |times| {
            let start = [name.clone(), times.edit.name().to_owned(), times.edits.to_string()];
            let seconds = [times.rectify_secs, Some(times.image_secs), Some(times.worst_secs)].map(number);
            let end = [times.width, width, height].map(|side| side.to_string());
            start.into_iter().chain(seconds).chain(end).collect()
        })
    });
    Table {
        file: "editing.csv",
        about: "How long the picture takes to follow an edit",
        columns: vec![
            ("scene", "name of the scene"),
            ("edit", "what is edited: ior, transform or camera"),
            ("edits", "how many were timed"),
            ("rectify_secs", "median seconds of rectifying the edited scene; empty where it need not be"),
            ("image_secs", "median seconds until each of four panes had a new image"),
            ("worst_secs", "the longest of those times"),
            ("first_width", "pixels across the coarsest of the first images, which are refined from there"),
            ("pane_width", "pixels across a pane"),
            ("pane_height", "pixels down a pane"),
        ],
        rows: rows.collect(),
    }
}

fn growth(report: &Report) -> Table {
    let rows = (report.growth.iter())
        .flat_map(|growth| growth.points.iter().map(move |point| (growth.quantity, point)))
        .map(|(quantity, point)| {
            let measured = Measure::ALL.map(|measure| number(measure.of(point)));
            let peak = number(point.peak_bytes.map(|bytes| bytes as f64));
            [quantity.name().to_owned(), point.size.to_string()].into_iter().chain(measured).chain([peak]).collect()
        })
        .collect();
    Table {
        file: "growth.csv",
        about: "Time and memory at each size",
        columns: vec![
            ("quantity", "what grows: triangles, nesting, objects or threads"),
            ("size", "how many of them"),
            ("build_secs", "seconds of tessellating, analysing meshes and building the tree"),
            ("rectify_secs", "seconds of rectification"),
            ("sample_secs", "seconds of one sample of one pixel, all threads working"),
            (
                "memory_bytes",
                "by how much the process's memory rose for the prepared scene, what earlier scenes left behind not counted; empty where it is too little to tell",
            ),
            ("peak_bytes", "the same of the most that it had while the scene was being prepared"),
        ],
        rows,
    }
}

fn exponents(report: &Report) -> Table {
    let rows = (report.growth.iter())
        .flat_map(|growth| growth.exponents.iter().map(move |exponent| (growth.quantity, exponent)))
        .map(|(quantity, e)| {
            let start = [quantity.name().to_owned(), e.measure.name().to_owned()];
            let numbers = [e.exponent, e.low, e.high].map(number);
            let end = [e.from_size.to_string(), e.points.to_string()];
            start.into_iter().chain(numbers).chain(end).collect()
        })
        .collect();
    Table {
        file: "exponents.csv",
        about: "How each measure of growth.csv grows: measure ~ size^exponent",
        columns: vec![
            ("quantity", "what grows"),
            ("measure", "build, rectify, sample or memory: a column of growth.csv"),
            ("exponent", "slope of a straight line through the logarithms, by least squares"),
            ("exponent_low", "lower end of its 95 % interval, if the points scatter independently about the line"),
            ("exponent_high", "its upper end"),
            ("from_size", "the smallest size that counts: below, what does not grow decides"),
            ("points", "sizes that count"),
        ],
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_have_to_be() {
        let table = Table {
            file: "a.csv",
            about: "",
            columns: vec![("name", ""), ("value", "")],
            rows: vec![vec!["plain".into(), "1".into()], vec!["a, \"b\"\nc".into(), String::new()]],
        };
        assert_eq!(table.text(), "name,value\r\nplain,1\r\n\"a, \"\"b\"\"\nc\",\r\n");
        assert_eq!(
            [number(0.1), number(1e-300), number(None)],
            ["0.1".to_owned(), format!("{}", 1e-300), String::new()]
        );
    }
}
