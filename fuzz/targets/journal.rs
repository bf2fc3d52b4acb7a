//! A journal whose entries have the right checksums, whatever they hold, with damage behind them.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_fuzz::Source;
use nextview_scan::fuzzing::entries;

fuzz_target!(|bytes: &[u8]| {
    let mut source = Source(bytes);
    let contents: Vec<&[u8]> = (0..source.byte() % 5).map(|_| source.part()).collect();
    let n = contents.len();
    if let Some(found) = entries(contents, source.0) {
        assert!(found.len() < n || source.0.len() > 8);
    }
});
