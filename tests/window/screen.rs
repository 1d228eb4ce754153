//! The real program in a real window, on a virtual screen and with software drawing: once with Vulkan, once with OpenGL. The pictures
//! of the window are left in `target/ui-screenshots` to be looked at.
//!
//! Needs Xvfb and Mesa. Where Xvfb is missing the tests are skipped, and say so, except with `CI=true`: there they fail.

#![cfg(target_os = "linux")]

use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use image::RgbImage;

/// A virtual screen that goes when the test does.
struct Screen {
    server: Child,
    display: String,
}

impl Screen {
    /// `None`, with a word on standard error, where there is no Xvfb.
    #[expect(clippy::print_stderr, reason = "a test has nowhere else to say that it was skipped")]
    fn open(size: &str) -> Option<Self> {
        let spawned = Command::new("Xvfb")
            // The server chooses a free number and prints it when it is ready.
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", &format!("{size}x24")])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match spawned {
            Ok(server) => server,
            Err(error) => {
                assert!(std::env::var("CI").as_deref() != Ok("true"), "Xvfb cannot be started: {error}");
                eprintln!("skipped: Xvfb cannot be started ({error}); install xvfb to run this test");
                return None;
            }
        };
        let mut number = String::new();
        let output = server.stdout.take().expect("the output is piped");
        BufReader::new(output).read_line(&mut number).expect("Xvfb says its number");
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        Some(Self { server, display: format!(":{}", number.trim()) })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // It may have gone by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program with a display and a home of its own, so that it neither reads nor leaves settings.
fn program(display: Option<&str>, home: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_iorect"));
    command
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env_remove("DISPLAY")
        .env("HOME", home)
        .env("XDG_DATA_HOME", home)
        .env("XDG_RUNTIME_DIR", home)
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .current_dir(home);
    if let Some(display) = display {
        command.env("DISPLAY", display);
    }
    command
}

/// Waits for the program; one that hangs is killed and fails the test.
fn wait(mut child: Child, patience: Duration) -> std::process::Output {
    let start = Instant::now();
    while child.try_wait().expect("the program can be waited for").is_none() {
        if start.elapsed() > patience {
            let _ = child.kill();
            let output = child.wait_with_output().expect("its output can be read");
            panic!("the window did not close by itself: {}", String::from_utf8_lossy(&output.stderr));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    child.wait_with_output().expect("its output can be read")
}

/// A picture of the window on a screen of just its size, left under `name`; `None` where there is no Xvfb.
fn picture(name: &str, backend: &str, size: [u32; 2], arguments: &[&str]) -> Option<RgbImage> {
    let size_text = format!("{}x{}", size[0], size[1]);
    let screen = Screen::open(&size_text)?;
    let home = tempfile::tempdir().expect("a temporary folder");
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/ui-screenshots");
    std::fs::create_dir_all(&folder).expect("the build folder is writable");
    let path = folder.join(format!("{name}.png"));
    let _ = std::fs::remove_file(&path);

    let child = program(Some(&screen.display), home.path())
        .env("WGPU_BACKEND", backend)
        .args(["nested-spheres", "--samples", "1", "--window-size", &size_text])
        .args(arguments)
        .arg("--screenshot")
        .arg(&path)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let output = wait(child, Duration::from_secs(240));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {errors}");

    let picture = image::open(&path).expect("a picture of the window").to_rgb8();
    assert_eq!([picture.width(), picture.height()], size, "{name}");
    Some(picture)
}

/// The standard deviation of the green of the pixels in these ranges.
fn spread(picture: &RgbImage, xs: Range<u32>, ys: Range<u32>) -> f64 {
    let values: Vec<f64> = xs
        .flat_map(|x| ys.clone().map(move |y| (x, y)))
        .map(|(x, y)| f64::from(picture.get_pixel(x, y).0[1]))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn window_shows_images(backend: &str) {
    let Some(picture) = picture(&format!("window-{backend}"), backend, [1280, 720], &[]) else { return };
    // The panels are even, the panes between them are not.
    for (name, xs, ys) in [("first", 320..640, 80..340), ("second", 680..980, 80..340), ("third", 320..640, 420..680)] {
        let spread = spread(&picture, xs, ys);
        assert!(spread > 10.0, "{backend}: the {name} pane is blank (deviation {spread:.1})");
    }
    assert!(spread(&picture, 20..280, 400..600) < 3.0, "{backend}: the scene panel is not where it should be");
}

/// From the smallest screen to a large one, light and dark: bars from edge to edge in the theme's colour, and a picture between them.
#[test]
fn the_window_fills_screens_of_every_size() {
    for [width, height] in [[800, 600], [1280, 720], [1920, 1080], [3840, 2160]] {
        for theme in ["dark", "light"] {
            let name = format!("window-{width}x{height}-{theme}");
            let arguments: &[&str] = if theme == "light" { &["--light", "--panes", "2"] } else { &["--panes", "2"] };
            let Some(picture) = picture(&name, "vulkan", [width, height], arguments) else { return };
            for y in [1, height - 2] {
                let [left, right] = [2, width - 3].map(|x| picture.get_pixel(x, y).0);
                assert_eq!(left, right, "{name}: the bar at {y} does not reach from edge to edge");
                assert_eq!(theme == "light", left[1] > 128, "{name}: {left:?}");
            }
            let part = |of: u32, from: u32, to: u32| of * from / 100..of * to / 100;
            let spread = spread(&picture, part(width, 35, 48), part(height, 30, 60));
            assert!(spread > 5.0, "{name}: the pane is blank (deviation {spread:.1})");
        }
    }
}

#[test]
fn the_window_opens_with_vulkan() {
    window_shows_images("vulkan");
}

#[test]
fn the_window_opens_with_opengl() {
    window_shows_images("gl");
}

#[test]
fn without_a_display_a_picture_of_the_window_is_refused_in_words() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("window.png");
    let child = program(None, home.path())
        .args(["nested-spheres", "--screenshot"])
        .arg(&path)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let output = wait(child, Duration::from_secs(60));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("window") && !errors.contains("panicked"), "{errors}");
    assert!(!path.exists());
}
