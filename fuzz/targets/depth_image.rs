//! Depth, masks and colours as PNG and JPEG, and the compressed images of ROS.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_fuzz::{Source, camera};
use nextview_recording::ros::CompressedImage;
use nextview_recording::{decode_color, decode_depth};

const FORMATS: [&str; 3] =
    ["16UC1; compressedDepth png", "32FC1; compressedDepth png", "rgb8; jpeg compressed bgr8"];

fuzz_target!(|bytes: &[u8]| {
    let (camera, mut source) = (camera(), Source(bytes));
    match source.byte() % 4 {
        0 => {
            let mask = source.part();
            let mask = (!mask.is_empty()).then_some(mask);
            let _ = decode_depth(source.0, mask, &camera, 0.001);
        }
        1 => _ = decode_color(source.0, &camera),
        _ => {
            let image = CompressedImage { format: source.pick(&FORMATS), data: source.0 };
            let _ = (image.is_depth(), image.depth(&camera), image.color(&camera));
        }
    }
});
