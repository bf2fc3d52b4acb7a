//! The description of a scan that a server is asked for, JSON.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_server::fuzzing::new_scan;

fuzz_target!(|bytes: &[u8]| new_scan(bytes));
