//! A batch of views as text.

use nextview_scan::{BatchRecord, BatchViewRecord};

/// A choice with at least this share of the best one is reported as the best: the rest may be rounding.
const IS_BEST: f64 = 1.0 - 1e-6;

/// A table of the views, below a summary of all of them.
pub(super) fn to_text(batch: &BatchRecord) -> String {
    if batch.views.is_empty() {
        return "next views  none: no candidate gains anything\n".to_owned();
    }
    let n = batch.views.len();
    let best = match batch.share_of_best {
        share if share >= IS_BEST => format!("no {n} views show more"),
        share => format!("at least {:.1} % of what the best {n} views show", floor(100.0 * share)),
    };
    let rows: String = batch.views.iter().map(to_row).collect();
    format!(
        "{:<12}{n}, which show {:.1} % of what is worth seeing\n\
         {:<12}{best}\n\
         {:<12}{:.3} m\n\n\
         {:>6} {:>8}  {:<24}  quaternion (x y z w)\n{rows}",
        "next views",
        100.0 * batch.share,
        "bound",
        "path",
        batch.path_length_m,
        "view",
        "adds",
        "position (m)"
    )
}

fn to_row(of: &BatchViewRecord) -> String {
    let ([x, y, z], [qx, qy, qz, qw]) = (of.position_m, of.quaternion_xyzw);
    let position = format!("{x:.4} {y:.4} {z:.4}");
    let (view, share) = (of.view, 100.0 * of.share);
    format!("{view:>6} {share:>6.1} %  {position:<24}  {qx:.6} {qy:.6} {qz:.6} {qw:.6}\n")
}

/// Rounds down to a tenth, which keeps "at least" true.
fn floor(percent: f64) -> f64 {
    (percent * 10.0).floor() / 10.0
}
