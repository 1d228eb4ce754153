//! A slot for one message: the latest wins, and a reader can watch it while it works.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Holds at most one message; a newer one replaces an unread one.
#[derive(Debug)]
pub(super) struct Mailbox<T> {
    slot: Mutex<Slot<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Slot<T> {
    message: Option<T>,
    is_closed: bool,
    /// Set by [`Mailbox::finish`]; what [`Mailbox::watch`] waits for.
    is_finished: bool,
}

/// What a reader finds.
pub(super) enum Taken<T> {
    Message(T),
    Empty,
    Closed,
}

impl<T> From<Option<T>> for Taken<T> {
    /// `None`, from [`Mailbox::wait`], means closed.
    fn from(message: Option<T>) -> Self {
        message.map_or(Self::Closed, Self::Message)
    }
}

impl<T> Mailbox<T> {
    pub(super) fn new() -> Self {
        Self { slot: Mutex::new(Slot { message: None, is_closed: false, is_finished: false }), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Slot<T>> {
        // A slot is valid after every statement, so a panic elsewhere leaves nothing half done.
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a message in, over an unread one.
    pub(super) fn post(&self, message: T) {
        self.lock().message = Some(message);
        self.changed.notify_all();
    }

    /// Tells every reader to stop.
    pub(super) fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    /// The message, if there is one now.
    pub(super) fn take(&self) -> Taken<T> {
        let mut slot = self.lock();
        match slot.message.take() {
            _ if slot.is_closed => Taken::Closed,
            Some(message) => Taken::Message(message),
            None => Taken::Empty,
        }
    }

    /// Waits for a message; `None` when closed.
    pub(super) fn wait(&self) -> Option<T> {
        let mut slot = self.lock();
        loop {
            if slot.is_closed {
                return None;
            }
            if let Some(message) = slot.message.take() {
                return Some(message);
            }
            slot = self.changed.wait(slot).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// [`Self::wait`], but no longer than `patience`.
    pub(super) fn wait_for(&self, patience: Duration) -> Taken<T> {
        let end = Instant::now() + patience;
        let mut slot = self.lock();
        loop {
            if slot.is_closed {
                return Taken::Closed;
            }
            if let Some(message) = slot.message.take() {
                return Taken::Message(message);
            }
            let remaining = end.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                return Taken::Empty;
            }
            slot = self.changed.wait_timeout(slot, remaining).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Ends a [`Self::watch`].
    pub(super) fn finish(&self) {
        self.lock().is_finished = true;
        self.changed.notify_all();
    }

    /// Makes ready for another [`Self::watch`].
    pub(super) fn begin(&self) {
        self.lock().is_finished = false;
    }

    /// Waits until [`Self::finish`]. Calls `interrupt` once if, meanwhile, the box is closed, or holds a message for which
    /// `matters` and the time is past `not_before`; rings `alarm` when its time comes, before it interrupts.
    pub(super) fn watch(
        &self,
        not_before: Instant,
        matters: impl Fn(&T) -> bool,
        interrupt: impl FnOnce(),
        mut alarm: Option<Alarm<'_>>,
    ) {
        let mut interrupt = Some(interrupt);
        let mut slot = self.lock();
        while !slot.is_finished {
            let now = Instant::now();
            if let Some(alarm) = alarm.take_if(|alarm| alarm.at <= now) {
                drop(slot);
                (alarm.ring)();
                slot = self.lock();
                continue;
            }
            let is_wanted = interrupt.is_some() && slot.message.as_ref().is_some_and(&matters);
            if (slot.is_closed || (is_wanted && not_before <= now))
                && let Some(interrupt) = interrupt.take()
            {
                interrupt();
            }
            let interrupt_at = (is_wanted && interrupt.is_some()).then_some(not_before);
            let next = interrupt_at.into_iter().chain(alarm.as_ref().map(|alarm| alarm.at)).min();
            slot = match next {
                Some(next) => {
                    let patience = next.saturating_duration_since(now);
                    self.changed.wait_timeout(slot, patience).unwrap_or_else(PoisonError::into_inner).0
                }
                None => self.changed.wait(slot).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }
}

/// Something to be done during a [`Mailbox::watch`], if it lasts until then.
pub(super) struct Alarm<'a> {
    pub at: Instant,
    pub ring: Box<dyn FnOnce() + 'a>,
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn the_latest_message_wins() {
        let mailbox = Mailbox::new();
        mailbox.post(1);
        mailbox.post(2);
        assert_eq!(mailbox.wait(), Some(2));
        assert!(matches!(mailbox.take(), Taken::Empty));
        mailbox.post(3);
        mailbox.close();
        assert!(matches!(mailbox.take(), Taken::Closed));
        assert_eq!(mailbox.wait(), None);
    }

    #[test]
    fn waiting_ends_with_patience_or_a_message() {
        let mailbox = Arc::new(Mailbox::<i32>::new());
        let start = Instant::now();
        assert!(matches!(mailbox.wait_for(Duration::from_millis(20)), Taken::Empty));
        assert!(start.elapsed() >= Duration::from_millis(20));
        let sender = Arc::clone(&mailbox);
        std::thread::scope(|scope| {
            scope.spawn(move || sender.post(5));
            assert!(matches!(mailbox.wait_for(Duration::from_secs(60)), Taken::Message(5)));
        });
        mailbox.close();
        assert!(matches!(mailbox.wait_for(Duration::from_secs(60)), Taken::Closed));
    }

    #[test]
    fn a_message_interrupts_only_when_it_matters_and_not_too_early() {
        let mailbox = Arc::new(Mailbox::new());
        let worker = Arc::clone(&mailbox);
        let start = Instant::now();
        let grace = Duration::from_millis(60);
        mailbox.post(7);
        std::thread::scope(|scope| {
            let (sender, receiver) = std::sync::mpsc::channel();
            scope.spawn(move || {
                let _ = receiver.recv();
                worker.finish();
            });
            let send = move || sender.send(()).expect("the receiver waits");
            mailbox.watch(start + grace, |message| *message == 7, send, None);
        });
        assert!(start.elapsed() >= grace);

        // One that does not matter never interrupts.
        mailbox.begin();
        let worker = Arc::clone(&mailbox);
        std::thread::scope(|scope| {
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(20));
                worker.finish();
            });
            mailbox.watch(start, |message| *message == 8, || panic!("interrupted"), None);
        });
    }

    #[test]
    fn an_alarm_rings_once_in_time_and_not_after_the_end() {
        let mailbox = Mailbox::<i32>::new();
        let start = Instant::now();
        let (mailbox, rings) = (&mailbox, &std::cell::Cell::new(0));
        let alarm = |at: Instant| {
            let ring = move || {
                assert!(Instant::now() >= at);
                rings.set(rings.get() + 1);
                mailbox.finish();
            };
            Some(Alarm { at, ring: Box::new(ring) })
        };
        mailbox.begin();
        mailbox.watch(start, |_| false, || panic!("interrupted"), alarm(start + Duration::from_millis(20)));
        assert_eq!(rings.get(), 1);
        mailbox.watch(start, |_| false, || panic!("interrupted"), alarm(start));
        assert_eq!(rings.get(), 1, "what is finished already is not watched");
    }
}
