//! An MCAP file as a recording: container, chunks, topics, poses and images.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_recording::fuzzing::chunk;
use nextview_recording::{ReadOptions, Recording};
use std::path::PathBuf;
use std::sync::LazyLock;

/// In memory: recordings are opened by their path.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = [PathBuf::from("/dev/shm"), std::env::temp_dir()].into_iter().find(|folder| folder.is_dir());
    folder.expect("there is a folder").join(format!("nextview-fuzz-{}.mcap", std::process::id()))
});

fuzz_target!(|bytes: &[u8]| {
    chunk(bytes);
    std::fs::write(&*FILE, bytes).expect("there is room");
    if let Ok(recording) = Recording::open(&FILE, &ReadOptions::default()) {
        for frame in &recording.frames {
            let _ = (frame.load(), frame.load_color());
        }
    }
    let _ = std::fs::remove_file(&*FILE);
});
