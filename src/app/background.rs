//! A worker thread: it takes the latest order, is woken by a bell when its inputs change, and leaves finished work to be collected. The
//! window never waits for it.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// Tells the window that there is something new.
pub type Repaint = Arc<dyn Fn() + Send + Sync>;

/// State shared by the window and the thread.
#[derive(Debug, Default)]
struct Tray<Order, Finished> {
    order: Order,
    has_news: bool,
    is_closed: bool,
    finished: Finished,
}

/// The thread's side: where orders come from and finished work goes to.
#[derive(Debug, Default)]
pub struct Desk<Order, Finished> {
    tray: Mutex<Tray<Order, Finished>>,
    changed: Condvar,
}

impl<Order: Clone, Finished> Desk<Order, Finished> {
    /// Waits for an order, the bell or `until`, and returns the latest order; `None` when the thread is to end.
    pub fn wait(&self, until: Option<Instant>) -> Option<Order> {
        let mut tray = self.lock();
        while !tray.has_news && !tray.is_closed {
            tray = match until.map(|until| until.saturating_duration_since(Instant::now())) {
                Some(rest) if rest.is_zero() => break,
                Some(rest) => self.changed.wait_timeout(tray, rest).unwrap_or_else(PoisonError::into_inner).0,
                None => self.changed.wait(tray).unwrap_or_else(PoisonError::into_inner),
            };
        }
        tray.has_news = false;
        (!tray.is_closed).then(|| tray.order.clone())
    }

    /// The latest order, for a thread that is to end.
    pub fn order(&self) -> Order {
        self.lock().order.clone()
    }
}

impl<Order, Finished> Desk<Order, Finished> {
    fn lock(&self) -> MutexGuard<'_, Tray<Order, Finished>> {
        // A tray is valid after every statement, so a panic elsewhere leaves nothing half done.
        self.tray.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts finished work out for the window, with what it has not taken yet.
    pub fn put(&self, add: impl FnOnce(&mut Finished)) {
        add(&mut self.lock().finished);
    }
}

/// A way to tell the thread that what it works with has changed.
#[derive(Debug)]
pub struct Bell<Order, Finished>(Arc<Desk<Order, Finished>>);

// Not derived: that would require orders and finished work to be `Clone`.
impl<Order, Finished> Clone for Bell<Order, Finished> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<Order: Default, Finished: Default> Default for Bell<Order, Finished> {
    /// A bell without a thread yet.
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<Order, Finished> Bell<Order, Finished> {
    pub fn ring(&self) {
        self.0.lock().has_news = true;
        self.0.changed.notify_all();
    }
}

/// The handle to the thread. Dropping it ends the thread.
#[derive(Debug)]
pub struct Background<Order, Finished> {
    desk: Arc<Desk<Order, Finished>>,
    thread: Option<JoinHandle<()>>,
}

impl<Order, Finished> Background<Order, Finished>
where
    Order: PartialEq + Clone + Send + 'static,
    Finished: Default + Send + 'static,
{
    /// Starts the thread, if the system lets it; it is to `work` until its desk has no order for it, and `bell` is heard there.
    pub fn start(
        name: &str,
        bell: Bell<Order, Finished>,
        work: impl FnOnce(&Desk<Order, Finished>) + Send + 'static,
    ) -> std::io::Result<Self> {
        let desk = Arc::clone(&bell.0);
        let thread = std::thread::Builder::new().name(name.into()).spawn(move || work(&bell.0))?;
        Ok(Self { desk, thread: Some(thread) })
    }

    /// Says what to do from now on. An order that has not been looked at is forgotten.
    pub fn set_order(&self, order: &Order) {
        let mut tray = self.desk.lock();
        if tray.order != *order {
            tray.order = order.clone();
            tray.has_news = true;
            self.desk.changed.notify_all();
        }
    }

    /// What has been finished since the last call.
    pub fn take_finished(&self) -> Finished {
        std::mem::take(&mut self.desk.lock().finished)
    }
}

impl<Order, Finished> Drop for Background<Order, Finished> {
    fn drop(&mut self) {
        self.desk.lock().is_closed = true;
        self.desk.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_latest_order_wins_and_the_same_one_is_no_news() {
        // Declared first to be dropped last: where this test fails, the thread must not wait for it.
        let background;
        let bell = Bell::default();
        let (seen, sees) = channel();
        let (resume, resumed) = channel();
        // It finishes every order it sees, says that it has, and goes back to its desk when told to.
        let work = move |desk: &Desk<u32, Vec<u32>>| {
            while let Some(order) = desk.wait(None) {
                desk.put(|finished| finished.push(order));
                if seen.send(order).is_err() || resumed.recv().is_err() {
                    return;
                }
            }
        };
        background = Background::start("echo", bell.clone(), work).unwrap();
        background.set_order(&1);
        assert_eq!(sees.recv(), Ok(1));
        // It is not at its desk: of these only the last is seen, and the bell adds nothing to it.
        (2..5).for_each(|order| background.set_order(&order));
        bell.ring();
        resume.send(()).unwrap();
        assert_eq!(sees.recv(), Ok(4));
        background.set_order(&4);
        resume.send(()).unwrap();
        assert!(sees.recv_timeout(Duration::from_millis(50)).is_err(), "the same order is no news");
        bell.ring();
        assert_eq!(sees.recv(), Ok(4), "but what it is about has changed");
        assert_eq!(background.take_finished(), [1, 4, 4]);
        assert_eq!(background.take_finished(), [0; 0]);
        resume.send(()).unwrap();
        drop(background);
        assert!(sees.recv().is_err(), "the thread has ended");
    }

    #[test]
    fn waiting_ends_with_a_ring_an_end_or_its_time() {
        let desk = Desk::<u32, ()>::default();
        let start = Instant::now();
        let until = start + Duration::from_millis(20);
        assert_eq!(desk.wait(Some(until)), Some(0));
        assert!(Instant::now() >= until);
        let bell = Bell(Arc::new(desk));
        bell.ring();
        let long = Instant::now() + Duration::from_secs(600);
        assert_eq!(bell.0.wait(Some(long)), Some(0));
        bell.0.lock().is_closed = true;
        assert_eq!(bell.0.wait(Some(long)), None);
        assert!(Instant::now() < long);
    }
}
