//! One run, whatever comes of it.

use super::campaign::Run;
use super::{Host, Measures, RunRecord, RunResult, StepMeasures};
use crate::Failure;
use crate::scan::{Baselines, FinishedScan, ScanConfig, Setting, Truth, memory, milliseconds, ways_so_far};
use nextview_sim::run::Step;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What the runs of a group share, or why they all fail.
pub(super) type Prepared = Result<(Setting, Option<Truth>), String>;

/// Loads an object and, where that is needed, looks at it from everywhere.
pub(super) fn prepare(config: &ScanConfig) -> Prepared {
    guarded(|| {
        let setting = Setting::new(config)?;
        let truth = config.needs_truth().then(|| Truth::new(&setting, || ())).transpose()?;
        Ok((setting, truth))
    })
}

/// Scans and measures. The growth of the process's memory is that of the run only if there is no other beside it.
pub(super) fn execute(run: &Run, prepared: &Prepared, host: &Host, is_alone: bool) -> RunRecord {
    let mut config = run.config.clone();
    let result = prepared.as_ref().map_err(String::clone).and_then(|(setting, truth)| {
        config.voxel_size_m = Some(setting.voxel_size);
        guarded(|| measure(&config, setting, truth.as_ref(), is_alone))
    });
    RunRecord {
        object: run.id.object.clone(),
        data_set: run.data_set.clone(),
        variant: run.id.variant.clone(),
        seed: run.id.seed,
        first_view: run.id.first_view,
        config,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        host: host.clone(),
        result: result.map_or_else(RunResult::Failed, |measures| RunResult::Done(Box::new(measures))),
    }
}

fn measure(
    config: &ScanConfig,
    setting: &Setting,
    truth: Option<&Truth>,
    is_alone: bool,
) -> Result<Measures, Failure> {
    let before = if is_alone { memory::forget_peak().and_then(|()| memory::now_mb()) } else { None };
    let scan = setting.scan(config, truth, |_, frame| Ok(frame), |_| Ok(()))?;
    let after = before.and_then(|_| memory::peak_mb());
    let baselines = truth.map(|truth| Baselines::new(truth, config));
    let growth = before.zip(after).map(|(before, after)| (after - before).max(0.0));
    Ok(Measures {
        cloud: scan.quality(&scan.plain_cloud()?, &setting.true_surface),
        extra_memory_mb: growth.map(|mb| (10.0 * mb).round() / 10.0),
        ..measures(config, setting, &scan, baselines.as_ref())
    })
}

fn measures(
    config: &ScanConfig,
    setting: &Setting,
    scan: &FinishedScan,
    baselines: Option<&Baselines>,
) -> Measures {
    let is_pose_wrong = config.noise.is_pose_wrong();
    let steps = scan.steps.iter().zip(ways_so_far(&scan.steps));
    Measures {
        n_object_voxels: setting.object_voxels.len(),
        n_reachable: baselines.map(Baselines::n_reachable),
        stop_reason: scan.stop_reason,
        steps: steps.map(|(step, way)| step_measures(step, way, is_pose_wrong, baselines)).collect(),
        random_curve: baselines.map(|b| b.random.mean.clone()),
        clairvoyant_curve: baselines.map(|b| b.clairvoyant.clone()),
        skill: baselines.and_then(|b| b.skill(scan.steps.iter().map(|step| &step.measures))),
        cloud: None,
        extra_memory_mb: None,
    }
}

fn step_measures(
    step: &Step,
    [way_m, move_time_s]: [f64; 2],
    is_pose_wrong: bool,
    baselines: Option<&Baselines>,
) -> StepMeasures {
    let truth = &step.measures;
    let [surface_1mm, surface_2mm, surface_5mm] = truth.surface_coverage;
    StepMeasures {
        view: step.report.view,
        voxel_size_m: step.report.voxel_size,
        voxel_coverage: truth.voxels.coverage(),
        false_voxels: truth.voxels.n_false,
        seen: baselines.map(|b| b.reachable_coverage(truth)),
        estimated_seen_before: step.report.outlook.map(|outlook| outlook.completeness()),
        expected_new_voxels: step.report.outlook.map(|outlook| outlook.n_expected),
        surface_1mm,
        surface_2mm,
        surface_5mm,
        misplaced_mm: truth.misplacement.filter(|_| is_pose_wrong).map(|m| 1e3 * m),
        registration: step.report.registration.map(|found| found.verdict),
        overlap: step.report.registration.map(|found| found.overlap),
        entropy_nats: step.report.map.entropy,
        entropy_share: step.report.map.entropy_share,
        path_length_m: step.path_length,
        way_m: Some(way_m),
        move_time_s: Some(move_time_s),
        plan_time_ms: milliseconds(step.plan_time),
        map_time_ms: milliseconds(step.map_time),
        render_time_ms: milliseconds(step.capture_time),
    }
}

/// The work's value, or why there is none. A panic is a fault of ours, but must not cost the other runs.
fn guarded<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|failure| failure.message().to_owned()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            Err(format!("a fault in nextview: {text}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_failure() {
        let result: Result<(), String> = guarded(|| panic!("at {}", 3));
        assert_eq!(result, Err("a fault in nextview: at 3".to_owned()));
        assert_eq!(guarded(|| Err::<(), _>(Failure::data("no"))), Err("no".to_owned()));
    }
}
