use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, DepthImage};

/// A frame of a user's camera.
#[derive(Clone, Debug)]
pub struct LiveFrame {
    /// The depth image, of the camera's size.
    pub depth: DepthImage,
    /// Where the camera stood; none if it is to be [found out](crate::LiveScan::locate).
    pub world_from_camera: Option<Pose>,
    /// A colour image of the same size that belongs to it.
    pub color: Option<ColorImage>,
    /// A name for it, which its record has.
    pub name: Option<String>,
}

impl LiveFrame {
    /// A depth image without colours and name.
    pub fn new(depth: DepthImage, world_from_camera: Pose) -> Self {
        Self { depth, world_from_camera: Some(world_from_camera), color: None, name: None }
    }
}
