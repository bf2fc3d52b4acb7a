use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Depth, Frame};

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

    /// The pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = Depth> + '_ {
        let image = self.frame.image();
        (0..image.height()).flat_map(move |v| (0..image.width()).map(move |u| image.get(u, v)))
    }
}

/// The rows of the 4 x 4 matrix of a pose.
pub(crate) fn rows(pose: &Pose) -> [[f64; 4]; 4] {
    nextview_scan::rows_of_pose(pose)
}

/// The rows as lines of text.
pub(crate) fn matrix_text(pose: &Pose) -> String {
    rows(pose).map(|[a, b, c, d]| format!("{a} {b} {c} {d}\n")).concat()
}
