use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Frame};
use nextview_scan::rows_of_pose;

/// A picture by a camera without distortion: depth, and colour if there is any.
pub(crate) struct UndistortedView {
    /// Number of its step, from 1.
    pub number: usize,
    /// The depth image at its mapped pose.
    pub frame: Frame,
    /// The colour image, of the same size.
    pub color: Option<ColorImage>,
}

impl UndistortedView {
    /// Returns the name of its image files without extension.
    pub fn stem(&self) -> String {
        format!("{:06}", self.number)
    }

    /// Transform from the camera to the world.
    pub fn world_from_camera(&self) -> Pose {
        self.frame.world_from_camera()
    }
}

/// The rows as lines of text.
pub(crate) fn matrix_text(pose: &Pose) -> String {
    rows_of_pose(pose).map(|[a, b, c, d]| format!("{a} {b} {c} {d}\n")).concat()
}
