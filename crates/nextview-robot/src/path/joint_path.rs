/// A piecewise straight path of joint values.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPath {
    corners: Vec<Vec<f64>>,
}

impl JointPath {
    /// Creates a path through at least one corner.
    pub(super) fn new(corners: Vec<Vec<f64>>) -> Self {
        debug_assert!(!corners.is_empty());
        Self { corners }
    }

    /// The joint values at the start, at each corner and at the end, radians or metres.
    pub fn corners(&self) -> &[Vec<f64>] {
        &self.corners
    }
}
