//! What scans, campaigns and workers write for each other, JSON.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_campaign::RunRecord;
use nextview_campaign::execution::Batch;
use nextview_fuzz::Source;
use nextview_scan::{ScanRecord, StepRecord};

fuzz_target!(|bytes: &[u8]| {
    let mut source = Source(bytes);
    match source.byte() % 4 {
        0 => {
            if let Ok(record) = serde_json::from_slice::<ScanRecord>(source.0) {
                let written = serde_json::to_vec(&record).expect("a record can be written");
                serde_json::from_slice::<ScanRecord>(&written).expect("our own record");
            }
        }
        1 => {
            if let Ok(record) = serde_json::from_slice::<StepRecord>(source.0) {
                let _ = (record.world_from_camera(), record.table());
            }
        }
        2 => _ = serde_json::from_slice::<RunRecord>(source.0),
        _ => _ = str::from_utf8(source.0).map(Batch::from_json),
    }
});
