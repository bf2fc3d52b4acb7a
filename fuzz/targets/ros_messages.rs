//! Messages of ROS 2 by themselves.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_fuzz::camera;
use nextview_recording::fuzzing::messages;

fuzz_target!(|bytes: &[u8]| messages(bytes, &camera()));
