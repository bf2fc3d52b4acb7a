use crate::geometry::Pose;
use crate::sensor::CameraAxes;
use glam::{DQuat, DVec3};
use std::fmt;

/// Another interpretation of poses or depths.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reading {
    /// The poses are of cameras with these axes.
    Axes(CameraAxes),
    /// The poses are of cameras with OpenCV axes, but were converted as if they had ROS axes.
    TurnedFromRos,
    /// The poses are `camera_from_world`.
    Inverted,
    /// The quaternions have w first.
    WFirst,
    /// The positions in metres are the given ones times this factor.
    Positions(f64),
    /// The depths in metres are the given ones times this factor.
    Depths(f64),
}

impl Reading {
    /// All readings that are tried.
    pub(super) const ALL: [Self; 16] = [
        Self::Axes(CameraAxes::OpenGl),
        Self::Axes(CameraAxes::Ros),
        Self::TurnedFromRos,
        Self::Inverted,
        Self::WFirst,
        Self::Positions(0.001),
        Self::Positions(0.01),
        Self::Positions(1000.0),
        Self::Depths(0.001),
        Self::Depths(0.1),
        Self::Depths(0.2),
        Self::Depths(0.25),
        Self::Depths(4.0),
        Self::Depths(5.0),
        Self::Depths(10.0),
        Self::Depths(1000.0),
    ];

    /// Whether it concerns the convention of poses, not units.
    pub(super) fn is_convention(self) -> bool {
        matches!(self, Self::Axes(_) | Self::TurnedFromRos | Self::Inverted | Self::WFirst)
    }

    /// The intended pose.
    pub(super) fn pose(self, pose: &Pose) -> Pose {
        match self {
            Self::Axes(axes) => axes.to_opencv(pose),
            Self::TurnedFromRos => {
                let turn = CameraAxes::Ros.to_opencv(&Pose::IDENTITY).rotation();
                Pose::from_unit((pose.rotation() * turn.inverse()).normalize(), pose.translation())
            }
            Self::Inverted => pose.inverse(),
            Self::WFirst => {
                let [w, x, y, z] = pose.rotation().to_array();
                Pose::from_unit(DQuat::from_xyzw(x, y, z, w), pose.translation())
            }
            Self::Positions(factor) => pose.with_translation(pose.translation() * factor),
            Self::Depths(_) => *pose,
        }
    }

    /// The intended point, in the camera frame.
    pub(super) fn point(self, in_camera: DVec3) -> DVec3 {
        match self {
            Self::Depths(factor) => in_camera * factor,
            _ => in_camera,
        }
    }
}

impl fmt::Display for Reading {
    /// Describes the data under this reading.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axes(CameraAxes::OpenCv) => {
                f.write_str("the poses look like those of cameras with OpenCV axes")
            }
            Self::Axes(CameraAxes::OpenGl) => {
                f.write_str("the poses look like those of cameras with OpenGL axes (y up, z backward)")
            }
            Self::Axes(CameraAxes::Ros) => {
                f.write_str("the poses look like those of cameras with ROS body axes (x forward, z up)")
            }
            Self::TurnedFromRos => f.write_str(
                "the poses look like those of cameras with OpenCV axes, turned as if they had ROS body axes",
            ),
            Self::Inverted => f.write_str("the poses look inverted (camera_from_world)"),
            Self::WFirst => f.write_str("the quaternions look as if w came first"),
            Self::Positions(factor) => write!(f, "the positions look {}", times(*factor)),
            Self::Depths(factor) => write!(f, "the depths look {}", times(*factor)),
        }
    }
}

/// Describes the error of numbers that would have to be multiplied by this factor.
fn times(factor: f64) -> String {
    match factor {
        0.001 => "1000 times too large, as if in mm".to_owned(),
        0.01 => "100 times too large, as if in cm".to_owned(),
        factor if factor < 1.0 => format!("{:.0} times too large", 1.0 / factor),
        factor => format!("{factor} times too small"),
    }
}
