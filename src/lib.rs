//! iorect: rendering of scenes in which dielectrics sit inside dielectrics.
//!
//! A user gives every object the index of refraction (IOR) of its own interior. What lies on the *other* side of each surface is
//! found by the program: *IOR rectification* pre-traces rays outward from each refractor; the first dielectric whose first hit
//! is from behind is its exterior. It is stored, and rendering needs no state per path.
//!
//! # Map of the code, in the order in which data flows
//!
//! | module | what it holds |
//! |---|---|
//! | [`spectrum`] | light at the wavelengths of a path: radiance, throughput, transmittance |
//! | [`optics`] | Fresnel and Snell, dispersion formulas, media, the catalogue: physics without geometry |
//! | [`color`] | sRGB's transfer function, scales of false colours |
//! | [`geometry`] | rays, triangles, spheres, meshes with their analysis and repair, and the tree that finds what a ray hits |
//! | [`scene`] | the scene as the user wrote it ([`scene::Description`]), and its compiled form ([`scene::Scene`]) |
//! | [`formats`] | scenes, meshes and images from files, and scenes back to them; the built-in scenes |
//! | [`rectify`] | what lies on both sides of every place on every refractor: contacts, cells, patches, votes, the interface table |
//! | [`tracking`] | the modes: given a crossing, which medium is left and which is entered |
//! | [`scatter`] | scattering functions about interpolated normals, given a pair of indices: sample, evaluate, pdf |
//! | [`transport`] | a ray's life, from the camera to its last vertex: what it meets, where it goes on, what it brings |
//! | [`render`] | the settings of an image, the film that samples are added to, and what renders them: the CPU, and the graphics processor |
//! | [`check`] | what is wrong or doubtful in a scene, with advice |
//! | [`measure`] | image differences |
//! | [`session`] | the threads behind the window: scenes are prepared and rendered while they are edited |
//! | [`writing`] | files that are either whole or not there, whatever happens |
//! | [`export`] | PNG and EXR, labelled comparisons |
//! | [`report`] | error against run time, stability, what was left out, growth, and the page that shows them |
//! | [`cli`], `app` | the command line and the window (feature `window`), both thin over the rest |
//!
//! # Invariants
//!
//! - Nothing outside `app` knows egui; nothing outside `app` and `render::gpu` knows wgpu; nothing outside `geometry` knows
//!   obvhs; `cli` and `app` never use each other.
//! - No tracker sees a scattering function and no scattering function sees a tracker: they share a pair of IORs.
//! - Random numbers are a pure function of (seed, pixel, sample, dimension), the same in every mode and on every processor.
//! - What the graphics processor computes is in WGSL beside its twin in Rust, and a test calls both with the same numbers.

/// Declares an enum whose variants have names: words for files, tables and legends.
macro_rules! named {
    ($(#[$meta:meta])* $visible:vis enum $type:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$meta])*
        $visible enum $type {
            $($(#[$doc])* $variant,)*
        }

        impl $type {
            /// The stable word for it.
            $visible fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

#[cfg(feature = "window")]
pub mod app;
pub mod check;
pub mod cli;
pub mod color;
pub mod export;
pub mod formats;
pub mod geometry;
pub mod measure;
pub mod optics;
pub mod rectify;
pub mod render;
pub mod report;
pub mod scatter;
pub mod scene;
pub mod session;
pub mod spectrum;
pub mod tracking;
pub mod transport;
pub mod writing;
