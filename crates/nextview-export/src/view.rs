use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Frame};
use nextview_scan::rows_of_pose;

/// A picture: depth, and colour where there is some, of a camera without distortion.
pub(crate) struct View {
    /// Of its step, from 1.
    pub number: usize,
    /// The depth image in the pose in which it was mapped.
    pub frame: Frame,
    /// Of the same size.
    pub color: Option<ColorImage>,
}

impl View {
    /// The name of its image files without extension.
    pub fn stem(&self) -> String {
        format!("{:06}", self.number)
    }

    /// Points of the camera to the world.
    pub fn world_from_camera(&self) -> Pose {
        self.frame.world_from_camera()
    }
}

/// The rows as lines of text.
pub(crate) fn matrix_text(pose: &Pose) -> String {
    rows_of_pose(pose).map(|[a, b, c, d]| format!("{a} {b} {c} {d}\n")).concat()
}
