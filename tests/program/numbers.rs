//! Numbers beyond what files, sums and products hold: finite pictures with a count of what was capped, or a refusal that names the limit.

use crate::desk::{self, Desk};
use serde_json::Value;

const CAMERA: &str = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nvertical_fov = 30\n";
const GLASS: &str = "[[medium]]\nname = \"glass\"\nior = 1.5\n";

fn ball(extra: &str) -> String {
    format!(
        "{GLASS}{extra}[[refractor]]\nname = \"ball\"\nmedium = \"glass\"\nshape = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}\n"
    )
}

fn lamp(radiance: &str) -> String {
    let shape = "shape = { sphere = { center = [0, 2, 0], radius = 1 } }";
    format!("[[light]]\nname = \"lamp\"\nradiance = [{radiance}, {radiance}, 1]\n{shape}\n")
}

/// What is finite is said to be, in every mode.
fn finite_pixels(desk: &Desk, scene: &str) -> (Vec<f32>, Value) {
    desk.put("s.toml", scene);
    for mode in ["naive", "declared", "stack", "priority", "rectified-object", "reference", "rectified"] {
        let said = desk.json(&format!("render s.toml --mode {mode} --size 12x12 --spp 16 -o s.exr --json"));
        let pixels = desk.picture("s.exr");
        assert!(pixels.iter().all(|x| x.is_finite() && *x >= 0.0), "{mode}: {scene}");
        assert_eq!(said["events"]["non_finite"], 0, "{mode}: {scene}");
        if mode == "rectified" {
            return (pixels, said);
        }
    }
    unreachable!("the last mode returns");
}

#[test]
fn radiance_beyond_the_files_format_is_capped_counted_and_said() {
    let desk = Desk::with("s.toml", CAMERA);
    for radiance in ["1e38", "1e39", "1e100"] {
        let is_beyond = radiance != "1e38";
        let sky = format!("{CAMERA}[environment]\ncolor = [{radiance}, 1, 0]\n{}", ball(""));
        for scene in [sky, format!("{CAMERA}{}{}", ball(""), lamp(radiance))] {
            let (pixels, said) = finite_pixels(&desk, &scene);
            let overflow = said["events"]["radiance_overflow"].as_u64().unwrap();
            assert_eq!(overflow > 0, is_beyond, "{radiance}");
            assert_eq!(pixels.contains(&f32::MAX), is_beyond, "{radiance}");
            let words = desk.fine("render s.toml --size 12x12 --spp 16");
            assert_eq!(words.contains("radiance overflow"), is_beyond, "{words}");
        }
    }
    // Parts are merged with their counts, comparisons have figures, and the picture's labels say so too.
    desk.fine("render s.toml --size 8x8 --samples 0..4 -o a.exr");
    desk.fine("render s.toml --size 8x8 --samples 4..8 -o b.exr");
    let merged = desk.json("merge a.exr b.exr -o all.exr --json");
    assert!(merged["events"]["radiance_overflow"].as_u64().unwrap() > 0);
    assert!(desk.picture("all.exr").contains(&f32::MAX));
    let compared = desk.json("compare s.toml --size 8x8 --spp 4 -o c.png --json");
    for pair in compared["differences"].as_array().unwrap() {
        for figure in ["mse", "relmse", "mean_abs", "flip"] {
            assert!(pair[figure].is_number(), "{figure}: {pair}");
        }
    }
}

fn refused(desk: &Desk, scene: &str, expected: &[&str]) {
    desk.put("s.toml", scene);
    let error = desk.wrong("render s.toml --size 8x8 --spp 1 -o s.exr");
    for part in expected {
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    }
}

#[test]
fn what_no_sum_could_hold_is_refused_with_its_limit() {
    let desk = Desk::with("s.toml", CAMERA);
    refused(&desk, &format!("{CAMERA}{}{}", ball(""), lamp("1e300")), &["s.toml:", "`radiance`", "at most 1e100"]);
    refused(&desk, &format!("{CAMERA}[environment]\ncolor = [1e101, 0, 0]\n"), &["`color`", "at most 1e100"]);
    let gradient = "gradient = { zenith = [0, 0, 0], horizon = [0, 0, 1e308], nadir = [0, 0, 0] }";
    refused(&desk, &format!("{CAMERA}[environment]\n{gradient}\n"), &["`horizon`", "at most 1e100"]);
    let camera = |from: &str, to: &str| format!("[camera]\n{}\n", CAMERA[9..].replace(from, to));
    refused(&desk, &camera("[0, 0, 5]", "[0, 0, 1e300]"), &["position", "within 1e18"]);
    refused(&desk, &camera("[0, 0, 0]", "[0, -1e19, 0]"), &["target", "within 1e18"]);
    refused(&desk, &format!("{CAMERA}aperture_radius = 1e200\n"), &["aperture_radius", "at most 1e18"]);
    refused(&desk, &format!("{CAMERA}focus_distance = 1e-200\n"), &["focus_distance", "1e-100"]);
    let scaled = |scale: &str| format!("{CAMERA}{}transform = {{ scale = {scale} }}\n", ball(""));
    refused(&desk, &scaled("1e-300"), &["`scale`", "at least 1e-100"]);
    refused(&desk, &scaled("1e300"), &["`scale`", "at most 1e18"]);
    let small = scaled("1e-80").replace("radius = 1 }", "radius = 1e-80 }");
    refused(&desk, &small, &["`ball`", "at least 1e-100"]);
    let small = small.replace("sphere = {", "icosphere = { subdivisions = 1,");
    refused(&desk, &small, &["`ball`", "smaller than 1e-100"]);
    assert!(desk.wrong("trace iced-water --origin 0,0,1e300 --direction 0,0,-1").contains("at most 1e18"));
}

#[test]
fn extremes_within_the_limits_stay_finite() {
    let desk = Desk::with("s.toml", CAMERA);
    let white = "[environment]\ncolor = [1, 1, 1]\n";
    for absorption in ["1e-308", "1e5", "1e300", "1e308"] {
        let scene = format!("{CAMERA}{white}{}", ball(&format!("absorption = [{absorption}, {absorption}, 0]\n")));
        finite_pixels(&desk, &scene);
        finite_pixels(&desk, &format!("{CAMERA}[world]\nabsorption = [{absorption}, 0, 0]\n{white}{}", ball("")));
    }
    for (from, to) in
        [("[0, 0, 5]", "[0, 0, 1e18]"), ("[0, 0, 0]", "[1e18, 1e18, -1e18]"), ("30", "1e-300"), ("30", "179.9999999")]
    {
        let (head, rest) = CAMERA.split_at(9);
        finite_pixels(&desk, &format!("{head}{}{white}{}", rest.replace(from, to), ball("")));
    }
    finite_pixels(&desk, &format!("{CAMERA}aperture_radius = 1e18\nfocus_distance = 1e-100\n{white}{}", ball("")));
    for scale in ["1e-90", "1e-20", "1e17"] {
        finite_pixels(&desk, &format!("{CAMERA}{white}{}transform = {{ scale = {scale} }}\n", ball("")));
    }
    for radiance in ["5e-324", "1e-300"] {
        finite_pixels(&desk, &format!("{CAMERA}{}{}", ball(""), lamp(radiance)));
    }
}

/// Small spheres far from each other, and cameras far from small spheres: places are numbers, or the sphere is refused.
#[test]
fn places_on_small_spheres_are_numbers() {
    let desk = Desk::with("s.toml", CAMERA);
    let (mut traced, mut refused) = (0, 0);
    for exponent in 6..24 {
        for (distance, radius) in [(1.0, 0.1_f64.powi(exponent)), (0.7e6, 0.7e6 * 0.1_f64.powi(exponent))] {
            let far = format!(
                "{CAMERA}{}[[refractor]]\nname = \"far\"\nmedium = \"glass\"\nshape = {{ sphere = {{ center = [{distance:e}, 0, 0], radius = {radius:e} }} }}\n",
                ball("")
                    .replace("[0, 0, 0]", &format!("[{:e}, 0, 0]", -distance))
                    .replace("radius = 1 ", &format!("radius = {radius:e} "))
            );
            desk.put("s.toml", far);
            let line = format!("trace s.toml --origin {distance:e},0,{distance:e} --direction 0,0,-1 --json");
            let output = desk.run(&line);
            let said = desk::text(&output.stdout);
            if output.status.success() {
                let path: Value = serde_json::from_str(&said).unwrap();
                for vertex in path["vertices"].as_array().unwrap() {
                    assert!(
                        vertex["position"].as_array().unwrap().iter().all(Value::is_number),
                        "{radius:e}: {vertex}"
                    );
                    traced += 1;
                }
                assert!(!said.contains("null,\n        null"), "{said}");
            } else {
                let error = desk::text(&output.stderr);
                assert!(error.contains("`far`") && error.contains("must be at least"), "{radius:e}: {error}");
                refused += 1;
            }
        }
    }
    assert!(traced > 20 && refused > 6, "{traced} vertices, {refused} refused");
    // One sphere alone is the middle of its scene, whatever the camera's distance.
    for exponent in [10, 15, 16, 17, 25, 60] {
        let radius = 0.1_f64.powi(exponent);
        desk.put("s.toml", format!("{CAMERA}{}", ball("").replace("radius = 1 ", &format!("radius = {radius:e} "))));
        let path = desk.json("trace s.toml --origin 0,0,1 --direction 0,0,-1 --json");
        for vertex in path["vertices"].as_array().unwrap() {
            assert!(vertex["position"].as_array().unwrap().iter().all(Value::is_number), "{radius:e}: {vertex}");
        }
    }
}
