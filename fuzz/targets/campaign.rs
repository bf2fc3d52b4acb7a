//! The specification of a campaign, TOML, and the runs that it stands for.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview_campaign::Spec;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    // No patterns of file names: they would search this machine's folders.
    if !text.contains(['*', '?'])
        && let Ok(spec) = Spec::parse(text, Path::new("/nowhere"))
    {
        let _ = spec.runs();
    }
});
