//! Parameters of the ROS 2 node, YAML.

#![no_main]

use libfuzzer_sys::fuzz_target;

// The node is a program, which has no interface.
#[path = "../../crates/nextview-ros2/src/parameters/value.rs"]
mod value;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    let _ = value::parse(text);
});
