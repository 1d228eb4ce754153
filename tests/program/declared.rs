//! The program as a linter of other renderers' scenes: what a file declares, against what is found, told by the exit code and as JSON.

use serde_json::Value;

use crate::desk::Desk;

const MITSUBA: &str = r#"<scene version="3.0.0">
<sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, 9" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
<emitter type="constant"/>
<shape type="sphere" id="water"><float name="radius" value="2"/><bsdf type="dielectric"><string name="int_ior" value="water"/></bsdf></shape>
<shape type="sphere" id="ice"><bsdf type="dielectric"><float name="int_ior" value="1.31"/><EXT/></bsdf></shape>
</scene>
"#;

const PBRT: &str = r#"LookAt 0 0 -9  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
MakeNamedMedium "water" "string type" "homogeneous" "rgb sigma_a" [0 0 0] "rgb sigma_s" [0 0 0]
LightSource "infinite" "rgb L" [1 1 1]
AttributeBegin
MediumInterface "water" ""
Material "dielectric" "float eta" 1.333
Shape "sphere" "float radius" 2
AttributeEnd
MediumInterface "" OUTSIDE
Material "dielectric" "float eta" ETA
Shape "sphere"
"#;

fn problems(desk: &Desk, scene: &str) -> (i32, Vec<Value>) {
    let output = desk.run(&format!("check {scene} --json --deny warning"));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    (output.status.code().unwrap(), report["problems"].as_array().unwrap().clone())
}

#[test]
fn a_wrong_exterior_fails_the_check_and_the_right_one_passes() {
    let mitsuba = |ext: &str| MITSUBA.replace("<EXT/>", ext);
    let pbrt = |outside: &str, eta: &str| PBRT.replace("OUTSIDE", outside).replace("ETA", eta);
    let desk = Desk::with("wrong.xml", &mitsuba(""));
    desk.put("right.xml", mitsuba(r#"<float name="ext_ior" value="1.333"/>"#));
    desk.put("wrong.pbrt", pbrt("\"\"", "1.31"));
    desk.put("right.pbrt", pbrt("\"water\"", "0.98275"));
    for (scene, advice) in [("wrong.xml", "ext_ior = 1.333"), ("wrong.pbrt", "eta = 0.98275")] {
        let (code, problems) = problems(&desk, scene);
        assert_eq!(code, 1, "{scene}");
        let found = problems.iter().find(|problem| problem["kind"] == "declared_outside");
        let found = found.unwrap_or_else(|| panic!("{scene}: {problems:?}"));
        assert!(found["message"].as_str().unwrap().contains(advice), "{scene}: {found}");
    }
    for scene in ["right.xml", "right.pbrt"] {
        let (code, problems) = problems(&desk, scene);
        assert!(code == 0 && problems.iter().all(|problem| problem["severity"] == "advice"), "{scene}: {problems:?}");
    }
}

#[test]
fn a_scene_of_another_renderer_is_rendered_and_converted() {
    let desk = Desk::with("s.xml", &MITSUBA.replace("<EXT/>", ""));
    for mode in ["declared", "rectified"] {
        desk.fine(&format!("render s.xml --mode {mode} --size 16x12 --spp 1 -o {mode}.exr"));
    }
    assert_ne!(desk.picture("declared.exr"), desk.picture("rectified.exr"));
    desk.fine("convert s.xml s.toml");
    desk.fine("render s.toml --mode declared --size 16x12 --spp 1 -o again.exr");
    assert_eq!(desk.picture("again.exr"), desk.picture("declared.exr"));
}
