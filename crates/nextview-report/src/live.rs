//! The live page: what a server needs to show a scan as it happens.
//!
//! A server answers `/` and `/scans/{id}/page` with [`PAGE`], `/assets/viewer.js` with [`SCRIPT`],
//! `/assets/style.css` with [`STYLE`], and `/scans/{id}/scene?after=N` with [`scene`]. The page asks for
//! nothing from anywhere else, and runs under [`CONTENT_SECURITY_POLICY`].

use nextview::session::NextView;
use nextview_scan::{FinishedScan, ScanConfig};

/// The page, HTML without scripts and styles of its own.
pub const PAGE: &str = crate::scan::LIVE_PAGE;

/// Its script.
pub const SCRIPT: &str = crate::scan::LIVE_SCRIPT;

/// Its style.
pub const STYLE: &str = crate::text::STYLE;

/// The policy to send with the page: everything comes from the server itself, and no script stands in the
/// page. The pictures of views are parts of the [`scene`].
pub const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What the page shows, as JSON: the surface so far, measured and expected, the candidates with their
/// expected gains, the view to take next, the curves and tables, and the cameras, points and pictures of the
/// views after number `after`; 0 is everything.
///
/// An update by one view of 640 x 480 pixels takes less than 300 kB. Making it takes time that grows with the
/// number of frames, half a second for 8 and a second for 20 on two cores: no frame should wait for it.
/// Equal scans give equal bytes, but for times and memory.
pub fn scene(scan: &FinishedScan<'_>, config: &ScanConfig, next: Option<&NextView>, after: usize) -> String {
    crate::scan::scene(scan, config, next, after)
}
