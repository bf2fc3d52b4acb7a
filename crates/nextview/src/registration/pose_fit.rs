use crate::geometry::Pose;

/// How well aligned frames fit together, and what this shows of their given poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseFit {
    /// By frame, the root mean square distance, metres, of its surface from those of the other frames; `None`
    /// if it meets no other.
    pub residuals: Vec<Option<f64>>,
    /// The error that all given poses share; `None` if they come from alignment, so that none is shared.
    pub hand_eye: Option<HandEyeError>,
    /// Root mean square distance, metres, of the same surfaces from each other in the given poses; `None` if
    /// no frames meet.
    pub given_residual: Option<f64>,
    /// By how many standard deviations the aligned poses fit better than they would if the given ones were
    /// exact. Negative if they fit as well as by chance.
    pub certainty_wrong: f64,
    /// Deviation of the depths' errors that pixels share, metres.
    pub(crate) systematic: f64,
}

/// The error that all given poses share. For a camera on a robot, this is the error of the hand-eye
/// calibration: the true `flange_from_camera` is the calibrated one times `given_from_camera`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandEyeError {
    /// The most likely error: a camera's pose is its given one times this, up to the given one's own error.
    pub given_from_camera: Pose,
    /// Standard deviation of the translation, metres: of the distance from the true one. Errors that the
    /// depths of all frames have in common count, too.
    pub position_deviation: f64,
    /// Standard deviation of the rotation, radians.
    pub rotation_deviation: f64,
}

/// An error that exceeds its deviation this many times is hardly ever due to chance.
const CLEARLY: f64 = 3.0;

/// Number of deviations by which exact poses never seem to be wrong: they reach 1 with the first frames of
/// simulated objects, and less with more frames.
const UNDOUBTEDLY: f64 = 3.0;

/// Errors of the given poses below this share of a cell do not matter.
const LEAST_ERROR: f64 = 0.05;

/// Number of deviations of the systematic error up to which the sensor explains what is apart.
const EXPLAINED: f64 = 3.0;

impl PoseFit {
    /// Returns the root mean square of the frames' residuals, metres; `None` if no frames meet.
    pub fn residual(&self) -> Option<f64> {
        let (n, squares) = self
            .residuals
            .iter()
            .flatten()
            .fold((0, 0.0), |(n, sum), residual| (n + 1, sum + residual.powi(2)));
        (n > 0).then(|| (squares / f64::from(n)).sqrt())
    }
}

impl PoseFit {
    /// Returns how far apart the given poses put the same surfaces, metres, if they are wrong: if the frames
    /// leave no doubt, and alignment removes more of the squared distances than remains, than the sensor
    /// explains, and than a share of a cell of this edge (metres).
    pub(crate) fn error_of_given(&self, spacing: f64) -> Option<f64> {
        let (given, aligned) = (self.given_residual?, self.residual()?);
        let removed_sq = given.powi(2) - aligned.powi(2);
        let explained = (LEAST_ERROR * spacing).max(EXPLAINED * self.systematic);
        let matters = removed_sq > aligned.max(explained).powi(2);
        (self.certainty_wrong > UNDOUBTEDLY && matters).then_some(given)
    }
}

impl HandEyeError {
    /// Returns the length of the translation, metres.
    pub fn moved(&self) -> f64 {
        self.given_from_camera.translation().length()
    }

    /// Returns the angle of the rotation, radians.
    pub fn turned(&self) -> f64 {
        2.0 * self.given_from_camera.rotation().xyz().length().min(1.0).asin()
    }

    /// Whether the frames show that there is an error: it is more than three times its deviation.
    pub fn is_shown(&self) -> bool {
        self.moved() > CLEARLY * self.position_deviation || self.turned() > CLEARLY * self.rotation_deviation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn an_error_is_shown_if_it_clearly_exceeds_what_is_unknown_of_it() {
        let of = |shift: f64, turn: f64| HandEyeError {
            given_from_camera: Pose::new(DQuat::from_rotation_x(turn), DVec3::Y * shift).unwrap(),
            position_deviation: 0.001,
            rotation_deviation: 0.01,
        };
        assert!(!of(0.0, 0.0).is_shown() && !of(0.0029, -0.029).is_shown());
        assert!(of(0.0031, 0.0).is_shown() && of(0.0, -0.031).is_shown());
        assert!((of(0.003, -0.02).turned() - 0.02).abs() < 1e-12 && of(0.003, 0.0).moved() == 0.003);
    }

    #[test]
    fn frames_that_meet_no_other_have_no_residual() {
        assert_eq!(PoseFit::default().residual(), None);
        let fit = PoseFit { residuals: vec![Some(3.0), None, Some(4.0)], ..PoseFit::default() };
        assert_eq!(fit.residual(), Some(12.5_f64.sqrt()));
    }

    #[test]
    fn given_poses_are_wrong_if_frames_leave_no_doubt_and_it_matters() {
        let fit = |aligned_mm: f64, given_mm: f64, certainty_wrong: f64| {
            let residuals = vec![Some(1e-3 * aligned_mm); 2];
            let given_residual = Some(1e-3 * given_mm);
            PoseFit { residuals, given_residual, certainty_wrong, ..PoseFit::default() }
        };
        let error =
            |aligned_mm, given_mm, certainty| fit(aligned_mm, given_mm, certainty).error_of_given(0.005);
        let blurred = PoseFit { systematic: 2.1e-4, ..fit(0.3, 0.5, 4.0) };
        assert_eq!(blurred.error_of_given(0.005), None, "what the sensor explains");
        assert_eq!(error(0.3, 0.5, 4.0), Some(0.0005));
        assert_eq!(error(0.3, 0.5, 2.0), None, "by chance");
        assert_eq!(error(0.3, 0.4, 9.0), None, "less than the noise");
        assert_eq!(error(0.01, 0.2, 9.0), None, "less than a twentieth of a cell");
        assert_eq!(PoseFit::default().error_of_given(0.005), None);
    }
}
