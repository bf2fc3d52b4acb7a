use crate::{DoneRun, Host, Run, RunRecord, RunResult};
use nextview::Cancel;
use nextview::session::StopReason;
use nextview_scan::{
    BuildIdentity, Fault, Faults, Measured, RunOptions, ScanConfig, ScanRun, SimulatedObject, Simulation,
    Truth, TruthCache, memory,
};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The data shared by the runs on an object, or the reason why they all fail.
pub(super) type Prepared = Result<(SimulatedObject, Option<Truth>), String>;

/// Loads an object and, if needed, looks at it from all candidates, unless a cache has the result.
pub(super) fn prepare(config: &ScanConfig, truths: Option<&TruthCache>, cancel: &Cancel) -> Prepared {
    let config = config.of_object();
    guarded(|| {
        let object = SimulatedObject::new(&config)?;
        let look = || match truths {
            Some(truths) => truths.truth(&object, &config, cancel),
            None => Truth::new(&object, cancel, || ()),
        };
        let truth = config.needs_truth().then(look).transpose()?;
        Ok((object, truth))
    })
}

/// Scans, measures and records a run. The growth of the process's memory is that of the run only if it is
/// alone.
pub(super) fn measured(
    run: &Run,
    prepared: &Prepared,
    host: &Host,
    is_alone: bool,
    cancel: &Cancel,
) -> RunRecord {
    let mut config = run.config.clone();
    let result = prepared.as_ref().map_err(String::clone).and_then(|(object, truth)| {
        config.voxel_size_m = Some(object.voxel_size);
        if let Some(draw) = run.first_view_draw {
            let n_views = object.views.len();
            config.first_view = draw.among(n_views).ok_or_else(|| {
                format!("first view {} cannot be drawn from {n_views} candidates", draw.place + 1)
            })?;
        }
        guarded(|| measure(&config, object, truth.as_ref(), is_alone, cancel))
    });
    RunRecord {
        object: run.id.object.clone(),
        data_set: run.data_set.clone(),
        variant: run.id.variant.clone(),
        seed: run.id.seed,
        view_seed: run.id.view_seed,
        first_view: run.id.first_view,
        config,
        build: BuildIdentity::this(),
        host: host.clone(),
        result: result.map_or_else(RunResult::Failed, |done| RunResult::Done(Box::new(done))),
    }
}

/// Whether the run of a record ended before it could be cancelled.
pub(super) fn is_complete(record: &RunRecord) -> bool {
    record.done().is_some_and(|done| done.record.stop_reason != Some(StopReason::Cancelled))
}

fn measure(
    config: &ScanConfig,
    object: &SimulatedObject,
    truth: Option<&Truth>,
    is_alone: bool,
    cancel: &Cancel,
) -> Result<DoneRun, Faults> {
    config.check_views(object.views.len())?;
    let simulation = Simulation::new(object, config, truth);
    let before = if is_alone { memory::forget_peak().and_then(|()| memory::now_mb()) } else { None };
    let mut run =
        ScanRun::begin(&simulation, config, RunOptions { cancel: cancel.clone(), ..RunOptions::default() })?;
    let stop = run.drive(|_| Ok(()))?;
    let finished = run.finish(Some(stop));
    let after = before.and_then(|_| memory::peak_mb());
    let growth = before.zip(after).map(|(before, after)| (after - before).max(0.0));
    let mut record = finished.record(config, Measured::CloudOnly)?;
    // The process's peak says nothing about one run of many.
    record.peak_memory_mb = None;
    Ok(DoneRun { record, extra_memory_mb: growth.map(|mb| (10.0 * mb).round() / 10.0) })
}

/// The result of the work, or the reason for its failure. A panic is a bug of ours, but must not affect the
/// other runs.
fn guarded<T>(work: impl FnOnce() -> Result<T, Faults>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|faults| reason(&faults)),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            Err(format!("a bug in nextview: {text}"))
        }
    }
}

/// All faults with their remedies on one line.
fn reason(faults: &Faults) -> String {
    let with_remedy = |fault: &Fault| match &fault.remedy {
        Some(remedy) => format!("{fault} ({remedy})"),
        None => fault.to_string(),
    };
    faults.iter().map(with_remedy).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_failure() {
        let result: Result<(), String> = guarded(|| panic!("at {}", 3));
        assert_eq!(result, Err("a bug in nextview: at 3".to_owned()));
        let faults = Faults::of(vec![Fault::data("no"), Fault::data("never").with_remedy("ever")]).unwrap();
        assert_eq!(guarded(|| Err::<(), _>(faults)), Err("no; never (ever)".to_owned()));
    }
}
