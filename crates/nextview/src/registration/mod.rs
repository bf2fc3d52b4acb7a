//! Aligns new frames to the surface measured so far, so that wrong poses do not spoil the map.
//!
//! Start with [`KnownSurface`]: it [registers](KnownSurface::register) a frame by point-to-plane ICP and adds
//! the frames that fit. An alignment that cannot be trusted is refused: the given pose stays, and the
//! [`Verdict`] gives the reason. Added frames are [realigned](KnownSurface::realign) to each other. [`align`]
//! is the same ICP for other surfaces, and [`PointPairs`] finds its starting pose if none is known, for
//! example between a part and its CAD model. The formulas are in `docs/methods/registration.md`.

mod agreement;
mod anywhere;
mod camera;
mod config;
mod fitting;
mod icp;
mod joint;
mod joint_equations;
mod known_surface;
mod mode;
mod normal_equations;
mod outcome;
mod pair;
mod point_tree;
mod pose_fit;
mod pose_prior;
mod surface_points;

pub use anywhere::{PointPairs, VotedPose};
pub use config::{GivenPoses, RegistrationConfig};
pub use icp::{MAX_STEPS, SearchReach, align};
pub use known_surface::{KnownSurface, Realigned};
pub use mode::RegistrationMode;
pub use outcome::{Registration, Verdict};
pub use pair::Pair;
pub use pose_fit::{HandEyeError, PoseFit};
pub use surface_points::SurfacePoint;

pub(crate) use agreement::{Agreement, apart};
