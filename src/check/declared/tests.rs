use std::path::Path;
use std::sync::Arc;

use crate::check::{Problem, Severity, check};
use crate::formats;
use crate::scene::Description;
use crate::tracking::prepare;

const MEDIA: &str = r#"
[environment]
color = [1, 1, 1]
[[medium]]
name = "water"
ior = 1.333
absorption = [0.1, 0, 0]
[[medium]]
name = "ice"
ior = 1.31
[[medium]]
name = "oil"
ior = 1.47
"#;

fn scene(camera: &str, objects: &str) -> Description {
    let camera = format!("[camera]\ntarget = [0, 0, 0]\n{camera}\n");
    formats::parse(&format!("{camera}{MEDIA}{objects}"), Path::new("test.toml"), &formats::Disk).unwrap()
}

fn boxed(name: &str, medium: &str, half: [f64; 3], y: f64, more: &str) -> String {
    let [x, h, z] = half;
    let (low, high) = (y - h, y + h);
    format!(
        "[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\n{more}\nshape = {{ box = {{ min = [-{x}, {low}, -{z}], max = [{x}, {high}, {z}] }} }}\n"
    )
}

/// Findings about declarations.
fn found(description: Description) -> Vec<Problem> {
    let problems = check(&prepare(Arc::new(description), None).unwrap());
    problems.into_iter().filter(|problem| problem.kind.starts_with("declared")).collect()
}

const OUT: &str = "position = [0, 0, 20]";
const TANK: [f64; 3] = [4.0, 4.0, 4.0];

#[test]
fn a_wrong_exterior_is_named_with_the_right_one() {
    let tank = boxed("tank", "water", TANK, 0.0, "outside = \"world\"");
    let cube = |more: &str| tank.clone() + &boxed("cube", "ice", [1.0; 3], 0.0, more);
    let wrong = found(scene(OUT, &cube("outside = \"world\"")));
    let [only] = &wrong[..] else { panic!("{wrong:?}") };
    assert_eq!((only.severity, only.kind, only.place.as_str()), (Severity::Warning, "declared_outside", "cube"));
    assert_eq!(
        only.message,
        "it declares `world` (IOR 1) outside, but all of its surface lies in `water` (IOR 1.333): declare `water`."
    );
    assert_eq!(found(scene(OUT, &cube("outside = \"water\""))), []);
    // Silence counts as the world, but only where others have spoken.
    let silent = found(scene(OUT, &cube("")));
    assert_eq!((silent.len(), silent[0].severity), (1, Severity::Advice), "{silent:?}");
    let all_silent = boxed("tank", "water", TANK, 0.0, "") + &boxed("cube", "ice", [1.0; 3], 0.0, "");
    assert_eq!(found(scene(OUT, &all_silent)), []);
}

/// A cube of side 2 that sinks in by 1.5 has 4 + 4 · 3 of 24 in water.
#[test]
fn several_surroundings_are_given_with_their_shares() {
    let floating = boxed("tank", "water", TANK, 0.0, "outside = \"world\"")
        + &boxed("cube", "ice", [1.0; 3], 3.5, "priority = 1\noutside = \"world\"");
    let wrong = found(scene(OUT, &floating));
    let cube = wrong.iter().find(|problem| problem.place == "cube").unwrap_or_else(|| panic!("{wrong:?}"));
    // To the sampling of the faces that the waterline crosses.
    let shares = |percents: [u32; 3]| percents.iter().any(|p| cube.message.contains(&format!("{p} % of its surface")));
    assert!(shares([66, 67, 68]) && shares([32, 33, 34]), "{}", cube.message);
    assert!(cube.message.contains("no single exterior"), "{}", cube.message);
    assert!(cube.spot.is_some());
    // The part of the tank's surface that the cube fills is no interface.
    let tank = wrong.iter().find(|problem| problem.place == "tank").unwrap_or_else(|| panic!("{wrong:?}"));
    assert_eq!((tank.kind, tank.severity), ("declared_overlap", Severity::Advice));
}

#[test]
fn a_forgotten_medium_of_the_camera_is_found() {
    let tank = boxed("tank", "water", TANK, 0.0, "outside = \"world\"");
    let inside = "position = [0, 0, 3]";
    let forgotten = found(scene(inside, &tank));
    let [only] = &forgotten[..] else { panic!("{forgotten:?}") };
    assert_eq!((only.kind, only.place.as_str()), ("declared_camera", "camera"));
    assert!(only.message.ends_with("declare `water`"), "{}", only.message);
    assert_eq!(found(scene(&format!("{inside}\nmedium = \"water\""), &tank)), []);
    let elsewhere = found(scene(&format!("{OUT}\nmedium = \"oil\""), &tank));
    assert!(elsewhere[0].message.contains("to be in `oil` (IOR 1.47), but it is in `world` (IOR 1)"), "{elsewhere:?}");
}

#[test]
fn a_light_in_an_absorbing_medium_is_told_of_it() {
    let lamp = |more: &str| {
        boxed("tank", "water", TANK, 0.0, "outside = \"world\"")
            + &format!(
                "[[light]]\nname = \"lamp\"\nintensity = [1, 1, 1]\npoint = {{ position = [0, 1, 0] }}\n{more}\n"
            )
    };
    let kinds = |more: &str| found(scene(OUT, &lamp(more))).into_iter().map(|p| (p.kind, p.place)).collect::<Vec<_>>();
    assert_eq!(kinds(""), [("declared_light", "lamp".to_owned())]);
    assert_eq!(kinds("outside = \"oil\""), [("declared_light", "lamp".to_owned())]);
    assert_eq!(kinds("outside = \"water\""), []);
}

/// Two sheets, one above the other, must name the same medium between them.
#[test]
fn sheets_that_contradict_each_other() {
    let sheet = |name: &str, medium: &str, y: f64, outside: &str| {
        format!(
            "[[refractor]]\nname = \"{name}\"\nmedium = \"{medium}\"\noutside = \"{outside}\"\nshape = {{ quad = {{ center = [0, {y}, 0], edge_u = [0, 0, 9], edge_v = [9, 0, 0] }} }}\n"
        )
    };
    let both = |between: &str| sheet("low", "water", 0.0, "oil") + &sheet("high", between, 1.0, "world");
    assert_eq!(found(scene(OUT, &both("oil"))), []);
    let wrong = found(scene(OUT, &both("ice")));
    let [only] = &wrong[..] else { panic!("{wrong:?}") };
    assert_eq!((only.kind, only.place.as_str()), ("declared_contradiction", "low, high"));
    assert!(only.message.contains("`oil` (IOR 1.47) on the outer side of `low`"), "{}", only.message);
    assert!(only.message.contains("`ice` (IOR 1.31) on the inner side of `high`"), "{}", only.message);
}
