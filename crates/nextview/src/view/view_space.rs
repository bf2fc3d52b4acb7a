use super::csv;
use crate::{Error, geometry::Pose};
use glam::DVec3;
use std::io::{Read, Write};

/// The view candidates: an immutable list of camera poses (`world_from_camera`), numbered from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSpace {
    poses: Vec<Pose>,
}

impl ViewSpace {
    /// A view space of at least one pose.
    pub fn new(poses: Vec<Pose>) -> Result<Self, Error> {
        if poses.is_empty() {
            return Err(Error::invalid("view space", "empty", "at least one view candidate"));
        }
        Ok(Self { poses })
    }

    /// Reads candidates from CSV text: a row each, `x_m, y_m, z_m` for a camera that looks at `target`, or
    /// `x_m, y_m, z_m, qx, qy, qz, qw` for a whole pose (`world_from_camera`, Hamilton quaternion). A header
    /// with these names may come first; then other columns are passed over. Empty lines and lines that start
    /// with `#` do not count. Errors name the line.
    pub fn read_csv(reader: impl Read, target: DVec3) -> Result<Self, Error> {
        Self::new(csv::read(reader, target)?)
    }

    /// Writes the candidates as CSV that [`read_csv`](Self::read_csv) reads back to the same bits.
    pub fn write_csv(&self, writer: impl Write) -> Result<(), Error> {
        csv::write(writer, &self.poses)
    }

    /// Number of candidates; never 0.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Always false: a view space has at least one candidate.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The pose of candidate `view`, which must be below [`len`](Self::len).
    pub fn pose(&self, view: usize) -> Pose {
        self.poses[view]
    }

    /// All poses in the order of their numbers.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
}
