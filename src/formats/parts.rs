//! The parts of a mesh file: which of its faces belong to which groups and to which material.

use std::collections::HashMap;
use std::ops::Range;

use super::suggest::suggestion;
use crate::scene::description::MeshPart;

/// What faces before the first name belong to, as OBJ calls it.
const UNNAMED: &str = "default";
/// Most names that an error lists.
const MOST_LISTED: usize = 20;

/// Names by number, in the order in which they came.
#[derive(Debug, Clone, Default)]
struct Names {
    all: Vec<String>,
    numbers: HashMap<String, u32>,
}

impl Names {
    fn number(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = self.all.len() as u32;
        self.all.push(name.to_owned());
        self.numbers.insert(name.to_owned(), number);
        number
    }
}

/// From one face on, what faces belong to.
#[derive(Debug, Clone, Default)]
struct Section {
    start: usize,
    groups: Vec<u32>,
    material: Option<u32>,
}

/// The parts of a file's faces, which are numbered in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    groups: Names,
    materials: Names,
    sections: Vec<Section>,
}

/// A part that a file does not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct NoSuchPart {
    /// The key that names it.
    pub key: &'static str,
    /// In words that follow the file's name.
    pub message: String,
}

impl Parts {
    /// From face `start` on, faces belong to `groups` and `material`. `start` never goes back.
    pub fn begin<'a>(&mut self, start: usize, groups: impl Iterator<Item = &'a str>, material: Option<&str>) {
        let mut groups: Vec<u32> = groups.map(|name| self.groups.number(name)).collect();
        groups.sort_unstable();
        groups.dedup();
        let section = Section { start, groups, material: material.map(|name| self.materials.number(name)) };
        match self.sections.last_mut() {
            Some(last) if last.start == start => *last = section,
            _ => self.sections.push(section),
        }
    }

    /// Those of `count` faces that have one of them.
    fn sections(&self, count: usize) -> impl Iterator<Item = (Range<usize>, &[u32], Option<u32>)> {
        let first = self.sections.first().map_or(count, |section| section.start.min(count));
        let ends = self.sections.iter().skip(1).map(|section| section.start).chain([count]);
        let named = self.sections.iter().zip(ends).map(move |(section, end)| {
            let range = section.start.min(count)..end.min(count);
            (range, &section.groups[..], section.material)
        });
        std::iter::once((0..first, &[][..], None)).chain(named).filter(|(range, ..)| !range.is_empty())
    }

    /// The names of the groups that any of the `count` faces belong to.
    pub fn groups(&self, count: usize) -> Vec<&str> {
        self.names(&self.groups, count, |groups, _| groups)
    }

    /// The names of the materials that any of the `count` faces have.
    pub fn materials(&self, count: usize) -> Vec<&str> {
        self.names(&self.materials, count, |_, material| material.as_slice())
    }

    fn names<'a>(
        &'a self,
        names: &'a Names,
        count: usize,
        of: impl for<'s> Fn(&'s [u32], &'s Option<u32>) -> &'s [u32],
    ) -> Vec<&'a str> {
        let mut is_used = vec![false; names.all.len()];
        let mut has_unnamed = false;
        for (_, groups, material) in self.sections(count) {
            let numbers = of(groups, &material);
            has_unnamed |= numbers.is_empty();
            numbers.iter().for_each(|&number| is_used[number as usize] = true);
        }
        let used = names.all.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let mut used: Vec<&str> = used.map(|(name, _)| name.as_str()).collect();
        if has_unnamed && !used.is_empty() && !used.contains(&UNNAMED) {
            used.insert(0, UNNAMED);
        }
        used
    }

    /// Whether each face is of one group, so that the groups together are the whole.
    pub fn has_one_group_each(&self, count: usize) -> bool {
        self.sections(count).all(|(_, groups, _)| groups.len() <= 1)
    }

    /// Which of `count` faces a part has: at least one.
    pub fn faces(&self, part: &MeshPart, count: usize) -> Result<Vec<Range<usize>>, NoSuchPart> {
        let group = part.group.as_deref().map(|name| (name, self.groups.numbers.get(name).copied()));
        let material = part.material.as_deref().map(|name| (name, self.materials.numbers.get(name).copied()));
        let is_of = |numbers: &[u32], wanted: Option<(&str, Option<u32>)>| match wanted {
            None => true,
            Some((name, number)) => match numbers {
                [] => name == UNNAMED,
                numbers => number.is_some_and(|number| numbers.contains(&number)),
            },
        };
        for (key, plural, name, names) in [
            ("group", "groups", &part.group, self.groups(count)),
            ("material", "materials", &part.material, self.materials(count)),
        ] {
            if let Some(name) = name.as_ref().filter(|name| !names.contains(&name.as_str())) {
                return Err(no_such(key, plural, name, &names));
            }
        }
        let of_both =
            (self.sections(count)).filter(|(_, groups, own)| is_of(groups, group) && is_of(own.as_slice(), material));
        let ranges: Vec<Range<usize>> = of_both.map(|(range, ..)| range).collect();
        match (&ranges[..], &part.group, &part.material) {
            ([], Some(group), Some(material)) => {
                let message = format!("has no face of the group `{group}` with the material `{material}`");
                Err(NoSuchPart { key: "material", message })
            }
            _ => Ok(ranges),
        }
    }
}

/// The name that is not there, and those that are.
fn no_such(key: &'static str, plural: &str, name: &str, names: &[&str]) -> NoSuchPart {
    let hint = suggestion(name, names.iter().copied());
    let list = match names {
        [] => format!("it has no {plural}"),
        names if names.len() > MOST_LISTED => {
            format!("{plural}: {} and {} more", names[..MOST_LISTED].join(", "), names.len() - MOST_LISTED)
        }
        names => format!("{plural}: {}", names.join(", ")),
    };
    NoSuchPart { key, message: format!("has no {key} `{name}`{hint}; {list}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> Parts {
        let mut parts = Parts::default();
        parts.begin(2, ["cup"].into_iter(), None);
        parts.begin(2, ["cup"].into_iter(), Some("glass"));
        parts.begin(4, ["cup", "all"].into_iter(), Some("wine"));
        parts.begin(6, ["cup"].into_iter(), Some("glass"));
        parts.begin(9, ["nothing"].into_iter(), Some("nothing"));
        parts
    }

    fn faces(part: MeshPart) -> Result<Vec<[usize; 2]>, NoSuchPart> {
        parts().faces(&part, 9).map(|ranges| ranges.iter().map(|range| [range.start, range.end]).collect())
    }

    #[test]
    fn faces_by_the_names_of_their_parts() {
        assert_eq!(parts().groups(9), ["default", "cup", "all"]);
        assert_eq!(parts().materials(9), ["default", "glass", "wine"]);
        assert_eq!(faces(MeshPart::of_group("cup")), Ok(vec![[2, 4], [4, 6], [6, 9]]));
        assert_eq!(faces(MeshPart::of_group("all")), Ok(vec![[4, 6]]));
        assert_eq!(faces(MeshPart::of_group("default")), Ok(vec![[0, 2]]));
        assert_eq!(faces(MeshPart::of_material("glass")), Ok(vec![[2, 4], [6, 9]]));
        assert_eq!(faces(MeshPart::of_material("default")), Ok(vec![[0, 2]]));
        let both = MeshPart { group: Some("all".into()), material: Some("wine".into()) };
        assert_eq!(faces(both), Ok(vec![[4, 6]]));
        assert_eq!(faces(MeshPart::default()), Ok(vec![[0, 2], [2, 4], [4, 6], [6, 9]]));
        assert!(!parts().has_one_group_each(9) && parts().has_one_group_each(4));
    }

    #[test]
    fn a_name_that_is_not_there_is_answered_with_those_that_are() {
        let message = |part| faces(part).unwrap_err().message;
        assert_eq!(
            message(MeshPart::of_material("wien")),
            "has no material `wien`; did you mean `wine`?; materials: default, glass, wine"
        );
        assert_eq!(faces(MeshPart::of_group("nothing")).unwrap_err().key, "group");
        let both = MeshPart { group: Some("all".into()), material: Some("glass".into()) };
        assert_eq!(message(both), "has no face of the group `all` with the material `glass`");
        let none = Parts::default().faces(&MeshPart::of_group("a"), 3).unwrap_err();
        assert_eq!(none.message, "has no group `a`; it has no groups");
        let mut many = Parts::default();
        (0..50).for_each(|i| many.begin(i, [&*format!("g{i}")].into_iter(), None));
        let message = many.faces(&MeshPart::of_group("?"), 50).unwrap_err().message;
        assert!(message.ends_with("g18, g19 and 30 more"), "{message}");
    }
}
