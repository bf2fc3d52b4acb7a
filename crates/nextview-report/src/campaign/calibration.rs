//! Accuracy of the planners' estimates of completeness, current and after their next views.

use super::data_file::DataFile;
use super::document::{Block, Cell, Column, Figure, Row, Section, Table};
use crate::plot::{CurveMarker, HorizontalAxis, Plot, PlotCurve};
use crate::text::fixed;
use nextview_campaign::statistics::{Study, StudyVariant, mean, percentile};

/// Bounds between classes of estimates, closer near 1, where estimates stop scans.
const BOUNDS: [f64; 11] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98];

/// The section; `None` if no planner of the campaign estimates.
pub(crate) fn section(study: &Study) -> Option<Section> {
    let of_variant = |variant: &StudyVariant| {
        let classes = classes(&estimates(variant));
        (!classes.is_empty()).then(|| (variant.name.clone(), classes))
    };
    let variants: Vec<(String, Vec<EstimateClass>)> = study.variants.iter().filter_map(of_variant).collect();
    if variants.is_empty() {
        return None;
    }
    let caption = "Reachable coverage against the planner's estimated completeness before each of its views: \
                   mean, and 10th to 90th percentile. On the thin line, both are equal.";
    let figure = Figure {
        caption: caption.to_owned(),
        overview: None,
        panels: variants.iter().map(|(name, classes)| (name.clone(), plot(classes))).collect(),
        data: data(&variants),
    };
    Some(Section {
        title: "Completeness estimated by the planner".to_owned(),
        blocks: std::iter::once(Block::Figure(figure)).chain(forecasts(study)).collect(),
    })
}

/// Forecasts against the true outcome; `None` if no planner makes any.
fn forecasts(study: &Study) -> Option<Block> {
    let rows: Vec<Row> = study.variants.iter().flat_map(forecast_rows).collect();
    let caption = "Completeness after the next views as the planner forecast it before the first of them, \
                   and the reachable coverage that followed: means over all views of all runs, and the mean \
                   absolute difference.";
    let numbers = ["views ahead", "forecasts", "forecast, %", "reachable coverage, %", "difference, points"];
    (!rows.is_empty()).then(|| {
        let head = std::iter::once(Column::text("planner")).chain(numbers.map(Column::number)).collect();
        Block::Table(Table { caption: caption.to_owned(), head, rows })
    })
}

/// A row for each number of views ahead.
fn forecast_rows(variant: &StudyVariant) -> Vec<Row> {
    let steps = variant.measured().map(|run| &run.steps);
    // For each number of views ahead, pairs of a forecast and the true coverage.
    let mut ahead: Vec<Vec<(f64, f64)>> = Vec::new();
    for (steps, i) in steps.flat_map(|steps| (0..steps.len()).map(move |i| (steps, i))) {
        let forecast = steps[i].forecast_completeness.iter().flatten();
        let truths = steps[i..].iter().filter_map(|step| step.reachable_coverage);
        for (n, pair) in forecast.copied().zip(truths).enumerate() {
            ahead.resize_with(ahead.len().max(n + 1), Vec::new);
            ahead[n].push(pair);
        }
    }
    let row = |(n, pairs): (usize, Vec<(f64, f64)>)| {
        let (forecasts, truths): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
        let differences: Vec<f64> = pairs.iter().map(|(forecast, truth)| (forecast - truth).abs()).collect();
        let percent = |shares: &[f64]| fixed(100.0 * mean(shares).unwrap_or_default(), 1);
        let n_ahead = (n + 1).to_string();
        let values = [
            ("n", pairs.len().to_string()),
            ("estimate_percent", percent(&forecasts)),
            ("reachable_coverage_percent", percent(&truths)),
            ("difference_points", percent(&differences)),
        ];
        let names = [&variant.name, &n_ahead].map(|name| Cell::from(name.as_str()));
        let cells = values.map(|value| {
            let cell = Cell::from(value.1.clone()).with_values([value]);
            cell.in_row(DataFile::Estimates, [&variant.name, &n_ahead, "", ""])
        });
        Row::new(names.into_iter().chain(cells).collect())
    };
    ahead.into_iter().enumerate().map(row).collect()
}

/// Pairs of an estimate and the true coverage, for all runs of a variant after all their views but the last.
fn estimates(variant: &StudyVariant) -> Vec<(f64, f64)> {
    let pairs = variant.measured().flat_map(|run| run.steps.windows(2));
    pairs.filter_map(|steps| Some((steps[1].estimated_completeness?, steps[0].reachable_coverage?))).collect()
}

/// Estimates of similar value, and the true coverage at each.
struct EstimateClass {
    low: f64,
    high: f64,
    estimate: f64,
    truths: Vec<f64>,
}

/// The non-empty classes.
fn classes(estimates: &[(f64, f64)]) -> Vec<EstimateClass> {
    let lows = std::iter::once(0.0).chain(BOUNDS);
    let highs = BOUNDS.into_iter().chain([1.0]);
    let class = |(low, high): (f64, f64)| {
        let within = |estimate: f64| estimate >= low && (estimate < high || high == 1.0);
        let (estimates, truths): (Vec<f64>, Vec<f64>) =
            estimates.iter().filter(|(estimate, _)| within(*estimate)).copied().unzip();
        Some(EstimateClass { low, high, estimate: mean(&estimates)?, truths })
    };
    lows.zip(highs).filter_map(class).collect()
}

impl EstimateClass {
    fn truth(&self) -> [f64; 3] {
        let [low, high] = [0.1, 0.9].map(|share| percentile(&self.truths, share).unwrap_or_default());
        [low, mean(&self.truths).unwrap_or_default(), high]
    }
}

fn plot(classes: &[EstimateClass]) -> Plot {
    let at = |class: &EstimateClass| (100.0 * class.estimate).round() as usize;
    let truth = PlotCurve {
        class: "v0".to_owned(),
        label: String::new(),
        marker: CurveMarker::Circle,
        points: classes.iter().map(|class| (at(class), class.truth()[1])).collect(),
        band: classes.iter().map(|class| (at(class), class.truth()[0], class.truth()[2])).collect(),
    };
    let equal = PlotCurve {
        class: "other".to_owned(),
        marker: CurveMarker::None,
        points: vec![(0, 0.0), (100, 1.0)],
        band: Vec::new(),
        ..truth.clone()
    };
    Plot {
        x_axis: HorizontalAxis::Percent("estimated completeness"),
        y_label: "reachable coverage".to_owned(),
        y_range: [0.0, 1.0],
        size: [240.0, 8.0, 240.0],
        curves: vec![truth, equal],
    }
}

fn data(variants: &[(String, Vec<EstimateClass>)]) -> Table {
    let percent = |share: f64| fixed(100.0 * share, 1);
    let row = |name: &str, class: &EstimateClass| {
        let [low, truth, high] = class.truth().map(percent);
        let [from, to] = [class.low, class.high].map(|bound| format!("{:.0}", 100.0 * bound));
        let (n, estimate) = (class.truths.len().to_string(), percent(class.estimate));
        let values = [
            ("n", n.clone()),
            ("estimate_percent", estimate.clone()),
            ("reachable_coverage_percent", truth.clone()),
            ("reachable_coverage_p10_percent", low.clone()),
            ("reachable_coverage_p90_percent", high.clone()),
        ];
        let truth = Cell::with_note(truth, format!("{low} to {high}")).with_values(values);
        let truth = truth.in_row(DataFile::Estimates, [name, "0", &from, &to]);
        Row::new(vec![format!("{name}, {from} to {to} %").into(), n.into(), estimate.into(), truth])
    };
    let rows = variants.iter().flat_map(|(name, classes)| classes.iter().map(move |class| row(name, class)));
    Table {
        caption: String::new(),
        head: std::iter::once(Column::text("estimate"))
            .chain(["views", "mean estimate, %", "reachable coverage, %"].map(Column::number))
            .collect(),
        rows: rows.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic;
    use super::*;

    #[test]
    fn campaigns_without_estimates_have_none() {
        assert!(section(&Study::new(&synthetic::campaign(&["a"], 2).runs)).is_none());
    }

    #[test]
    fn every_estimate_is_held_against_the_view_before() {
        let mut campaign = synthetic::campaign(&["a", "b"], 2);
        for run in campaign.runs.iter_mut().filter(|run| run.variant == "b") {
            let steps = &mut synthetic::record_mut(run).steps;
            steps.truncate(3);
            for (step, (estimate, truth)) in
                steps.iter_mut().zip([(None, 0.5), (Some(0.97), 0.9), (Some(1.0), 1.0)])
            {
                (step.estimated_completeness, step.reachable_coverage) = (estimate, Some(truth));
            }
        }
        let study = Study::new(&campaign.runs);
        let [Block::Figure(figure)] = &section(&study).unwrap().blocks[..] else { panic!("one figure") };
        let cells: Vec<Vec<&str>> = figure
            .data
            .rows
            .iter()
            .map(|row| row.cells.iter().map(|cell| &cell.text[..]).collect())
            .collect();
        assert_eq!(cells, [["b, 95 to 98 %", "2", "97.0", "50.0"], ["b, 98 to 100 %", "2", "100.0", "90.0"]]);
        let (title, plot) = &figure.panels[0];
        assert_eq!((&title[..], plot.x_axis), ("b", HorizontalAxis::Percent("estimated completeness")));
        assert_eq!(plot.curves[0].points, [(97, 0.5), (100, 0.9)]);
    }

    #[test]
    fn every_forecast_is_held_against_the_views_that_followed() {
        let mut campaign = synthetic::campaign(&["a"], 1);
        for run in &mut campaign.runs {
            let steps = &mut synthetic::record_mut(run).steps;
            steps.truncate(3);
            let all = [(None, 0.5), (Some(vec![0.8, 1.0, 1.0]), 0.7), (Some(vec![0.9]), 0.9)];
            for (step, (forecast, truth)) in steps.iter_mut().zip(all) {
                (step.forecast_completeness, step.reachable_coverage) = (forecast, Some(truth));
                step.estimated_completeness = Some(0.5);
            }
        }
        let study = Study::new(&campaign.runs);
        let Block::Table(table) = &section(&study).unwrap().blocks[1] else { panic!("a table") };
        let texts = |row: &Row| row.cells.iter().map(|cell| cell.text.clone()).collect::<Vec<_>>();
        let n_runs = campaign.runs.len();
        let expected = [
            ["a", "1", &(2 * n_runs).to_string(), "85.0", "80.0", "5.0"].map(str::to_owned),
            ["a", "2", &n_runs.to_string(), "100.0", "90.0", "10.0"].map(str::to_owned),
        ];
        assert_eq!(table.rows.iter().map(texts).collect::<Vec<_>>(), expected);
    }
}
