//! Where and when something was measured, as far as the system tells.

use std::fs;

use serde::{Deserialize, Serialize};

/// The machine that measures. What cannot be found out is `None`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// As the processor calls itself.
    pub cpu: Option<String>,
    /// Threads that the system can run at once.
    pub cores: usize,
    /// Name and version of the system, and the kind of processor it was built for.
    pub system: String,
    pub memory_bytes: Option<u64>,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        let os = field("/etc/os-release", "PRETTY_NAME", '=').map(|name| name.trim_matches('"').to_owned());
        Self {
            cpu: field("/proc/cpuinfo", "model name", ':'),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{}, {}", os.unwrap_or_else(|| std::env::consts::OS.to_owned()), std::env::consts::ARCH),
            memory_bytes: kilobytes("/proc/meminfo", "MemTotal"),
        }
    }
}

/// Memory that this process has in use, in bytes; `None` where the system does not tell in a file.
pub fn resident_bytes() -> Option<u64> {
    kilobytes("/proc/self/status", "VmRSS")
}

/// The most memory that this process had in use since [`forget_peak`], or since it began, in bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    kilobytes("/proc/self/status", "VmHWM")
}

/// Resets [`peak_bytes`]; `false` where the system cannot.
pub fn forget_peak() -> bool {
    // proc_pid_clear_refs(5): "reset the peak resident set size to the process's current resident set size value".
    cfg!(target_os = "linux") && fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// Memory that could be had without swapping, in bytes; `None` where the system does not tell in a file.
pub fn available_bytes() -> Option<u64> {
    kilobytes("/proc/meminfo", "MemAvailable")
}

/// Load average over the last minute, this program's tasks included; `None` where the system does not tell.
pub fn load_average() -> Option<f64> {
    fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

fn kilobytes(path: &str, name: &str) -> Option<u64> {
    let value = field(path, name, ':')?;
    value.strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// The value behind `name` and `separator` in the first such line of a file.
fn field(path: &str, name: &str, separator: char) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    text.lines().find_map(|line| {
        let (key, value) = line.split_once(separator)?;
        (key.trim() == name).then(|| value.trim().to_owned())
    })
}

/// The time now in UTC, as in `2026-11-23 14:05 UTC`.
pub fn now() -> String {
    jiff::Timestamp::now().strftime("%Y-%m-%d %H:%M UTC").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_machine_is_known() {
        let machine = Machine::here();
        assert!(machine.cores >= 1 && machine.memory_bytes.is_some_and(|bytes| bytes > 1 << 26));
        let before = resident_bytes().unwrap();
        let block = vec![1_u8; 64 << 20];
        let after = resident_bytes().unwrap();
        assert!(after > before + (48 << 20), "{before} {after}");
        assert_eq!(block[12_345], 1);
        assert!(peak_bytes().unwrap() >= after);
        drop(block);
        // Other tests use memory at the same time, but not so much.
        if forget_peak() {
            assert!(peak_bytes().unwrap() < after, "{after}");
        }
    }
}
