//! What pictures are made from.

use std::sync::Arc;

use super::Recipe;
use crate::app::settings::PaneContent;
use crate::app::slicer::CutSlice;
use crate::app::snapshots::{Kept, SnapshotId};
use crate::session::{Board, Halves, PaintedSurfaces, Snapshot};

/// What a picture was made from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// One film, or two for a difference.
    pub films: Vec<Arc<Snapshot>>,
    pub painted: Option<Arc<PaintedSurfaces>>,
    /// Pictures that were kept: after the film that is compared with one, if there is one.
    pub kept: Vec<Arc<Kept>>,
    /// Made by [`crate::app::slicer`].
    pub slice: Option<Arc<CutSlice>>,
    /// What the film is compared with, for an error.
    pub truth: Option<Arc<Halves>>,
}

impl Source {
    /// The two images, row by row, that a difference is of; `None` for anything else, or while they are not of one size.
    pub fn pair(&self) -> Option<[&[[f32; 3]]; 2]> {
        let truth = self.truth.iter().map(|truth| (truth.size, &truth.mean[..]));
        let mut images = self.images().map(|film| (film.size, &film.rgb[..])).chain(truth);
        let ((size, a), (other_size, b)) = (images.next()?, images.next()?);
        (size == other_size).then_some([a, b])
    }

    /// Films, and after them what was kept.
    pub fn images(&self) -> impl Iterator<Item = &Arc<Snapshot>> {
        self.films.iter().chain(self.kept.iter().map(|kept| &kept.film))
    }

    /// Whether it is made from the very same images.
    pub fn is(&self, other: &Self) -> bool {
        fn same<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
            a.map(Arc::as_ptr) == b.map(Arc::as_ptr)
        }
        self.films.len() == other.films.len()
            && self.kept.len() == other.kept.len()
            && self.images().zip(other.images()).all(|(a, b)| Arc::ptr_eq(a, b))
            && same(self.painted.as_ref(), other.painted.as_ref())
            && same(self.slice.as_ref(), other.slice.as_ref())
            && same(self.truth.as_ref(), other.truth.as_ref())
    }

    /// The epochs of what it was made from.
    pub fn epochs(&self) -> impl Iterator<Item = u64> {
        self.films.iter().map(|film| film.epoch).chain(self.painted.iter().map(|painted| painted.epoch))
    }

    /// The size of the whole picture, of which a preview has fewer pixels; `None` where there is none.
    pub fn full_size(&self) -> Option<[u32; 2]> {
        let painted = self.painted.iter().map(|painted| painted.full_size);
        self.images().map(|film| film.full_size).chain(painted).next()
    }

    /// Whether any of it is at a lower resolution.
    pub fn is_preview(&self) -> bool {
        self.films.iter().any(|film| film.is_preview())
            || self.painted.iter().any(|painted| painted.is_preview())
            || self.slice.iter().any(|slice| slice.is_preview())
    }

    /// Whether nothing more will come.
    pub fn is_done(&self) -> bool {
        self.films.iter().all(|film| film.is_done) && self.painted.iter().all(|painted| painted.is_done())
    }

    /// Samples for each pixel.
    pub fn samples(&self) -> u32 {
        let painted = self.painted.iter().map(|painted| painted.painting.rays);
        // There is no noise in a slice.
        let sliced = self.slice.iter().map(|_| u32::MAX);
        self.images().map(|film| film.samples).chain(painted).chain(sliced).min().unwrap_or(0)
    }
}

/// What there is to make pictures from.
pub(super) fn sources(recipe: &Recipe, board: &Board) -> Vec<(PaneContent, Source)> {
    let snapshots = board.snapshots();
    let paintings = board.paintings();
    let truth = board.ground_truth();
    let source = |content: PaneContent| {
        let films: Option<Vec<_>> = content.modes().map(|mode| snapshots.get(&mode).cloned()).collect();
        let source = Source { films: films?, ..Source::default() };
        Some(match content {
            PaneContent::Mode(_) | PaneContent::Difference(..) => source,
            PaneContent::Snapshot(_) | PaneContent::Change(..) | PaneContent::SnapshotDifference => {
                let kept = |id: SnapshotId| recipe.snapshots.get(id).cloned();
                Source { kept: content.snapshots().map(kept).collect::<Option<_>>()?, ..source }
            }
            PaneContent::Surfaces(quantity) => {
                Source { painted: Some(Arc::clone(paintings.get(&quantity)?)), ..source }
            }
            PaneContent::Slice(_) => return None,
            PaneContent::Error(_) => {
                let epoch = source.films.first()?.epoch;
                let truth = recipe.given.or_rendered(epoch, truth.clone())?;
                Source { truth: Some(truth.halves?), ..source }
            }
        })
    };
    recipe.contents.iter().filter_map(|content| Some((*content, source(*content)?))).collect()
}
