//! Indices of refraction.

use super::node::Node;
use crate::formats::suggest::suggestion;
use crate::optics::{Ior, catalog};
use crate::scene::SceneError;
use crate::scene::fields::IOR;

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
        return node.number_within(IOR).map(Ior::Constant);
    }
    let table = node.table()?;
    table.unknown(&FORMS).next().map_or(Ok(()), Err)?;
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
    IOR.require_of_formula(model.ior()).map_err(|message| node.error(message))?;
    Ok(model)
}
