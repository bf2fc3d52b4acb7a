//! Reference views for FoundationPose (Wen et al. 2024): an object's folder for the training of a neural
//! object field, and the model and camera file for its demonstration.

use super::out::Out;
use crate::masks::Masks;
use crate::scanned::Scanned;
use crate::textured;
use crate::view::matrix_text;
use nextview_recording::{encode_color, encode_depth, encode_mask};
use nextview_scan::Fault;
use std::fmt::Write;

/// Metres per unit of depth.
const UNIT: f64 = 0.001;

pub(super) fn write(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    let (width, height) = (scanned.intrinsics.width(), scanned.intrinsics.height());
    let (focal, center) = (scanned.intrinsics.focal(), scanned.intrinsics.center());
    let matrix = format!("{} 0 {}\n0 {} {}\n0 0 1\n", focal.x, center.x, focal.y, center.y);
    out.add("K.txt", matrix.clone());
    out.add("cam_K.txt", matrix);
    let masks = Masks::new(scanned)?;
    let mut selected = String::new();
    for view in &scanned.views {
        let stem = view.stem();
        let depth = encode_depth(view.frame.image(), UNIT);
        let mask = encode_mask(width, height, &masks.of(view)?.visible);
        out.add(format!("depth/{stem}.png"), depth.clone());
        out.add(format!("depth_enhanced/{stem}.png"), depth);
        out.add(format!("mask/{stem}.png"), mask.clone());
        out.add(format!("masks/{stem}.png"), mask);
        out.add(format!("cam_in_ob/{stem}.txt"), matrix_text(&view.world_from_camera()));
        if let Some(color) = &view.color {
            out.add(format!("rgb/{stem}.png"), encode_color(color));
        }
        let _ = writeln!(selected, "- \"{stem}\""); // to memory
    }
    out.add("select_frames.yml", selected);
    for (name, bytes) in textured::files(scanned, "model")? {
        out.add(format!("model/{name}"), bytes);
    }
    Ok(())
}
