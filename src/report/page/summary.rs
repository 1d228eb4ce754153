//! The whole in a few sentences, each with what came of it.

use maud::{Markup, html};

use super::words::verdict;
use crate::report::data::Report;
use crate::report::summary::findings;

pub fn section(report: &Report) -> Markup {
    html! {
        section id="glance" {
            h2 { "At a glance" }
            ul class="glance" {
                @for finding in findings(report) {
                    li {
                        @match finding.is_good {
                            Some(true) => (verdict(Some(true), "yes")),
                            Some(false) => (verdict(Some(false), "no")),
                            None => {},
                        }
                        strong { (finding.what) }
                        span class="muted" { (finding.details) }
                    }
                }
            }
        }
    }
}
