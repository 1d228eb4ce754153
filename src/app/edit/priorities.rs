//! The order of refractors by priority, and what changes when one is moved in it.

use super::Edit;
use crate::scene::Description;

/// Refractors of one priority, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    pub priority: i32,
    pub names: Vec<String>,
}

/// Where a refractor is moved to: at, above or below the level of that index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    Above(usize),
    At(usize),
    Below(usize),
}

/// The levels of a scene, highest first; within one, refractors stand as in the scene.
pub fn levels(description: &Description) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for object in description.objects.refractors() {
        let priority = object.refractor().map_or(0, |refractor| refractor.priority);
        let at = levels.partition_point(|level| level.priority > priority);
        match levels.get_mut(at).filter(|level| level.priority == priority) {
            Some(level) => level.names.push(object.name.clone()),
            None => levels.insert(at, Level { priority, names: vec![object.name.clone()] }),
        }
    }
    levels
}

/// The edit that moves a refractor; `None` if it is there already. Others keep their priorities where there is room between them.
pub fn moved(levels: &[Level], name: &str, place: Place) -> Option<Edit> {
    let (Place::Above(index) | Place::At(index) | Place::Below(index)) = place;
    let target = levels.get(index)?;
    let is_alone_there = target.names == [name];
    let from = levels.iter().position(|level| level.names.iter().any(|n| n == name))?;
    // The other levels, and before which of them the refractor goes.
    let mut others = levels.to_vec();
    others[from].names.retain(|n| n != name);
    let priority_of_target = target.priority;
    others.retain(|level| !level.names.is_empty());
    let priority = match place {
        Place::At(_) => priority_of_target,
        _ if is_alone_there => return None,
        _ => {
            let is_above = |level: &Level| match place {
                Place::Above(_) => level.priority > priority_of_target,
                _ => level.priority >= priority_of_target,
            };
            let before = others.partition_point(is_above);
            make_room(&mut others, before)
        }
    };
    others.push(Level { priority, names: vec![name.to_owned()] });
    let old =
        |name: &str| levels.iter().find(|level| level.names.iter().any(|n| n == name)).map(|level| level.priority);
    let changes = others.iter().flat_map(|level| level.names.iter().map(|name| (name.clone(), level.priority)));
    let changes: Vec<_> = changes.filter(|(name, priority)| old(name) != Some(*priority)).collect();
    (!changes.is_empty()).then_some(Edit::Priorities(changes))
}

/// One step up (1) or down (−1): a refractor that shares its level gets one of its own, one that is alone joins the next.
pub fn stepped(levels: &[Level], name: &str, step: i32) -> Option<Edit> {
    let from = levels.iter().position(|level| level.names.iter().any(|n| n == name))?;
    let is_alone = levels[from].names.len() == 1;
    let place = match (step > 0, is_alone) {
        (true, true) => Place::At(from.checked_sub(1)?),
        (true, false) => Place::Above(from),
        (false, true) => Place::At(from + 1),
        (false, false) => Place::Below(from),
    };
    moved(levels, name, place)
}

/// A priority for a new level before that of index `before`.
fn make_room(levels: &mut [Level], before: usize) -> i32 {
    let above = before.checked_sub(1).map(|i| i64::from(levels[i].priority));
    let below = levels.get(before).map(|level| i64::from(level.priority));
    let wanted = match (above, below) {
        (None, None) => 0,
        (Some(above), None) => above - 1,
        (None, Some(below)) => below + 1,
        (Some(above), Some(below)) if above - below > 1 => below + (above - below) / 2,
        (Some(_), Some(below)) => {
            // All above make room by one step.
            if levels[0].priority < i32::MAX {
                levels[..before].iter_mut().for_each(|level| level.priority += 1);
            }
            below + 1
        }
    };
    let is_taken = levels.iter().any(|level| i64::from(level.priority) == wanted);
    match i32::try_from(wanted) {
        Ok(wanted) if !is_taken => wanted,
        // At the ends of what numbers hold: all are numbered anew.
        _ => {
            let count = levels.len() as i32;
            for (level, index) in levels.iter_mut().zip(0..) {
                level.priority = if index < before as i32 { count - index } else { count - 1 - index };
            }
            count - before as i32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::build::empty_scene;
    use crate::scene::description::{Object, Refractor, Shape};

    fn scene(priorities: &[(&str, i32)]) -> Description {
        let mut scene = empty_scene();
        for &(name, priority) in priorities {
            let shape = Shape::Sphere { center: glam::DVec3::ZERO, radius: 1.0 };
            scene.objects.push(Object::new(name, shape, Refractor { priority, ..Refractor::of("glass") }));
        }
        scene
    }

    fn order(description: &Description) -> Vec<Vec<String>> {
        levels(description).into_iter().map(|level| level.names).collect()
    }

    /// Every refractor to every place: it stands there, and all others stand to each other as before.
    #[test]
    fn a_refractor_stands_where_it_is_moved_to_and_others_stay_in_order() {
        let scenes = [
            scene(&[("a", 3), ("b", 1), ("c", 1), ("d", 0)]),
            scene(&[("a", i32::MAX), ("b", i32::MAX - 1), ("c", i32::MIN)]),
            scene(&[("a", i32::MIN), ("b", i32::MIN + 1)]),
            scene(&[("a", 0), ("b", 0)]),
            scene(&[("a", 5)]),
        ];
        for before in scenes {
            let levels_before = levels(&before);
            for name in before.objects.refractors().iter().map(|object| object.name.clone()) {
                for index in 0..levels_before.len() {
                    for place in [Place::Above(index), Place::At(index), Place::Below(index)] {
                        let after = match moved(&levels_before, &name, place) {
                            Some(edit) => edit.apply(&before).unwrap().expect("something changes"),
                            None => before.clone(),
                        };
                        let without = |scene: &Description| {
                            let mut order = order(scene);
                            order.iter_mut().for_each(|names| names.retain(|n| *n != name));
                            order.retain(|names| !names.is_empty());
                            order
                        };
                        assert_eq!(without(&after), without(&before), "{name} to {place:?}");
                        let priority = |n: &str| after.objects.find(n).unwrap().refractor().unwrap().priority;
                        for other in levels_before[index].names.iter().filter(|other| **other != name) {
                            let (mine, theirs) = (priority(&name), priority(other));
                            let is_right = match place {
                                Place::Above(_) => mine > theirs,
                                Place::At(_) => mine == theirs,
                                Place::Below(_) => mine < theirs,
                            };
                            assert!(is_right, "{name} to {place:?}: {mine} and {theirs}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn steps_go_through_all_levels_and_between_them() {
        let mut description = scene(&[("a", 2), ("b", 1), ("c", 0)]);
        let mut seen = vec![order(&description)];
        while let Some(edit) = stepped(&levels(&description), "c", 1) {
            description = edit.apply(&description).unwrap().unwrap();
            seen.push(order(&description));
            assert!(seen.len() < 10);
        }
        let text = |order: &Vec<Vec<String>>| order.iter().map(|names| names.concat()).collect::<Vec<_>>().join(" ");
        let seen: Vec<String> = seen.iter().map(text).collect();
        assert_eq!(seen, ["a b c", "a bc", "a c b", "ac b", "c a b"]);
        while let Some(edit) = stepped(&levels(&description), "c", -1) {
            description = edit.apply(&description).unwrap().unwrap();
        }
        assert_eq!(text(&order(&description)), "a b c");
        assert!(stepped(&levels(&description), "soup", 1).is_none());
    }
}
