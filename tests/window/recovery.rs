//! What the window does when things go wrong or take long: crashes, scenes that are not wanted any more, and windows larger than textures.

use std::fs;
#[cfg(unix)]
use std::path::PathBuf;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use iorect::app::{App, Command, MediumRef, Settings};
use iorect::optics::Ior;

use crate::harness::{apply, every_pane_has_an_image, quick, until, window, window_of};

/// A scene's file, and a folder for autosaves.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = iorect::formats::open("nested-spheres").expect("a built-in scene");
        iorect::formats::save(&scene, &folder.path().join("mine.toml")).expect("the folder is writable");
        Self { folder }
    }

    fn scene(&self) -> PathBuf {
        self.folder.path().join("mine.toml")
    }

    fn autosaves(&self) -> PathBuf {
        self.folder.path().join("data/autosave")
    }

    /// The autosaves that are there.
    fn kept(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.autosaves()).into_iter().flatten();
        let paths = entries.map(|entry| entry.expect("a folder can be listed").path());
        paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect()
    }

    fn window(&self, scene: &str) -> Harness<'static, App> {
        let mut harness = window(scene);
        let ctx = harness.ctx.clone();
        harness.state_mut().keep_edits_in(&ctx, self.autosaves()).expect("a thread can be started");
        harness.run_steps(3);
        harness
    }

    /// A window with an edit that is kept by now.
    fn edited(&self, ior: f64) -> Harness<'static, App> {
        let mut harness = self.window(self.scene().to_str().expect("a plain path"));
        let before = self.kept().len();
        set_ior(&mut harness, ior);
        until(&mut harness, "the edit is kept", |_| self.kept().len() > before);
        harness
    }
}

fn set_ior(harness: &mut Harness<'_, App>, ior: f64) {
    apply(harness, Command::set_ior(MediumRef::Named("glass".into()), Ior::Constant(ior)));
}

fn ior(app: &App) -> f64 {
    app.state().document.description().medium("glass").expect("the scene has glass").ior.ior()
}

#[test]
fn edits_survive_a_crash_and_are_restored() {
    let desk = Desk::new();
    // A window that goes without being closed has crashed.
    drop(desk.edited(1.61));
    assert_eq!(desk.kept().len(), 1);
    let on_disk = fs::read(desk.scene()).unwrap();

    let mut harness = desk.window("nested-spheres");
    until(&mut harness, "the edits are offered", |app| !app.state().left_behind.is_empty());
    harness.get_by_label_contains("Edits of “Nested spheres”");
    harness.get_by_label("Restore").click();
    until(&mut harness, "they are back", |app| app.state().document.path.is_some() && app.state().is_prepared());
    assert_eq!(ior(harness.state()), 1.61);
    assert!(harness.state().state().document.is_dirty());
    assert_eq!(harness.state().state().document.path, Some(desk.scene()));
    assert_eq!(fs::read(desk.scene()).unwrap(), on_disk, "the file is as it was");
    assert!(harness.query_by_label("Restore").is_none());

    // Crashed again, with one more edit that was not kept yet.
    set_ior(&mut harness, 1.62);
    drop(harness);
    let mut harness = desk.window("nested-spheres");
    until(&mut harness, "the edits are offered", |app| !app.state().left_behind.is_empty());
    harness.get_by_label("Restore").click();
    until(&mut harness, "they are back", |app| app.state().document.path.is_some());
    assert_eq!(ior(harness.state()), 1.62);

    // What has been saved is kept no longer.
    apply(&mut harness, Command::Save);
    until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
    until(&mut harness, "nothing is kept", |_| desk.kept().is_empty());
    assert_ne!(fs::read(desk.scene()).unwrap(), on_disk);
    drop(harness);
    assert_eq!(fs::read_dir(desk.autosaves()).unwrap().count(), 0);
}

/// Scenes of other formats, whose meshes and materials an autosave must not lose.
#[test]
fn edits_of_scenes_from_other_programs_are_restored() {
    let mitsuba = r#"<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="40"/><transform name="to_world">
        <lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform></sensor><emitter type="constant"/>
        <shape type="cube" id="block"><bsdf type="dielectric"><float name="int_ior" value="1.7"/></bsdf></shape></scene>"#;
    let pbrt = "LookAt 0 1 6  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\nLightSource \"infinite\"\n\
        Material \"dielectric\" \"float eta\" 1.7\nShape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  0 0 1]\n  \
        \"integer indices\" [0 2 1  0 3 2  0 1 3  1 2 3]\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for name in ["scene.gltf", "scene.xml", "scene.pbrt", "scene.obj"] {
        let desk = Desk::new();
        let path = desk.folder.path().join(name);
        match name {
            "scene.gltf" => crate::opening::write_gltf(&path, 1.7),
            "scene.xml" => fs::write(&path, mitsuba).expect("the folder is writable"),
            "scene.pbrt" => fs::write(&path, pbrt).expect("the folder is writable"),
            _ => fs::write(&path, obj).expect("the folder is writable"),
        }
        let on_disk = fs::read(&path).unwrap();
        let mut harness = desk.window(path.to_str().expect("a plain path"));
        let medium = harness.state().state().document.description().media[0].name.clone();
        apply(&mut harness, Command::set_ior(MediumRef::Named(medium.clone()), Ior::Constant(1.61)));
        until(&mut harness, "the edit is kept", |_| desk.kept().len() == 1);
        let edited = harness.state().state().document.description().clone();
        drop(harness);

        let mut harness = desk.window("nested-spheres");
        until(&mut harness, "the edits are offered", |app| !app.state().left_behind.is_empty());
        harness.get_by_label("Restore").click();
        until(&mut harness, "they are back", |app| app.state().document.description().medium(&medium).is_some());
        let restored = harness.state().state().document.description().clone();
        assert_eq!(restored.fingerprint(), edited.fingerprint(), "{name}");
        assert_eq!(restored.medium(&medium).unwrap().ior.ior(), 1.61, "{name}");
        until(&mut harness, "it is shown", |app| app.state().is_prepared() && every_pane_has_an_image(app));
        // Saved as a scene file of its own, with everything beside it: the other program's file stays as it is.
        assert!(harness.state().state().document.path.is_none(), "{name}");
        let saved = desk.folder.path().join("saved/here.toml");
        fs::create_dir(saved.parent().unwrap()).expect("the folder is writable");
        apply(&mut harness, Command::SaveAs(saved.clone()));
        until(&mut harness, "it is saved", |app| !app.state().document.is_dirty());
        until(&mut harness, "nothing is kept", |_| desk.kept().is_empty());
        drop(harness);
        assert_eq!(fs::read(&path).unwrap(), on_disk, "{name}");
        let again = iorect::formats::open(&saved).expect("it can be read");
        assert_eq!(again.fingerprint(), edited.fingerprint(), "{name}");
    }
}

#[test]
fn edits_are_discarded_put_off_or_undone() {
    let desk = Desk::new();
    drop(desk.edited(1.61));
    let mut harness = desk.window("nested-spheres");
    until(&mut harness, "the edits are offered", |app| !app.state().left_behind.is_empty());
    harness.get_by_label("Later").click();
    until(&mut harness, "the offer is gone", |app| app.state().left_behind.is_empty());
    assert_eq!(desk.kept().len(), 1);
    drop(harness);

    let mut harness = desk.window("nested-spheres");
    until(&mut harness, "they are offered again", |app| !app.state().left_behind.is_empty());
    harness.get_by_label("Discard").click();
    until(&mut harness, "they are gone", |app| app.state().left_behind.is_empty() && desk.kept().is_empty());
    drop(harness);

    // Back at what the file has, there is nothing to keep.
    let mut harness = desk.edited(1.7);
    apply(&mut harness, Command::Undo);
    until(&mut harness, "nothing is kept", |_| desk.kept().is_empty());
}

#[test]
fn instances_that_run_keep_their_edits_apart() {
    let desk = Desk::new();
    let first = desk.edited(1.61);
    let mut second = desk.edited(1.62);
    second.run_steps(5);
    assert_eq!(desk.kept().len(), 2);
    assert!(second.state().state().left_behind.is_empty(), "the first one runs");
    drop(first);
    let mut third = desk.window("nested-spheres");
    until(&mut third, "the first one's edits are offered", |app| !app.state().left_behind.is_empty());
    assert_eq!(third.state().state().left_behind.len(), 1);
    // Restored over edits: asked about first.
    third.get_by_label_contains("Edits of “Nested spheres”");
    apply(&mut third, Command::set_ior(MediumRef::World, Ior::Constant(1.1)));
    third.get_by_label("Restore").click();
    third.run_steps(3);
    assert!(third.state().state().document.path.is_none());
    third.get_by_label("Restore without saving").click();
    until(&mut third, "they are back", |app| app.state().document.path.is_some());
    assert_eq!(ior(third.state()), 1.61);
}

#[test]
fn what_cannot_be_restored_is_kept() {
    let desk = Desk::new();
    let mesh = desk.folder.path().join("mesh.obj");
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").unwrap();
    let text = fs::read_to_string(desk.scene()).unwrap()
        + "[[refractor]]\nname = \"from a file\"\nmedium = \"glass\"\nshape = { mesh = \"mesh.obj\" }\n";
    fs::write(desk.scene(), text).unwrap();
    drop(desk.edited(1.61));
    fs::remove_file(&mesh).unwrap();
    let mut harness = desk.window("nested-spheres");
    until(&mut harness, "the edits are offered", |app| !app.state().left_behind.is_empty());
    harness.get_by_label("Restore").click();
    until(&mut harness, "the failure is told", |app| app.state().notices.iter().any(|notice| notice.is_error));
    let notice = &harness.state().state().notices[0].text;
    assert!(notice.contains("mesh.obj") && notice.contains("The edits stay in"), "{notice}");
    assert_eq!((desk.kept().len(), harness.state().state().left_behind.len()), (1, 1));
}

#[test]
fn edits_that_cannot_be_kept_are_told() {
    let desk = Desk::new();
    fs::write(desk.folder.path().join("data"), "a file where the folder should be").unwrap();
    let mut harness = desk.window(desk.scene().to_str().unwrap());
    set_ior(&mut harness, 1.61);
    until(&mut harness, "it is told", |app| app.state().notices.iter().any(|notice| notice.is_error));
    let notice = &harness.state().state().notices[0].text;
    assert!(notice.contains("not safe from a crash") && notice.contains("autosave"), "{notice}");
}

#[test]
fn only_the_scene_that_was_asked_for_last_is_opened() {
    let mut harness = window("nested-spheres");
    let ctx = harness.ctx.clone();
    let open = |harness: &mut Harness<'_, App>, names: &[&str]| {
        names.iter().for_each(|name| harness.state_mut().apply(&ctx, Command::Open((*name).into())));
    };
    open(&mut harness, &["plain-glass", "camera-in-water"]);
    until(&mut harness, "a scene has come", |app| app.state().opening().is_none());
    let name = |harness: &Harness<'_, App>| {
        let source = harness.state().state().document.description().source.clone().expect("it comes from somewhere");
        source.path.file_stem().expect("it has a name").to_string_lossy().into_owned()
    };
    assert_eq!(name(&harness), "camera-in-water");
    // Given up: neither it nor its failure is heard of again.
    open(&mut harness, &["plain-glass"]);
    harness.state_mut().apply(&ctx, Command::CancelOpening);
    open(&mut harness, &["no/such/scene.toml"]);
    harness.state_mut().apply(&ctx, Command::CancelOpening);
    for _ in 0..30 {
        std::thread::sleep(std::time::Duration::from_millis(10));
        harness.step();
    }
    assert_eq!(name(&harness), "camera-in-water");
    assert!(harness.state().state().notices.is_empty());
}

/// Edited while another scene was read: that asks, too.
#[test]
fn an_edit_during_opening_is_not_lost() {
    let mut harness = window("nested-spheres");
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Open("plain-glass".into()));
    let edit = Command::set_ior(MediumRef::Named("glass".into()), Ior::Constant(1.61));
    harness.state_mut().apply(&ctx, edit);
    until(&mut harness, "the other scene has come", |app| app.state().opening().is_none());
    assert_eq!(ior(harness.state()), 1.61);
    harness.get_by_label("Stay").click();
    harness.run_steps(3);
    assert!(harness.state().state().document.is_dirty());
}

/// The harness, as a small graphics card, has textures of 2048 pixels a side.
#[test]
fn a_window_larger_than_a_texture_shows_images() {
    let settings = Settings { pane_count: 1, resolution_scale: 1.0, sample_limit: Some(1), ..quick() };
    let mut harness = window_of("nested-spheres", settings, [10_000.0, 200.0]);
    until(&mut harness, "there is an image", every_pane_has_an_image);
    let [width, height] = harness.state().state().film_size();
    assert!(width == 2048 && (5..60).contains(&height), "{width} × {height}");
}

/// A file that nobody writes to must not stop the window.
#[cfg(unix)]
#[test]
fn special_files_do_not_stop_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.toml");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("POSIX has mkfifo");
    assert!(made.success());
    let mut harness = window("nested-spheres");
    apply(&mut harness, Command::Open(pipe.clone()));
    // Frames go on, whether it is refused or waited for; another scene can be opened meanwhile.
    apply(&mut harness, Command::Open("camera-in-water".into()));
    until(&mut harness, "the other scene is open", |app| app.state().opening().is_none());
    assert_eq!(harness.state().state().document.path, None);
    until(&mut harness, "it is shown", every_pane_has_an_image);
}
