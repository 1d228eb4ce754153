//! A stand-in for tev that listens on a port of its own and keeps what it is sent. Written from the description of tev's protocol, not
//! from the code that sends.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

#[derive(Debug, Clone, Default)]
pub struct Image {
    pub size: [usize; 2],
    /// Row by row, by the channel's name.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Packets that brought pixels.
    pub updates: usize,
}

#[derive(Clone)]
pub struct Listener {
    pub address: String,
    images: Arc<Mutex<BTreeMap<String, Image>>>,
}

impl Listener {
    pub fn open() -> Self {
        let socket = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = socket.local_addr().unwrap().to_string();
        let listener = Self { address, images: Arc::default() };
        let images = Arc::clone(&listener.images);
        // It ends with the test.
        std::thread::spawn(move || {
            for stream in socket.incoming() {
                let images = Arc::clone(&images);
                std::thread::spawn(move || serve(stream.expect("a connection"), &images));
            }
        });
        listener
    }

    pub fn images(&self) -> BTreeMap<String, Image> {
        self.images.lock().expect("no packet was malformed").clone()
    }

    /// Waits until the images are as they should be.
    pub fn wait_for(&self, what: &str, is_met: impl Fn(&BTreeMap<String, Image>) -> bool) -> BTreeMap<String, Image> {
        let start = Instant::now();
        loop {
            let images = self.images();
            if is_met(&images) {
                return images;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "waited too long for {what}: {:?}", images.keys());
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn serve(mut stream: TcpStream, images: &Mutex<BTreeMap<String, Image>>) {
    loop {
        let mut length = [0; 4];
        if stream.read_exact(&mut length).is_err() {
            return;
        }
        let length = u32::from_le_bytes(length) as usize;
        let mut rest = vec![0; length - 4];
        // A connection that ends within a packet loses it.
        if stream.read_exact(&mut rest).is_err() {
            return;
        }
        take(&mut Packet(&rest), &mut images.lock().expect("no packet was malformed"));
    }
}

struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_at(N);
        self.0 = rest;
        head.try_into().unwrap()
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("text ends with a zero byte");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("text is UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }

    fn int(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.bytes())).expect("no size is negative")
    }

    fn long(&mut self) -> usize {
        usize::try_from(i64::from_le_bytes(self.bytes())).expect("no offset is negative")
    }
}

fn take(packet: &mut Packet<'_>, images: &mut BTreeMap<String, Image>) {
    let [kind, _focus] = packet.bytes();
    let name = packet.text();
    match kind {
        4 => {
            let size = [packet.int(), packet.int()];
            let count = packet.int();
            let blank = vec![0.0; size[0] * size[1]];
            let channels = (0..count).map(|_| (packet.text(), blank.clone())).collect();
            images.insert(name, Image { size, channels, updates: 0 });
            assert!(packet.0.is_empty(), "nothing follows");
        }
        6 => {
            let count = packet.int();
            let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
            let [x, y, width, height] = std::array::from_fn(|_| packet.int());
            let offsets: Vec<usize> = (0..count).map(|_| packet.long()).collect();
            let strides: Vec<usize> = (0..count).map(|_| packet.long()).collect();
            let values: Vec<f32> =
                packet.0.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
            let image = images.get_mut(&name).expect("the image was made before");
            for (channel, name) in names.iter().enumerate() {
                let pixels = image.channels.get_mut(name).expect("the image has this channel");
                for pixel in 0..width * height {
                    let place = (y + pixel / width) * image.size[0] + x + pixel % width;
                    pixels[place] = values[offsets[channel] + pixel * strides[channel]];
                }
            }
            image.updates += 1;
        }
        other => panic!("packets of kind {other} are not expected"),
    }
}
