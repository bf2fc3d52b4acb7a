use nextview::geometry::Pose;

/// The requested and the last known pose of the camera.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KnownPoses {
    /// The view requested last, if its frame has not arrived yet.
    pub asked: Option<Pose>,
    /// Pose of the last image located after the last frame.
    pub located: Option<Pose>,
}
