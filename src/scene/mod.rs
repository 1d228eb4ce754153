//! The scene: as written ([`Description`]), read from files ([`load`]), built in ([`builtin`]), and compiled for tracing ([`Scene`]).

pub mod builtin;
pub mod camera;
pub mod compile;
pub mod description;
pub mod environment;
pub mod error;
pub mod fields;
pub mod files;
pub mod fingerprint;
pub mod light;
pub mod load;
pub mod needs;
pub mod note;
pub mod save;
mod scene;
pub mod shapes;

pub use description::Description;
pub use error::{Fault, SceneError};
pub use fingerprint::Fingerprint;
pub use needs::SceneNeeds;
pub use note::LoadNote;
pub use scene::{MediumId, Object, ObjectId, Paint, Scene, SceneMedium, Surface};
