use std::f64::consts::TAU;

/// Values for a joint that may have any in a singular pose.
const N_FREE: usize = 8;

/// The values of joints without influence: equal steps, and the values that the caller is near to.
pub(super) struct Free {
    near: Option<[f64; 6]>,
}

impl Free {
    pub fn new(near: Option<[f64; 6]>) -> Self {
        Self { near }
    }

    /// Values for a joint, by its number.
    pub fn values(&self, joint: usize) -> Vec<f64> {
        let steps = (0..N_FREE).map(|step| (step as f64 / N_FREE as f64 - 0.5) * TAU);
        self.near.iter().map(|near| near[joint]).chain(steps).collect()
    }

    /// For the joints in the opposite order.
    pub fn reversed(&self) -> Self {
        let near = self.near.map(|mut near| {
            near.reverse();
            near
        });
        Self { near }
    }
}
