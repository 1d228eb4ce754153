//! What the program does not render yet is kept: from files of other renderers into the description, and into files for them again.

use std::path::Path;
use std::sync::Arc;

use iorect::export::resolved::{Frame, Target, export};
use iorect::formats::{self, Memory};
use iorect::scene::description::{Description, Object};

const FRAME: Frame = Frame { width: 16, height: 16, samples: 1 };

/// What is kept of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kept {
    is_solid: bool,
    roughness: [f64; 2],
    is_thin: bool,
    /// Of its medium at the d line, relative to that declared outside; of a solid, 0.
    ior: f64,
    /// 0 without dispersion.
    dispersion: f64,
}

fn kept(description: &Description) -> Vec<Kept> {
    let one = |object: &Object| {
        let refractor = object.refractor();
        let index = refractor.map(|refractor| &description.medium(&refractor.medium).expect("a medium").ior);
        let outside =
            object.outside().and_then(|name| description.medium(name)).map_or(&description.world.ior, |m| &m.ior);
        Kept {
            is_solid: refractor.is_none(),
            roughness: object.roughness(),
            is_thin: refractor.is_some_and(|refractor| refractor.thin),
            ior: index.map_or(0.0, |index| index.ior() / outside.ior()),
            dispersion: index.and_then(iorect::optics::Ior::abbe_number).map_or(0.0, |abbe| 1.0 / abbe),
        }
    };
    let mut all: Vec<Kept> = description.objects.iter().map(one).collect();
    all.sort_by(|a, b| a.roughness.partial_cmp(&b.roughness).unwrap().then(a.ior.total_cmp(&b.ior)));
    all
}

fn refractor(ior: f64, roughness: [f64; 2]) -> Kept {
    Kept { is_solid: false, roughness, is_thin: false, ior, dispersion: 0.0 }
}

fn mirror(roughness: [f64; 2]) -> Kept {
    Kept { is_solid: true, ..refractor(0.0, roughness) }
}

fn wall(ior: f64) -> Kept {
    Kept { is_thin: true, ..refractor(ior, [0.0; 2]) }
}

/// Reads files of an exported scene.
fn exported(description: &Description, target: Target) -> Description {
    let bundle = export(&Arc::new(description.clone()), target, FRAME).unwrap();
    let files = bundle.paths().map(|path| (path.to_owned(), bundle.get(path).unwrap().to_vec())).collect();
    formats::read(bundle.get(&bundle.main).unwrap(), &bundle.main, &Memory(files)).unwrap()
}

#[track_caller]
fn assert_kept(description: &Description, expected: &[Kept]) {
    let found = kept(description);
    let is_near = |a: f64, b: f64| (a - b).abs() < 1e-6;
    let is_same = |(a, b): (&Kept, &Kept)| {
        (a.is_solid, a.is_thin) == (b.is_solid, b.is_thin)
            && [0, 1].iter().all(|&k| (a.roughness[k] - b.roughness[k]).abs() < 1e-12)
            && is_near(a.ior, b.ior)
            && is_near(a.dispersion, b.dispersion)
    };
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    assert!(found.iter().zip(expected).all(is_same), "{found:#?}\n{expected:#?}");
}

#[track_caller]
fn assert_round_trip(description: &Description, target: Target, expected: &[Kept]) {
    assert_kept(description, expected);
    let again = exported(description, target);
    assert_kept(&again, expected);
    assert_kept(&exported(&again, target), expected);
}

fn scene(text: &str, name: &str) -> Description {
    formats::read(text.as_bytes(), Path::new(name), &Memory::default()).unwrap()
}

const MITSUBA: &str = r#"<scene version="3.0.0">
<sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, 20" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
<bsdf type="roughdielectric" id="frosted"><string name="distribution" value="ggx"/><float name="alpha_u" value="0.125"/>
  <float name="alpha_v" value="0.25"/><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
<shape type="sphere"><ref id="frosted"/></shape>
<shape type="sphere"><point name="center" value="4, 0, 0"/><bsdf type="roughdielectric"><float name="int_ior" value="1.25"/>
  <float name="ext_ior" value="1"/></bsdf></shape>
<shape type="cube"><transform name="to_world"><translate x="-4"/></transform>
  <bsdf type="twosided"><bsdf type="roughconductor"><string name="material" value="none"/><string name="distribution" value="ggx"/>
  <float name="alpha" value="0.5"/></bsdf></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><translate z="4"/></transform>
  <bsdf type="thindielectric"><float name="int_ior" value="1.75"/><float name="ext_ior" value="1"/></bsdf></shape>
</scene>"#;

#[test]
fn of_mitsuba() {
    let read = scene(MITSUBA, "s.xml");
    let expected = [wall(1.75), refractor(1.25, [0.1; 2]), refractor(1.5, [0.125, 0.25]), mirror([0.5; 2])];
    assert_round_trip(&read, Target::Mitsuba, &expected);
    // Into the other format as well.
    assert_kept(&exported(&read, Target::Pbrt), &expected);
    let notes = &read.source.as_ref().unwrap().import.as_ref().unwrap().notes;
    assert_eq!(notes.iter().map(|note| note.kind).collect::<Vec<_>>(), ["distribution"], "Beckmann's, by default");
}

/// α is the root of a roughness that is remapped.
const PBRT: &str = r#"LookAt 0 0 -20  0 0 0  0 1 0
Camera "perspective"
WorldBegin
Material "dielectric" "float eta" 1.5 "float uroughness" 0.015625 "float vroughness" 0.0625
Shape "sphere"
AttributeBegin
  Translate 4 0 0
  Material "dielectric" "spectrum eta" "glass-BK7" "float roughness" 0.0625 "bool remaproughness" false
  Shape "sphere"
AttributeEnd
AttributeBegin
  Translate -4 0 0
  Material "conductor" "rgb reflectance" [ .9 .9 .9 ] "float roughness" 0.25
  Shape "disk"
AttributeEnd
Translate 0 0 4
Material "thindielectric" "float eta" 1.75
Shape "disk"
"#;

#[test]
fn of_pbrt() {
    let read = scene(PBRT, "s.pbrt");
    let bk7 = iorect::optics::catalog::find("n-bk7").unwrap();
    let dispersion = 1.0 / bk7.model.abbe_number().unwrap();
    let expected = [
        wall(1.75),
        Kept { dispersion, ..refractor(bk7.ior(), [0.0625; 2]) },
        refractor(1.5, [0.125, 0.25]),
        mirror([0.5; 2]),
    ];
    assert_kept(&read, &expected);
    // Of the formula come samples, and of them another formula.
    let close = |description: &Description| {
        let mut found = kept(description);
        let glass = found.iter_mut().find(|kept| kept.dispersion > 0.0).expect("a glass that disperses");
        assert!(
            (glass.dispersion / dispersion - 1.0).abs() < 0.02 && (glass.ior - bk7.ior()).abs() < 1e-4,
            "{glass:?}"
        );
        (glass.dispersion, glass.ior) = (dispersion, bk7.ior());
        assert_eq!(found, kept(&read));
    };
    let again = exported(&read, Target::Pbrt);
    close(&again);
    close(&exported(&again, Target::Pbrt));
}

const OWN: &str = r#"
[camera]
position = [0, 0, 20]
target = [0, 0, 0]
[[medium]]
name = "glass"
ior = 1.5
[[medium]]
name = "flint"
ior = { cauchy = [1.6, 0.0125, 0] }
[[refractor]]
name = "frosted"
medium = "glass"
roughness = 0.0625
shape = { sphere = { center = [0, 0, 0], radius = 1 } }
[[refractor]]
name = "gem"
medium = "flint"
shape = { sphere = { center = [4, 0, 0], radius = 1 } }
[[refractor]]
name = "bulb"
medium = "glass"
thin = true
shape = { sphere = { center = [-4, 0, 0], radius = 1 } }
[[refractor]]
name = "pane"
medium = "glass"
thin = true
visible = false
shape = { quad = { center = [0, 0, 4], edge_u = [1, 0, 0], edge_v = [0, 1, 0] } }
[[solid]]
name = "tray"
mirror = true
roughness = 0.25
shape = { box = { min = [-1, -3, -1], max = [1, -2, 1] } }
"#;

#[test]
fn of_gltf() {
    let own = scene(OWN, "s.toml");
    let flint = &own.media[1].ior;
    let expected = [
        wall(1.5),
        wall(1.5),
        Kept { dispersion: 1.0 / flint.abbe_number().unwrap(), ..refractor(flint.ior(), [0.0; 2]) },
        refractor(1.5, [0.0625; 2]),
        mirror([0.25; 2]),
    ];
    assert_kept(&own, &expected);
    let read = exported(&own, Target::Gltf);
    assert_round_trip(&read, Target::Gltf, &expected);
    // Both walls are shown as bodies, as what glTF says of them is where a file comes from elsewhere.
    assert!(read.objects.iter().all(|object| object.visible));
}

/// In the program's own format, and what is hidden is a wall elsewhere while what is shown as a body is one.
#[test]
fn of_the_own_format() {
    let own = scene(OWN, "s.toml");
    let saved = formats::to_text(&Description { source: None, ..own.clone() });
    assert_eq!(kept(&scene(&saved, "s.toml")), kept(&own), "{saved}");
    for (target, format) in [(Target::Mitsuba, "Mitsuba"), (Target::Pbrt, "pbrt")] {
        let read = exported(&own, target);
        assert_eq!(kept(&read).iter().filter(|kept| kept.is_thin).count(), 1);
        let thin = read.objects.iter().find(|object| object.refractor().is_some_and(|r| r.thin)).unwrap();
        assert!(!thin.visible, "light goes straight through");
        let notes = export(&Arc::new(own.clone()), target, FRAME).unwrap().notes.join("\n");
        assert!(
            notes.contains("`pane`: hidden here")
                && notes.contains(&format!("`bulb`: thin walls are bodies in {format}")),
            "{notes}"
        );
        assert!(notes.contains("`flint`"), "dispersion: {notes}");
    }
}
