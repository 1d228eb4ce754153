//! Media that nothing is made of, and what is not rendered of those that are used.

use std::collections::HashSet;

use super::{Problem, names};
use crate::optics::Ior;
use crate::tracking::Prepared;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let used: HashSet<&str> =
        description.objects.refractor_roles().map(|r| r.medium.as_str()).chain(description.declared()).collect();
    let (used, unused): (Vec<_>, Vec<_>) = description.media.iter().partition(|m| used.contains(m.name.as_str()));
    let mut problems = Vec::new();
    if !unused.is_empty() {
        let all = || unused.iter().map(|medium| medium.name.as_str());
        let message = match unused.len() {
            1 => "no refractor is made of this medium; remove it or use it".to_owned(),
            count => {
                let list = names::list(all());
                format!("no refractor is made of these {count} media, {list}; remove them or use them")
            }
        };
        problems.push(Problem::advice(names::place(all()), "unused_medium", message));
    }
    let used = used.iter().map(|m| (m.name.as_str(), &m.ior));
    let dispersive: Vec<(&str, &Ior)> = ([("world", &description.world.ior)].into_iter().chain(used))
        // A catalogue's entry is asked for by name, and its IOR is shown; a formula was written for its dispersion.
        .filter(|(_, ior)| ior.is_dispersive() && !matches!(ior, Ior::Catalog(_)))
        .collect();
    if !dispersive.is_empty() {
        let values: Vec<String> =
            dispersive.iter().take(8).map(|(name, ior)| format!("{name} {:.4}", ior.ior())).collect();
        problems.push(Problem::advice(
            names::place(dispersive.iter().map(|(name, _)| *name)),
            "dispersion",
            format!("dispersion is not rendered yet: every colour gets the IOR at 587.56 nm ({})", values.join(", ")),
        ));
    }
    problems
}
