//! Ways to damage a file, chosen at random from a seed.

/// Texts that readers of numbers stumble over.
const TEXTS: [&str; 16] = [
    "-1",
    "0",
    "1e999",
    "-1e-400",
    "nan",
    "inf",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "999999999",
    "\"",
    "\n",
    "\r",
    "[",
    "}",
    "\u{feff}",
];
/// Numbers that readers of binary fields stumble over.
const NUMBERS: [u32; 8] = [0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF];

pub struct Damage {
    state: u64,
}

impl Damage {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// SplitMix64 (Steele, Lea and Flood 2014).
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 if that is 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// A copy of `bytes` with one to four faults; parts of `others` may come into it.
    pub fn apply(&mut self, bytes: &[u8], others: &[&[u8]]) -> Vec<u8> {
        let mut damaged = bytes.to_vec();
        for _ in 0..=self.below(4) {
            self.fault(&mut damaged, others);
        }
        damaged
    }

    fn fault(&mut self, bytes: &mut Vec<u8>, others: &[&[u8]]) {
        let at = self.below(bytes.len());
        match self.below(8) {
            // A flipped bit, and a byte that is another.
            0 | 1 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
            2 if !bytes.is_empty() => bytes[at] = self.next() as u8,
            // A cut.
            3 => bytes.truncate(at),
            // A part that is missing, and one that is there twice.
            4 => {
                let end = (at + 1 + self.below(16)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            5 => {
                let end = (at + 1 + self.below(32)).min(bytes.len());
                let part = bytes[at.min(end)..end].to_vec();
                bytes.splice(at..at, part);
            }
            // The end of another file.
            6 => {
                let other = others[self.below(others.len())];
                bytes.truncate(at);
                bytes.extend(&other[self.below(other.len())..]);
            }
            // A number that is another, as text or in binary.
            _ if self.below(2) == 0 => {
                let is_digit = |byte: &u8| byte.is_ascii_digit();
                let start = bytes[at..].iter().position(is_digit).map_or(at, |offset| at + offset);
                let end =
                    bytes[start..].iter().position(|byte| !is_digit(byte)).map_or(bytes.len(), |offset| start + offset);
                let text = TEXTS[self.below(TEXTS.len())];
                bytes.splice(start..end, text.bytes());
            }
            _ => {
                let number = NUMBERS[self.below(NUMBERS.len())];
                let number = if self.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
                for (byte, new) in bytes.iter_mut().skip(at).zip(number) {
                    *byte = new;
                }
            }
        }
    }
}
