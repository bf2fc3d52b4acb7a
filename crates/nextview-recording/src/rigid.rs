//! Poses in files, validated before use.

use crate::RecordingError;
use crate::text;
use glam::{DMat3, DQuat, DVec3};
use nextview::geometry::Pose;
use std::path::Path;

/// Maximum deviation from the identity of a rotation times its transpose. Files carry few digits, and some
/// calibrations leave a scale or shear: the poses of a public capture in our tests are off by 0.007.
const TOLERANCE: f64 = 0.01;

/// A position farther from the origin, in metres, is probably given in millimetres.
pub const FARTHEST_POSITION: f64 = 100.0;

/// Reads a rigid transform: 4 lines of 4 numbers, the last `0 0 0 1`; the translation is in metres.
pub fn read_transform(path: &Path) -> Result<Pose, RecordingError> {
    text::read(path).and_then(|text| parse_transform(&text)).map_err(|error| error.in_file(path))
}

/// Parses the text of such a file.
pub(crate) fn parse_transform(text: &str) -> Result<Pose, RecordingError> {
    let mut numbers: Vec<f64> = Vec::new();
    for line in text::lines(text) {
        for word in line.words() {
            numbers.push(line.value("an entry", word)?);
        }
    }
    let matrix: [f64; 16] = numbers.try_into().map_err(|numbers: Vec<f64>| {
        RecordingError::Content(format!("{} numbers, expected 4 lines of 4", numbers.len()))
    })?;
    let (rows, last) = matrix.split_at(12);
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(RecordingError::Content(format!("the last line is {last:?}, expected 0 0 0 1")));
    }
    let rows = std::array::from_fn(|i| rows[i]);
    from_rows(rows).map(|rigid| rigid.pose).map_err(RecordingError::Content)
}

/// A matrix made rigid.
pub(crate) struct Rigid {
    pub pose: Pose,
    /// Largest deviation of an entry from the identity, in the product of the rotation read and its
    /// transpose.
    pub error: f64,
}

/// Makes a pose from the first three rows of its matrix, with the nearest rotation; or describes the fault.
pub(crate) fn from_rows(m: [f64; 12]) -> Result<Rigid, String> {
    let rotation = DMat3::from_cols_array(&[m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]]);
    let translation = checked_position(DVec3::new(m[3], m[7], m[11]))?;
    if !rotation.is_finite() {
        return Err("the rotation has an entry that is not finite, expected numbers".into());
    }
    let product = rotation * rotation.transpose() - DMat3::IDENTITY;
    let error = product.to_cols_array().into_iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    let determinant = rotation.determinant();
    if error > TOLERANCE {
        return Err(format!(
            "the rotation is not rigid: its rows deviate from unit length or right angles by {error:.3}, its determinant is \
             {determinant:.3}; expected a rotation, row by row, within {TOLERANCE}"
        ));
    }
    if determinant < 0.0 {
        return Err("the rotation mirrors: its determinant is -1, expected 1".into());
    }
    let rotation = DQuat::from_mat3(&nearest_rotation(rotation)).normalize();
    Ok(Rigid { pose: Pose::new(rotation, translation).map_err(|error| error.to_string())?, error })
}

/// The orthogonal factor of a near-rotation, by Newton's iteration (Higham 1986), which doubles the number of
/// correct digits in each step.
fn nearest_rotation(matrix: DMat3) -> DMat3 {
    (0..5).fold(matrix, |m, _| (m + m.inverse().transpose()) * 0.5)
}

/// Makes a pose from position and quaternion, or describes the fault.
pub(crate) fn from_quaternion(translation: DVec3, rotation: DQuat) -> Result<Pose, String> {
    Pose::new(rotation, checked_position(translation)?).map_err(|error| error.to_string())
}

/// Checks the position of a camera in metres; describes the fault if it is not finite or farther from the
/// origin than [`FARTHEST_POSITION`].
pub fn checked_position(position: DVec3) -> Result<DVec3, String> {
    let length = position.length();
    match () {
        _ if !position.is_finite() => {
            Err(format!("the position is {position}, expected finite numbers of metres"))
        }
        _ if length > FARTHEST_POSITION => Err(format!(
            "the position is {length:.0} m from the origin, expected at most {FARTHEST_POSITION} m; is it in millimetres?"
        )),
        _ => Ok(position),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURNED: [f64; 12] = [0.0, -1.0, 0.0, 0.5, 1.0, 0.0, 0.0, -0.25, 0.0, 0.0, 1.0, 2.0];

    fn refused(change: impl Fn(&mut [f64; 12])) -> String {
        let mut rows = TURNED;
        change(&mut rows);
        from_rows(rows).err().unwrap()
    }

    #[test]
    fn rows_are_rows() {
        let rigid = from_rows(TURNED).unwrap();
        assert!(rigid.pose.transform_point(DVec3::X).distance(DVec3::new(0.5, 0.75, 2.0)) < 1e-15);
        assert_eq!(rigid.error, 0.0);
    }

    #[test]
    fn a_little_scale_and_shear_is_taken_out() {
        let turned = DMat3::from_rotation_x(0.4) * DMat3::from_rotation_z(-1.1);
        let stretch = DMat3::from_cols_array(&[1.002, 0.001, 0.0, 0.001, 0.998, -0.002, 0.0, -0.002, 1.001]);
        let m = (turned * stretch).transpose().to_cols_array();
        let rows = [m[0], m[1], m[2], 0.0, m[3], m[4], m[5], 0.0, m[6], m[7], m[8], 0.0];
        let Ok(Rigid { pose, error }) = from_rows(rows) else { panic!("it is nearly rigid") };
        assert!((0.004..0.006).contains(&error), "{error}");
        assert!(pose.rotation_matrix().abs_diff_eq(turned, 1e-12));
    }

    #[test]
    fn what_is_not_rigid_is_refused() {
        assert!(refused(|m| m[10] = 1.02).contains("deviate from unit length or right angles by 0.040"));
        assert!(refused(|m| m[10] = -1.0).contains("mirrors"));
        assert!(refused(|m| m[2] = 0.1).contains("not rigid"));
        assert!(refused(|m| m.fill(0.0)).contains("determinant is 0.000"));
        assert!(refused(|m| m[0] = f64::NAN).contains("not finite"));
        assert!(refused(|m| m[3] = f64::INFINITY).contains("finite numbers of metres"));
        assert!(refused(|m| m[3] = 500.0).contains("500 m from the origin") && TURNED[3] == 0.5);
        assert!(from_quaternion(DVec3::splat(400.0), DQuat::IDENTITY).unwrap_err().contains("millimetres?"));
        assert!(from_quaternion(DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)).is_err());
    }
}
