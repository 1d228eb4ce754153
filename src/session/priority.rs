//! Threads that yield to the window.

/// Lowers the priority of the calling thread for good: it works when nobody else wants to. Only Linux has a priority for each thread that
/// everybody may lower; elsewhere nothing happens. What the system refuses is left as it is.
pub fn yield_to_the_window() {
    #[cfg(target_os = "linux")]
    {
        /// On a scale where each step is about a quarter more time: a third of the time of a thread that is as usual, while that wants to run.
        const STEPS: i32 = 5;
        let thread = Some(rustix::thread::gettid());
        let lowered = rustix::process::getpriority_process(thread)
            .and_then(|nice| rustix::process::setpriority_process(thread, (nice + STEPS).min(19)));
        if let Err(error) = lowered {
            log::debug!("the priority of a thread cannot be lowered: {error}");
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn only_the_calling_thread_yields() {
        let nice = || rustix::process::getpriority_process(Some(rustix::thread::gettid())).unwrap();
        let before = nice();
        let lowered = std::thread::spawn(move || {
            super::yield_to_the_window();
            nice()
        });
        assert_eq!(lowered.join().unwrap(), (before + 5).min(19));
        assert_eq!(nice(), before);
    }
}
