use crate::Error;
use crate::checked::{check_range, checked_when_read};
use crate::geometry::Pose;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A plane with an upper side, given by its normal.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Plane;
///
/// let table = Plane::horizontal(0.7).unwrap();
/// assert!((table.height(DVec3::new(3.0, 1.0, 0.9)) - 0.2).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct Plane {
    /// Of unit length.
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    normal: DVec3,
    /// `normal . p` of its points, metres.
    #[serde(rename = "offset_m")]
    offset: f64,
}

checked_when_read!(Plane);

impl Plane {
    /// Returns the plane through `point` (metres) with this normal, of any nonzero length.
    pub fn new(normal: DVec3, point: DVec3) -> Result<Self, Error> {
        let unit = normal.try_normalize().filter(|_| point.is_finite());
        let normal = unit.ok_or_else(|| {
            Error::invalid(
                "plane",
                format!("normal {normal} through {point}"),
                "a direction and a finite point",
            )
        })?;
        Ok(Self { normal, offset: normal.dot(point) })
    }

    /// Returns `normal . p` of its points, metres.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Returns the horizontal plane at this height, metres, upper side up. Fails unless the height is finite.
    pub fn horizontal(z: f64) -> Result<Self, Error> {
        Self::new(DVec3::Z, DVec3::Z * z)
    }

    /// Fails unless the normal is of unit length, within 1e-6, and the offset finite.
    fn check(&self) -> Result<(), Error> {
        let length = self.normal.length();
        check_range("length of the normal", length, 1.0 - 1e-6..=1.0 + 1e-6, "1 (within 1e-6)")?;
        if !self.offset.is_finite() {
            return Err(Error::invalid("offset_m", self.offset, "a finite number of metres"));
        }
        Ok(())
    }

    /// Returns the normal, of unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Returns the height of a point above the plane, metres; negative below.
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Returns the plane in another frame.
    pub fn moved(&self, pose: &Pose) -> Self {
        let normal = pose.rotation() * self.normal;
        Self { normal, offset: self.offset + normal.dot(pose.translation()) }
    }

    /// Returns the parallel plane `distance` metres above.
    pub fn raised(&self, distance: f64) -> Self {
        Self { normal: self.normal, offset: self.offset + distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn heights_are_distances_to_the_plane() {
        let plane = Plane::new(DVec3::new(0.0, 3.0, 4.0), DVec3::X).unwrap();
        assert_eq!(plane.height(DVec3::X * 7.0), 0.0);
        assert!((plane.height(DVec3::Z) - 0.8).abs() < 1e-15);
        assert!((plane.raised(0.5).height(DVec3::Z) - 0.3).abs() < 1e-15);
        let pose = Pose::new(DQuat::from_rotation_y(1.0), DVec3::new(0.1, 0.2, 0.3)).unwrap();
        let height = plane.moved(&pose).height(pose.transform_point(DVec3::Z));
        assert!((height - plane.height(DVec3::Z)).abs() < 1e-15);
    }

    #[test]
    fn refuses_what_is_no_plane() {
        assert!(Plane::new(DVec3::ZERO, DVec3::ZERO).is_err());
        assert!(Plane::new(DVec3::NAN, DVec3::ZERO).is_err());
        assert!(Plane::horizontal(f64::NAN).unwrap_err().to_string().contains("finite point"));
    }
}
