use crate::geometry::Pose;
use serde::{Deserialize, Serialize};

/// Result of aligning a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Registration {
    /// The camera pose: corrected if the alignment was accepted, corrected only where the surface holds it if
    /// it slides, otherwise as given.
    pub world_from_camera: Pose,
    /// Whether the alignment was accepted, or why not.
    pub verdict: Verdict,
    /// Root mean square distance, metres, in the given pose, from the tangent planes, of the points that lie
    /// on the known surface after the alignment. Zero if there are none.
    #[serde(rename = "residual_before_m")]
    pub residual_before: f64,
    /// Root mean square distance of the same points after the alignment, metres.
    #[serde(rename = "residual_after_m")]
    pub residual_after: f64,
    /// Share, 0..=1, of the frame's points that lie on the known surface after the alignment.
    pub overlap: f64,
    /// Misfit after the alignment, metres: root mean square distance of all points from the known surface. A
    /// point that is not on it counts as half of the search distance, and one that a camera looked through as
    /// all of it. Among alignments of the same image, the true one has the least misfit; a wrong one may
    /// overlap more.
    #[serde(rename = "misfit_m")]
    pub misfit: f64,
    /// Distance by which the alignment moves the camera, metres.
    #[serde(rename = "moved_m")]
    pub moved: f64,
    /// Angle by which the alignment turns the camera, radians.
    #[serde(rename = "turned_rad")]
    pub turned: f64,
    /// How firmly the surface holds the frame in place, 0..=1: the smallest eigenvalue of the mean of the
    /// residuals' squared derivatives, with rotations measured at the points' root mean square distance from
    /// their middle. It is 0 if the frame can slide: along a plane, around a ball or a cylinder.
    pub stiffness: f64,
    /// Number of iterations.
    pub n_iterations: usize,
}

/// Whether an alignment was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Verdict {
    /// Accepted.
    Aligned,
    /// Refused: too few of the frame's points lie on the known surface.
    LittleOverlap,
    /// Partly accepted: the surface, such as a plane or a ball, does not hold the frame in place. The given
    /// pose stays along the directions in which it can slide.
    Sliding,
    /// Refused: it moves or turns the camera beyond the uncertainty of the given pose.
    TooFar,
    /// Refused: the frame fits no better than in the given pose, which is correct.
    NoBetter,
}

impl Registration {
    /// Whether the alignment was accepted.
    pub fn is_accepted(&self) -> bool {
        self.verdict == Verdict::Aligned
    }

    /// Whether the frame in its final pose lies on the known surface: it was aligned, at least partly, or
    /// already fitted as given.
    pub fn fits(&self) -> bool {
        matches!(self.verdict, Verdict::Aligned | Verdict::Sliding | Verdict::NoBetter)
    }
}
