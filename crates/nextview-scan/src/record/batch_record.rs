use nextview::planner::{BatchPlan, BatchView};
use nextview::view::ViewSpace;
use serde::Serialize;

/// A [batch of views](nextview::planner::Batch), as `nextview plan --batch` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchRecord {
    /// The views in the order of the tour.
    pub views: Vec<BatchViewRecord>,
    /// Share, 0..=1, of everything worth seeing that the views show together.
    pub share: f64,
    /// Upper bound on the share that any choice of this number of views shows.
    pub share_bound: f64,
    /// `share` relative to that of the best choice: a guaranteed lower bound.
    pub share_of_best: f64,
    /// Length of the tour in metres.
    pub path_length_m: f64,
}

/// A view of a batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchViewRecord {
    /// Number of the view.
    pub view: usize,
    /// Position of the camera in the world in metres.
    pub position_m: [f64; 3],
    /// Rotation `world_from_camera`: x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
    /// Gain of the view beyond the views before it, in nats.
    pub gain_nats: f64,
    /// The gain as a share, 0..=1, of everything worth seeing.
    pub share: f64,
}

impl BatchRecord {
    /// The record of a batch of these views.
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
