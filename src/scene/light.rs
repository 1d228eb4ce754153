//! Emitting objects, ready to be sampled.

/// Every light of the scene.
#[derive(Debug, Clone)]
pub struct Emitters {}
