//! Poses as 4 x 4 matrices, as used by robots and cameras.

use crate::Fault;
use glam::{DMat3, DQuat, DVec3};
use nextview::geometry::Pose;
use nextview_recording::checked_position;

/// Maximum deviation from the identity of a rotation times its transpose: matrices of 32-bit numbers are off
/// by 1e-6, a calibration rounded to four digits by 1e-3.
const TOLERANCE: f64 = 1e-3;

/// Returns the rows of the matrix of a pose.
pub fn rows_of_pose(pose: &Pose) -> [[f64; 4]; 4] {
    let (r, t) = (pose.rotation_matrix(), pose.translation());
    let row = |i: usize| [r.col(0)[i], r.col(1)[i], r.col(2)[i], t[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// Returns the pose of a matrix given by its rows; `name` is used in messages. Fails unless the matrix is
/// rigid, its rotation off by at most 1e-3, its last row 0 0 0 1, and its position within 100 m of the
/// origin.
///
/// ```
/// use nextview_scan::{pose_of_rows, rows_of_pose};
///
/// let rows = [[0.0, -1.0, 0.0, 0.4], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.2], [0.0, 0.0, 0.0, 1.0]];
/// let pose = pose_of_rows("world_from_camera", &rows)?;
/// assert_eq!(pose.translation().to_array(), [0.4, 0.0, 0.2]);
/// assert_eq!(rows_of_pose(&pose)[1][3], 0.0);
/// # Ok::<(), nextview_scan::Fault>(())
/// ```
pub fn pose_of_rows(name: &str, rows: &[[f64; 4]; 4]) -> Result<Pose, Fault> {
    let fault = |message: String| Fault {
        key: Some(name.to_owned()),
        ..Fault::request(format!("`{name}`: {message}"))
    };
    if let Some(entry) = rows.iter().flatten().find(|entry| !entry.is_finite()) {
        return Err(fault(format!("an entry is {entry}, expected finite numbers")));
    }
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        let is_transposed = rows[3][3] == 1.0 && (0..3).all(|i| rows[i][3] == 0.0);
        let hint = if is_transposed { "; is the matrix transposed?" } else { "" };
        return Err(fault(format!("the last row is {:?}, expected 0 0 0 1{hint}", rows[3])));
    }
    let rotation = DMat3::from_cols_array_2d(&std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j])));
    let product = rotation * rotation.transpose() - DMat3::IDENTITY;
    let error = product.to_cols_array().into_iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
    let determinant = rotation.determinant();
    if error.is_nan() || error > TOLERANCE {
        return Err(fault(format!(
            "the rotation is not rigid: its rows deviate from unit length or right angles by {error:.3}, its \
             determinant is {determinant:.3}; expected a rotation within {TOLERANCE}"
        )));
    }
    if determinant < 0.0 {
        let message = "the rotation mirrors: its determinant is -1, expected 1; is an axis left-handed?";
        return Err(fault(message.to_owned()));
    }
    let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
    let translation = checked_position(translation).map_err(fault)?;
    let pose = Pose::new(DQuat::from_mat3(&rotation).normalize(), translation);
    pose.map_err(|error| Fault::from(error).within(format!("`{name}`")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGID: [[f64; 4]; 4] =
        [[0.0, -1.0, 0.0, 0.4], [1.0, 0.0, 0.0, -0.1], [0.0, 0.0, 1.0, 0.2], [0.0, 0.0, 0.0, 1.0]];

    #[test]
    fn a_pose_comes_back() {
        let rows = rows_of_pose(&pose_of_rows("pose", &RIGID).unwrap());
        let off = rows.iter().flatten().zip(RIGID.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-15);
    }

    #[test]
    fn what_is_no_pose_is_refused_with_the_reason() {
        let changed = |change: &dyn Fn(&mut [[f64; 4]; 4])| {
            let mut rows = RIGID;
            change(&mut rows);
            pose_of_rows("pose", &rows).unwrap_err().to_string()
        };
        assert_eq!(
            changed(&|rows| rows[0][3] = f64::NAN),
            "`pose`: an entry is NaN, expected finite numbers"
        );
        assert!(changed(&|rows| rows[3][3] = 2.0).ends_with("2.0], expected 0 0 0 1"));
        let transposed = |rows: &mut [[f64; 4]; 4]| {
            *rows = std::array::from_fn(|i| std::array::from_fn(|j| RIGID[j][i]));
        };
        assert!(changed(&transposed).ends_with("is the matrix transposed?"));
        assert!(changed(&|rows| rows[0][1] = -1.1).contains("not rigid: its rows deviate"));
        assert!(changed(&|rows| rows[2][2] = -1.0).contains("mirrors"));
        assert!(changed(&|rows| rows[0][0] = f64::MAX).contains("not rigid"));
        assert_eq!(
            changed(&|rows| rows[1][3] = -250.0),
            "`pose`: the position is 250 m from the origin, expected at most 100 m; is it in millimetres?"
        );
    }
}
