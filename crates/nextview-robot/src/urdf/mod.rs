//! Arms from URDF, the robot description format of ROS.

mod chain;
mod error;
mod fold;
mod geometry;
mod joint;
mod model;
mod options;
mod reader;

pub use error::{UrdfError, UrdfFault};
pub use options::UrdfOptions;

use crate::Arm;
use chain::Chain;
use reader::UrdfReader;

impl Arm {
    /// Reads the arm between two links of a URDF.
    ///
    /// Links connected by fixed joints become one link with all their shapes. Joints between base and tip
    /// must be `revolute`, `continuous` (its limits become ±2π) or `prismatic`. Parts attached to the side of
    /// the chain or beyond the tip take up space, too; their joints are held at the value nearest to 0 within
    /// their limits. Parts above the base are left out. Neighbouring links may touch.
    ///
    /// Collision shapes count, visual ones do not. The axis of a joint need not have unit length.
    ///
    /// # Errors
    ///
    /// All faults of the file's elements, or all faults of the tree that they form, each with its line.
    /// Expand Xacro files first.
    ///
    /// ```
    /// use nextview_robot::{Arm, urdf::UrdfOptions};
    ///
    /// let text = r#"<robot name="pointer">
    ///     <link name="base"/>
    ///     <link name="hand"/>
    ///     <joint name="turn" type="revolute">
    ///         <parent link="base"/> <child link="hand"/> <origin xyz="0 0 0.5"/> <axis xyz="0 0 1"/>
    ///         <limit lower="-1" upper="1" velocity="2" effort="0"/>
    ///     </joint>
    /// </robot>"#;
    /// let arm = Arm::from_urdf(text, &UrdfOptions::default())?;
    /// assert_eq!(arm.forward(&[0.3]).translation().z, 0.5);
    /// # Ok::<(), nextview_robot::urdf::UrdfError>(())
    /// ```
    pub fn from_urdf(text: &str, options: &UrdfOptions) -> Result<Self, UrdfError> {
        let model = UrdfReader::new(options).read(text)?;
        let chain = Chain::find(&model, options.base_link, options.tip_link)?;
        Ok(fold::fold(&model, &chain))
    }
}

#[cfg(test)]
mod tests;
