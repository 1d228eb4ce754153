//! Surfaces that so many others meet that their surroundings are not worked out beforehand.

use super::Problem;
use crate::tracking::Prepared;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let scene = &*prepared.scene;
    (prepared.table.crowded().into_iter())
        .map(|(object, faces)| {
            let (verb, whom) = if faces == 1 { ("is", "it") } else { ("are", "them") };
            Problem::warning(
                &scene.object(object).name,
                "crowded",
                format!(
                    "{faces} of its faces {verb} each met by more than a hundred others at one place: what lies beside {whom} is asked anew at every hit, \
                     which is right but slow. Remove repeated or nearly repeated surfaces there"
                ),
            )
        })
        .collect()
}
