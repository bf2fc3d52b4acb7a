//! What the page will be made of.

/// The page.
pub(crate) fn page() -> &'static str {
    "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>nextview</title>\
     <link rel=\"stylesheet\" href=\"/assets/style.css\"><script src=\"/assets/viewer.js\" defer></script></head>\n\
     <body><p>nextview serves scans here; docs/server.md says how to ask for them.</p></body></html>\n"
}

/// Its script.
pub(crate) fn script() -> &'static str {
    ""
}

/// Its style.
pub(crate) fn style() -> &'static str {
    ""
}

/// The scan as the page draws it.
pub(crate) fn scene(
    _scan: &nextview_scan::FinishedScan<'_>,
    _config: &nextview_scan::ScanConfig,
    _next: Option<&nextview::session::NextView>,
    _after: usize,
) -> String {
    "{}".to_owned()
}
