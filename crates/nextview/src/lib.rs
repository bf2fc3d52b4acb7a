//! Next-best-view planning: where should a depth camera look next to scan an unknown object completely in as
//! few views as possible?
//!
//! Start with [`session::Session`]: it takes depth frames and decides on camera poses.
//! [`session::SessionConfig`] sets the object's box and the voxel size, [`view::generate`] makes the view
//! candidates, and a [`planner::ViewPlanner`] chooses among them: begin with [`planner::MostSurface`]. After
//! the scan, the crate `nextview-model` makes a cloud and a mesh from the frames.
//!
//! # Your own camera
//!
//! The session asks for a view; how the camera gets there and takes the image is up to you.
//!
//! ```
//! use nextview::geometry::{Aabb, Pose};
//! use nextview::glam::DVec3;
//! use nextview::planner::{MostSurface, MostSurfaceConfig};
//! use nextview::sensor::{DepthImage, Frame, Intrinsics};
//! use nextview::session::{Decision, Session, SessionConfig};
//! use nextview::view::generate;
//!
//! /// Stands for a depth camera on a robot: here, nothing is in front of it.
//! fn take_depth_image(camera: &Intrinsics, _world_from_camera: &Pose) -> Vec<f32> {
//!     vec![f32::INFINITY; camera.n_pixels()]
//! }
//!
//! fn main() -> Result<(), nextview::Error> {
//!     let camera = Intrinsics::d435i();
//!     let config = SessionConfig::new(0.02, Aabb::cube(DVec3::ZERO, 0.1));
//!     let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 50)?;
//!     let planner = MostSurface::new(MostSurfaceConfig::default())?;
//!     let mut session = Session::new(config, camera, views, Box::new(planner))?;
//!     while let Decision::Move(next) = session.decide()? {
//!         let depth = take_depth_image(&camera, &next.world_from_camera);
//!         let image = DepthImage::from_metres(camera.width(), camera.height(), depth)?;
//!         session.observe(&Frame::new(image, camera, next.world_from_camera, 3.0)?)?;
//!     }
//!     assert!(!session.frames().is_empty());
//!     Ok(())
//! }
//! ```
//!
//! The folder `examples` contains this loop with a simulated ball, a custom gain and a custom planner.
//!
//! # Modules
//!
//! The modules are layers, and each imports only from those before it: [`geometry`], [`flow`] -> [`sensor`]
//! -> [`map`], [`diagnosis`] -> [`view`], [`surface`], [`prior`], [`registration`] -> [`visibility`],
//! [`motion`] -> [`gain`] -> [`planner`] -> [`session`]. The library computes: it opens no file, prints
//! nothing, reads no clock and holds no global state. Long computations can be [cancelled](Cancel).
//!
//! # Features
//!
//! - `mint`: conversions between `glam` vectors and quaternions and other math libraries, such as nalgebra,
//!   through `mint`.
//! - `schema`: JSON Schemas for configurations and records.
#![cfg_attr(feature = "mint", doc = "")]
#![cfg_attr(feature = "mint", doc = "```")]
#![cfg_attr(feature = "mint", doc = "use nextview::geometry::Pose;")]
#![cfg_attr(feature = "mint", doc = "use nextview::glam::{DQuat, DVec3};")]
#![cfg_attr(feature = "mint", doc = "")]
#![cfg_attr(
    feature = "mint",
    doc = "// What `nalgebra::UnitQuaternion::into()` and `nalgebra::Vector3::into()` give."
)]
#![cfg_attr(feature = "mint", doc = "let rotation = mint::Quaternion { v: [0.0, 0.0, 0.0].into(), s: 1.0 };")]
#![cfg_attr(feature = "mint", doc = "let translation = mint::Vector3 { x: 0.1, y: 0.2, z: 0.3 };")]
#![cfg_attr(
    feature = "mint",
    doc = "let pose = Pose::new(DQuat::from(rotation), DVec3::from(translation)).unwrap();"
)]
#![cfg_attr(feature = "mint", doc = "assert_eq!(mint::Vector3::from(pose.translation()), translation);")]
#![cfg_attr(feature = "mint", doc = "```")]
#![doc = ""]
#![doc = include_str!("../conventions.md")]

mod cancel;
mod checked;
mod degrees;
pub mod diagnosis;
mod error;
pub mod flow;
pub mod gain;
pub mod geometry;
mod instructions;
pub mod map;
pub mod motion;
pub mod object;
pub mod placement;
pub mod planner;
pub mod prior;
pub mod registration;
pub mod sensor;
pub mod session;
pub mod surface;
pub mod text;
pub mod view;
pub mod visibility;

pub use cancel::{Cancel, Cancelled};
pub use error::Error;
pub use glam;
