//! What files of an inspected path hold.

use std::sync::Arc;

use super::outline::Outlines;
use super::{Traced, svg};
use crate::app::command::ExportKind;
use crate::app::state::State;
use crate::app::viewport::modes_drawn;
use crate::app::viewport::sight::Sight;
use crate::transport::parting::Compared;

/// The text of an SVG or JSON file of the paths over the active pane.
///
/// # Errors
/// When there is no path yet: in words for the user.
pub fn text_of(state: &State, kind: ExportKind) -> Result<String, String> {
    const NONE: &str = "There is no path to export: click a picture first.";
    let traced = state.inspection.as_ref().and_then(|inspection| inspection.traced.as_ref()).ok_or(NONE)?;
    match kind {
        ExportKind::PathSvg => {
            let sight = Sight::of(state).ok_or(NONE)?;
            let outlines = Arc::new(Outlines::of(&traced.question.report.prepared.scene));
            let whole = Traced { outlines, ..Traced::clone(traced) };
            Ok(svg::drawing(&whole, &modes_drawn(state, state.view.active_pane), &sight))
        }
        _ => json(state, traced).ok_or_else(|| NONE.to_owned()),
    }
}

/// As `iorect trace --json` writes it.
fn json(state: &State, traced: &Traced) -> Option<String> {
    let path = traced.path(state.inspected_mode())?;
    let text = match traced.question.pair {
        Some([a, b]) => {
            let (path, against) = (traced.path(a)?.clone(), traced.path(b)?.clone());
            serde_json::to_string_pretty(&Compared { path, against, parting: traced.parting.clone() })
        }
        None => serde_json::to_string_pretty(path),
    };
    Some(text.ok()? + "\n")
}
