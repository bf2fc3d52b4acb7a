//! View candidates from a table of comma-separated values.

#![no_main]

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use nextview::view::ViewSpace;

fuzz_target!(|bytes: &[u8]| {
    let Ok(views) = ViewSpace::read_csv(bytes, DVec3::ZERO) else { return };
    let mut written = Vec::new();
    views.write_csv(&mut written).expect("memory takes it");
    let again = ViewSpace::read_csv(&written[..], DVec3::ZERO).expect("our own file");
    assert_eq!(again.len(), views.len());
});
