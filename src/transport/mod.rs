//! Light paths through a scene. A path's life, in the order in which it is lived:
//!
//! ```text
//! scene::camera        a ray through a point of a pixel and of the lens
//! rectify::start       the medium that the ray starts in
//! interaction          what the ray meets, in the media that a tracker knows: a light, a surface to pass or one to turn at
//! path                 the path tracer: where it goes on (scatter), what it brings, when it ends
//! direct               light that is looked for where a path scatters
//! render::film         where its radiance is added
//! ```
//!
//! [`inspect`] tells one path vertex by vertex, [`parting`] where and why the paths of two modes part, and [`sampler`] has the random numbers
//! of each.

pub mod aim;
pub mod bidirectional;
pub mod caustics;
pub mod connection;
mod direct;
mod emission;
pub mod inspect;
pub mod interaction;
pub mod parting;
pub mod path;
pub mod photon_map;
mod roulette;
pub mod sampler;
mod walk;
mod weights;

/// Random dimensions of a path: the camera's, then a block for each segment.
pub mod dimension {
    pub const PIXEL: u32 = 0;
    pub const LENS: u32 = 1;
    pub const FIRST_SEGMENT: u32 = 2;
    pub const PER_SEGMENT: u32 = 6;
    pub const SCATTER: u32 = 0;
    pub const DIRECTION: u32 = 1;
    pub const EMITTER_CHOICE: u32 = 2;
    pub const EMITTER: u32 = 3;
    pub const ENVIRONMENT: u32 = 4;
    pub const ROULETTE: u32 = 5;

    /// Of subpaths from lights, whose numbers are others: instead of the camera's.
    pub const LIGHT_START: u32 = 0;
    pub const LIGHT_DIRECTION: u32 = 1;
    pub const LIGHT_CHOICE: u32 = u32::MAX;
    pub const LIGHT_AIM: u32 = u32::MAX - 1;

    /// The first of the block of a segment, counted from 1.
    #[inline]
    pub fn of_segment(segment: u32) -> u32 {
        FIRST_SEGMENT + (segment - 1) * PER_SEGMENT
    }
}
