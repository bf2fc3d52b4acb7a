//! Information gains: the value of rays.
//!
//! [`LocalGain`] is the paper's gain and evaluates single crossings, as the flow requires. The others come
//! from the literature that the paper compares with; they are [`InformationGain`]s and evaluate whole rays.
//! They follow the published formulas. If a formula leaves something open, the documentation of the gain
//! states our choice.
//!
//! [`ExpectedSurface`] is ours: it counts the surface that a view will probably show, under a learned prior.
//!
//! [`BetterSurface`], [`MoreLooks`] and [`SurerSurface`] value second looks at surface that was not measured
//! well enough, or not often enough.
//!
//! In the formulas x runs over the voxels of a ray from the camera up to and including the first occupied
//! one, or to the border of the box; H is entropy in nats, and P(vis_x) the product of 1 - P(occupied) over
//! the voxels before x.

mod apora;
mod area_factor;
mod average_entropy;
mod behind_surface;
mod better_surface;
mod expected_surface;
mod information_gain;
mod krainin;
mod local_gain;
mod more_looks;
mod nearest;
mod object_probability;
mod occlusion_aware;
#[cfg(test)]
mod plate;
mod potthast;
mod proximity_count;
mod rear_side_entropy;
mod rear_side_voxel;
mod seen_voxels;
mod surer_surface;
mod unobserved_voxel;

pub use apora::Apora;
pub use area_factor::AreaFactor;
pub use average_entropy::AverageEntropy;
pub use better_surface::BetterSurface;
pub use expected_surface::{ExpectedSurface, ViewEvaluator};
pub use information_gain::InformationGain;
pub use krainin::Krainin;
pub use local_gain::LocalGain;
pub use more_looks::MoreLooks;
pub use object_probability::object_probability;
pub use occlusion_aware::OcclusionAware;
pub use potthast::Potthast;
pub use proximity_count::ProximityCount;
pub use rear_side_entropy::RearSideEntropy;
pub use rear_side_voxel::RearSideVoxel;
pub(crate) use seen_voxels::is_in_measured_voxels;
pub use surer_surface::SurerSurface;
pub use unobserved_voxel::UnobservedVoxel;
