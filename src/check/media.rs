//! Media that nothing is made of.

use std::collections::HashSet;

use super::{Problem, names};
use crate::tracking::Prepared;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let used: HashSet<&str> =
        description.objects.refractor_roles().map(|r| r.medium.as_str()).chain(description.declared()).collect();
    let unused = || description.media.iter().map(|m| m.name.as_str()).filter(|name| !used.contains(name));
    let message = match unused().count() {
        0 => return Vec::new(),
        1 => "no refractor is made of this medium; remove it or use it".to_owned(),
        count => {
            let list = names::list(unused());
            format!("no refractor is made of these {count} media, {list}; remove them or use them")
        }
    };
    vec![Problem::advice(names::place(unused()), "unused_medium", message)]
}
