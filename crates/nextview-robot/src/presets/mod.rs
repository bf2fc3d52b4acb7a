//! Well-known arms, as our own URDF files: kinematics and limits as published by the manufacturers, and
//! solids that roughly enclose the links. Each file names its sources.

use crate::Arm;
use crate::urdf::UrdfOptions;

/// Names accepted by [`Arm::preset`].
pub const NAMES: [&str; 6] = ["ur3e", "ur5e", "ur10e", "kr6_r900", "lr_mate_200id", "panda"];

/// Returns the URDF of a preset, to modify or to extend with a camera; `None` for an unknown name.
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

/// The error for an unknown preset.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no arm is called {name:?}, expected one of {}, or your own URDF file", NAMES.join(", "))]
pub struct UnknownPreset {
    /// The name.
    pub name: String,
}

impl Arm {
    /// Returns a well-known arm by one of the [names](NAMES), without tools. Its acceleration limits follow
    /// from the defaults of [`UrdfOptions`].
    pub fn preset(name: &str) -> Result<Self, UnknownPreset> {
        let text = urdf(name).ok_or_else(|| UnknownPreset { name: name.to_owned() })?;
        Ok(Self::from_urdf(text, &UrdfOptions::default()).expect("a test reads every preset"))
    }
}

#[cfg(test)]
mod tests;
