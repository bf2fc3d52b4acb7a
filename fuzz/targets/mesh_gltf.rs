//! A glTF or GLB file, and the buffer or image that it names.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_fuzz::Source;
use nextview_sim::mesh::fuzzing::parse;

fuzz_target!(|bytes: &[u8]| {
    let mut source = Source(bytes);
    let beside = source.part();
    if let Ok(mesh) = parse("gltf", source.0, beside) {
        assert!(mesh.bounds().min.is_finite() && mesh.area() > 0.0);
        mesh.color(0, [1.0, 0.0, 0.0]);
    }
});
