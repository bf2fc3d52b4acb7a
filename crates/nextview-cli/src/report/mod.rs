//! The report of one scan: a single HTML page that needs no network, for the screen and for print.
//!
//! Fill a [`ScanReport`] and give it to [`render`]; the caller writes the file. Equal reports give equal bytes.

mod chart;
mod cloud;
mod headline;
pub(crate) mod plot;
mod ramp;
mod scene;
mod table;
pub(crate) mod text;
mod thumbnail;

use glam::{DVec3, Vec3};
use nextview::geometry::Pose;
use nextview::planner::{Choice, Outlook};
use nextview::sensor::{DepthImage, Intrinsics};

/// The style of all pages.
pub(crate) const STYLE: &str = include_str!("style.css");

/// What the page shows of a scan. All strings are plain text; the page escapes them.
#[derive(Clone, Debug)]
pub struct ScanReport {
    /// Name of the object, the page's title.
    pub object: String,
    /// Name of the planner.
    pub planner: String,
    /// Name of the preset the configuration came from.
    pub profile: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Why the scan ended, as a phrase: "budget of 10 views used up".
    pub stop_reason: String,
    /// The measures of the scan as label and value with unit, in the order to show them.
    pub summary: Vec<(String, String)>,
    /// The views, in the order they were taken.
    pub steps: Vec<Step>,
    /// What random choice would have reached, if it was tried.
    pub random: Option<RandomCurve>,
    /// Coverage in 0..=1 after each view of a planner that knows the object, if it was tried.
    pub clairvoyant: Option<Vec<f64>>,
    /// Where the camera could have been put, world frame, metres.
    pub candidates: Vec<DVec3>,
    /// The camera, for the shape of the frusta.
    pub camera: Intrinsics,
    /// The command line that makes this scan again.
    pub command: String,
    /// The resolved configuration, as text.
    pub config: String,
}

/// One view of the scan.
#[derive(Clone, Debug)]
pub struct Step {
    /// Number of the view in the list of candidates; none for a first view that is none of them.
    pub view: Option<usize>,
    /// Where the camera stood.
    pub world_from_camera: Pose,
    /// What it saw; shown as a thumbnail.
    pub depth: DepthImage,
    /// The measured points that no earlier view had seen, world frame, metres.
    pub points: Vec<Vec3>,
    /// Share of the reachable surface seen after this view, 0..=1; none if the true object is not known.
    pub coverage: Option<f64>,
    /// Number of voxels that this view made occupied.
    pub new_voxels: usize,
    /// Why it was chosen; none if the planner did not choose it.
    pub choice: Option<Choice>,
    /// What the planner expected of it, and of all views before it was taken; none for planners that do not tell.
    pub outlook: Option<Outlook>,
    /// Time taken to choose this view, seconds.
    pub plan_time: f64,
    /// Length of the way from the view before, metres.
    pub travel: f64,
    /// The way from the view before, both ends included, world frame, metres. If empty, a straight line is drawn.
    pub path: Vec<DVec3>,
}

/// Coverage over several scans with randomly chosen views; entry `i` is after view `i + 1`, in 0..=1.
#[derive(Clone, Debug)]
pub struct RandomCurve {
    /// Mean over the scans.
    pub mean: Vec<f64>,
    /// Lower edge of the band.
    pub low: Vec<f64>,
    /// Upper edge of the band.
    pub high: Vec<f64>,
    /// What the band spans, for the legend: "5th to 95th percentile of 100 scans".
    pub band: String,
}

/// The page. Above 150 000 points it shows an even choice of them, so that it stays below 3 MB.
pub fn render(report: &ScanReport) -> String {
    let subtitle = format!(
        "planner <b>{}</b> · profile <b>{}</b> · seed <b>{}</b> · stopped: <b>{}</b>",
        text::escape(&report.planner),
        text::escape(&report.profile),
        report.seed,
        text::escape(&report.stop_reason)
    );
    let values = [
        ("object", text::escape(&report.object)),
        ("style", STYLE.to_owned()),
        ("subtitle", subtitle),
        ("headline", headline::draw(report)),
        ("chart", chart::draw(report)),
        ("n_views", report.steps.len().to_string()),
        ("steps", table::steps(report)),
        ("summary", table::summary(&report.summary)),
        ("command", text::escape(&report.command)),
        ("config", text::escape(&report.config)),
        ("thinned", cloud::note(&report.steps)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("scene", scene::json(report)),
        ("script", include_str!("script.js").to_owned()),
    ];
    text::fill(include_str!("page.html"), &values)
}
