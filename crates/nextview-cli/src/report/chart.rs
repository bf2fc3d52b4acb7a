//! The coverage curve as an SVG drawing. Curves differ in dash and marker as well as in colour.

use super::text::{escape, percent};
use super::{RandomCurve, ScanReport};

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 350.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 430.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 306.0;

/// Smallest vertical distance between two labels.
const LABEL_STEP: f64 = 17.0;

/// The chart with its legend; a sentence if no coverage is known.
pub fn draw(report: &ScanReport) -> String {
    let curves = curves(report);
    if curves[0].points.is_empty() {
        return r#"<p class="note">Coverage is not known for this scan.</p>"#.to_owned();
    }
    let n_views = curves.iter().flat_map(|c| &c.points).map(|p| p.0).max().unwrap_or(1);
    let axes = Axes { n_views: n_views.max(2) };
    let mut svg = format!(
        r#"<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{}">"#,
        description(&curves)
    );
    svg += &axes.draw();
    if let Some(random) = &report.random {
        svg += &band(&axes, random);
    }
    // This scan last, so that it lies on top.
    for curve in curves.iter().rev() {
        svg += &curve.draw(&axes);
    }
    svg += &labels(&axes, &curves);
    svg + "</svg>" + &legend(report, &curves)
}

struct Curve {
    /// CSS class; also the key of its marker.
    class: &'static str,
    label: &'static str,
    /// Number of the view, from 1, and coverage.
    points: Vec<(usize, f64)>,
}

/// This scan, then what it is compared with.
fn curves(report: &ScanReport) -> Vec<Curve> {
    let curve = |class, label, coverage: Vec<Option<f64>>| {
        let known =
            |(i, c): (usize, Option<f64>)| Some((i + 1, c.filter(|c| c.is_finite())?.clamp(0.0, 1.0)));
        Curve { class, label, points: coverage.into_iter().enumerate().filter_map(known).collect() }
    };
    let all_known = |coverage: &[f64]| coverage.iter().copied().map(Some).collect();
    let mut curves = vec![curve("scan", "this scan", report.steps.iter().map(|s| s.coverage).collect())];
    if let Some(coverage) = &report.clairvoyant {
        curves.push(curve("clairvoyant", "clairvoyant", all_known(coverage)));
    }
    if let Some(random) = &report.random {
        curves.push(curve("random", "random", all_known(&random.mean)));
    }
    curves
}

fn description(curves: &[Curve]) -> String {
    let part = |c: &Curve| {
        let (view, coverage) = c.points.last()?;
        Some(format!("{} reaches {} after {view} views", c.label, percent(*coverage)))
    };
    let parts: Vec<String> = curves.iter().filter_map(part).collect();
    format!("Coverage over the number of views: {}.", parts.join("; "))
}

struct Axes {
    n_views: usize,
}

impl Axes {
    fn x(&self, view: usize) -> f64 {
        LEFT + 8.0 + (RIGHT - LEFT - 16.0) * (view - 1) as f64 / (self.n_views - 1) as f64
    }

    fn y(&self, coverage: f64) -> f64 {
        BOTTOM + (TOP - BOTTOM) * coverage
    }

    fn draw(&self) -> String {
        let mut svg = String::new();
        for tick in (0..=100).step_by(20) {
            let y = self.y(tick as f64 / 100.0);
            svg += &format!(r#"<path class="grid" d="M{LEFT} {y:.1}H{RIGHT}"/>"#);
            svg += &format!(r#"<text class="end" x="{}" y="{:.1}">{tick}</text>"#, LEFT - 7.0, y + 4.5);
        }
        for view in self.view_ticks() {
            let x = self.x(view);
            svg += &format!(r#"<path class="axis" d="M{x:.1} {BOTTOM}v4"/>"#);
            svg += &format!(r#"<text class="middle" x="{x:.1}" y="{}">{view}</text>"#, BOTTOM + 19.0);
        }
        let (middle_x, middle_y) = ((LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0);
        svg += &format!(r#"<path class="axis" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>"#);
        svg += &format!(r#"<text class="middle" x="{middle_x}" y="{}">views</text>"#, HEIGHT - 6.0);
        svg + &format!(
            r#"<text class="middle" transform="translate(14 {middle_y}) rotate(-90)">reachable coverage, %</text>"#
        )
    }

    /// View 1 and round numbers, at most about ten.
    fn view_ticks(&self) -> Vec<usize> {
        let round = (0..).flat_map(|e| [1, 2, 5].map(|m| m * 10_usize.pow(e)));
        let step = round.into_iter().find(|step| self.n_views / step <= 10).unwrap_or(1);
        let rest = (1..=self.n_views / step).map(|i| i * step).filter(|&view| view > 1);
        std::iter::once(1).chain(rest).collect()
    }
}

impl Curve {
    fn draw(&self, axes: &Axes) -> String {
        let at = |&(view, coverage): &(usize, f64)| (axes.x(view), axes.y(coverage));
        let line = polyline(self.points.iter().map(at));
        let mut svg = format!(r#"<g class="{}"><path class="line" d="{line}"/>"#, self.class);
        // More than about thirty markers would run into each other; the last point always has one.
        for point in self.points.iter().rev().step_by(self.points.len().div_ceil(30).max(1)) {
            let (x, y) = at(point);
            let value = percent(point.1);
            svg += &format!("<g><title>{}, view {}: {value}</title>", self.label, point.0);
            svg += &format!("{}</g>", marker(self.class, x, y));
        }
        svg + "</g>"
    }
}

fn polyline(points: impl Iterator<Item = (f64, f64)>) -> String {
    let corner =
        |(i, (x, y)): (usize, (f64, f64))| format!("{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
    points.enumerate().map(corner).collect()
}

fn marker(class: &str, x: f64, y: f64) -> String {
    match class {
        "scan" => format!(r#"<circle class="mark" cx="{x:.1}" cy="{y:.1}" r="3.6"/>"#),
        "clairvoyant" => format!(r#"<path class="mark" d="M{x:.1} {:.1}l3.8 6.6h-7.6z"/>"#, y - 4.4),
        _ => format!(r#"<path class="mark" d="M{:.1} {:.1}h6v6h-6z"/>"#, x - 3.0, y - 3.0),
    }
}

/// The area between the lower and the upper curve of the random scans.
fn band(axes: &Axes, random: &RandomCurve) -> String {
    let edge = |coverage: &[f64]| -> Vec<(f64, f64)> {
        let finite = coverage.iter().take(axes.n_views).enumerate().filter(|(_, c)| c.is_finite());
        finite.map(|(i, c)| (axes.x(i + 1), axes.y(c.clamp(0.0, 1.0)))).collect()
    };
    let (low, high) = (edge(&random.low), edge(&random.high));
    if low.is_empty() || high.is_empty() {
        return String::new();
    }
    let around = polyline(high.into_iter().chain(low.into_iter().rev()));
    format!(r#"<path class="band" d="{around}Z"/>"#)
}

/// The name and last value of each curve, right of the plot, pushed apart where they would overlap.
fn labels(axes: &Axes, curves: &[Curve]) -> String {
    let mut ends: Vec<(&Curve, usize, f64)> =
        curves.iter().filter_map(|c| c.points.last().map(|&(view, coverage)| (c, view, coverage))).collect();
    ends.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut heights: Vec<f64> = ends.iter().map(|end| axes.y(end.2)).collect();
    spread(&mut heights);
    let mut svg = String::new();
    for ((curve, view, coverage), y) in ends.into_iter().zip(heights) {
        let (x0, y0) = (axes.x(view) + 6.0, axes.y(coverage));
        svg += &format!(r#"<path class="leader" d="M{x0:.1} {y0:.1}L{} {y:.1}"/>"#, RIGHT + 3.0);
        svg += &format!(
            r#"<text class="label {}" x="{}" y="{:.1}">{} {:.1}</text>"#,
            curve.class,
            RIGHT + 6.0,
            y + 4.5,
            curve.label,
            100.0 * coverage
        );
    }
    svg
}

/// Moves sorted heights apart to [`LABEL_STEP`], inside the plot.
fn spread(heights: &mut [f64]) {
    for i in 1..heights.len() {
        heights[i] = heights[i].max(heights[i - 1] + LABEL_STEP);
    }
    let mut limit = BOTTOM;
    for height in heights.iter_mut().rev() {
        *height = height.min(limit);
        limit = *height - LABEL_STEP;
    }
}

fn legend(report: &ScanReport, curves: &[Curve]) -> String {
    let key = |class: &str, drawing: &str, text: &str| {
        format!(
            r#"<li><svg class="chart key" viewBox="0 0 38 12" aria-hidden="true"><g class="{class}">{drawing}</g></svg>{text}</li>"#
        )
    };
    let mut items = String::new();
    for curve in curves {
        let drawing = format!(r#"<path class="line" d="M1 6H37"/>{}"#, marker(curve.class, 19.0, 6.0));
        let text = match curve.class {
            "scan" => escape(&format!("this scan ({})", report.planner)),
            "clairvoyant" => "clairvoyant: knows the object".to_owned(),
            _ => "random views, mean".to_owned(),
        };
        items += &key(curve.class, &drawing, &text);
    }
    if let Some(random) = &report.random {
        let text = format!("random views, {}", escape(&random.band));
        items += &key("random", r#"<path class="band" d="M1 1H37V11H1Z"/>"#, &text);
    }
    format!(r#"<ul class="legend">{items}</ul>"#)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_round() {
        assert_eq!(Axes { n_views: 4 }.view_ticks(), [1, 2, 3, 4]);
        assert_eq!(Axes { n_views: 12 }.view_ticks(), [1, 2, 4, 6, 8, 10, 12]);
        assert_eq!(Axes { n_views: 100 }.view_ticks(), [1, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
    }

    #[test]
    fn labels_keep_their_distance_and_stay_inside() {
        for mut heights in [vec![20.0, 21.0, 22.0], vec![TOP, 100.0, 101.0], vec![BOTTOM; 3]] {
            spread(&mut heights);
            assert!(heights.windows(2).all(|w| w[1] - w[0] >= LABEL_STEP - 1e-9), "{heights:?}");
            assert!(heights.iter().all(|h| (TOP..=BOTTOM).contains(h)), "{heights:?}");
        }
    }
}
