//! The scene's tree: what stands below what, and what is marked.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::harness::{has_text, quick, until, window_of};

/// A bubble of air in a block of water, and a ball of glass that crosses the bubble's surface: `x` is where its middle is.
fn crossing(x: f64) -> String {
    format!(
        "name = \"Crossing\"\n[camera]\nposition = [0, 1, 9]\ntarget = [0, -1, 0]\n[environment]\ncolor = [1, 1, 1]\n\
         [[medium]]\nname = \"water\"\nior = 1.333\n[[medium]]\nname = \"air\"\nior = 1.0\n[[medium]]\nname = \"glass\"\nior = 1.5\n\
         [[refractor]]\nname = \"block\"\nmedium = \"water\"\nshape = {{ box = {{ min = [-3, -3, -3], max = [3, 0, 3] }} }}\n\
         [[refractor]]\nname = \"ball\"\nmedium = \"glass\"\npriority = 2\n\
         shape = {{ icosphere = {{ center = [{x}, -1.5, 0], radius = 0.5, subdivisions = 4 }} }}\n\
         [[refractor]]\nname = \"bubble\"\nmedium = \"air\"\npriority = 1\n\
         shape = {{ icosphere = {{ center = [0, -1.5, 0], radius = 1, subdivisions = 4 }} }}\n"
    )
}

/// Below the refractor that most of its surface lies in, and marked; a ball that crosses nothing has no mark.
#[test]
fn what_crosses_a_boundary_stands_below_its_majority_container_and_is_marked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("crossing.toml");
    for (x, is_mixed, is_in_bubble) in [(1.2, true, false), (0.8, true, true), (0.2, false, true), (2.2, false, false)]
    {
        std::fs::write(&path, crossing(x)).expect("the folder can be written to");
        let mut harness = window_of(path.to_str().expect("a plain path"), quick(), [1280.0, 720.0]);
        until(&mut harness, "the scene is prepared", |app| app.state().is_prepared());
        assert_eq!(has_text(&harness, "ball is mixed"), is_mixed, "at {x}");
        assert!(!has_text(&harness, "bubble is mixed") && !has_text(&harness, "block is mixed"), "at {x}");
        // Children follow their parents, and siblings the file, in which the ball comes first.
        let [block, ball, bubble] =
            ["block", "ball", "bubble"].map(|name| harness.get_by_role_and_label(Role::TreeItem, name).rect().top());
        assert!(block < ball && block < bubble && (bubble < ball) == is_in_bubble, "at {x}: {block}, {ball}, {bubble}");
        if is_mixed {
            harness.get_by_label("ball is mixed").hover();
            harness.run_steps(60);
            assert!(has_text(&harness, "It crosses a boundary: of its surface, "), "the mark says what it means");
        }
    }
}
