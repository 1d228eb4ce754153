//! Files as they are: meshes with oddities, files that are no files, and names that are no text.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use iorect::check::{Problem, Severity, check};
use iorect::formats;
use iorect::geometry::Enclosure;
use iorect::scene::Description;
use iorect::scene::description::Shape;
use iorect::tracking::prepare;

use crate::desk::{self, Desk};

const HEAD: &str = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n[environment]\ncolor = [1, 1, 1]\n";

fn with_mesh(file: &str) -> String {
    format!(
        "{HEAD}[[medium]]\nname = \"glass\"\nior = 1.5\n[[refractor]]\nname = \"o\"\nmedium = \"glass\"\nshape = {{ mesh = \"{file}\" }}\n"
    )
}

fn problems(scene: Description) -> Vec<Problem> {
    check(&prepare(Arc::new(scene), None).unwrap())
}

/// Each loads as the closed cube that it is, and `check` says what was passed over in it, once, and nothing else.
#[test]
fn one_harmless_oddity_refuses_no_mesh() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases/mesh-files-refused");
    let cases = [
        ("bom", None),
        ("continuation", None),
        ("cr_only", None),
        ("normals_missing", Some(("missing_normals", "normals_missing.obj:9: 4 corners name normals"))),
        ("two_corner_face", Some(("short_faces", "two_corner_face.obj:15: 1 face has fewer than three corners"))),
        ("unknown_statement", Some(("unknown_statement", "unknown_statement.obj:1: 1 statement, `vw`"))),
    ];
    for (name, said) in cases {
        let scene = formats::file(&folder.join(format!("{name}_obj.toml"))).unwrap();
        let Shape::Mesh { mesh, .. } = &scene.objects.refractors()[0].shape else { panic!("no mesh") };
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12), "{name}");
        assert_eq!(mesh.signed_volume(), 8.0, "{name}");
        let text = formats::to_text(&scene);
        assert_eq!(text, std::fs::read_to_string(folder.join(format!("{name}_obj.toml"))).unwrap());
        let prepared = prepare(Arc::new(scene.clone()), None).unwrap();
        let topology = prepared.scene.objects[0].topology.as_ref().expect("a mesh is analysed");
        assert_eq!(topology.enclosure, Enclosure::Closed, "{name}");
        let problems = problems(scene);
        assert_eq!(problems.len(), usize::from(said.is_some()), "{name}: {problems:?}");
        if let Some((kind, message)) = said {
            let problem = &problems[0];
            assert_eq!((problem.severity, problem.kind, problem.place.as_str()), (Severity::Warning, kind, "o"));
            assert!(problem.message.starts_with(message), "{}", problem.message);
        }
    }
}

/// Notes are about the file, not about the scene.
#[test]
fn what_is_passed_over_does_not_change_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let read = |obj: &str| {
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        formats::parse(&with_mesh("m.obj"), &folder.path().join("s.toml"), &formats::Disk).unwrap()
    };
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";
    let plain = read(tetrahedron);
    let odd = read(&format!("\u{feff}{}zz 1\nf 1 2\n", tetrahedron.replace('\n', "\r")));
    assert_ne!(plain.objects.refractors()[0].shape, odd.objects.refractors()[0].shape, "one has notes");
    assert_eq!(plain.fingerprint(), odd.fingerprint());
    assert_eq!(formats::to_text(&plain), formats::to_text(&odd));
    assert_eq!(problems(odd).iter().map(|p| p.kind).collect::<Vec<_>>(), ["unknown_statement", "short_faces"]);
}

#[test]
fn scene_text_with_marks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        formats::file(&path)
    };
    for ends in ["\n", "\r\n"] {
        let text = format!("\u{feff}# a scene\n{HEAD}").replace('\n', ends);
        let scene = read(text.as_bytes()).unwrap();
        assert_eq!(scene.camera.position.z, 5.0);
        assert_eq!(formats::to_text(&scene), text, "{ends:?}");
    }
    // A fault is where the author sees it.
    let error = read("\u{feff}camer = 1\n".as_bytes()).unwrap_err();
    assert!(error.to_string().contains("s.toml:1:1: unknown key `camer`"), "{error}");
    let utf16 = |text: &str, bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    for text in [HEAD.to_owned(), format!("\u{feff}{HEAD}")] {
        for bytes in [utf16(&text, u16::to_le_bytes), utf16(&text, u16::to_be_bytes)] {
            let error = read(&bytes).unwrap_err().to_string();
            assert!(error.contains("UTF-16") && error.contains("save it"), "{error}");
        }
    }
}

/// Commands that read what is no file end at once, and name it.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_at_once() {
    let desk = Desk::with("pipe-mesh.toml", &with_mesh("pipe.obj"));
    let at = |name: &str| desk.path().join(name);
    for name in ["pipe", "pipe.obj", "pipe.exr", "pipe.toml"] {
        assert!(std::process::Command::new("mkfifo").arg(at(name)).status().unwrap().success());
    }
    for name in ["zero.toml", "zero.obj", "zero.hdr", "zero.exr"] {
        std::os::unix::fs::symlink("/dev/zero", at(name)).unwrap();
    }
    let _listener = std::os::unix::net::UnixListener::bind(at("socket.toml")).unwrap();
    desk.put("zero-mesh.toml", with_mesh("zero.obj"));
    desk.put("pipe-sky.toml", HEAD.replace("color = [1, 1, 1]", "image = \"pipe.exr\""));
    desk.put("zero-sky.toml", HEAD.replace("color = [1, 1, 1]", "image = \"zero.hdr\""));
    std::fs::create_dir(at("folder.toml")).unwrap();
    let cases = [
        ("check pipe.toml", "named pipe"),
        ("render pipe.toml --json", "named pipe"),
        ("trace pipe --pixel 1,1", "named pipe"),
        ("pipe.toml", "named pipe"),
        ("rectify zero.toml", "device"),
        ("compare zero.toml --json", "device"),
        ("zero.toml", "device"),
        ("rectify socket.toml", "socket"),
        ("rectify folder.toml", "folder"),
        ("rectify pipe-mesh.toml", "named pipe"),
        ("rectify zero-mesh.toml", "device"),
        ("rectify pipe-sky.toml", "named pipe"),
        ("rectify zero-sky.toml", "device"),
        ("merge pipe.exr --json", "named pipe"),
        ("merge zero.exr --json", "device"),
    ];
    for (line, what) in cases {
        let start = std::time::Instant::now();
        let output = desk.run(line);
        let said = format!("{}{}", desk::text(&output.stdout), desk::text(&output.stderr));
        assert!(said.contains(what) && said.contains("not a file"), "{line}: {said}");
        assert_ne!(output.status.code(), Some(0), "{line}");
        // Reading a device would never end; a machine that is busy may take its time.
        assert!(start.elapsed().as_secs() < 60, "{line}");
    }
}

/// A pipe that the shell hands over is read to its end.
#[cfg(target_os = "linux")]
#[test]
fn a_scene_may_come_from_standard_input() {
    use std::io::Write;
    let desk = Desk::with("unused.toml", HEAD);
    let mut child = (desk.command("rectify /dev/stdin --json"))
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(HEAD.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(desk::text(&output.stdout).contains("\"scene\": \"/dev/stdin\""));
}

/// Names of files are bytes: a scene and its folder may have any.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let name = |bytes: &[u8]| PathBuf::from(OsStr::from_bytes(bytes));
    let desk = Desk::with("unused.toml", HEAD);
    let folder = desk.path().join(name(b"caf\xe9"));
    std::fs::create_dir(&folder).unwrap();
    let path = folder.join(name(b"sc\xe8ne.toml"));
    std::fs::write(&path, with_mesh("m.obj")).unwrap();
    std::fs::write(folder.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n")
        .unwrap();

    let scene = formats::open(&path).unwrap();
    assert_eq!(scene.name, "sc\u{fffd}ne");
    let copy = folder.join(name(b"copy\xff.toml"));
    formats::save(&scene, &copy).unwrap();
    assert_eq!(formats::open(&copy).unwrap().objects, scene.objects);
    // From elsewhere the mesh could only be named by what a scene file cannot hold.
    let error = formats::save(&scene, &desk.path().join("elsewhere.toml")).unwrap_err().to_string();
    assert!(error.contains("not UTF-8") && !desk.path().join("elsewhere.toml").exists(), "{error}");
    let missing = formats::open(folder.join("missing.toml")).unwrap_err().to_string();
    assert!(missing.contains("caf\u{fffd}/missing.toml: cannot be read: there is no such file"), "{missing}");

    for command in ["rectify", "check", "trace --pixel 1,1 --size 2x2", "render --size 2x2 --spp 1 -o a.png"] {
        let output = desk.command(command).arg(&path).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{command}: {}", desk::text(&output.stderr));
    }
    let output = desk.command("render --size 2x2 --spp 1 --json").arg(&path).output().unwrap();
    assert!(desk::text(&output.stdout).contains("caf\u{fffd}/sc\u{fffd}ne.toml"));
}
