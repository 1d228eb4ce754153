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
    /// What [`Mailbox::watch`] waits for.
    is_finished: bool,
}

/// What a reader finds.
pub(super) enum Taken<T> {
    Message(T),
    Empty,
    Closed,
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

    /// Waits for a message, no longer than `patience` where there is one.
    pub(super) fn wait(&self, patience: Option<Duration>) -> Taken<T> {
        let end = patience.map(|patience| Instant::now() + patience);
        let mut slot = self.lock();
        loop {
            match slot.message.take() {
                _ if slot.is_closed => return Taken::Closed,
                Some(message) => return Taken::Message(message),
                None => {}
            }
            slot = match end.map(|end| end.saturating_duration_since(Instant::now())) {
                Some(rest) if rest.is_zero() => return Taken::Empty,
                Some(rest) => self.changed.wait_timeout(slot, rest).unwrap_or_else(PoisonError::into_inner).0,
                None => self.changed.wait(slot).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    /// Makes ready for another [`Self::watch`], which ends when what is returned is dropped, by a panic too.
    #[must_use]
    pub(super) fn begin(&self) -> Watched<'_, T> {
        self.lock().is_finished = false;
        Watched(self)
    }

    /// Waits until what is [`Watched`] is over. Calls `interrupt` once if, meanwhile, the box is closed, or holds a message for which
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

/// Work during which the box is watched.
pub(super) struct Watched<'a, T>(&'a Mailbox<T>);

impl<T> Drop for Watched<'_, T> {
    fn drop(&mut self) {
        self.0.lock().is_finished = true;
        self.0.changed.notify_all();
    }
}

/// Something to be done during a [`Mailbox::watch`], if it lasts until then.
pub(super) struct Alarm<'a> {
    pub at: Instant,
    pub ring: Box<dyn FnOnce() + 'a>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_message_wins() {
        let mailbox = Mailbox::new();
        mailbox.post(1);
        mailbox.post(2);
        assert!(matches!(mailbox.wait(None), Taken::Message(2)));
        assert!(matches!(mailbox.wait(Some(Duration::ZERO)), Taken::Empty));
        mailbox.post(3);
        mailbox.close();
        assert!(matches!(mailbox.wait(Some(Duration::ZERO)), Taken::Closed));
        assert!(matches!(mailbox.wait(None), Taken::Closed));
    }

    #[test]
    fn waiting_ends_with_patience_or_a_message() {
        let mailbox = Mailbox::<i32>::new();
        let start = Instant::now();
        assert!(matches!(mailbox.wait(Some(Duration::from_millis(20))), Taken::Empty));
        assert!(start.elapsed() >= Duration::from_millis(20));
        std::thread::scope(|scope| {
            scope.spawn(|| mailbox.post(5));
            assert!(matches!(mailbox.wait(Some(Duration::from_secs(60))), Taken::Message(5)));
        });
        mailbox.close();
        assert!(matches!(mailbox.wait(Some(Duration::from_secs(60))), Taken::Closed));
    }

    #[test]
    fn a_message_interrupts_only_when_it_matters_and_not_too_early() {
        let mailbox = Mailbox::new();
        let start = Instant::now();
        let grace = Duration::from_millis(60);
        mailbox.post(7);
        let work = mailbox.begin();
        std::thread::scope(|scope| {
            let (sender, receiver) = std::sync::mpsc::channel();
            scope.spawn(move || {
                let _ = receiver.recv();
                drop(work);
            });
            let send = move || sender.send(()).expect("the receiver waits");
            mailbox.watch(start + grace, |message| *message == 7, send, None);
        });
        assert!(start.elapsed() >= grace);

        // One that does not matter never interrupts.
        let work = mailbox.begin();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                std::thread::sleep(Duration::from_millis(20));
                drop(work);
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
                drop(mailbox.begin());
            };
            Some(Alarm { at, ring: Box::new(ring) })
        };
        mailbox.watch(start, |_| false, || panic!("interrupted"), alarm(start + Duration::from_millis(20)));
        assert_eq!(rings.get(), 1);
        mailbox.watch(start, |_| false, || panic!("interrupted"), alarm(start));
        assert_eq!(rings.get(), 1, "what is finished already is not watched");
    }
}
