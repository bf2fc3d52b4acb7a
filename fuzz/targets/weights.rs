//! Files of learned weights.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview::prior::SurfacePrior;
use nextview_learned::nbv_net::{Grid, Network};

fuzz_target!(|bytes: &[u8]| {
    let _ = Network::from_safetensors(bytes);
    let _ = SurfacePrior::from_bytes(bytes);
    let _ = Grid::from_bytes(bytes);
});
