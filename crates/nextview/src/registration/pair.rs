use glam::DVec3;

/// A point and the plane of the surface that it belongs to, metres.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The point.
    pub point: DVec3,
    /// A point on the plane.
    pub known: DVec3,
    /// The normal of the plane, of unit length.
    pub normal: DVec3,
}

impl Pair {
    /// Returns the signed distance of the point from the plane, metres, positive in front.
    pub(super) fn residual(&self) -> f64 {
        self.normal.dot(self.point - self.known)
    }

    /// Returns the weight of the pair, 0..=1, after Geman & McClure 1987.
    pub(super) fn weight(&self, scale: f64) -> f64 {
        1.0 / (1.0 + (self.residual() / scale).powi(2)).powi(2)
    }
}
