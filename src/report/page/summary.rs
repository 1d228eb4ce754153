//! The whole in a few sentences, each with what came of it.

use maud::{Markup, html};

use super::words::verdict;
use crate::report::data::Report;
use crate::report::summary::findings;

pub fn section(report: &Report) -> Markup {
    html! {
        ul class="glance" {
            @for finding in findings(report) {
                li {
                    @if let Some(is_good) = finding.is_good { (verdict(Some(is_good), if is_good { "yes" } else { "no" })) }
                    strong { (finding.what) }
                    span class="muted" { (finding.details) }
                }
            }
        }
    }
}
