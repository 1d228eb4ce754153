//! Kinds of surfaces by what they enclose.

/// How to ask whether a point lies inside a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Enclosure {
    /// Closed, without crossing itself; inner components are cavities. Inside is where a ray's first hit is from behind.
    Closed,
    /// Closed, of parts that overlap. Inside is where a ray leaves more often than it enters.
    Union,
    /// It encloses something but has holes. Inside is where the generalised winding number is above one half.
    Holed,
    /// An open surface. Inside is behind it, as far as its first hit can tell.
    Sheet,
}
