use crate::Failure;
use nextview::planner::{BatchPlan, BatchView};
use nextview::view::ViewSpace;
use serde::Serialize;

/// The output of `nextview plan --batch`.
#[derive(Debug, Serialize)]
pub(super) struct BatchAnswer {
    /// In the order of the tour.
    views: Vec<ViewAnswer>,
    /// The part of all that is worth seeing that the views show together.
    share: f64,
    /// No choice of as many views shows more than this part.
    share_bound: f64,
    /// The first as a part of the second: what is sure of that of the best choice.
    share_of_best: f64,
    path_length_m: f64,
}

#[derive(Debug, Serialize)]
struct ViewAnswer {
    view: usize,
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
    /// What it shows that those before it do not.
    gain_nats: f64,
    share: f64,
}

/// From this share on the choice is reported as the best: the rest may be rounding.
const IS_BEST: f64 = 1.0 - 1e-6;

impl BatchAnswer {
    pub fn new(plan: &BatchPlan, views: &ViewSpace) -> Self {
        let answer = |&BatchView { view, gain, share }: &BatchView| {
            let pose = views.pose(view);
            let (position_m, quaternion_xyzw) = (pose.translation().to_array(), pose.rotation().to_array());
            ViewAnswer { view, position_m, quaternion_xyzw, gain_nats: gain, share }
        };
        Self {
            views: plan.views.iter().map(answer).collect(),
            share: plan.share,
            share_bound: plan.share_bound,
            share_of_best: if plan.share_bound > 0.0 { plan.share / plan.share_bound } else { 1.0 },
            path_length_m: plan.path_length,
        }
    }

    /// One JSON object on a line.
    pub fn to_json(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string(self).map_err(Failure::data)? + "\n")
    }

    pub fn to_text(&self) -> String {
        if self.views.is_empty() {
            return "next views  none: no candidate gains anything\n".to_owned();
        }
        let n = self.views.len();
        let best = match self.share_of_best {
            share if share >= IS_BEST => format!("no {n} views show more"),
            share => format!("at least {:.1} % of what the best {n} views show", floor(100.0 * share)),
        };
        let rows: String = self.views.iter().map(ViewAnswer::to_row).collect();
        format!(
            "{:<12}{n}, which show {:.1} % of what is worth seeing\n\
             {:<12}{best}\n\
             {:<12}{:.3} m\n\n\
             {:>6} {:>8}  {:<24}  quaternion (x y z w)\n{rows}",
            "next views",
            100.0 * self.share,
            "bound",
            "path",
            self.path_length_m,
            "view",
            "adds",
            "position (m)"
        )
    }
}

impl ViewAnswer {
    fn to_row(&self) -> String {
        let ([x, y, z], [qx, qy, qz, qw]) = (self.position_m, self.quaternion_xyzw);
        let position = format!("{x:.4} {y:.4} {z:.4}");
        let (view, share) = (self.view, 100.0 * self.share);
        format!("{view:>6} {share:>6.1} %  {position:<24}  {qx:.6} {qy:.6} {qz:.6} {qw:.6}\n")
    }
}

/// Down to a tenth, so that "at least" stays true.
fn floor(percent: f64) -> f64 {
    (percent * 10.0).floor() / 10.0
}
