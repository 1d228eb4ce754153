//! Random numbers: Sobol points, Owen-scrambled and shuffled by hashing (Burley 2020, "Practical Hash-based Owen Scrambling"), padded
//! in pairs of dimensions.
//!
//! Every number is a pure function of (seed, pixel, sample, dimension). Within a pixel and dimension the first n samples are
//! well distributed for every n.

named! {
    /// Where numbers come from.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Sequence {
        /// Sobol points: the samples of a pixel are spread evenly.
        Sobol = "sobol",
        /// Hashes, each for itself.
        Independent = "independent",
    }
}

/// The numbers of one sample of one pixel.
#[derive(Debug, Clone, Copy)]
pub struct Sampler {
    sequence: Sequence,
    pixel_seed: u32,
    /// The sample's number with its bits reversed.
    sample: u32,
}

impl Sampler {
    /// Of Sobol points.
    #[inline]
    pub fn new(seed: u64, pixel: u32, sample: u32) -> Self {
        Self::of(Sequence::Sobol, seed, pixel, sample)
    }

    #[inline]
    pub fn of(sequence: Sequence, seed: u64, pixel: u32, sample: u32) -> Self {
        Self {
            sequence,
            pixel_seed: mix(Self::seed_hash(seed) ^ pixel.wrapping_mul(0x85EB_CA6B)),
            sample: sample.reverse_bits(),
        }
    }

    /// What the numbers of all pixels have of the seed.
    #[inline]
    pub fn seed_hash(seed: u64) -> u32 {
        mix(mix(seed as u32 ^ 0x9E37_79B9) ^ (seed >> 32) as u32)
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn get_1d(&self, dimension: u32) -> f64 {
        let seed = mix(self.pixel_seed ^ dimension.wrapping_mul(0xC2B2_AE35));
        if self.sequence == Sequence::Independent {
            return self.hash(seed);
        }
        // The first Sobol dimension is the index with its bits reversed.
        let first = permute(self.sample, seed);
        scramble(first.reverse_bits(), mix(seed ^ 0x27D4_EB2F))
    }

    /// Uniform in [0, 1)²; uses the one dimension id.
    #[inline]
    pub fn get_2d(&self, dimension: u32) -> [f64; 2] {
        let seed = mix(self.pixel_seed ^ dimension.wrapping_mul(0xC2B2_AE35));
        if self.sequence == Sequence::Independent {
            return [self.hash(seed), self.hash(mix(seed ^ 0x1656_67B1))];
        }
        let index = permute(self.sample, seed).reverse_bits();
        [scramble(index, mix(seed ^ 0x27D4_EB2F)), scramble(sobol_second(index), mix(seed ^ 0x1656_67B1))]
    }
}

impl Sampler {
    /// A number of its own for each sample and seed.
    #[inline]
    fn hash(&self, seed: u32) -> f64 {
        f64::from(mix(mix(self.sample ^ seed).wrapping_add(seed))) * (1.0 / 4_294_967_296.0)
    }
}

/// Integer hash with good avalanche (Wellons, "lowbias32").
#[inline]
fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7FEB_352D);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846C_A68B);
    x ^ (x >> 16)
}

/// Nested uniform scramble in base 2 on numbers whose bits are reversed: the permutation of Laine and Karras (2011) with Vegdahl's
/// constants. Every bit depends on those below it only.
#[inline]
fn permute(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3D20_ADEA);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6C56);
    x ^ x.wrapping_mul(0x53A2_2864)
}

/// The point with the bits `reversed`, lowest first, scrambled.
#[inline]
fn scramble(reversed: u32, seed: u32) -> f64 {
    f64::from(permute(reversed, seed).reverse_bits()) * (1.0 / 4_294_967_296.0)
}

/// The second Sobol dimension, its bits reversed: Pascal's triangle modulo 2, a byte of the index at a time.
#[inline]
fn sobol_second(index: u32) -> u32 {
    let bytes = index.to_le_bytes();
    (0..4).fold(0, |sum, byte| sum ^ SECOND[byte][usize::from(bytes[byte])])
}

static SECOND: [[u32; 256]; 4] = second_table();

const fn second_table() -> [[u32; 256]; 4] {
    let mut directions = [0u32; 32];
    let mut direction = 1u32 << 31;
    let mut bit = 0;
    while bit < 32 {
        directions[bit] = direction;
        direction ^= direction >> 1;
        bit += 1;
    }
    let mut table = [[0u32; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 0;
        while value < 256 {
            let mut bit = 0;
            while bit < 8 {
                if value >> bit & 1 == 1 {
                    table[byte][value] ^= directions[byte * 8 + bit].reverse_bits();
                }
                bit += 1;
            }
            value += 1;
        }
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any 2^k samples of a pair are a (0, k, 2)-net: each elementary interval of area 2^−k holds exactly one.
    #[test]
    fn pairs_are_nets() {
        for (pixel, dimension) in [(0, 0), (7, 3), (123_456, 41)] {
            let points: Vec<[f64; 2]> = (0..64).map(|s| Sampler::new(5, pixel, s).get_2d(dimension)).collect();
            for bits in 0..=6u32 {
                let (nx, ny) = (1usize << bits, 1usize << (6 - bits));
                let mut seen = vec![0; 64];
                for p in &points {
                    seen[(p[0] * nx as f64) as usize * ny + (p[1] * ny as f64) as usize] += 1;
                }
                assert!(seen.iter().all(|&count| count == 1), "{nx}×{ny}");
            }
        }
    }

    #[test]
    fn dimensions_pixels_and_seeds_differ() {
        let base = Sampler::new(0, 0, 0).get_1d(0);
        assert_ne!(base, Sampler::new(0, 0, 0).get_1d(1));
        assert_ne!(base, Sampler::new(0, 1, 0).get_1d(0));
        assert_ne!(base, Sampler::new(1, 0, 0).get_1d(0));
        assert_ne!(base, Sampler::new(1 << 32, 0, 0).get_1d(0));
    }

    /// Two dimensions of one pixel are not correlated: over many pixels the mean of the product is that of independent numbers.
    #[test]
    fn dimensions_are_independent() {
        let count = 40_000;
        let mean: f64 = (0..count)
            .map(|pixel| {
                let s = Sampler::new(9, pixel, 3);
                (s.get_1d(4) - 0.5) * (s.get_1d(5) - 0.5)
            })
            .sum::<f64>()
            / f64::from(count);
        // Standard deviation of the product is 1/12.
        assert!(mean.abs() < 4.0 / 12.0 / f64::from(count).sqrt(), "{mean}");
    }

    /// Independent numbers are uniform, and neither the samples of a pixel nor the two of a pair know of each other.
    #[test]
    fn independent_numbers() {
        let count = 40_000;
        let numbers = |sample| Sampler::of(Sequence::Independent, 4, 17, sample).get_2d(6);
        let product = |a: f64, b: f64| (a - 0.5) * (b - 0.5) * 12.0;
        let (mut mean, mut square, mut pair, mut next) = (0.0, 0.0, 0.0, 0.0);
        for sample in 0..count {
            let ([a, b], [c, _]) = (numbers(sample), numbers(sample + 1));
            mean += (a - 0.5) * 12f64.sqrt();
            square += product(a, a) - 1.0;
            pair += product(a, b);
            next += product(a, c);
        }
        // Each sum has a standard deviation of the root of the count, that of squares less.
        let most = 4.0 * f64::from(count).sqrt();
        assert!([mean, square, pair, next].iter().all(|sum| sum.abs() < most), "{mean} {square} {pair} {next}");
    }
}
