//! `check` as a linter of scenes of Mitsuba and pbrt: a wrong exterior and a forgotten medium of the camera are found, with the right advice, and
//! right ones leave nothing to be said.

use std::path::Path;

use iorect::check::{Problem, Severity, check};
use iorect::formats::{Memory, read};
use iorect::scene::description::Description;

use crate::common::ready;

fn scene(name: &str, text: &str) -> Description {
    read(text.as_bytes(), Path::new(name), &Memory::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A refractor's medium, its index, and what is declared outside.
fn declared(description: &Description, object: &str) -> (String, f64, String) {
    let object = description.objects.find(object).unwrap_or_else(|| panic!("no {object}: {:?}", description.objects));
    let refractor = object.refractor().expect("a refractor");
    let ior = description.medium(&refractor.medium).unwrap().ior.ior();
    (refractor.medium.clone(), ior, refractor.outside.clone().unwrap_or_default())
}

/// What `check` says of declarations.
fn found(description: Description) -> Vec<Problem> {
    check(&ready(description)).into_iter().filter(|problem| problem.kind.starts_with("declared")).collect()
}

fn only(problems: &[Problem]) -> &Problem {
    let [only] = problems else { panic!("{problems:#?}") };
    only
}

mod mitsuba {
    use super::*;

    const SENSOR: &str = r#"<sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, 9" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>"#;

    fn read(inner: &str) -> Description {
        scene("s.xml", &format!("<scene version=\"3.0.0\">{inner}</scene>"))
    }

    fn glass(inside: &str, outside: &str) -> String {
        format!(r#"<bsdf type="dielectric"><float name="int_ior" value="{inside}"/>{outside}</bsdf>"#)
    }

    fn cube(id: &str, half: f64, inner: &str) -> String {
        format!(
            r#"<shape type="cube" id="{id}"><transform name="to_world"><scale value="{half}"/></transform>{inner}</shape>"#
        )
    }

    /// An ice cube in water that is declared against air, and the same declared against the water.
    #[test]
    fn a_wrong_exterior_is_found() {
        let tank = cube("tank", 3.0, &glass("1.333", r#"<string name="ext_ior" value="air"/>"#));
        let ice = |outside: &str| cube("ice", 1.0, &glass("1.31", outside));
        let wrong = read(&(SENSOR.to_owned() + &tank + &ice("")));
        assert_eq!(declared(&wrong, "ice"), ("ice".into(), 1.31, "world".into()));
        assert_eq!(declared(&wrong, "tank"), ("water".into(), 1.333, "world".into()));
        assert_eq!(wrong.world.ior.ior(), 1.000_277);
        let problems = found(wrong);
        let problem = only(&problems);
        let facts = (problem.severity, problem.kind, problem.place.as_str());
        assert_eq!(facts, (Severity::Warning, "declared_outside", "ice"));
        for words in ["all of its surface lies in `water` (IOR 1.333): declare `water`", "ext_ior = 1.333"] {
            assert!(problem.message.contains(words), "{}", problem.message);
        }
        let right = read(&(SENSOR.to_owned() + &tank + &ice(r#"<float name="ext_ior" value="1.333"/>"#)));
        assert_eq!(declared(&right, "ice").2, "water");
        assert_eq!(found(right), []);
    }

    #[test]
    fn a_forgotten_medium_of_the_camera_is_found() {
        let medium = r#"<medium type="homogeneous" id="sea"><rgb name="sigma_t" value="0.2, 0.1, 0"/><float name="albedo" value="0"/></medium>"#;
        let tank = cube("tank", 30.0, &(glass("1.333", "") + r#"<ref name="interior" id="sea"/>"#));
        let forgotten = read(&(medium.to_owned() + SENSOR + &tank));
        assert_eq!(declared(&forgotten, "tank"), ("sea".into(), 1.333, "world".into()));
        assert_eq!(forgotten.media[0].absorption, [0.2, 0.1, 0.0]);
        let problems = found(forgotten);
        let problem = only(&problems);
        assert_eq!((problem.kind, problem.place.as_str()), ("declared_camera", "camera"));
        for words in ["`sea` (IOR 1.333)", "declare `sea`"] {
            assert!(problem.message.contains(words), "{}", problem.message);
        }
        let sensor = SENSOR.replace("</sensor>", r#"<ref id="sea"/></sensor>"#);
        let right = read(&(medium.to_owned() + &sensor + &tank));
        assert_eq!(right.camera_medium.as_deref(), Some("sea"));
        assert_eq!(found(right), []);
    }
}

mod pbrt {
    use super::*;

    const CAMERA: &str = "LookAt 0 0 -9  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [40]\n";
    const MEDIA: &str = "MakeNamedMedium \"sea\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.2 0.1 0] \"rgb sigma_s\" [0 0 0]\n\
                         MakeNamedMedium \"frost\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.01 0 0] \"rgb sigma_s\" [0 0 0]\n";

    fn ball(radius: f64, eta: f64, media: [&str; 2]) -> String {
        let [inside, outside] = media;
        format!(
            "AttributeBegin\nMediumInterface \"{inside}\" \"{outside}\"\nMaterial \"dielectric\" \"float eta\" {eta}\n\
             Shape \"sphere\" \"float radius\" {radius}\nAttributeEnd\n"
        )
    }

    fn read(text: &str) -> Description {
        scene("s.pbrt", text)
    }

    /// Ice in water that is declared against air, and the same declared against the water.
    #[test]
    fn a_wrong_exterior_is_found() {
        let with = |ice: &str| read(&format!("{CAMERA}WorldBegin\n{MEDIA}{}{ice}", ball(3.0, 1.333, ["sea", ""])));
        let wrong = with(&ball(1.0, 1.31, ["frost", ""]));
        assert_eq!(declared(&wrong, "sphere"), ("sea".into(), 1.333, "world".into()));
        assert_eq!(declared(&wrong, "sphere 2"), ("frost".into(), 1.31, "world".into()));
        let problems = found(wrong);
        let problem = only(&problems);
        let facts = (problem.severity, problem.kind, problem.place.as_str());
        assert_eq!(facts, (Severity::Warning, "declared_outside", "sphere 2"));
        for words in ["all of its surface lies in `sea` (IOR 1.333): declare `sea`", "eta = 0.98275"] {
            assert!(problem.message.contains(words), "{}", problem.message);
        }
        // The index of a medium follows along the names.
        let right = with(&ball(1.0, 1.31 / 1.333, ["frost", "sea"]));
        let (medium, ior, outside) = declared(&right, "sphere 2");
        assert_eq!((medium.as_str(), outside.as_str()), ("frost", "sea"));
        assert!((ior - 1.31).abs() < 1e-12);
        assert_eq!(found(right), []);
        // Without names nobody knows what a ratio is to.
        let unnamed =
            format!("{CAMERA}WorldBegin\n{}{}", ball(3.0, 1.333, ["", ""]), ball(1.0, 1.31 / 1.333, ["", ""]));
        let problems = found(read(&unnamed));
        assert!(only(&problems).message.contains("is the ratio 1.31/1.333 already"), "{problems:?}");
    }

    #[test]
    fn a_forgotten_medium_of_the_camera_is_found() {
        let with =
            |before: &str| read(&format!("{MEDIA}{before}{CAMERA}WorldBegin\n{}", ball(30.0, 1.333, ["sea", ""])));
        let problems = found(with(""));
        let problem = only(&problems);
        assert_eq!((problem.kind, problem.place.as_str()), ("declared_camera", "camera"));
        assert!(problem.message.contains("declare `sea`"), "{}", problem.message);
        let right = with("MediumInterface \"\" \"sea\"\n");
        assert_eq!(right.camera_medium.as_deref(), Some("sea"));
        assert_eq!(found(right), []);
    }
}
