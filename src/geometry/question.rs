//! What a search along a ray looks for.

use super::ray::Hit;

/// What to do with a hit. Returns whether the search is over.
pub(super) trait Question {
    fn found(&mut self, hit: Hit, t_max: &mut f64) -> bool;
}
