use nextview::registration::Verdict;
use nextview_scan::{ScanConfig, StepRecord};

/// Returns a description of the object and of its scan, and the header of the table of steps; see
/// [`step_line`].
///
/// The description ends with a line break, as the heading does.
pub fn heading(config: &ScanConfig, description: &str, candidates: usize) -> String {
    // To a nanometre: 5 mm must not read 5.000000000000001.
    let voxel_mm = (config.voxel_size_m.unwrap_or_default() * 1e9).round() / 1e6;
    format!(
        "{description}planner {}, profile {}, {candidates} candidate views, voxels of {voxel_mm} mm\n\n\
         {:>4}  {:>6}  {:>9}  {:>9}  {:>10}  {:>10}  {:>7}\n",
        config.planner,
        config.profile,
        "step",
        "view",
        "reachable",
        "surface",
        "new voxels",
        "planning",
        "path"
    )
}

/// Returns the line of a step in the table: its number, its view, `reachable_coverage`,
/// `surface_coverage_2mm`, `new_voxels`, `plan_time_ms` and `path_length_m`, with a dash for unknown values,
/// and the reason if registration set the frame aside. Ends with a line break.
pub fn step_line(step: &StepRecord) -> String {
    let percent =
        |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    format!(
        "{:>4}  {:>6}  {:>9}  {:>9}  {:>10}  {:>7.1} ms  {:>5.2} m{}\n",
        step.step,
        step.view.map_or("-".to_owned(), |view| view.to_string()),
        percent(step.reachable_coverage),
        percent(step.surface_coverage_2mm),
        step.new_voxels,
        step.plan_time_ms,
        step.path_length_m,
        set_aside_phrase(step),
    )
}

/// The reason why the frame was set aside; empty if it was not.
fn set_aside_phrase(step: &StepRecord) -> String {
    let verdict = step.registration_verdict.filter(|_| step.registration_set_aside == Some(true));
    verdict.map_or(String::new(), |verdict| format!("  set aside: {}", verdict_phrase(verdict)))
}

/// An outcome of registration in words.
pub(super) fn verdict_phrase(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Aligned => "aligned",
        Verdict::LittleOverlap => "little overlap",
        Verdict::Sliding => "aligned where it cannot slide",
        Verdict::TooFar => "moved too far",
        Verdict::NoBetter => "fits as given",
        _ => "unknown reason",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview_scan::Profile;

    #[test]
    fn lines_stand_below_the_heading() {
        let config =
            ScanConfig { voxel_size_m: Some(0.1 * 0.05), ..ScanConfig::of_profile(Profile::Default) };
        let heading = heading(&config, "a mug\n", 1000);
        assert!(
            heading.starts_with("a mug\nplanner ")
                && heading.contains("1000 candidate views, voxels of 5 mm\n\n"),
            "{heading}"
        );
        let step = StepRecord { step: 2, view: Some(637), path_length_m: 0.66, ..StepRecord::default() };
        let known = StepRecord {
            reachable_coverage: Some(0.477),
            surface_coverage_2mm: Some(0.399),
            new_voxels: 967,
            plan_time_ms: 169.84,
            ..step.clone()
        };
        let expected = [
            "step    view  reachable    surface  new voxels    planning     path\n",
            "   2     637     47.7 %     39.9 %         967    169.8 ms   0.66 m\n",
            "   2     637          -          -           0      0.0 ms   0.66 m\n",
        ];
        assert_eq!(heading.lines().last().unwrap().to_owned() + "\n", expected[0]);
        assert_eq!([step_line(&known), step_line(&step)], expected[1..]);
        let aside = StepRecord {
            registration_verdict: Some(Verdict::LittleOverlap),
            registration_set_aside: Some(true),
            ..step
        };
        assert!(step_line(&aside).ends_with("0.66 m  set aside: little overlap\n"), "{}", step_line(&aside));
    }
}
