//! What surfaces do with light, given a pair of indices: no scattering function knows how media are tracked.
//!
//! All unit vectors point away from the surface: `wo` to where the path comes from, `wi` to where it goes on. [`Normals`] lie on the side of
//! `wo`. Where paths carry radiance, light travels from `wi` to `wo`; where they carry importance, from `wo` to `wi` (Veach 1997, *Robust
//! Monte Carlo Methods for Light Transport Simulation*, section 3.7).

pub mod dielectric;
mod frame;
pub mod lambert;
pub mod mirror;
pub mod normals;
#[cfg(test)]
mod tests;

use glam::DVec3;

pub use dielectric::{Choice, Dielectric};
pub use frame::frame;
pub use lambert::Lambert;
pub use mirror::Mirror;
pub use normals::Normals;

use crate::spectrum::Spectrum;

/// What a path carries from its start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// Camera paths look for radiance, which is scaled by (n_wo/n_wi)² where it is refracted (Veach 1997, section 5.2).
    Radiance,
    /// Light paths carry power, which is not; interpolated normals weigh on it instead (section 5.3).
    Importance,
}

/// The scattering function of a surface at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scattering {
    Lambert(Lambert),
    Mirror(Mirror),
    Dielectric(Dielectric),
}

/// A direction that was sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatterSample {
    /// Unit.
    pub wi: DVec3,
    /// f·|cos wi| divided by the density of `wi` among directions on its side, without [`Self::radiance_scale`]. What goes through and what goes
    /// back are each other's alternatives: sampled by chance their shares cancel, and where both are followed each is worth its
    /// [`Self::share`].
    pub weight: Spectrum,
    /// Density per steradian that [`Scattering::pdf`] gives too; 0 from a function that [`Scattering::is_delta`].
    pub pdf: f64,
    /// (n_wo/n_wi)² where radiance is refracted, else 1. Apart from `weight`, because Russian roulette must not see it.
    pub radiance_scale: f64,
    /// Share of the light that is reflected, in [0, 1]; 1 where reflection is total, and of opaque surfaces.
    pub reflectance: f64,
    pub is_transmitted: bool,
    /// Whether nothing could go through.
    pub is_total: bool,
}

impl ScatterSample {
    /// Share of the light that goes this way, and the probability with which chance chooses it.
    #[inline]
    pub fn share(&self) -> f64 {
        if self.is_transmitted { 1.0 - self.reflectance } else { self.reflectance }
    }
}

impl Scattering {
    /// Samples where a path goes on. `choice` says whether through or back, where there is a choice; `u` gives two numbers uniform in [0, 1),
    /// and is called only by functions that are not delta functions.
    #[inline]
    pub fn sample(
        &self,
        normals: &Normals,
        wo: DVec3,
        choice: Choice,
        u: impl FnOnce() -> [f64; 2],
        transport: Transport,
    ) -> ScatterSample {
        let opaque = |wi, weight, pdf| ScatterSample {
            wi,
            weight,
            pdf,
            radiance_scale: 1.0,
            reflectance: 1.0,
            is_transmitted: false,
            is_total: true,
        };
        let mut sample = match self {
            Self::Lambert(Lambert { albedo }) => {
                let (wi, pdf) = lambert::sample(normals, u());
                opaque(wi, *albedo, pdf)
            }
            Self::Mirror(Mirror { albedo }) => opaque(mirror::reflect(-wo, normals), *albedo, 0.0),
            Self::Dielectric(Dielectric { interface, segment }) => {
                let scattered = dielectric::scatter(interface, -wo, normals, *segment, choice);
                let is_scaled = scattered.is_transmitted && transport == Transport::Radiance;
                ScatterSample {
                    wi: scattered.direction,
                    weight: Spectrum::ONE,
                    pdf: 0.0,
                    radiance_scale: if is_scaled { interface.radiance_factor() } else { 1.0 },
                    reflectance: scattered.reflectance,
                    is_transmitted: scattered.is_transmitted,
                    is_total: scattered.is_total,
                }
            }
        };
        if transport == Transport::Importance {
            sample.weight *= normals.importance_factor(wo, sample.wi);
        }
        sample
    }

    /// f·|cos wi|, with the factor (n_wo/n_wi)² on radiance that goes through; black for delta functions.
    #[inline]
    pub fn evaluate(&self, normals: &Normals, wo: DVec3, wi: DVec3, transport: Transport) -> Spectrum {
        match self {
            Self::Lambert(lambert) => {
                let value = lambert.evaluate(normals, wi);
                match transport {
                    Transport::Radiance => value,
                    Transport::Importance => value * normals.importance_factor(wo, wi),
                }
            }
            Self::Mirror(_) | Self::Dielectric(_) => Spectrum::ZERO,
        }
    }

    /// Density per steradian with which [`Self::sample`] gives `wi`, in both ways of transport; 0 for delta functions.
    #[inline]
    pub fn pdf(&self, normals: &Normals, _wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::Lambert(_) => lambert::pdf(normals, wi),
            Self::Mirror(_) | Self::Dielectric(_) => 0.0,
        }
    }

    /// Whether light leaves in single directions only, so that nothing can be found by asking for another.
    #[inline]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Lambert(_) => false,
            Self::Mirror(_) | Self::Dielectric(_) => true,
        }
    }
}
