//! The tables: one row per view, and the measures of the scan.

use super::text::{count, escape, metres, percent, seconds};
use super::{ScanReport, Step, ramp, thumbnail};

/// What each view saw and cost.
pub fn steps(report: &ScanReport) -> String {
    if report.steps.is_empty() {
        return r#"<p class="note">No view was taken.</p>"#.to_owned();
    }
    let range = thumbnail::Range::of(report.steps.iter().map(|s| &s.depth));
    let columns = columns(report);
    let mut head = r#"<th scope="col">View</th><th scope="col">Depth</th>"#.to_owned();
    for column in &columns {
        head += &format!(r#"<th scope="col" class="number">{}</th>"#, column.name);
    }
    let mut rows = String::new();
    for (i, step) in report.steps.iter().enumerate() {
        rows += &row(report, &columns, i, &thumbnail::img(&step.depth, range.unwrap_or_default(), i + 1));
    }
    let legend = thumbnail::legend(range);
    format!(r#"{legend}<table class="steps"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"#)
}

/// The measures, one per row.
pub fn summary(measures: &[(String, String)]) -> String {
    let row = |(label, value): &(String, String)| {
        format!(r#"<tr><th scope="row">{}</th><td class="number">{}</td></tr>"#, escape(label), escape(value))
    };
    format!(
        "<table class=\"summary\"><tbody>{}</tbody></table>",
        measures.iter().map(row).collect::<String>()
    )
}

struct Column {
    name: &'static str,
    cell: fn(&ScanReport, usize, &Step) -> String,
}

/// The columns of numbers; those that nothing is known about are left out.
fn columns(report: &ScanReport) -> Vec<Column> {
    let known = report.steps.iter().any(|s| s.coverage.is_some());
    let mut columns = Vec::new();
    if known {
        columns.push(Column { name: "Coverage", cell: |r, i, _| coverage(r, i) });
        columns.push(Column { name: "Gained", cell: |r, i, _| gained(r, i) });
    }
    if known && report.random.is_some() {
        let cell = |r: &ScanReport, i, _: &Step| baseline(r.random.as_ref().map(|r| &r.mean), i);
        columns.push(Column { name: "Random", cell });
    }
    if known && report.clairvoyant.is_some() {
        let cell = |r: &ScanReport, i, _: &Step| baseline(r.clairvoyant.as_ref(), i);
        columns.push(Column { name: "Clairvoyant", cell });
    }
    columns.push(Column { name: "New voxels", cell: |_, _, s| new_voxels(s) });
    if report.steps.iter().any(|s| s.outlook.is_some()) {
        columns.push(Column { name: "Estimate before", cell: |_, _, s| estimate(s) });
    }
    columns.push(Column { name: "Planning", cell: |_, _, s| seconds(s.plan_time) });
    columns.push(Column { name: "Path", cell: |_, _, s| metres(s.travel) });
    columns.push(Column { name: "Position, m", cell: |_, _, s| position(s) });
    columns
}

fn row(report: &ScanReport, columns: &[Column], i: usize, img: &str) -> String {
    let step = &report.steps[i];
    let color = ramp::css(ramp::view(i, report.steps.len()));
    let mut out = format!(
        r#"<tr><th scope="row"><i class="swatch" style="background:{color}"></i>{} <small>{}</small></th><td class="depth">{img}</td>"#,
        i + 1,
        candidate(step)
    );
    for Column { name, cell } in columns {
        let value = cell(report, i, step);
        out += &format!(r#"<td class="number" data-label="{name}">{value}</td>"#);
    }
    out + "</tr>"
}

fn coverage(report: &ScanReport, i: usize) -> String {
    percent(report.steps[i].coverage.unwrap_or(f64::NAN))
}

fn gained(report: &ScanReport, i: usize) -> String {
    let at = |i: usize| report.steps[i].coverage.unwrap_or(f64::NAN);
    percent(at(i) - if i == 0 { 0.0 } else { at(i - 1) })
}

fn baseline(coverage: Option<&Vec<f64>>, i: usize) -> String {
    percent(coverage.and_then(|c| c.get(i)).copied().unwrap_or(f64::NAN))
}

/// How many voxels the view made occupied, and how many the planner expected.
fn new_voxels(step: &Step) -> String {
    let expected = step.outlook.map_or(String::new(), |outlook| {
        format!("<small>{} expected</small>", count(outlook.n_expected.round() as usize))
    });
    count(step.new_voxels) + &expected
}

fn estimate(step: &Step) -> String {
    step.outlook.map_or("–".to_owned(), |outlook| percent(outlook.completeness()))
}

/// Which view it was, and which one it was preferred to.
fn candidate(step: &Step) -> String {
    let view = step.view.map_or("given pose".to_owned(), |view| format!("candidate {view}"));
    let runner_up = step.choice.and_then(|choice| choice.runner_up);
    view + &runner_up.map_or(String::new(), |view| format!(", next best {view}"))
}

fn position(step: &Step) -> String {
    let p = step.world_from_camera.translation();
    format!("{:.3}, {:.3}, {:.3}", p.x, p.y, p.z).replace('-', "−")
}
