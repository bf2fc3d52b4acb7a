use super::recording::N_SCANS;

/// Measured coverage of the authors' program after each scan: from the authors' record, or from runs of the
/// program with a fixed thread order.
pub const CURVES: [(&str, [f64; N_SCANS]); 4] = [
    ("their recorded run", [0.481, 0.740, 0.871, 0.867, 0.914, 0.935, 0.958, 0.964, 0.964, 0.964]),
    ("their program, fixed order", FIXED_ORDER),
    (
        "their program, slip 1 repaired",
        [0.481, 0.652, 0.667, 0.683, 0.692, 0.703, 0.707, 0.711, 0.711, 0.837],
    ),
    (
        "their program, slips 1 to 3 repaired",
        [0.481, 0.652, 0.772, 0.838, 0.892, 0.903, 0.941, 0.953, 0.943, 0.958],
    ),
];

/// The authors' program with a fixed thread order.
pub const FIXED_ORDER: [f64; N_SCANS] =
    [0.481, 0.702, 0.869, 0.878, 0.922, 0.953, 0.958, 0.958, 0.958, 0.960];

/// The first of the draws 0 to 599 of thread timing whose curve is within 0.02 of [`FIXED_ORDER`] everywhere.
pub const ORDER_LIKE_FIXED: u64 = 333;

/// The draw among them whose curve is nearest to that of the recorded run.
pub const ORDER_LIKE_RECORDED: u64 = 75;

/// The authors' first plan on the recorded first map: rays, rays per view, views without one, voxels in the
/// flow, edges, quality.
pub const FIRST_PLAN: [f64; 6] = [5029.0, 3.0, 1067.0, 443.0, 4945.0, 201.318660058];

/// The first plan without the second slip, where measured.
pub const FIRST_PLAN_THROUGH_UNKNOWN: [Option<f64>; 6] =
    [Some(19177.0), None, None, Some(938.0), Some(9304.0), None];
