//! The `iorect` binary: hands the window to the command line. Only here do the two meet.

use std::process::ExitCode;

#[cfg(feature = "window")]
use iorect::app::{self, Arrangement, Launch, RunError, Screenshot, Settings, Tab, Theme};
#[cfg(feature = "window")]
use iorect::cli::WindowScreenshot;
use iorect::cli::{self, WindowError, WindowRequest};

fn main() -> ExitCode {
    cli::main(open_window)
}

#[cfg(not(feature = "window"))]
fn open_window(_: WindowRequest) -> Result<(), WindowError> {
    Err(WindowError::NotBuilt)
}

#[cfg(feature = "window")]
fn open_window(request: WindowRequest) -> Result<(), WindowError> {
    let launch = Launch {
        scene: request.scene,
        size: request.size,
        measures: request.screenshot.as_ref().is_some_and(|shot| shot.tab.as_deref() == Some("measure")),
        settings: request.screenshot.as_ref().map(settings_for),
        screenshot: request.screenshot.map(|shot| Screenshot { path: shot.path, samples: shot.samples }),
    };
    app::run_with(launch).map_err(|error| match error {
        RunError::NoWindow(reason) => WindowError::NoWindow(reason),
        RunError::Scene(error) => WindowError::Scene(error),
        RunError::Screenshot(_) => WindowError::Other(error.to_string()),
    })
}

/// Pictures of the window are the same whatever the last session left behind.
#[cfg(feature = "window")]
fn settings_for(shot: &WindowScreenshot) -> Settings {
    let defaults = Settings::default();
    Settings {
        pane_count: shot.panes.unwrap_or(defaults.pane_count),
        arrangement: if shot.is_wipe { Arrangement::Wipe } else { Arrangement::Tiles },
        theme: if shot.is_light { Theme::Light } else { Theme::Dark },
        tab: match shot.tab.as_deref() {
            Some("rectification") => Tab::Rectification,
            Some("inspector") => Tab::Inspector,
            Some("measure") => Tab::Measure,
            _ => Tab::Render,
        },
        ..defaults
    }
}
