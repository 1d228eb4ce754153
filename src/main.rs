//! The `iorect` binary: hands the window to the command line. Only here do the two meet.

use std::process::ExitCode;

#[cfg(feature = "window")]
use iorect::app::{self, Arrangement, Launch, RunError, Screenshot, Settings, SidePanel, Tab, Theme};
use iorect::cli::{self, WindowArguments, WindowError};

fn main() -> ExitCode {
    cli::main(open_window)
}

#[cfg(not(feature = "window"))]
fn open_window(_: &WindowArguments) -> Result<(), WindowError> {
    Err(WindowError::NotBuilt)
}

#[cfg(feature = "window")]
fn open_window(arguments: &WindowArguments) -> Result<(), WindowError> {
    let screenshot = arguments.screenshot.clone().map(|path| Screenshot { path, samples: arguments.samples });
    let is_scripted = screenshot.is_some() || arguments.measure_frames.is_some();
    let launch = Launch {
        scene: arguments.scene.clone(),
        size: arguments.window_size.map(|size| [size.width, size.height]),
        pane_count: arguments.panes,
        measures: arguments.tab.as_deref() == Some("measure"),
        inspect: arguments.inspect.map(|percent| percent.map(|x| f64::from(x) / 100.0)),
        is_ghost: arguments.ghost,
        settings: is_scripted.then(|| settings_for(arguments)),
        screenshot,
        measure_frames: arguments.measure_frames.clone(),
    };
    app::run(launch).map_err(|error| match error {
        RunError::NoWindow(reason) => WindowError::NoWindow(reason),
        RunError::Scene(error) => WindowError::Scene(error),
        RunError::Screenshot(_) => WindowError::Other(error.to_string()),
    })
}

/// Pictures of the window are the same whatever the last session left behind.
#[cfg(feature = "window")]
fn settings_for(shot: &WindowArguments) -> Settings {
    let defaults = Settings::default();
    Settings {
        arrangement: if shot.wipe { Arrangement::Wipe } else { Arrangement::Tiles },
        theme: if shot.light { Theme::Light } else { Theme::Dark },
        tab: match shot.tab.as_deref() {
            Some("rectification") => Tab::Rectification,
            Some("inspector") => Tab::Inspector,
            Some("measure") => Tab::Measure,
            _ => Tab::Render,
        },
        narrow_panel: if shot.tab.is_some() { SidePanel::Render } else { defaults.narrow_panel },
        // As many samples as are asked for.
        noise_target: None,
        backend: shot.backend,
        ..defaults
    }
}
