//! The live page: the parts a server needs to show a scan in progress.
//!
//! A server answers `/` and `/scans/{id}/page` with [`PAGE`], `/assets/viewer.js` with [`SCRIPT`],
//! `/assets/style.css` with [`STYLE`], and `/scans/{id}/scene?after=N` with [`LiveScene::json`]. The page
//! requests nothing else, and runs under [`CONTENT_SECURITY_POLICY`].

pub use crate::scan::{LiveScene, SceneSource};

/// The page, HTML without inline scripts and styles.
pub const PAGE: &str = crate::scan::LIVE_PAGE;

/// The page's script.
pub const SCRIPT: &str = crate::scan::LIVE_SCRIPT;

/// The page's style.
pub const STYLE: &str = crate::text::STYLE;

/// The policy to send with the page: everything comes from the server itself, and the page has no inline
/// script. The pictures of views are parts of the [scene](LiveScene).
pub const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
