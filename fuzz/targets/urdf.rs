//! A robot, URDF.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_robot::{Arm, UrdfOptions};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    if let Ok(arm) = Arm::from_urdf(text, &UrdfOptions::default()) {
        let values = vec![0.0; arm.joints.len()];
        assert!(arm.forward(&values).translation().is_finite());
    }
});
