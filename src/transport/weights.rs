//! Weights of all the ways in which one path can be made, for multiple importance sampling (Veach 1997, chapter 10).
//!
//! A path of k segments can be made by joining a subpath from the camera with one from a light at any of its edges, or by merging both at any
//! of its vertices. The weight of one way against all others needs densities of the whole path, but they differ vertex by vertex only in
//! a factor that both subpaths know on their way. So each subpath carries two sums, and a weight is computed where subpaths meet, from those of
//! both (Georgiev 2012, *Implementing Vertex Connection and Merging*, whose third sum is the second divided by the number of merges).
//!
//! At an interface the density of a refracted direction and that of the same path the other way round differ by the solid angles that they are
//! spread over, dω_in/dω_out = n_out² cos_out / (n_in² cos_in).
//!
//! The heuristic is that of powers with exponent 2.

/// The heuristic's power of a ratio of densities.
#[inline]
pub fn power(ratio: f64) -> f64 {
    ratio * ratio
}

/// What a subpath knows of the other ways to make it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weights {
    /// The density of connecting to the last vertex's predecessor over that of coming from there; 0 behind a mirror or an interface.
    pub connection: f64,
    /// The ways that part earlier on this subpath, over the density of coming the way that it came; without the factor of the next reverse
    /// density.
    pub earlier: f64,
    /// The merges at the last vertex that scattered, in the same way; they count as [`Self::earlier`] if the path comes to a mirror or an
    /// interface next.
    pending: f64,
}

impl Weights {
    /// At the end of a segment of that squared length, on a surface at that cosine to its normal.
    #[inline]
    pub fn arrive(&mut self, squared_length: f64, cosine: f64, is_delta: bool) {
        if is_delta {
            self.earlier += self.pending;
        }
        self.pending = 0.0;
        self.connection *= power(squared_length / cosine);
        self.earlier /= power(cosine);
    }

    /// Goes on from a surface along a direction of density `pdf` per steradian, at `cosine` to the normal, where `reverse_pdf` is the density
    /// of going back where the path comes from, if it came from the new direction.
    #[inline]
    pub fn scatter(&mut self, cosine: f64, pdf: f64, reverse_pdf: f64, merges: Merges) {
        let (now, pending) = match merges {
            Merges::Here(number) => (number, 0.0),
            Merges::IfDeltaFollows(number) => (0.0, number),
        };
        self.earlier = power(cosine / pdf) * self.before(reverse_pdf, now);
        self.pending = power(cosine / pdf) * power(pending);
        self.connection = power(1.0 / pdf);
    }

    /// Goes on from a mirror or an interface at `cosine` to the normal. `solid_angle_ratio` is dω_out/dω_in.
    #[inline]
    pub fn scatter_delta(&mut self, cosine: f64, solid_angle_ratio: f64) {
        self.earlier *= power(cosine * solid_angle_ratio);
        self.connection = 0.0;
    }

    /// All ways that part at this vertex or earlier, over the one that does not: to be multiplied by the power of the density with which
    /// the other subpath would come here. `merges` is the number of subpaths that are expected to be merged here.
    #[inline]
    pub fn before(&self, reverse_pdf: f64, merges: f64) -> f64 {
        power(merges) + self.connection + power(reverse_pdf) * self.earlier
    }
}

/// How many subpaths are expected to be merged at a vertex: those of lights that come from a mirror or an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Merges {
    /// At a vertex of a subpath from a light, which knows where it has come from.
    Here(f64),
    /// At one of a subpath from the camera: if what comes next, seen from the camera, is a mirror or an interface.
    IfDeltaFollows(f64),
}
