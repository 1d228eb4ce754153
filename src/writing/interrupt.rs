//! Clean-up when the program is told to stop: temporary files are removed.

use std::io;

/// From here on, a program that is told to stop removes its temporary files and then ends as it would have; and a file that becomes larger than
/// the process may write (`ulimit -f`) is an error like a full disk, not the process's end. To be called once, by the program and not
/// by a library, for signals belong to the whole process.
///
/// # Errors
/// When the system refuses.
#[cfg(unix)]
pub fn clean_up_when_interrupted() -> io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;

    // Any handler keeps the process alive; the write then fails with an error.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    let ignored = ignored_signals();
    let is_heeded = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    let mut signals = Signals::new([SIGHUP, SIGINT, SIGTERM].into_iter().filter(is_heeded))?;
    std::thread::Builder::new().name("interruptions".into()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let _none_can_be_made = super::temporary::remove_all();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    })?;
    Ok(())
}

#[cfg(not(unix))]
pub fn clean_up_when_interrupted() -> io::Result<()> {
    Ok(())
}

/// Signals that were ignored when the process started, signal 1 in the lowest bit: `nohup` and a shell's background jobs rely on that
/// they stay so. Known on Linux; elsewhere none.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
