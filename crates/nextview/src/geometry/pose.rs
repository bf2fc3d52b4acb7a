use crate::Error;
use crate::checked::{check_range, checked_when_read};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::ops::Mul;

/// A rigid transform between two frames, named destination first: `world_from_camera`.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use nextview::geometry::Pose;
///
/// let world_from_camera = Pose::new(DQuat::IDENTITY, DVec3::new(1.0, 0.0, 0.0)).unwrap();
/// let camera_from_world = world_from_camera.inverse();
/// assert_eq!(camera_from_world.transform_point(DVec3::X), DVec3::ZERO);
/// ```
///
/// Files store the rotation as a Hamilton quaternion x, y, z, w and the translation in metres. Reading and
/// writing preserve every bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct Pose {
    #[serde(rename = "rotation_xyzw")]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 4]"))]
    rotation: DQuat,
    #[serde(rename = "translation_m")]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    translation: DVec3,
}

checked_when_read!(Pose);

impl Pose {
    /// The identity transform.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// Largest coordinate of a translation, metres: ten times what geodetic coordinates need. Double
    /// precision resolves 15 nm there.
    pub const REACH: f64 = 1e8;

    /// Returns the transform with this rotation and translation in metres, with coordinates within
    /// [`REACH`](Self::REACH).
    ///
    /// The quaternion may be off unit length by 1e-3 (text files carry few digits) and is normalised.
    pub fn new(rotation: DQuat, translation: DVec3) -> Result<Self, Error> {
        if !rotation.is_finite() || !translation.is_finite() {
            return Err(Error::invalid("pose", format!("{rotation}, {translation}"), "finite numbers"));
        }
        check_position("translation", translation)?;
        if (rotation.length() - 1.0).abs() > 1e-3 {
            return Err(Error::invalid("length of the quaternion", rotation.length(), "1 (within 1e-3)"));
        }
        Ok(Self { rotation: rotation.normalize(), translation })
    }

    /// Fails unless the quaternion is of length 1, within 1e-6, and the translation within reach.
    fn check(&self) -> Result<(), Error> {
        let length = self.rotation.length();
        check_range("length of the quaternion", length, 1.0 - 1e-6..=1.0 + 1e-6, "1 (within 1e-6)")?;
        check_position("translation_m", self.translation)
    }

    /// Returns the transform of an orthonormal, right-handed basis.
    pub(crate) fn from_basis(basis: DMat3, translation: DVec3) -> Self {
        Self { rotation: DQuat::from_mat3(&basis).normalize(), translation }
    }

    /// Returns the transform with a rotation of unit length and a translation within reach, unchecked.
    pub(crate) fn from_unit(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation, translation }
    }

    /// Sets the translation.
    pub(crate) fn with_translation(self, translation: DVec3) -> Self {
        Self { translation, ..self }
    }

    /// Returns the rotation, of unit length.
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }

    /// Returns the origin of the source frame in the destination frame, metres: for `world_from_camera`, the
    /// camera position.
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// Returns the rotation as a matrix, which is faster for many points.
    pub fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }

    /// Transforms a point from the source frame to the destination frame.
    pub fn transform_point(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Returns the inverse transform.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: -(rotation * self.translation) }
    }
}

/// Fails unless all coordinates are numbers within [`Pose::REACH`].
pub(crate) fn check_position(name: &'static str, position: DVec3) -> Result<(), Error> {
    // Comparisons with NaN are false.
    if position.abs().cmple(DVec3::splat(Pose::REACH)).all() {
        return Ok(());
    }
    Err(Error::invalid(name, position, "metres, at most 1e8 on each axis"))
}

impl Mul for Pose {
    type Output = Self;

    /// Chains transforms: `a_from_b * b_from_c` is `a_from_c`.
    fn mul(self, b_from_c: Self) -> Self {
        Self {
            rotation: (self.rotation * b_from_c.rotation).normalize(),
            translation: self.transform_point(b_from_c.translation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chaining_with_the_inverse_gives_identity() {
        let a =
            Pose::new(DQuat::from_rotation_x(0.3) * DQuat::from_rotation_z(1.1), DVec3::new(1.0, -2.0, 0.5));
        let a = a.unwrap();
        let identity = a * a.inverse();
        assert!(identity.translation().length() < 1e-14);
        assert!(identity.rotation().dot(DQuat::IDENTITY).abs() > 1.0 - 1e-14);
    }

    #[test]
    fn refuses_numbers_that_are_not_rigid() {
        let refused =
            |w: f64| Pose::new(DQuat::from_xyzw(0.0, 0.0, 0.0, w), DVec3::ZERO).unwrap_err().to_string();
        assert!(refused(f64::NAN).contains("finite"));
        assert_eq!(refused(2.0), "length of the quaternion is 2, expected 1 (within 1e-3)");
    }
}
