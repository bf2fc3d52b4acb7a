//! An OFF file.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_sim::mesh::fuzzing::parse;
use nextview_sim::mesh::sample_surface;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = parse("off", bytes, &[]) {
        assert!(mesh.bounds().min.is_finite() && mesh.area() > 0.0);
        sample_surface(&mesh, 3, 0);
    }
});
