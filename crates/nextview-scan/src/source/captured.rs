use nextview::sensor::Frame;
#[cfg(feature = "simulated")]
pub use nextview_sim::evaluator::FrameTruth;

/// The truth about a frame. It has no value in a build without the simulator.
#[cfg(not(feature = "simulated"))]
#[derive(Clone, Debug)]
pub enum FrameTruth {}

/// A frame as a source captures it, with the truth about it.
#[derive(Clone, Debug)]
pub struct Captured {
    /// The depth image and the pose that it claims.
    pub frame: Frame,
    /// The truth about the frame; `None` if the source does not know it.
    pub truth: Option<FrameTruth>,
}
