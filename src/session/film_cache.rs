//! Films that are not shown just now, kept for when they are wanted again: after a pane has shown something else, an edit was undone, or the
//! window had another size.
//!
//! Where memory runs short, films go that bring least time for their size, aged by what went before them: GreedyDual-Size (Cao and
//! Irani 1997).

use std::sync::Arc;

use super::job::Job;
use crate::rectify::table::InterfaceTable;
use crate::render::{Film, ImageSettings, Noise};
use crate::scene::camera::Camera;
use crate::scene::compile::looks_the_same;
use crate::scene::description::Description;
use crate::tracking::Mode;

/// Bytes of films that are kept.
pub(super) const MOST_BYTES: usize = 512 << 20;

/// All that decides a film's samples, but for its mode.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    description: Arc<Description>,
    table: Arc<InterfaceTable>,
    camera: Camera,
    size: [u32; 2],
    /// Of any mode.
    settings: ImageSettings,
    restarts: u64,
}

impl Picture {
    pub(super) fn of(job: &Job) -> Self {
        Self {
            description: Arc::clone(&job.prepared.description),
            table: Arc::clone(&job.prepared.table),
            camera: job.camera,
            size: job.request.size,
            settings: job.request.settings,
            restarts: job.request.restarts,
        }
    }

    fn is(&self, other: &Self) -> bool {
        self.size == other.size
            && self.camera == other.camera
            && self.settings == other.settings
            && self.restarts == other.restarts
            && (Arc::ptr_eq(&self.description, &other.description)
                || looks_the_same(&self.description, &other.description))
            && (Arc::ptr_eq(&self.table, &other.table) || self.table.says_the_same(&other.table))
    }
}

/// One mode's film at full size.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) mode: Mode,
    pub(super) film: Film,
    /// Time spent on it.
    pub(super) seconds: f64,
    pub(super) noise: Noise,
}

impl Entry {
    pub(super) fn new(mode: Mode, [width, height]: [u32; 2]) -> Self {
        Self { mode, film: Film::new(width, height), seconds: 0.0, noise: Noise::default() }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.film.sums[..]) + size_of_val(&self.film.counts[..]) + self.noise.bytes()
    }
}

struct Kept {
    picture: Picture,
    entry: Entry,
    bytes: usize,
    /// Those of the least value go first.
    value: f64,
}

pub(super) struct FilmCache {
    kept: Vec<Kept>,
    most_bytes: usize,
    /// Value of the last film that had to go.
    clock: f64,
}

impl FilmCache {
    pub(super) fn new(most_bytes: usize) -> Self {
        Self { kept: Vec::new(), most_bytes, clock: 0.0 }
    }

    /// Keeps a film, if it has samples and there is room.
    pub(super) fn put(&mut self, picture: &Picture, entry: Entry) {
        if entry.film.samples == 0 {
            return;
        }
        let bytes = entry.bytes();
        if bytes > self.most_bytes {
            return;
        }
        let value = self.clock + entry.seconds / bytes.max(1) as f64;
        // A better film of the same may be there from before.
        drop(self.take(picture, entry.mode));
        self.kept.push(Kept { picture: picture.clone(), entry, bytes, value });
        while self.kept.iter().map(|kept| kept.bytes).sum::<usize>() > self.most_bytes {
            let least = (0..self.kept.len()).min_by(|a, b| self.kept[*a].value.total_cmp(&self.kept[*b].value));
            let Some(least) = least else { break };
            self.clock = self.kept.remove(least).value;
        }
    }

    /// The film of that picture, which is then no longer kept.
    pub(super) fn take(&mut self, picture: &Picture, mode: Mode) -> Option<Entry> {
        let at = self.kept.iter().position(|kept| kept.entry.mode == mode && kept.picture.is(picture))?;
        Some(self.kept.remove(at).entry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::prepare;

    fn picture(scene: &Arc<Description>, size: [u32; 2]) -> Picture {
        Picture {
            description: Arc::clone(scene),
            table: prepare(Arc::clone(scene), None).unwrap().table,
            camera: Camera::new(&scene.camera).unwrap(),
            size,
            settings: ImageSettings::new(Mode::Rectified, 0),
            restarts: 0,
        }
    }

    fn entry(mode: Mode, samples: u32, seconds: f64) -> Entry {
        let mut entry = Entry::new(mode, [10, 10]);
        entry.film.samples = samples;
        Entry { seconds, ..entry }
    }

    #[test]
    fn a_film_comes_back_for_what_looks_the_same_and_nothing_else() {
        let scene = Arc::new(crate::formats::open("nested-spheres").unwrap());
        let there = picture(&scene, [10, 10]);
        let mut cache = FilmCache::new(1 << 20);
        cache.put(&there, entry(Mode::Stack, 7, 1.0));
        cache.put(&there, entry(Mode::Naive, 0, 1.0));
        assert!(cache.take(&there, Mode::Naive).is_none(), "without samples there is nothing to keep");
        assert!(cache.take(&there, Mode::Rectified).is_none());
        let mut others = vec![picture(&scene, [10, 11]), Picture { restarts: 1, ..there.clone() }];
        let mut edited = Description::clone(&scene);
        edited.world.ior = crate::optics::Ior::Constant(1.1);
        others.push(picture(&Arc::new(edited), [10, 10]));
        let mut moved = there.clone();
        moved.camera.position.x += 0.1;
        others.push(moved);
        others.push(Picture { settings: ImageSettings { max_depth: Some(3), ..there.settings }, ..there.clone() });
        assert!(others.iter().all(|other| cache.take(other, Mode::Stack).is_none()));
        // Typed anew, and under another name.
        let again = Description { name: "another".into(), ..Description::clone(&scene) };
        assert_eq!(cache.take(&picture(&Arc::new(again), [10, 10]), Mode::Stack).unwrap().film.samples, 7);
        assert!(cache.take(&there, Mode::Stack).is_none(), "it is there once");
    }

    #[test]
    fn what_took_least_time_goes_first() {
        let scene = Arc::new(crate::formats::open("plain-glass").unwrap());
        let there = picture(&scene, [10, 10]);
        let bytes = entry(Mode::Stack, 1, 1.0).bytes();
        let mut cache = FilmCache::new(2 * bytes);
        for (mode, seconds) in [(Mode::Stack, 5.0), (Mode::Naive, 0.1), (Mode::Rectified, 2.0)] {
            cache.put(&there, entry(mode, 1, seconds));
        }
        assert!(cache.take(&there, Mode::Naive).is_none());
        assert!(cache.take(&there, Mode::Stack).is_some() && cache.take(&there, Mode::Rectified).is_some());
        // One that is too large for all is not kept, and nothing goes on for ever.
        let mut cache = FilmCache::new(bytes - 1);
        cache.put(&there, entry(Mode::Stack, 1, 5.0));
        assert!(cache.take(&there, Mode::Stack).is_none());
    }
}
