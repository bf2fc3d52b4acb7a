use nextview::planner::{BatchPlan, BatchView};
use nextview::view::ViewSpace;
use serde::Serialize;

/// A [batch of views](nextview::planner::Batch), as `nextview plan --batch` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchRecord {
    /// In the order of the tour.
    pub views: Vec<BatchViewRecord>,
    /// The part of all that is worth seeing that the views show together, 0..=1.
    pub share: f64,
    /// No choice of as many views shows more than this part.
    pub share_bound: f64,
    /// The first as a part of the second: what is sure of that of the best choice.
    pub share_of_best: f64,
    /// Length of the tour, metres.
    pub path_length_m: f64,
}

/// A view of a batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchViewRecord {
    /// Its number.
    pub view: usize,
    /// Position of the camera in the world, metres.
    pub position_m: [f64; 3],
    /// Rotation `world_from_camera`: x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
    /// What it shows that those before it do not, nats.
    pub gain_nats: f64,
    /// The same as a part of all that is worth seeing, 0..=1.
    pub share: f64,
}

impl BatchRecord {
    /// Of a batch of these views.
    pub fn new(plan: &BatchPlan, views: &ViewSpace) -> Self {
        let record = |&BatchView { view, gain, share }: &BatchView| {
            let pose = views.pose(view);
            let (position_m, quaternion_xyzw) = (pose.translation().to_array(), pose.rotation().to_array());
            BatchViewRecord { view, position_m, quaternion_xyzw, gain_nats: gain, share }
        };
        Self {
            views: plan.views.iter().map(record).collect(),
            share: plan.share,
            share_bound: plan.share_bound,
            share_of_best: if plan.share_bound > 0.0 { plan.share / plan.share_bound } else { 1.0 },
            path_length_m: plan.path_length,
        }
    }
}
