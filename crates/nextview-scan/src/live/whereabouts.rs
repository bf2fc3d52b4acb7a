use nextview::geometry::Pose;

/// Where the camera was asked to go, and where it was last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whereabouts {
    /// The view that was asked for last, if its frame did not come yet.
    pub asked: Option<Pose>,
    /// Where the last image was taken that was located after the last frame.
    pub located: Option<Pose>,
}
