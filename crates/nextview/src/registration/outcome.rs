use crate::geometry::Pose;
use serde::{Deserialize, Serialize};

/// Result of the alignment of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Registration {
    /// Where the camera stood: corrected if the alignment was accepted, where it slides as far as the surface
    /// holds it, else as given.
    pub world_from_camera: Pose,
    /// Whether the alignment was accepted, or why not.
    pub verdict: Verdict,
    /// Of the points that lie on the known surface after the alignment, the root mean square of their
    /// distances, metres, to the tangent planes there: in the given pose. Zero if there are none.
    #[serde(rename = "residual_before_m")]
    pub residual_before: f64,
    /// The same after the alignment.
    #[serde(rename = "residual_after_m")]
    pub residual_after: f64,
    /// Share, 0..=1, of the frame's points that lie on the known surface after the alignment.
    pub overlap: f64,
    /// How badly the frame fits after the alignment, metres: of all its points, the root mean square of their
    /// distances to the known surface. A point that lies on none counts as half of the distance within which
    /// points do, and one that a camera looked through as the whole. Of places at which the same image was
    /// aligned, the true one has the least; a wrong one may overlap more.
    #[serde(rename = "misfit_m")]
    pub misfit: f64,
    /// How far the alignment moves the camera, metres.
    #[serde(rename = "moved_m")]
    pub moved: f64,
    /// How far it turns the camera, radians.
    #[serde(rename = "turned_rad")]
    pub turned: f64,
    /// How well the surface holds the frame in place, 0..=1: the smallest eigenvalue of the mean of the
    /// squared derivatives of the residuals, where turns are measured at the points' root mean square
    /// distance from their middle. It is 0 where the frame can slide: along a plane, around a ball or a
    /// cylinder.
    pub stiffness: f64,
    /// Number of steps.
    pub n_iterations: usize,
}

/// Whether an alignment was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Verdict {
    /// Yes.
    Aligned,
    /// No: too few of the frame's points lie on the known surface.
    LittleOverlap,
    /// In part: the surface does not hold the frame in place, such as a plane or a ball. Along the directions
    /// in which it can slide, the given pose stays.
    Sliding,
    /// No: it moves or turns the camera farther than the given pose may be wrong.
    TooFar,
    /// No: the frame fits no better than in the given pose, which is right.
    NoBetter,
}

impl Registration {
    /// Whether the alignment was accepted.
    pub fn is_accepted(&self) -> bool {
        self.verdict == Verdict::Aligned
    }

    /// Whether the frame in its final pose lies on the known surface: it was aligned, if only where it does
    /// not slide, or fitted already as given.
    pub fn fits(&self) -> bool {
        matches!(self.verdict, Verdict::Aligned | Verdict::Sliding | Verdict::NoBetter)
    }
}
