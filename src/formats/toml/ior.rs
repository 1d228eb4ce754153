//! Indices of refraction.

use super::node::Node;
use crate::formats::suggest::suggestion;
use crate::optics::ior::IOR_RANGE;
use crate::optics::{Ior, catalog};
use crate::scene::SceneError;
use crate::scene::fields::Limits;

const LIMITS: Limits = Limits { must: "greater than 0 (from 1e-6 to 1e6)", is_fine: |n| IOR_RANGE.contains(&n) };

/// A number, or a table with one of the formulas.
pub(super) fn ior(node: &Node<'_>) -> Result<Ior, SceneError> {
    const FORMS: [&str; 3] = ["catalog", "cauchy", "sellmeier"];
    if !node.is_table() {
        if !node.is_number() {
            // Both forms in one sentence; `number` alone would hide the other.
            return Err(node.error(format!(
                "{} must be a number, or a table with one of {}, such as {{ catalog = \"water\" }}",
                node.name,
                FORMS.join(", ")
            )));
        }
        return node.number_within(LIMITS).map(Ior::Constant);
    }
    let table = node.table()?;
    table.only(&FORMS)?;
    let model = match table.present(&FORMS)[..] {
        ["catalog"] => {
            let entry = table.need("catalog")?;
            let name = entry.words()?;
            let found = catalog::find(name).ok_or_else(|| {
                let names = || catalog::ALL.iter().map(|entry| entry.name);
                entry.error(format!(
                    "the catalogue has no `{name}`{}; it has: {}",
                    suggestion(name, names()),
                    names().collect::<Vec<_>>().join(", ")
                ))
            })?;
            Ior::Catalog(found)
        }
        ["cauchy"] => Ior::Cauchy(table.need("cauchy")?.numbers()?),
        ["sellmeier"] => {
            let terms = table.need("sellmeier")?;
            let pairs = terms.items()?.iter().map(Node::numbers).collect::<Result<Vec<[f64; 2]>, _>>()?;
            if pairs.is_empty() {
                return Err(terms.error("`sellmeier` is empty, must be one or more pairs [B, C]"));
            }
            Ior::Sellmeier(pairs.into())
        }
        _ => return Err(node.error(format!("{} must have exactly one of {}", node.name, FORMS.join(", ")))),
    };
    let n = model.ior();
    if IOR_RANGE.contains(&n) {
        Ok(model)
    } else {
        Err(node.error(format!("the formula gives an IOR of {n} at 587.56 nm, must be {}", LIMITS.must)))
    }
}
