//! The specification of a campaign: a TOML file that names objects, planners with their parameters, seeds,
//! sets of candidates and first views.

pub mod builtin;
mod expansion;
mod faults;
mod first_views;
mod label;
mod load;
mod object;
mod paths;
mod pattern;
mod reading;
mod section;
mod specification;
mod sweep;
mod values;
mod variant;

pub(crate) use expansion::{Variant, expand};
pub(crate) use faults::FaultList;
pub use first_views::FirstViews;
pub use object::ObjectSpec;
pub use specification::Spec;
pub use variant::VariantSpec;

#[cfg(test)]
mod tests;
