use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, DepthImage};

/// A frame from a user's camera.
#[derive(Clone, Debug)]
pub struct LiveFrame {
    /// The depth image, of the camera's size.
    pub depth: DepthImage,
    /// Pose of the camera; `None` if it must be [found](crate::LiveScan::locate).
    pub world_from_camera: Option<Pose>,
    /// The matching colour image of the same size.
    pub color: Option<ColorImage>,
    /// A name for its record.
    pub name: Option<String>,
}

impl LiveFrame {
    /// A depth image without colours or name.
    pub fn new(depth: DepthImage, world_from_camera: Pose) -> Self {
        Self { depth, world_from_camera: Some(world_from_camera), color: None, name: None }
    }
}
