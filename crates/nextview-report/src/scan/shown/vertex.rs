use glam::DVec3;

/// A vertex of the measured surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ShownVertex {
    /// World frame, metres.
    pub position: DVec3,
    /// Colour as measured in the frame that shows it best.
    pub color: Option<[u8; 3]>,
    /// Number of frames that show it.
    pub n_looks: usize,
    /// Cosine of the smallest angle between its normal and the direction to a camera that saw it, 0..=1.
    pub best_cosine: f64,
    /// Index of the first step that shows it.
    pub first_step: Option<usize>,
}
