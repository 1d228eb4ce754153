//! Numbers by which media and objects are known.

/// Index into [`super::Scene::media`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct MediumId(pub u32);

impl MediumId {
    /// The global medium.
    pub const WORLD: Self = Self(0);
    /// The reserved exterior of `naive`.
    pub const VACUUM: Self = Self(1);
}

/// Index into [`super::Scene::objects`]: refractors first, then solids, then lights, each in file order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectId(pub u32);
