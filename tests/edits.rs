//! What edits of objects do to the image and to the answers of rectification.

mod common;

use common::{nest, ready, render};
use iorect::scene::Description;
use iorect::tracking::Mode;

/// Hidden, and taken out of the file: the same world.
#[test]
fn an_invisible_object_is_as_if_it_were_not_there() {
    let hidden = |mut description: Description, index: usize| {
        description.refractors[index].visible = false;
        description
    };
    let removed = |mut description: Description, index: usize| {
        description.refractors.remove(index);
        description
    };
    let nested = || nest(1.0, &[(3.0, 1.5), (2.0, 1.33), (1.0, 1.0)]);
    for index in 0..3 {
        for mode in Mode::ALL {
            let image = |description| render(&ready(description), mode, (24, 24), 4, None).to_rgb();
            assert_eq!(image(hidden(nested(), index)), image(removed(nested(), index)), "object {index}, {mode}");
        }
    }
}
