//! Files are written whole or not at all, whatever stands at their place and whatever happens meanwhile.
#![cfg(unix)]

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::desk::{Desk, text};
use iorect::writing::{clean_up_when_interrupted, require_writable, write_atomically};

/// Nothing but sky: as quick as can be.
const SKY: &str = "
[camera]
position = [0, 0, 1]
target = [0, 0, 0]
[environment]
gradient = { zenith = [0.1, 0.2, 0.9], horizon = [1, 1, 1], nadir = [0.3, 0.2, 0.1] }
";

fn with_sky() -> Desk {
    Desk::with("sky.toml", SKY)
}

fn render(output: &str) -> String {
    format!("render sky.toml --size 16x12 --spp 1 -o {output}")
}

fn mode_of(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o7777
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

#[test]
fn permissions_are_kept() {
    let desk = with_sky();
    for mode in [0o600, 0o640, 0o644, 0o666, 0o755] {
        desk.put("a.png", "old");
        set_mode(&desk.path().join("a.png"), mode);
        desk.fine(&render("a.png"));
        assert_eq!(mode_of(&desk.path().join("a.png")), mode);
        assert!(image::open(desk.path().join("a.png")).is_ok());
    }
    // Scenes too.
    let path = desk.path().join("sky.toml");
    set_mode(&path, 0o600);
    let mut scene = iorect::formats::file(&path).unwrap();
    scene.camera.vertical_fov = 33.0;
    iorect::formats::save(&scene, &path).unwrap();
    assert_eq!(mode_of(&path), 0o600);
    assert!(fs::read_to_string(&path).unwrap().contains("vertical_fov = 33.0"));
}

#[test]
fn read_only_files_are_refused_before_any_work() {
    let desk = with_sky();
    desk.put("a.png", "old");
    desk.put("a.exr", "old");
    for name in ["a.png", "a.exr"] {
        set_mode(&desk.path().join(name), 0o444);
        let error = desk.wrong(&format!("render sky.toml --spp 1000000 --size 4096x4096 -o {name}"));
        assert!(error.contains(&format!("{name}: is read-only")) && error.contains("make it writable"), "{error}");
        assert_eq!(desk.get(name), b"old");
    }
    assert!(desk.wrong("compare sky.toml --spp 1000000 -o a.png").contains("is read-only"));
    for name in ["report.json", "summary.md", "curves.csv"] {
        fs::create_dir_all(desk.path().join("report")).unwrap();
        desk.put(&format!("report/{name}"), "old");
        set_mode(&desk.path().join("report").join(name), 0o444);
        assert!(desk.wrong("report --only editing -o report sky.toml").contains(&format!("{name}: is read-only")));
        fs::remove_file(desk.path().join("report").join(name)).unwrap();
    }
    // Through a link as well; and what is asked late is refused too.
    symlink("a.png", desk.path().join("link.png")).unwrap();
    assert!(desk.wrong(&render("link.png")).contains("link.png: is read-only"));
    assert!(write_atomically(&desk.path().join("a.png"), |file| file.write_all(b"new")).is_err());
    assert_eq!(desk.get("a.png"), b"old");
}

#[test]
fn links_stay_and_their_files_are_replaced() {
    let desk = with_sky();
    let at = |name: &str| desk.path().join(name);
    fs::create_dir(at("far")).unwrap();
    desk.put("far/picture.png", "old");
    // To a file by way of another link, and to nothing.
    symlink("far/picture.png", at("near.png")).unwrap();
    symlink("near.png", at("link.png")).unwrap();
    symlink("far/new.png", at("dangling.png")).unwrap();
    for (link, file) in [("link.png", "far/picture.png"), ("dangling.png", "far/new.png")] {
        desk.fine(&render(link));
        assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
        assert!(fs::symlink_metadata(at(file)).unwrap().is_file());
        assert!(image::open(at(file)).is_ok());
    }
    assert!(fs::symlink_metadata(at("near.png")).unwrap().is_symlink());
    symlink("no/such/folder.png", at("lost.png")).unwrap();
    assert!(desk.wrong(&render("lost.png")).contains("there is no folder"));
    symlink("round.png", at("round.png")).unwrap();
    let error = desk.wrong(&render("round.png"));
    assert!(error.contains("round.png: cannot be written"), "{error}");
}

#[test]
fn other_names_of_a_file_keep_the_old_contents() {
    let desk = with_sky();
    desk.put("a.png", "old");
    fs::hard_link(desk.path().join("a.png"), desk.path().join("b.png")).unwrap();
    desk.fine(&render("a.png"));
    assert_eq!(desk.get("b.png"), b"old");
    assert!(image::open(desk.path().join("a.png")).is_ok());
}

#[test]
fn streams_are_written_in_sequence_and_sockets_refused() {
    let desk = with_sky();
    let at = |name: &str| desk.path().join(name);
    assert!(Command::new("mkfifo").arg(at("pipe.png")).status().unwrap().success());
    // The early check neither waits for a reader nor ends it.
    require_writable(&at("pipe.png")).unwrap();
    let reader = Command::new("cat").arg(at("pipe.png")).stdout(Stdio::piped()).spawn().unwrap();
    desk.fine(&render("pipe.png"));
    let piped = reader.wait_with_output().unwrap().stdout;
    desk.fine(&render("file.png"));
    assert!(piped == desk.get("file.png"));
    assert!(fs::symlink_metadata(at("pipe.png")).unwrap().file_type().is_fifo(), "the FIFO stays");

    if Path::new("/dev/full").exists() {
        symlink("/dev/null", at("null.exr")).unwrap();
        desk.fine(&render("null.exr"));
        symlink("/dev/full", at("full.exr")).unwrap();
        let error = desk.refused(&render("full.exr"), 1);
        assert!(error.contains("full.exr: cannot be written"), "{error}");
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    let _socket = std::os::unix::net::UnixListener::bind(at("socket.png")).unwrap();
    assert!(desk.wrong(&render("socket.png")).contains("socket.png: is a socket and no file"));
    fs::create_dir(at("folder.png")).unwrap();
    assert!(desk.wrong(&render("folder.png")).contains("folder.png: is a folder"));
    // Of what has no format in its name, the format is not guessed.
    assert!(desk.wrong(&render("/dev/stdout")).contains("cannot tell the format"));
    assert!(desk.wrong(&render(&format!("{}.png", "x".repeat(300)))).contains("cannot be written"));
}

/// In a folder like /tmp nobody may replace what is another's, however its permissions are. Needs root, to be somebody else.
#[test]
fn files_of_others_in_sticky_folders_are_refused() {
    const NOBODY: u32 = 65534;
    let desk = with_sky();
    let at = |name: &str| desk.path().join(name);
    desk.put("a.png", "old");
    set_mode(&at("a.png"), 0o666);
    set_mode(desk.path(), 0o1777);
    let as_nobody = |line: &str| desk.command(line).uid(NOBODY).gid(NOBODY).output();
    match as_nobody("--version") {
        Ok(output) if output.status.success() => {}
        _ => {
            println!("skipped: the program cannot be run as another user here");
            return;
        }
    }
    let output = as_nobody(&render("a.png")).unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("a.png: belongs to another user"), "{error}");
    assert_eq!(desk.get("a.png"), b"old");
    // Without the sticky bit it is the folder that decides; the owner cannot be kept.
    set_mode(desk.path(), 0o777);
    assert!(as_nobody(&render("a.png")).unwrap().status.success());
    assert_eq!((fs::metadata(at("a.png")).unwrap().uid(), mode_of(&at("a.png"))), (NOBODY, 0o606));
    // Root gives a file back to whom it belongs.
    desk.fine(&render("a.png"));
    assert_eq!((fs::metadata(at("a.png")).unwrap().uid(), mode_of(&at("a.png"))), (NOBODY, 0o606));
    // A file that may not be written to is not replaced, though the folder would allow it.
    desk.put("b.png", "old");
    set_mode(&at("b.png"), 0o644);
    let output = as_nobody(&render("b.png")).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("b.png: cannot be written"));
    assert_eq!(desk.get("b.png"), b"old");
}

/// A child that writes and never ends: this test, run again with a place to write to.
#[test]
fn a_writer_that_never_ends() {
    let Some(path) = std::env::var_os("IORECT_TEST_ENDLESS") else { return };
    clean_up_when_interrupted().unwrap();
    let result = write_atomically(Path::new(&path), |file| {
        file.write_all(&[7; 100_000])?;
        loop {
            std::thread::sleep(Duration::from_secs(1));
        }
    });
    unreachable!("{result:?}");
}

/// Begun, so that there are `count` temporary files with its own.
fn endless_writer(path: &Path, count: usize) -> std::process::Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "writing::a_writer_that_never_ends"]).env("IORECT_TEST_ENDLESS", path);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    // With its bytes, it is locked.
    let begun = |path: &&PathBuf| fs::metadata(path).is_ok_and(|metadata| metadata.len() > 90_000);
    while temporaries(path.parent().unwrap()).iter().filter(begun).count() < count {
        assert!(start.elapsed() < Duration::from_secs(60), "no temporary file appears");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

fn temporaries(folder: &Path) -> Vec<PathBuf> {
    let is_temporary = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(".iorect-");
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(is_temporary).collect()
}

#[test]
fn temporary_files_go_when_the_program_is_told_to_stop() {
    for (signal, number) in [("-TERM", 15), ("-INT", 2), ("-HUP", 1)] {
        let desk = Desk::with("old.png", "old");
        let mut child = endless_writer(&desk.path().join("old.png"), 1);
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().signal(), Some(number), "it ends as the signal has it");
        assert_eq!(desk.files(), ["old.png"]);
        assert_eq!(desk.get("old.png"), b"old");
    }
}

#[test]
fn what_a_killed_program_left_goes_with_the_next_write() {
    let desk = with_sky();
    desk.put("old.png", "old");
    let mut killed = endless_writer(&desk.path().join("old.png"), 1);
    killed.kill().unwrap();
    killed.wait().unwrap();
    let left = temporaries(desk.path());
    assert_eq!(left.len(), 1);
    // Younger than a minute, it may be about to be locked.
    desk.fine(&render("a.png"));
    assert_eq!(temporaries(desk.path()), left);
    let age = |path: &Path| {
        let hour_ago = SystemTime::now() - Duration::from_secs(3600);
        fs::File::options().write(true).open(path).unwrap().set_modified(hour_ago).unwrap();
    };
    // One that is still written to stays, however old.
    let mut alive = endless_writer(&desk.path().join("b.png"), 2);
    temporaries(desk.path()).iter().for_each(|path| age(path));
    desk.fine(&render("a.png"));
    let now = temporaries(desk.path());
    assert!(!now.contains(&left[0]) && now.len() == 1, "{now:?}");
    alive.kill().unwrap();
    alive.wait().unwrap();
    desk.fine(&render("a.png"));
    assert!(temporaries(desk.path()).is_empty());
}

/// A limit of the system on the size of files stands for a full disk: wherever it hits, the old file stays and the new one goes.
#[test]
fn a_file_that_becomes_too_large_leaves_the_old_one() {
    let desk = with_sky();
    desk.put("old.exr", "old");
    let limited = |blocks: u32| {
        let script = format!("ulimit -f {blocks} && exec \"$0\" \"$@\"");
        let mut command = Command::new("sh");
        command.current_dir(desk.path()).args(["-c", &script, env!("CARGO_BIN_EXE_iorect")]);
        command.args("render sky.toml --size 64x64 --spp 1 -o old.exr".split(' ')).stdin(Stdio::null());
        command.output().unwrap()
    };
    let mut refused = 0;
    for blocks in 0..1000 {
        let output = limited(blocks);
        if output.status.success() {
            break;
        }
        refused += 1;
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{blocks}: {error}");
        assert!(error.starts_with("error: old.exr: cannot be written"), "{blocks}: {error}");
        assert!(!error.contains(".iorect-"), "{error}");
        assert_eq!(desk.get("old.exr"), b"old", "{blocks}");
        assert_eq!(desk.files(), ["old.exr", "sky.toml"], "{blocks}");
    }
    assert!(refused > 5, "only {refused} limits were too small");
    assert_eq!(image::image_dimensions(desk.path().join("old.exr")).unwrap(), (64, 64));
}

#[test]
fn equal_commands_write_equal_bytes() {
    let desk = with_sky();
    // Many blocks, compressed on several threads.
    for (line, ending) in [
        ("render sky.toml --size 128x128 --spp 2 --threads 4", "exr"),
        ("render sky.toml --size 128x128 --spp 2 --threads 4", "png"),
        ("render sky.toml --size 64x64 --samples 0..2 --threads 4", "exr"),
    ] {
        desk.fine(&format!("{line} -o first.{ending}"));
        for _ in 0..3 {
            desk.fine(&format!("{line} -o again.{ending}"));
            assert!(desk.get(&format!("first.{ending}")) == desk.get(&format!("again.{ending}")), "{line}: {ending}");
        }
        desk.fine(&format!("{line} --seed 1 -o other.{ending}"));
        assert!(desk.get(&format!("first.{ending}")) != desk.get(&format!("other.{ending}")), "{line}: the twin");
    }
}

/// Names of files are bytes here, and need not be Unicode.
#[test]
fn outputs_may_have_any_name() {
    let desk = with_sky();
    let output = |ending: &str| {
        let mut bytes = b"caf\xe9\x1b[31m.".to_vec();
        bytes.extend(ending.as_bytes());
        PathBuf::from(OsStr::from_bytes(&bytes))
    };
    let run = |line: &str, ending: &str| {
        let result = desk.command(line).arg("-o").arg(output(ending)).output().unwrap();
        let (out, err) = (text(&result.stdout), text(&result.stderr));
        assert_eq!(result.status.code(), Some(0), "{line}: {err}");
        assert!(!out.contains('\u{1b}') && desk.path().join(output(ending)).is_file(), "{line}: {out}");
        out
    };
    for (line, ending) in [
        ("render sky.toml --size 8x8 --spp 1", "png"),
        ("compare sky.toml --size 8x8 --spp 1", "png"),
        ("render sky.toml --size 8x8 --samples 0..1", "exr"),
    ] {
        assert!(run(line, ending).contains("caf\u{fffd}\\u{1b}[31m."), "{line}");
        let json: serde_json::Value = serde_json::from_str(&run(&format!("{line} --json"), ending)).unwrap();
        let said = json.get("output").unwrap_or_else(|| &json["panes"][0]["output"]);
        assert_eq!(said, &format!("caf\u{fffd}\u{1b}[31m.{ending}"), "{line}");
    }
    desk.fine("render sky.toml --size 8x8 --samples 0..1 -o part.exr");
    let merged = run("merge --json part.exr", "exr");
    assert!(merged.contains("caf\u{fffd}"));
}
