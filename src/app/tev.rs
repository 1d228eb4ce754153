//! The films of the panes to the image viewer tev: once, or whenever there are new samples. On a thread of its own.

use std::collections::BTreeMap;

use super::background::{Background, Bell, Desk, Repaint};
use super::develop::Source;
use crate::export::Picture;
use crate::export::tev::{PATIENCE, Tev, TevError};

/// What tev is to show.
#[derive(Debug, Clone, Default)]
pub struct Order {
    pub address: String,
    /// Whether every change is sent.
    pub is_live: bool,
    /// Counts what was asked for once.
    pub serial: u64,
    /// What the panes show, by name.
    pub images: Vec<(String, Source)>,
}

impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        self.address == other.address
            && self.is_live == other.is_live
            && self.serial == other.serial
            && self.images.len() == other.images.len()
            && self.images.iter().zip(&other.images).all(|((a, x), (b, y))| a == b && x.is(y))
    }
}

/// What has come of it since the last look.
#[derive(Debug, Default)]
pub struct Report {
    /// Images that were sent because they were asked for once.
    pub sent: Option<usize>,
    /// In words for the user.
    pub failure: Option<String>,
}

pub type Link = Background<Order, Report>;

/// Starts the thread, which calls `wake` when there is something to report.
pub fn start(wake: Repaint) -> std::io::Result<Link> {
    Background::start("tev", Bell::default(), move |desk| run(desk, &wake))
}

/// An open connection and the sizes of the images that it has made.
struct Connection {
    address: String,
    tev: Tev,
    sizes: BTreeMap<String, [u32; 2]>,
}

fn run(desk: &Desk<Order, Report>, wake: &Repaint) {
    let mut connection = None;
    let mut last_serial = 0;
    while let Some(order) = desk.wait(None) {
        let is_asked = order.serial != last_serial;
        last_serial = order.serial;
        if !is_asked && !order.is_live {
            connection = None;
            continue;
        }
        let result = match send(&mut connection, &order, is_asked) {
            // tev was closed and may be back.
            Err(TevError::Broken { .. }) => {
                connection = None;
                send(&mut connection, &order, is_asked)
            }
            other => other,
        };
        if result.is_err() || !order.is_live {
            connection = None;
        }
        let failure = result.as_ref().err().map(ToString::to_string);
        if failure.is_some() || is_asked {
            desk.put(|report| *report = Report { sent: result.ok().filter(|_| is_asked), failure });
            wake();
        }
    }
}

/// Sends every image, and returns how many there were.
fn send(connection: &mut Option<Connection>, order: &Order, takes_focus: bool) -> Result<usize, TevError> {
    let open = match connection.take().filter(|open| open.address == order.address) {
        Some(open) => open,
        None => Connection {
            address: order.address.clone(),
            tev: Tev::connect(&order.address, PATIENCE)?,
            sizes: BTreeMap::new(),
        },
    };
    let open = connection.insert(open);
    let mut count = 0;
    for (name, source) in &order.images {
        let Some(picture) = linear(source) else { continue };
        let size = [picture.width, picture.height];
        if open.sizes.get(name) == Some(&size) {
            open.tev.update(name, &picture)?;
        } else {
            open.tev.show(name, &picture, takes_focus && count == 0)?;
            open.sizes.insert(name.clone(), size);
        }
        count += 1;
    }
    Ok(count)
}

/// The radiance that a pane shows, or its difference; `None` for what is no radiance, and while there is nothing yet.
fn linear(source: &Source) -> Option<Picture> {
    let first = source.images().next()?;
    let rgb = match source.pair() {
        Some([a, b]) => a.iter().zip(b).map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect(),
        None if source.images().count() == 1 && source.truth.is_none() => first.rgb.clone(),
        None => return None,
    };
    Some(Picture { width: first.size[0], height: first.size[1], rgb })
}
