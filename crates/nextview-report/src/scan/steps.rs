//! The table of views, one row each.

use super::input::ScanPage;
use super::step_line::verdict_phrase;
use super::{color, coverage, thumbnail};
use crate::text::{count, escape, fixed, metres, percent, seconds};
use nextview_scan::StepRecord;

/// The table, with the pictures of each view.
pub(super) fn table(page: &ScanPage<'_>) -> String {
    let range = thumbnail::Range::of(page.views.iter().map(|picture| &picture.depth));
    table_with(page, range, |i| pictures(page, range, i))
}

/// The table with the picture that a function returns for each view, counted from 0; their depths are in this
/// range.
pub(super) fn table_with(
    page: &ScanPage<'_>,
    range: Option<thumbnail::Range>,
    pictures: impl Fn(usize) -> String,
) -> String {
    if page.steps().is_empty() {
        let yet = if page.record.stop_reason.is_none() { " yet" } else { "" };
        return format!(r#"<p class="note">No view was taken{yet}.</p>"#);
    }
    let columns = columns(page);
    let mut head = r#"<th scope="col">View</th><th scope="col">Depth</th>"#.to_owned();
    for column in &columns {
        head += &format!(r#"<th scope="col" class="number">{}</th>"#, column.name);
    }
    let rows: String = (0..page.steps().len()).map(|i| row(page, &columns, i, &pictures(i))).collect();
    let legend = thumbnail::legend(range);
    format!(
        r#"{legend}<div class="steps-box"><table class="steps"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"#
    )
}

/// Depth and colour image of a view.
pub(super) fn pictures(page: &ScanPage<'_>, range: Option<thumbnail::Range>, i: usize) -> String {
    let Some(picture) = page.picture(i) else { return String::new() };
    let size = thumbnail::depth_size(page.steps().len());
    let color = picture.color.as_ref().map(|color| thumbnail::color(color, i + 1)).unwrap_or_default();
    thumbnail::depth(&picture.depth, range.unwrap_or_default(), i + 1, size) + &color
}

struct Column {
    name: &'static str,
    cell: fn(&ScanPage<'_>, usize) -> String,
}

/// The columns of numbers; columns without any known value are left out.
fn columns(page: &ScanPage<'_>) -> Vec<Column> {
    let record = page.record;
    let measure = coverage::known(page);
    let is_reachable = measure.as_ref().is_some_and(|measure| measure.is_reachable);
    let estimated = page.steps().iter().any(|step| step.estimated_completeness.is_some());
    let registered = page.steps().iter().any(|step| step.registration_verdict.is_some());
    let shown = |is_known: bool, name, cell| is_known.then_some(Column { name, cell });
    [
        shown(measure.is_some(), measure.as_ref().map_or("", |measure| measure.name), |page, i| {
            percent(share(page, i))
        }),
        shown(measure.is_some(), "Gained", |page, i| percent(gained(page, i))),
        shown(is_reachable && record.random_curve.is_some(), "Random", |page, i| {
            baseline(page.record.random_curve.as_deref(), i)
        }),
        shown(is_reachable && record.clairvoyant_curve.is_some(), "Clairvoyant", |page, i| {
            baseline(page.record.clairvoyant_curve.as_deref(), i)
        }),
        shown(true, "New voxels", |page, i| new_voxels(&page.steps()[i])),
        shown(estimated, "Estimated completeness", |page, i| {
            percent(page.steps()[i].estimated_completeness.unwrap_or(f64::NAN))
        }),
        shown(registered, "Registration", |page, i| registration(&page.steps()[i])),
        shown(true, "Planning", |page, i| seconds(page.steps()[i].plan_time_ms / 1e3)),
        shown(true, "Path", |page, i| metres(page.travel(i))),
        shown(true, "Position, m", |page, i| position(&page.steps()[i])),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn row(page: &ScanPage<'_>, columns: &[Column], i: usize, img: &str) -> String {
    let color = color::css(color::view(i, page.steps().len()));
    let mut out = format!(
        r#"<tr><th scope="row"><svg class="swatch" viewBox="0 0 1 1" aria-hidden="true"><path fill="{color}" d="M0 0h1v1H0z"/></svg>{} <small>{}</small>{}</th><td class="depth">{img}</td>"#,
        i + 1,
        candidate(&page.steps()[i]),
        warning(&page.steps()[i])
    );
    for Column { name, cell } in columns {
        let value = cell(page, i);
        out += &format!(r#"<td class="number" data-label="{name}">{value}</td>"#);
    }
    out + "</tr>"
}

fn share(page: &ScanPage<'_>, i: usize) -> f64 {
    coverage::known(page).and_then(|known| known.values[i]).unwrap_or(f64::NAN)
}

fn gained(page: &ScanPage<'_>, i: usize) -> f64 {
    share(page, i) - if i == 0 { 0.0 } else { share(page, i - 1) }
}

fn baseline(curve: Option<&[f64]>, i: usize) -> String {
    percent(curve.and_then(|curve| curve.get(i)).copied().unwrap_or(f64::NAN))
}

/// The number of voxels that the view made occupied, and the planner's expected number.
fn new_voxels(step: &StepRecord) -> String {
    let expected = step.expected_new_voxels.map_or(String::new(), |expected| {
        format!("<small>{} expected</small>", count(expected.round() as usize))
    });
    count(step.new_voxels) + &expected
}

/// The view, and the runner-up of the planner's choice.
fn candidate(step: &StepRecord) -> String {
    let view = step.view.map_or("given pose".to_owned(), |view| format!("candidate {view}"));
    view + &step.runner_up.map_or(String::new(), |view| format!(", next best {view}"))
}

/// The result of the frame's registration.
fn registration(step: &StepRecord) -> String {
    let Some(verdict) = step.registration_verdict else { return "–".to_owned() };
    let moved = step.registration_moved_mm.zip(step.registration_turned_deg);
    let detail = match (step.registration_set_aside, moved) {
        (Some(true), _) => "set aside".to_owned(),
        (_, Some((moved, turned))) => format!("by {} mm, {}°", fixed(moved, 1), fixed(turned, 2)),
        _ => String::new(),
    };
    format!("{}<small>{detail}</small>", verdict_phrase(verdict))
}

fn warning(step: &StepRecord) -> String {
    let warning = step.warning.as_ref();
    warning.map_or(String::new(), |text| format!(r#"<small class="warning">{}</small>"#, escape(text)))
}

fn position(step: &StepRecord) -> String {
    let [x, y, z] = step.position_m;
    format!("{x:.3}, {y:.3}, {z:.3}").replace('-', "−")
}
