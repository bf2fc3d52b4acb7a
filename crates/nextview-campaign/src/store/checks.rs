use super::difference::difference;
use crate::{Run, RunRecord, Spec};
use nextview_scan::{BuildIdentity, Fault};
use toml::Table;

/// Fails unless this build computed the record.
pub(super) fn check_build(record: &RunRecord) -> Result<(), Fault> {
    let (build, this) = (&record.build, BuildIdentity::this());
    if *build == this {
        return Ok(());
    }
    let message = format!("{} was computed by build {build}, but this is build {this}", record.id());
    Err(Fault::data(message).with_remedy("resume with that build, or start again in another folder"))
}

/// Fails unless the record has the configuration of its run.
pub(super) fn check_config(run: &Run, record: &RunRecord) -> Result<(), Fault> {
    // The run may have chosen the voxel size to suit the object.
    let mut expected = run.config.clone();
    expected.voxel_size_m = expected.voxel_size_m.or(record.config.voxel_size_m);
    // The number of a drawn first view is known only after the candidates are counted.
    if run.first_view_draw.is_some() {
        expected.first_view = record.config.first_view;
    }
    if expected == record.config {
        return Ok(());
    }
    let [there, here] = [&record.config, &expected].map(Table::try_from);
    let problem = format!("{} has a different configuration in the folder", run.id);
    check_equal(&problem, &there.map_err(Fault::data)?, &here.map_err(Fault::data)?)
        .map_err(|fault| fault.with_remedy("start again in another folder"))
}

/// Fails unless the specification in a folder equals the given one.
pub(super) fn check_same(saved: &Spec, given: &Spec) -> Result<(), Fault> {
    let [there, here] = [saved, given].map(Table::try_from);
    let problem = "the folder belongs to another specification";
    let remedy =
        "choose another folder (`out`), or resume the campaign in this one with its own specification";
    check_equal(problem, &there.map_err(Fault::data)?, &here.map_err(Fault::data)?)
        .map_err(|fault| fault.with_remedy(remedy))
}

fn check_equal(problem: &str, there: &Table, here: &Table) -> Result<(), Fault> {
    difference(there, here).map_or(Ok(()), |it| {
        Err(Fault::data(format!("{problem}: {} is {} there, {} here", it.key, it.first, it.second)))
    })
}
