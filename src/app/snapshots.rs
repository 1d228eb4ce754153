//! Pictures that are kept, to be held against what comes after an edit. There is room for two.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::settings::PaneContent;
use crate::scene::Description;
use crate::scene::description::CameraDescription;
use crate::session::Snapshot;

/// Changes of IORs that are named one by one.
const MOST_CHANGES: usize = 2;

/// Which of the kept pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SnapshotId {
    A,
    B,
}

impl SnapshotId {
    pub const ALL: [Self; 2] = [Self::A, Self::B];
}

impl fmt::Display for SnapshotId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::A => "A",
            Self::B => "B",
        })
    }
}

/// A film and what it shows.
#[derive(Debug)]
pub struct Kept {
    pub film: Arc<Snapshot>,
    description: Arc<Description>,
    camera: CameraDescription,
}

impl Kept {
    pub fn new(film: Arc<Snapshot>, description: Arc<Description>, camera: CameraDescription) -> Self {
        Self { film, description, camera }
    }

    /// In what it differs from the scene and the view as they are now; empty where it does not.
    pub fn changes(&self, now: &Arc<Description>, camera: &CameraDescription) -> Vec<String> {
        let mut changes = Vec::new();
        let before = &self.description;
        if before.name != now.name {
            changes.push(before.name.clone());
        } else if !Arc::ptr_eq(before, now) {
            let present = iors(now);
            let mut named: Vec<String> = (iors(before).into_iter())
                .filter_map(|(name, old)| {
                    let (_, new) = present.iter().find(|(other, _)| *other == name)?;
                    (old != *new).then(|| format!("{name} {} → {}", short(old), short(*new)))
                })
                .collect();
            if named.len() > MOST_CHANGES {
                named = vec![format!("{} IORs changed", named.len())];
            } else if named.is_empty() {
                named.push("before edits".to_owned());
            }
            changes.extend(named);
        }
        if self.camera != *camera {
            changes.push("other view".to_owned());
        }
        changes
    }

    /// What it is in a line: mode, changes, samples.
    pub fn title(&self, now: &Arc<Description>, camera: &CameraDescription) -> String {
        let mut parts = vec![self.film.mode.name().to_owned()];
        parts.extend(self.changes(now, camera));
        parts.push(format!("{} spp", self.film.samples));
        parts.join(", ")
    }
}

/// Every medium's name and IOR, the world's first.
fn iors(description: &Description) -> Vec<(&str, f64)> {
    let world = [("world", description.world.ior.ior())];
    world.into_iter().chain(description.media.iter().map(|medium| (medium.name.as_str(), medium.ior.ior()))).collect()
}

fn short(ior: f64) -> String {
    ((ior * 1e5).round() / 1e5).to_string()
}

/// The kept pictures.
#[derive(Debug, Clone, Default)]
pub struct Snapshots([Option<Arc<Kept>>; 2]);

/// Whether they are the very same pictures.
impl PartialEq for Snapshots {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| a.as_ref().map(Arc::as_ptr) == b.as_ref().map(Arc::as_ptr))
    }
}

impl Snapshots {
    pub fn get(&self, id: SnapshotId) -> Option<&Arc<Kept>> {
        self.0[id as usize].as_ref()
    }

    pub fn set(&mut self, id: SnapshotId, kept: Option<Arc<Kept>>) {
        self.0[id as usize] = kept;
    }

    /// Why there is no picture of `content`, while films have `film_size`; `None` where snapshots are no obstacle.
    pub fn obstacle(&self, content: PaneContent, film_size: [u32; 2]) -> Option<String> {
        let mut sizes = match content {
            PaneContent::Change(..) => vec![("the film".to_owned(), film_size)],
            _ => Vec::new(),
        };
        for id in content.snapshots() {
            let Some(kept) = self.get(id) else {
                let key = if id == SnapshotId::A { "K" } else { "Shift+K" };
                return Some(format!(
                    "Snapshot {id} is empty.\nKeep a picture as {id} with {key} or in a pane's menu."
                ));
            };
            sizes.push((format!("snapshot {id}"), kept.film.size));
        }
        let [(a, size_a), (b, size_b)] = &sizes[..] else { return None };
        let text = |size: &[u32; 2]| format!("{} × {}", size[0], size[1]);
        (size_a != size_b).then(|| {
            let sizes = format!("No difference: {a} has {} pixels, {b} has {}.", text(size_a), text(size_b));
            format!("{sizes}\nKeep it anew, or give the window its old size.")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Ior;
    use crate::tracking::Mode;

    fn kept(size: [u32; 2], description: &Arc<Description>) -> Arc<Kept> {
        let film = Snapshot::of(Mode::Stack, size, vec![[0.0; 3]; (size[0] * size[1]) as usize]);
        Arc::new(Kept::new(film, Arc::clone(description), description.camera))
    }

    #[test]
    fn a_snapshot_says_what_has_changed_since() {
        let before = Arc::new(crate::formats::open("nested-spheres").unwrap());
        let kept = kept([2, 1], &before);
        assert_eq!(kept.title(&before, &before.camera), "stack, 1 spp");
        let mut edited = Description::clone(&before);
        let old = edited.media[0].ior.ior();
        edited.media[0].ior = Ior::Constant(1.7);
        let edited = Arc::new(edited);
        let expected = format!("{} {} → 1.7", before.media[0].name, short(old));
        assert_eq!(kept.changes(&edited, &before.camera), [expected]);
        let mut camera = before.camera;
        camera.vertical_fov += 1.0;
        assert_eq!(kept.changes(&before, &camera), ["other view"]);
        let other = Arc::new(crate::formats::open("plain-glass").unwrap());
        assert_eq!(kept.changes(&other, &before.camera)[0], before.name);
    }

    #[test]
    fn sizes_that_differ_are_said_plainly() {
        let scene = Arc::new(crate::formats::open("nested-spheres").unwrap());
        let mut snapshots = Snapshots::default();
        let change = PaneContent::Change(Mode::Stack, SnapshotId::A);
        assert!(snapshots.obstacle(change, [4, 2]).unwrap().contains("Snapshot A is empty"));
        snapshots.set(SnapshotId::A, Some(kept([4, 2], &scene)));
        assert_eq!(snapshots.obstacle(change, [4, 2]), None);
        let text = snapshots.obstacle(change, [4, 3]).unwrap();
        assert!(text.contains("4 × 3") && text.contains("4 × 2"), "{text}");
        assert!(snapshots.obstacle(PaneContent::SnapshotDifference, [4, 2]).unwrap().contains("Snapshot B is empty"));
        snapshots.set(SnapshotId::B, Some(kept([2, 2], &scene)));
        assert!(snapshots.obstacle(PaneContent::SnapshotDifference, [4, 2]).unwrap().contains("2 × 2"));
        assert_eq!(snapshots.obstacle(PaneContent::Snapshot(SnapshotId::B), [4, 2]), None);
        assert_eq!(snapshots.obstacle(PaneContent::Mode(Mode::Stack), [4, 2]), None);
    }
}
