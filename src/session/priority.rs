//! Threads that yield to the window.

/// Lowers the priority of the calling thread for good: it works when nobody else wants to. Only Linux has a priority for each thread that
/// everybody may lower; elsewhere nothing happens. What the system refuses is left as it is.
pub fn yield_to_the_window() {
    #[cfg(target_os = "linux")]
    {
        /// Of the scale from −20 to 19, where 0 is usual: a ninth of the time of a thread that is as usual, while that wants to run.
        const NICE: i32 = 10;
        let thread = rustix::thread::gettid();
        if let Err(error) = rustix::process::setpriority_process(Some(thread), NICE) {
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
        assert!(lowered.join().unwrap() >= 10);
        assert_eq!(nice(), before);
    }
}
