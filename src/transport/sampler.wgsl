// Twin of `sampler.rs`: the same bits. A number in f32 has the upper 24 of them.

/// Whether numbers are hashes, each for itself, and not Sobol points.
override INDEPENDENT: bool = false;

const PIXEL: u32 = 0u;
const LENS: u32 = 1u;
const SCATTER: u32 = 0u;
const DIRECTION: u32 = 1u;
const EMITTER_CHOICE: u32 = 2u;
const EMITTER: u32 = 3u;
const ENVIRONMENT: u32 = 4u;
const ROULETTE: u32 = 5u;

/// The first dimension of the block of a segment, counted from 1.
fn dimensions_of_segment(segment: u32) -> u32 {
    return 2u + (segment - 1u) * 6u;
}

struct Sampler {
    pixel_seed: u32,
    /// The sample's number with its bits reversed.
    sample: u32,
}

/// `seed_hash` is that of the image.
fn sampler_of(seed_hash: u32, pixel: u32, sample: u32) -> Sampler {
    return Sampler(mix_bits(seed_hash ^ (pixel * 0x85ebca6bu)), reverseBits(sample));
}

fn bits_1d(s: Sampler, dimension: u32) -> u32 {
    let seed = mix_bits(s.pixel_seed ^ (dimension * 0xc2b2ae35u));
    if INDEPENDENT {
        return hashed_bits(s, seed);
    }
    return scrambled_bits(reverseBits(permute_bits(s.sample, seed)), mix_bits(seed ^ 0x27d4eb2fu));
}

fn bits_2d(s: Sampler, dimension: u32) -> vec2u {
    let seed = mix_bits(s.pixel_seed ^ (dimension * 0xc2b2ae35u));
    if INDEPENDENT {
        return vec2u(hashed_bits(s, seed), hashed_bits(s, mix_bits(seed ^ 0x165667b1u)));
    }
    let index = reverseBits(permute_bits(s.sample, seed));
    return vec2u(
        scrambled_bits(index, mix_bits(seed ^ 0x27d4eb2fu)),
        scrambled_bits(sobol_second(index), mix_bits(seed ^ 0x165667b1u)),
    );
}

/// Uniform in [0, 1).
fn get_1d(s: Sampler, dimension: u32) -> f32 {
    return f32(bits_1d(s, dimension) >> 8u) * 5.9604644775390625e-8;
}

/// Uniform in [0, 1)².
fn get_2d(s: Sampler, dimension: u32) -> vec2f {
    return vec2f(bits_2d(s, dimension) >> vec2u(8u)) * 5.9604644775390625e-8;
}

fn hashed_bits(s: Sampler, seed: u32) -> u32 {
    return mix_bits(mix_bits(s.sample ^ seed) + seed);
}

fn mix_bits(bits: u32) -> u32 {
    var x = bits;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

fn permute_bits(bits: u32, seed: u32) -> u32 {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

fn scrambled_bits(reversed: u32, seed: u32) -> u32 {
    return reverseBits(permute_bits(reversed, seed));
}

/// The second Sobol dimension, its bits reversed. The matrix is Pascal's triangle modulo 2: as polynomials over GF(2) it takes p(x) to
/// p(1 + x), which halves do by themselves because (1 + x)^16 = 1 + x^16.
fn sobol_second(index: u32) -> u32 {
    var x = index;
    x ^= x >> 16u;
    x ^= (x >> 8u) & 0x00ff00ffu;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 2u) & 0x33333333u;
    return x ^ ((x >> 1u) & 0x55555555u);
}
