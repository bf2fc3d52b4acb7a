use nextview::geometry::Pose;

/// What is known of where the camera is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whereabouts {
    /// The view that was asked for last, if its frame did not come yet.
    pub asked: Option<Pose>,
    /// Where the last image was taken that was located after the last frame.
    pub located: Option<Pose>,
}
