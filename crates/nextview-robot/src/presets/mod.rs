//! Well-known arms, as URDF files of our own: kinematics and limits as their makers publish them, and solids
//! that enclose their links roughly. Each file names its sources.

use crate::Arm;
use crate::urdf::UrdfOptions;

/// Names that [`Arm::preset`] knows.
pub const NAMES: [&str; 6] = ["ur3e", "ur5e", "ur10e", "kr6_r900", "lr_mate_200id", "panda"];

/// The URDF of a preset, to be changed or extended with a camera; none for an unknown name.
pub fn urdf(name: &str) -> Option<&'static str> {
    match name {
        "ur3e" => Some(include_str!("../../presets/ur3e.urdf")),
        "ur5e" => Some(include_str!("../../presets/ur5e.urdf")),
        "ur10e" => Some(include_str!("../../presets/ur10e.urdf")),
        "kr6_r900" => Some(include_str!("../../presets/kr6_r900.urdf")),
        "lr_mate_200id" => Some(include_str!("../../presets/lr_mate_200id.urdf")),
        "panda" => Some(include_str!("../../presets/panda.urdf")),
        _ => None,
    }
}

/// A name that no preset has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no arm is called {name:?}, expected one of {}, or an own URDF file", NAMES.join(", "))]
pub struct UnknownPreset {
    /// The name.
    pub name: String,
}

impl Arm {
    /// A well-known arm by one of the [names](NAMES), without tools. Its acceleration limits are the default
    /// of [`UrdfOptions`].
    pub fn preset(name: &str) -> Result<Self, UnknownPreset> {
        let text = urdf(name).ok_or_else(|| UnknownPreset { name: name.to_owned() })?;
        Ok(Self::from_urdf(text, &UrdfOptions::default()).expect("a test reads every preset"))
    }
}

#[cfg(test)]
mod tests;
