//! The texts of recorded folders: optics, trajectories, lists of images, poses.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_recording::fuzzing::texts;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = str::from_utf8(bytes) {
        texts(text);
    }
});
