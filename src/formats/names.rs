//! Names for the objects and media of scenes that come from other formats, where names may be missing or there twice.

use std::collections::HashMap;

use crate::scene::validate::reserved_name;

/// Gives out names, each once.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// With the number that comes next after it.
    taken: HashMap<String, u32>,
}

impl Names {
    /// `wanted`, or where that is empty `otherwise`; with a number after it where it is taken or reserved.
    pub fn give(&mut self, wanted: &str, otherwise: &str) -> String {
        let wanted = match wanted.trim() {
            "" => otherwise,
            wanted => wanted,
        };
        let mut number = match self.taken.get(wanted) {
            None if reserved_name(wanted, "object").is_none() => {
                self.taken.insert(wanted.to_owned(), 2);
                return wanted.to_owned();
            }
            None => 2,
            Some(&next) => next,
        };
        let name = loop {
            let name = format!("{wanted} {number}");
            number += 1;
            if !self.taken.contains_key(&name) {
                break name;
            }
        };
        self.taken.insert(wanted.to_owned(), number);
        self.taken.insert(name.clone(), 2);
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_given_once() {
        let mut names = Names::default();
        let given = ["a", "a", " a 2 ", "a", "", "", "world"].map(|wanted| names.give(wanted, "part"));
        assert_eq!(given, ["a", "a 2", "a 2 2", "a 3", "part", "part 2", "world 2"]);
    }
}
