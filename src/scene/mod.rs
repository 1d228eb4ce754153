//! The scene: as written ([`Description`]), and compiled for tracing ([`Scene`]).

pub mod camera;
pub mod compile;
mod declared;
pub mod description;
pub mod emission;
pub mod environment;
pub mod equal_area;
mod error;
pub mod fields;
pub mod fingerprint;
mod ids;
pub mod lights;
pub mod needs;
pub mod note;
mod scene;
pub mod shapes;
mod survey;
pub mod tables;
pub mod texture;
pub mod validate;

pub use declared::Declared;
pub use description::Description;
pub use error::{Fault, Place, SceneError};
pub use fingerprint::Fingerprint;
pub use needs::SceneNeeds;
pub use note::LoadNote;
pub use scene::{Albedo, MediumId, Object, ObjectId, Scene, SceneMedium, Surface};
