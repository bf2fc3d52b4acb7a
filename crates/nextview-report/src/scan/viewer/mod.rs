//! The 3D view of a scan: measured and expected surface, points, cameras, and the path between them.
//!
//! Report and live page share it: a report is the live page of a finished scan.

mod cloud;
mod pack;
mod scene;

pub(super) use cloud::{MAX_POINTS, note};
pub(super) use scene::members as scene;

/// The picture with its controls, as HTML.
pub(super) const FIGURE: &str = include_str!("figure.html");

/// The script that draws a scene and lets the reader rotate it, one idea per file, with additional files.
macro_rules! script {
    ($($more:literal),*) => {
        concat!(
            "\"use strict\";\n(() => {\n",
            include_str!("js/math.js"),
            include_str!("js/decode.js"),
            include_str!("js/gl.js"),
            include_str!("js/lines.js"),
            include_str!("js/points.js"),
            include_str!("js/surface.js"),
            include_str!("js/expected.js"),
            include_str!("js/eye.js"),
            include_str!("js/cameras.js"),
            include_str!("js/grid.js"),
            include_str!("js/labels.js"),
            include_str!("js/view.js"),
            include_str!("js/controls.js"),
            include_str!("js/panel.js"),
            include_str!("js/enlarge.js"),
            $(include_str!($more),)*
            "})();\n"
        )
    };
}

/// The page that shows a server's scan in progress.
pub(crate) const LIVE_PAGE: &str =
    concat!(include_str!("live_head.html"), include_str!("figure.html"), include_str!("live_tail.html"));

/// The live page's script.
pub(crate) const LIVE_SCRIPT: &str =
    script!("js/api.js", "js/faults.js", "js/guidance.js", "js/proposal.js", "js/live.js");

/// The script of a report: it shows the scene in its page.
pub(super) const REPORT_SCRIPT: &str = script!("js/report.js");
