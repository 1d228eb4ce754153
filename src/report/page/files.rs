//! What lies beside the page, and how all of it is made again.

use maud::{Markup, html};

use crate::report::csv::Table;
use crate::report::data::Report;

pub fn section(report: &Report, tables: &[Table]) -> Markup {
    html! {
        p { "Everything here was measured by one command:" }
        pre { code { (report.origin.command) } }
        p {
            "It keeps what is finished in the folder " code { "cache" } " beside this page and, if it is interrupted, goes on from there when it is given again; what was made of another "
            "scene, with other settings, by another build or on another machine is not used. Images and answers depend on the seed alone. Times depend on the machine, and on what else it does."
        }
        p {
            "Numbers with all their digits lie beside this page: " a href="report.json" { "report.json" } " holds everything but the pictures, " a href="summary.md" { "summary.md" } " what stands at the top of this page; the tables are comma-separated values (RFC 4180)."
        }
        @for table in tables {
            details {
                summary { a href=(table.file) { (table.file) } ": " (table.about) }
                div class="scroll" {
                    table {
                        thead { tr { th { "column" } th { "what it holds" } } }
                        tbody { @for (name, about) in &table.columns { tr { th scope="row" { code { (name) } } td class="wide" { (about) } } } }
                    }
                }
            }
        }
        h3 { "Literature" }
        ul {
            li { "F. Rousselle, C. Knaus, M. Zwicker. " cite { "Adaptive Sampling and Reconstruction using Greedy Error Minimization" } ". SIGGRAPH Asia 2011: relMSE." }
            li { "P. Andersson et al. " cite { "Visualizing Errors in Rendered High Dynamic Range Images" } ". Eurographics 2021: HDR-FLIP." }
            li { "C. M. Schmidt, B. Budge. " cite { "Simple Nested Dielectrics in Ray Traced Images" } ". Journal of Graphics Tools 7(2), 2002: mode " code { "priority" } "." }
            li { "E. Veach. " cite { "Robust Monte Carlo Methods for Light Transport Simulation" } ". PhD thesis, Stanford, 1997." }
        }
    }
}
