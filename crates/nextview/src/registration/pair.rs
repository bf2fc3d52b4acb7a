use glam::DVec3;

/// A point of the frame beside the plane of the known surface that it belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The frame's point, world coordinates.
    pub point: DVec3,
    /// The known point.
    pub known: DVec3,
    /// The mean of both normals, of unit length: on a curved surface, the line between both points is at
    /// right angles to it and not to either normal (Rusinkiewicz 2019).
    pub normal: DVec3,
}

impl Pair {
    /// Distance of the point from the plane, metres, positive in front.
    pub fn residual(&self) -> f64 {
        self.normal.dot(self.point - self.known)
    }

    /// How much the pair counts, 0..=1: the weight of Geman & McClure 1987.
    pub fn weight(&self, scale: f64) -> f64 {
        1.0 / (1.0 + (self.residual() / scale).powi(2)).powi(2)
    }
}
