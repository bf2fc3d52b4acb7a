use super::timed_stage::Stage;
use crate::workload::{BOX_EDGE, N_IMAGES, bounds};
use nextview::Cancel;
use nextview::geometry::Lattice;
use nextview::sensor::Frame;
use nextview_model::DistanceField;
use std::hint::black_box;

/// Edge of the model's cells, metres: the finest of a scan in the box.
const CELL: f64 = BOX_EDGE / 125.0;

/// The cost of a model beyond the map: aligning an image to the others, fusing ten of them, and their mesh.
pub(super) fn stages() -> Vec<Stage> {
    vec![
        Stage::new("align an image", "2 mm", 1, |workload| {
            let alignment = workload.alignment();
            Box::new(move || _ = black_box(alignment.align()))
        }),
        Stage::new("fuse ten images", "2 mm", 1, |workload| {
            let frames = workload.frames();
            Box::new(move || _ = black_box(fused(&frames)))
        }),
        Stage::new("mesh of the fused images", "2 mm", 1, |workload| {
            let field = fused(&workload.frames());
            Box::new(move || _ = black_box(field.surface(&Cancel::default())))
        }),
    ]
}

fn fused(frames: &[Frame]) -> DistanceField {
    assert_eq!(frames.len(), N_IMAGES);
    let lattice = Lattice::new(CELL).expect("a size written in the source");
    let cells = lattice.block_inside(&bounds()).expect("the box is larger than a cell");
    let mut field = DistanceField::new(lattice, cells, 2.0 * CELL).expect("a field of few megabytes");
    frames.iter().for_each(|frame| field.integrate(frame, &Cancel::default()).expect("nobody cancels"));
    field
}
