use std::f64::consts::TAU;

/// Number of values for a joint that is arbitrary in a singular pose.
const N_FREE: usize = 8;

/// Values of joints without influence: evenly spaced, plus the caller's reference values.
pub(super) struct Free {
    near: Option<[f64; 6]>,
}

impl Free {
    pub fn new(near: Option<[f64; 6]>) -> Self {
        Self { near }
    }

    /// Values for a joint by number.
    pub fn values(&self, joint: usize) -> Vec<f64> {
        let steps = (0..N_FREE).map(|step| (step as f64 / N_FREE as f64 - 0.5) * TAU);
        self.near.iter().map(|near| near[joint]).chain(steps).collect()
    }

    /// Reverses the order of the joints.
    pub fn reversed(&self) -> Self {
        let near = self.near.map(|mut near| {
            near.reverse();
            near
        });
        Self { near }
    }
}
