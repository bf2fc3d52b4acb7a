use super::placement;
use super::step_line::verdict_phrase;
use super::stop_phrase::stop_phrase;
use crate::text::fixed;
use glam::DVec3;
use nextview_scan::{
    BoxRule, HandEyeRecord, OtherBodyRecord, QualityMm, ScanConfig, ScanRecord, StepRecord, TableRule,
};

/// Returns the quantities of a scan, finished or in progress, as label and value with unit, in display order.
///
/// Labels are the names in the record. Two spaces before a label make it part of the row above.
pub fn summary(record: &ScanRecord, config: &ScanConfig) -> Vec<(String, String)> {
    let last = record.steps.last();
    let mut rows = vec![
        ("views taken", format!("{} of {} candidates", record.steps.len(), record.candidates)),
        record.stop_reason.map_or(("state", "under way".to_owned()), |reason| {
            ("stopped because", stop_phrase(reason).to_owned())
        }),
    ];
    rows.extend(coverage(record));
    if let Some(skill) = record.skill {
        rows.push(("skill", format!("{}  (0 = random views, 1 = knows the object)", fixed(skill, 2))));
    }
    rows.extend(areas(record));
    rows.extend(last.iter().flat_map(|step| truth(step)));
    let phrase = |label, quality: Option<QualityMm>| quality.map(|quality| (label, quality_phrase(quality)));
    let scores = |label, quality: Option<QualityMm>| Some((label, score_phrase(quality?)?));
    rows.extend(phrase("cloud", record.cloud()));
    rows.extend(scores("  F-score", record.cloud()));
    rows.extend(phrase("mesh", record.mesh()));
    rows.extend(scores("  F-score", record.mesh()));
    rows.extend(expected_error(record));
    rows.extend(record.mesh_filled_share.map(filled));
    rows.extend(placement::turn(record).map(|text| ("turned", text)));
    rows.extend(placement::request(record).map(|text| ("not seen", text)));
    rows.extend(alignment(record));
    rows.extend(registered(record));
    rows.extend(record.frame_residual_mm.map(|mm| ("frames agree", format!("within {} mm", fixed(mm, 2)))));
    rows.extend(record.hand_eye.map(hand_eye));
    rows.extend(recorded(record));
    rows.extend(found(config, last));
    rows.extend(record.other_bodies.iter().map(other_body));
    rows.extend(costs(record));
    rows.into_iter().map(|(label, value)| (label.to_owned(), value)).collect()
}

/// Returns the quantities as text, one per line.
pub fn summary_text(record: &ScanRecord, config: &ScanConfig) -> String {
    summary(record, config).iter().map(|(label, value)| format!("{label:<22} {value}\n")).collect()
}

type SummaryRow = (&'static str, String);

fn percent(share: f64) -> String {
    format!("{} %", fixed(100.0 * share, 1))
}

/// Coverage against random views and the clairvoyant planner with the same number of views.
fn coverage(record: &ScanRecord) -> Vec<SummaryRow> {
    let (Some(last), Some(random), Some(clairvoyant)) =
        (record.steps.last(), &record.random_curve, &record.clairvoyant_curve)
    else {
        return Vec::new();
    };
    let Some(reached) = last.reachable_coverage else { return Vec::new() };
    let at = |curve: &[f64]| curve.get(record.steps.len() - 1).or(curve.last()).copied();
    vec![
        ("reachable coverage", percent(reached)),
        ("  random views", percent(at(random).unwrap_or_default())),
        ("  clairvoyant", percent(at(clairvoyant).unwrap_or_default())),
    ]
}

/// The known measures against the true object after a step.
fn truth(step: &StepRecord) -> Vec<SummaryRow> {
    let rows = [
        ("voxel coverage", step.voxel_coverage.map(percent)),
        ("false voxels", step.false_voxels.map(|n| n.to_string())),
        ("map", map_phrase(step)),
        ("surface coverage 2 mm", step.surface_coverage_2mm.map(percent)),
        ("surface coverage 5 mm", step.surface_coverage_5mm.map(percent)),
    ];
    rows.into_iter().filter_map(|(label, value)| Some((label, value?))).collect()
}

/// Precision, recall and IoU of the map; the latter two are unknown without baselines.
fn map_phrase(step: &StepRecord) -> Option<String> {
    let precision = format!("precision {}", percent(step.map_precision?));
    let reachable = step.map_recall.zip(step.map_iou);
    let reachable = reachable.map(|(r, iou)| format!(", recall {}, IoU {}", percent(r), percent(iou)));
    Some(precision + &reachable.unwrap_or_default())
}

/// The expected error of the cloud, and the share of the surface at the goal.
fn expected_error(record: &ScanRecord) -> Option<SummaryRow> {
    let median = fixed(record.cloud_expected_error_median_mm?, 2);
    let p95 = fixed(record.cloud_expected_error_p95_mm?, 2);
    let share = record.steps.last().and_then(|step| step.share_at_goal);
    let at_goal = share.map(|share| format!("; {} of the measured voxels at the goal", percent(share)));
    let at_goal = at_goal.unwrap_or_default();
    Some(("expected error", format!("median {median} mm, 95 % at most {p95} mm{at_goal}")))
}

/// The unmeasured share of the closed mesh.
fn filled(share: f64) -> SummaryRow {
    ("filled in", format!("{} of the mesh, which is watertight", percent(share)))
}

/// F-scores and Chamfer distance; `None` if there are no baselines.
fn score_phrase(quality: QualityMm) -> Option<String> {
    let at = [quality.f_score_1mm?, quality.f_score_2mm?, quality.f_score_5mm?].map(percent);
    Some(format!(
        "{} at 1 mm, {} at 2 mm, {} at 5 mm; Chamfer distance {:.2} mm",
        at[0], at[1], at[2], quality.chamfer_mm?
    ))
}

/// The areas under the coverage curve.
fn areas(record: &ScanRecord) -> Option<SummaryRow> {
    let [views, time, horizon] =
        [record.coverage_auc_views?, record.coverage_auc_time?, record.coverage_auc_horizon_s?];
    let phrase = format!("{} over the views, {} over {horizon:.0} s", percent(views), percent(time));
    Some(("mean coverage", phrase))
}

/// The motion of the model before its evaluation; `None` if it was not moved.
fn alignment(record: &ScanRecord) -> Option<SummaryRow> {
    let (moved, turned) = (record.alignment_moved_mm?, record.alignment_turned_deg?);
    let phrase = format!("by {moved:.1} mm and {turned:.2} degrees to the true object, for the evaluation");
    (moved > 0.0 || turned > 0.0).then_some(("model aligned", phrase))
}

/// The number of frames that registration could use, and the others with the reason; `None` if registration
/// is off.
fn registered(record: &ScanRecord) -> Option<SummaryRow> {
    let n_aside = record.frames_set_aside?;
    let n_used = record.steps.len().saturating_sub(n_aside);
    let aside: Vec<String> = record
        .steps_set_aside()
        .map(|step| {
            format!("{} ({})", step.step, step.registration_verdict.map_or("unknown", verdict_phrase))
        })
        .collect();
    let aside = if aside.is_empty() { String::new() } else { format!("; left out: {}", aside.join(", ")) };
    Some(("frames used", format!("{n_used} of {}{aside}", record.steps.len())))
}

/// The error of the hand-eye calibration, if the frames show one.
fn hand_eye(found: HandEyeRecord) -> SummaryRow {
    let of = |mm: f64, deg: f64| (fixed(mm, 1), fixed(deg, 2));
    let (mm, deg) = of(found.deviation_mm, found.deviation_deg);
    let phrase = if found.is_shown() {
        let (moved, turned) = of(found.moved_mm, found.turned_deg);
        format!(
            "off by {moved} ± {mm} mm and {turned} ± {deg} degrees; `hand_eye` in record.json corrects it"
        )
    } else {
        format!("no error shown; these views determine it to ± {mm} mm and ± {deg} degrees")
    };
    ("hand-eye calibration", phrase)
}

fn quality_phrase(quality: QualityMm) -> String {
    format!(
        "mean {} mm off, 95 % within {} mm; {} % of the surface within 2 mm",
        fixed(quality.accuracy_mean_mm, 2),
        fixed(quality.accuracy_p95_mm, 2),
        fixed(100.0 * quality.completeness_2mm, 1)
    )
}

/// Rows that only scans of recorded frames have.
fn recorded(record: &ScanRecord) -> Vec<SummaryRow> {
    let mut rows = Vec::new();
    let accuracy = record
        .steps
        .last()
        .and_then(|s| Some([s.accuracy_mean_mm?, s.accuracy_median_mm?, s.accuracy_p95_mm?]));
    if let Some([mean, median, p95]) = accuracy.map(|mm| mm.map(|mm| fixed(mm, 2))) {
        let value = format!("mean {mean} mm, median {median} mm, 95 % within {p95} mm");
        rows.push(("accuracy", value));
    }
    if !record.skipped.is_empty() {
        rows.push(("skipped", format!("{} of the recording", record.skipped.len())));
    }
    let blind = record.steps.iter().filter(|step| step.hit_voxels == 0);
    let blind: Vec<&str> = blind.filter_map(|step| step.frame.as_deref()).collect();
    if !blind.is_empty() {
        rows.push(("nothing in the box", blind.join(", ")));
    }
    rows
}

/// A body that was not scanned, and the gap that would make it part of the object.
fn other_body(body: &OtherBodyRecord) -> SummaryRow {
    let [size, center] = [body.size_m.map(|m| 1e3 * m), body.center_m];
    let size = format!("{:.0} x {:.0} x {:.0} mm", size[0], size[1], size[2]);
    let center = format!("({:.3}, {:.3}, {:.3}) m", center[0], center[1], center[2]);
    // Rounded up, to be large enough.
    let gap = (1e3 * body.gap_m).ceil();
    (
        "other body",
        format!("{size} at {center}; to include it, set `object_box.max_gap_m` to {} or more", gap / 1e3),
    )
}

/// The places of the object and its table, if the scan had to find them.
fn found(config: &ScanConfig, last: Option<&StepRecord>) -> Vec<SummaryRow> {
    let bounds = last.and_then(StepRecord::bounds);
    let table = last.and_then(StepRecord::table);
    let mut rows = Vec::new();
    if config.object_box.rule == BoxRule::Grows {
        let size = bounds.map(|bounds| bounds.size() * 1e3);
        let size = size.map(|mm| format!("{} mm", mm.to_array().map(|mm| fixed(mm, 0)).join(" x ")));
        rows.push(("box found", size.unwrap_or("none".to_owned())));
    }
    if config.object_box.table == TableRule::Fit {
        // Below the object if one was found.
        let place = bounds.map_or(DVec3::ZERO, |bounds| bounds.center().with_z(0.0));
        let height = table.map(|table| -table.height(place) / table.normal().z * 1e3);
        let height = height.map_or("none".to_owned(), |mm| {
            // Rounded first, to avoid -0.0.
            format!("at z = {} mm", fixed((mm * 10.0).round() / 10.0, 1))
        });
        rows.push(("table found", height));
    }
    rows
}

/// Lengths, times and memory.
fn costs(record: &ScanRecord) -> Vec<SummaryRow> {
    let steps = &record.steps;
    let [path, trajectory, time] =
        steps.last().map_or([0.0; 3], |s| [s.path_length_m, s.trajectory_length_m, s.trajectory_time_s]);
    // The first view is given and took no time to choose.
    let plan_times: Vec<f64> = steps.iter().skip(1).map(|step| step.plan_time_ms).collect();
    let map_times: Vec<f64> = steps.iter().map(|step| step.map_time_ms).collect();
    let mut rows = vec![
        ("path length", format!("{} m", fixed(path, 2))),
        ("trajectory", format!("{} m in {} s", fixed(trajectory, 2), fixed(time, 1))),
        ("planning time", format!("{} ms a view (median)", fixed(median(&plan_times), 1))),
        ("map update", format!("{} ms a view (median)", fixed(median(&map_times), 1))),
    ];
    if let Some(time) = record.baseline_time_ms {
        rows.push(("baselines took", format!("{} s, not counted as scan time", fixed(time / 1000.0, 1))));
    }
    if let Some(peak) = record.peak_memory_mb {
        rows.push(("peak memory", format!("{} MB", fixed(peak, 0))));
    }
    rows
}

/// The median; zero for an empty slice.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}
