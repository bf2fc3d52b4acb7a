//! The configuration of a scan, TOML.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_scan::ScanConfig;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    if let Ok(config) = ScanConfig::parse(text, None, None) {
        let written = toml::to_string(&config).expect("a configuration can be written");
        assert!(ScanConfig::parse(&written, None, None).expect("our own text") == config);
    }
});
