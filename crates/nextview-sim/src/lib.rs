//! The simulation side of next-best-view planning: meshes, objects that need no file, a simulated depth
//! camera, the truth about what it can see, and the measures that compare planners.
//!
//! Start with [`scene::Scene`]. A scan asks the session for views, [`evaluator::capture`] for frames, and
//! [`evaluator::Evaluator`] for measures. The only planners here are those that may look at a mesh:
//! [`baseline::Clairvoyant`] at the true object, [`inspection::InspectionViews`] at the CAD model of a part.

pub mod accuracy;
pub mod area;
pub mod baseline;
pub mod builtin;
pub mod camera;
mod error;
pub mod evaluator;
pub mod inspection;
pub mod mesh;
pub mod noise;
mod overlap;
pub mod quality;
pub mod random_object;
pub mod scene;
pub mod surface;
pub mod truth;

pub use error::SimError;
