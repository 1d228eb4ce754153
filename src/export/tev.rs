//! Pictures to tev (<https://github.com/Tom94/tev>), an image viewer that listens on a TCP port.
//!
//! A packet is its whole length in bytes (u32), its kind (one byte) and what the kind asks for, all little-endian; text ends with a zero
//! byte. Two kinds are used:
//!
//! - 4, "create image": focus (u8), name, width, height, number of channels (i32 each), their names. An image of that name is replaced.
//! - 6, "update image": focus (u8), name, number of channels (i32), their names, x, y, width, height (i32 each), for each channel the
//!   offset of its first value and for each the stride between its values (i64 each, in floats), and the values (f32).
//!
//! tev answers nothing.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::Picture;

/// Where tev listens by default.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:14158";
/// The port where an address names none.
const DEFAULT_PORT: u16 = 14158;
/// How long to wait for tev to answer a call or to take some bytes.
pub const PATIENCE: Duration = Duration::from_secs(3);
/// Most pixels of one packet: its length must fit into 32 bits, and tev holds a packet in memory.
const MOST_PIXELS: u32 = 1 << 22;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// tev could not be reached, or stopped listening.
#[derive(Debug, thiserror::Error)]
pub enum TevError {
    #[error("“{address}” is no address of a tev: use HOST:PORT, such as {DEFAULT_ADDRESS}")]
    BadAddress { address: String },
    #[error("tev does not listen at {address} ({reason}): start tev, or name where it listens")]
    NobodyListens { address: String, reason: io::Error },
    #[error("tev at {address} has stopped listening: {reason}")]
    Broken { address: String, reason: io::Error },
    #[error("a picture of {width} × {height} pixels cannot be sent to tev")]
    BadPicture { width: u32, height: u32 },
}

/// A connection to tev.
#[derive(Debug)]
pub struct Tev {
    address: String,
    stream: TcpStream,
}

impl Tev {
    /// Connects to `HOST:PORT`, or to `HOST` at tev's usual port. Each address of the host gets `patience`, and so does each write.
    ///
    /// # Errors
    /// When the address is none, or nobody listens there.
    pub fn connect(address: &str, patience: Duration) -> Result<Self, TevError> {
        let address = with_port(address.trim());
        let bad = || TevError::BadAddress { address: address.clone() };
        let (host, port) = address.rsplit_once(':').ok_or_else(bad)?;
        if host.is_empty() || port.parse::<u16>().is_err() {
            return Err(bad());
        }
        let failed = |reason| TevError::NobodyListens { address: address.clone(), reason };
        let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
        for place in address.to_socket_addrs().map_err(failed)? {
            match TcpStream::connect_timeout(&place, patience) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(patience)).map_err(failed)?;
                    return Ok(Self { address, stream });
                }
                Err(reason) => last = reason,
            }
        }
        Err(failed(last))
    }

    /// Shows `picture` under `name`, in the place of an image of that name if there is one. `takes_focus`: tev selects it.
    ///
    /// # Errors
    /// When the picture is empty or of impossible size, or tev has stopped listening.
    pub fn show(&mut self, name: &str, picture: &Picture, takes_focus: bool) -> Result<(), TevError> {
        let (width, height) = (picture.width, picture.height);
        let bad = || TevError::BadPicture { width, height };
        picture.require_sound().map_err(|_| bad())?;
        let size = [i32::try_from(width).map_err(|_| bad())?, i32::try_from(height).map_err(|_| bad())?];
        self.write(&create_image(name, size, takes_focus))?;
        self.update(name, picture)
    }

    /// New values for an image that [`Self::show`] has made in this size.
    ///
    /// # Errors
    /// As [`Self::show`].
    pub fn update(&mut self, name: &str, picture: &Picture) -> Result<(), TevError> {
        let (width, height) = (picture.width, picture.height);
        picture.require_sound().map_err(|_| TevError::BadPicture { width, height })?;
        let rows = (MOST_PIXELS / width).max(1);
        let parts = picture.rgb.chunks(rows as usize * width as usize);
        for (y, part) in (0..height).step_by(rows as usize).zip(parts) {
            self.write(&update_rows(name, [y, width], part))?;
        }
        Ok(())
    }

    fn write(&mut self, packet: &[u8]) -> Result<(), TevError> {
        let failed = |reason| TevError::Broken { address: self.address.clone(), reason };
        self.stream.write_all(packet).map_err(failed)
    }
}

/// The address with tev's usual port, where it names none.
fn with_port(address: &str) -> String {
    if address.is_empty() {
        DEFAULT_ADDRESS.to_owned()
    } else if address.contains(':') {
        address.to_owned()
    } else {
        format!("{address}:{DEFAULT_PORT}")
    }
}

/// A packet that is being written.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, takes_focus: bool, name: &str) -> Self {
        let mut packet = Self(vec![0; 4]);
        packet.0.extend([kind, u8::from(takes_focus)]);
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        // A zero byte would end it.
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    fn int(&mut self, x: i32) {
        self.0.extend(x.to_le_bytes());
    }

    /// With its length at its head.
    fn finish(mut self) -> Vec<u8> {
        let length = u32::try_from(self.0.len()).expect("packets are of limited size");
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

fn create_image(name: &str, [width, height]: [i32; 2], takes_focus: bool) -> Vec<u8> {
    let mut packet = Packet::new(4, takes_focus, name);
    [width, height, CHANNELS.len() as i32].into_iter().for_each(|x| packet.int(x));
    CHANNELS.into_iter().for_each(|channel| packet.text(channel));
    packet.finish()
}

/// Whole rows from row `y` on.
fn update_rows(name: &str, [y, width]: [u32; 2], rgb: &[[f32; 3]]) -> Vec<u8> {
    let mut packet = Packet::new(6, false, name);
    packet.int(CHANNELS.len() as i32);
    CHANNELS.into_iter().for_each(|channel| packet.text(channel));
    let height = rgb.len() / width as usize;
    [0, y as i32, width as i32, height as i32].into_iter().for_each(|x| packet.int(x));
    for offset in 0..CHANNELS.len() as i64 {
        packet.0.extend(offset.to_le_bytes());
    }
    for _ in CHANNELS {
        packet.0.extend((CHANNELS.len() as i64).to_le_bytes());
    }
    packet.0.reserve(12 * rgb.len());
    rgb.iter().flatten().for_each(|x| packet.0.extend(x.to_le_bytes()));
    packet.finish()
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn packets_are_laid_out_as_tev_reads_them() {
        let packet = create_image("a", [2, 3], true);
        let expected =
            [&[30, 0, 0, 0, 4, 1, b'a', 0][..], &[2, 0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0], b"R\0G\0B\0"].concat();
        assert_eq!(packet, [&(expected.len() as u32).to_le_bytes()[..], &expected[4..]].concat());
        // A zero byte in a name would end it early.
        assert_eq!(create_image("a\0", [2, 3], true), packet);
    }

    #[test]
    fn where_nobody_listens_there_is_a_clear_error_soon() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let error = Tev::connect(&free.to_string(), PATIENCE).unwrap_err().to_string();
        assert!(error.contains("does not listen") && error.contains(&free.to_string()), "{error}");
        for bad in [":1", "host:", "host:port", "host:99999", "a:b:c"] {
            let error = Tev::connect(bad, PATIENCE).unwrap_err();
            assert!(matches!(error, TevError::BadAddress { .. }), "{bad}: {error}");
        }
        assert_eq!((with_port(""), with_port("box")), (DEFAULT_ADDRESS.to_owned(), "box:14158".to_owned()));
    }

    #[test]
    fn impossible_pictures_are_refused() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut tev = Tev::connect(&listener.local_addr().unwrap().to_string(), PATIENCE).unwrap();
        for (width, height, pixels) in [(0, 0, 0), (2, 2, 3), (0, 5, 0)] {
            let picture = Picture { width, height, rgb: vec![[0.0; 3]; pixels] };
            assert!(matches!(tev.show("x", &picture, true), Err(TevError::BadPicture { .. })));
        }
    }
}
