//! Figure 10: coverage and entropy of the variants over the number of views.

use super::data_file::DataFile;
use super::document::{Block, Cell, Column, Figure, Row, Section, Table};
use super::line::{CurveLine, N_STYLES, baselines, shortened};
use crate::plot::{self, CurveMarker, HorizontalAxis, Plot, view_ticks};
use crate::text::fixed;
use nextview_campaign::statistics::{Curve, Study};

/// Maximum number of variants in one drawing.
const MAX_IN_OVERVIEW: usize = N_STYLES;

/// Maximum number of variants with bands: more would overlap.
const MAX_BANDS: usize = 3;

/// The section; figures without any value are left out.
pub(crate) fn section(study: &Study) -> Section {
    let figures = [
        (
            Curve::VoxelCoverage,
            "Voxel coverage",
            "Occupied object voxels of the map as a share of all object voxels (figure 10a of the paper).",
        ),
        (
            Curve::ReachableCoverage,
            "Reachable coverage",
            "Object voxels seen, as a share of those that any candidate sees.",
        ),
        (
            Curve::Entropy,
            "Entropy",
            "Entropy in the box, as a share of that of an unknown box (figure 10b of the paper); lower is better.",
        ),
    ];
    let blocks = figures.into_iter().filter_map(|(curve, title, text)| figure(study, curve, title, text));
    Section { title: "Progress over the views".to_owned(), blocks: blocks.collect() }
}

fn figure(study: &Study, of: Curve, title: &str, text: &str) -> Option<Block> {
    let variants = study.variants.iter().enumerate();
    let lines: Vec<CurveLine> = variants.map(|(i, variant)| CurveLine::of_variant(i, variant, of)).collect();
    let lines: Vec<CurveLine> = lines.into_iter().filter(|line| !line.means.is_empty()).collect();
    if lines.is_empty() {
        return None;
    }
    let baselines = baselines(study, of);
    let n = lines.len();
    let range = range(lines.iter().chain(&baselines));
    let axes = |curves, size| Plot {
        x_axis: HorizontalAxis::Views,
        y_label: title.to_lowercase(),
        y_range: range,
        size,
        curves,
    };
    let overview = (n <= MAX_IN_OVERVIEW).then(|| {
        let curves = lines.iter().chain(&baselines);
        let curves: Vec<plot::PlotCurve> =
            curves.map(|line| line.curve(n <= MAX_BANDS, &line.name)).collect();
        axes(curves, [400.0, label_room(&lines), 294.0])
    });
    let panels = lines.iter().enumerate().filter(|_| n > MAX_BANDS).map(|(i, line)| {
        let others = lines.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other.ghost());
        let baselines = baselines.iter().map(|line| line.curve(false, ""));
        let highlighted = CurveLine { class: "v0".to_owned(), marker: CurveMarker::Circle, ..line.clone() };
        let curves = std::iter::once(highlighted.curve(true, "")).chain(baselines).chain(others).collect();
        (line.title(), axes(curves, [240.0, 8.0, 170.0]))
    });
    Some(Block::Figure(Figure {
        caption: format!("{title}. {text} {}", caption(n, &baselines, of)),
        overview,
        panels: panels.collect(),
        data: data(lines.iter().chain(&baselines), of),
    }))
}

fn caption(n: usize, baselines: &[CurveLine], of: Curve) -> String {
    let mut text = "Mean over objects; bands are its 95 % interval.".to_owned();
    if n > MAX_BANDS {
        text += " Each small drawing shows one variant; thin lines are the others.";
    }
    if !baselines.is_empty() {
        text += " Squares: random views, the mean of many sequences; \
                 triangles: the clairvoyant planner, which knows the object.";
    }
    if !baselines.is_empty() && of == Curve::VoxelCoverage {
        text += " Both count voxels seen, a few of which do not become occupied.";
    }
    text
}

/// The range of all values, widened to whole tens of percent.
fn range<'a>(lines: impl Iterator<Item = &'a CurveLine>) -> [f64; 2] {
    let values: Vec<f64> = lines.flat_map(|line| line.means.iter().copied()).collect();
    let low = values.iter().copied().fold(1.0, f64::min).max(0.0);
    let high = values.iter().copied().fold(0.0, f64::max).min(1.0);
    let low = ((10.0 * low).floor() / 10.0).min(0.9);
    [low, ((10.0 * high).ceil() / 10.0).max(low + 0.1)]
}

/// Room for the longest label with its number, at about 7.5 units per letter.
fn label_room(lines: &[CurveLine]) -> f64 {
    let longest = lines.iter().map(|line| shortened(&line.name).chars().count()).max().unwrap_or(0);
    7.5 * (longest.max("clairvoyant (baseline)".len()) + 5) as f64
}

/// The means with their intervals at round numbers of views.
fn data<'a>(lines: impl Iterator<Item = &'a CurveLine>, of: Curve) -> Table {
    let [mean_column, low_column, high_column] = columns(of);
    let lines: Vec<&CurveLine> = lines.collect();
    let n_views = lines.iter().map(|line| line.means.len()).max().unwrap_or(0);
    let mut ticks = view_ticks(n_views);
    ticks.extend((ticks.last() != Some(&n_views)).then_some(n_views));
    let row = |line: &&CurveLine| {
        let value = |view: &usize| {
            let i = view - 1;
            let note = line.intervals.get(i).copied().flatten();
            let ends = note.map(|v| [v.low, v.high].map(|end| fixed(100.0 * end, 1)));
            let note = ends.as_ref().map(|[low, high]| format!("{low} to {high}"));
            let text = line.means.get(i).map_or("–".to_owned(), |mean| fixed(100.0 * mean, 1));
            Cell::with_note(text.clone(), note.unwrap_or_default())
                .with_values([(mean_column, text)])
                .with_values(
                    ends.into_iter().flat_map(|ends| [low_column, high_column].into_iter().zip(ends)),
                )
                .in_row(DataFile::Progress, [&line.name, &view.to_string()])
        };
        Row::new(std::iter::once(line.name.as_str().into()).chain(ticks.iter().map(value)).collect())
    };
    let views = ticks.iter().map(|view| Column::number(format!("view {view}, %")));
    Table {
        caption: String::new(),
        rows: lines.iter().map(row).collect(),
        head: std::iter::once(Column::text("")).chain(views).collect(),
    }
}

/// The columns of mean and interval in the file.
fn columns(of: Curve) -> [&'static str; 3] {
    match of {
        Curve::VoxelCoverage => {
            ["voxel_coverage_percent", "voxel_coverage_low_percent", "voxel_coverage_high_percent"]
        }
        Curve::ReachableCoverage => [
            "reachable_coverage_percent",
            "reachable_coverage_low_percent",
            "reachable_coverage_high_percent",
        ],
        Curve::Entropy => ["entropy_percent", "entropy_low_percent", "entropy_high_percent"],
    }
}
