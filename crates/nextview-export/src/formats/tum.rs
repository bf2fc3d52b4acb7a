//! A sequence of the TUM RGB-D benchmark (Sturm et al. 2012), with the additional intrinsics file that `scan
//! --frames` needs. Times are synthetic: one second per step.

use super::out::Out;
use crate::scanned::Scanned;
use nextview_recording::{encode_color, encode_depth, intrinsics_text};
use std::fmt::Write;

/// Metres per unit of depth: the benchmark's factor of 5000.
const UNIT: f64 = 1.0 / 5000.0;

pub(super) fn write(scanned: &Scanned, out: &mut Out) {
    out.add("intrinsics.txt", intrinsics_text(&scanned.intrinsics, UNIT));
    let mut poses = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
    let [mut depths, mut colors] = ["# timestamp filename\n"; 2].map(str::to_owned);
    for view in &scanned.views {
        let time = format!("{}.000000", view.number);
        let pose = view.world_from_camera();
        let (t, q) = (pose.translation(), pose.rotation());
        // These write to memory.
        let _ = writeln!(poses, "{time} {} {} {} {} {} {} {}", t.x, t.y, t.z, q.x, q.y, q.z, q.w);
        let _ = writeln!(depths, "{time} depth/{time}.png");
        out.add(format!("depth/{time}.png"), encode_depth(view.frame.image(), UNIT));
        if let Some(color) = &view.color {
            let _ = writeln!(colors, "{time} rgb/{time}.png");
            out.add(format!("rgb/{time}.png"), encode_color(color));
        }
    }
    out.add("groundtruth.txt", poses);
    out.add("depth.txt", depths);
    out.add("rgb.txt", colors);
}
