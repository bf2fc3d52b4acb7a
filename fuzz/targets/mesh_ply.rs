//! A PLY file, as a mesh and as points.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_sim::mesh::fuzzing::{parse, parse_points};
use nextview_sim::mesh::sample_surface;

fuzz_target!(|bytes: &[u8]| {
    let _ = parse_points(bytes);
    if let Ok(mesh) = parse("ply", bytes, &[]) {
        assert!(mesh.bounds().min.is_finite() && mesh.area() > 0.0);
        sample_surface(&mesh, 3, 0);
    }
});
