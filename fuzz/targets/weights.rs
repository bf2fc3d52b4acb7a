//! Files of learned weights.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview::prior::SurfacePrior;
use nextview_learned::{Grid, nbv_net, nbv_regression, pc_nbv};

fuzz_target!(|bytes: &[u8]| {
    let _ = nbv_net::Network::from_safetensors(bytes);
    let _ = nbv_regression::Network::from_safetensors(bytes);
    let _ = pc_nbv::Network::from_safetensors(bytes);
    let _ = SurfacePrior::from_bytes(bytes);
    let _ = Grid::from_bytes(bytes);
});
