use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview_campaign::execution::{RunList, execute};
use nextview_campaign::store::Store;
use nextview_campaign::{DoneRun, Run, RunRecord, RunResult, Runs, Shard, Spec};
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

const SPEC: &str = r#"
name = "many"
[scan]
candidates = 60
views = 10
voxel_size_m = 0.02
stop.entropy_share = 0
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
sweep.planner = ["most-surface", "max-flow", "apora", "rse", "random"]
"#;

/// Writes the folders of the shards below this one: five variants on this number of objects, with this number
/// of seeds.
pub fn write(
    folder: &Path,
    [n_objects, n_seeds, n_shards]: [usize; 3],
    draw: u64,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let objects: Vec<String> = (0..n_objects).map(|number| format!("builtin:random-{number}")).collect();
    let seeds: Vec<usize> = (0..n_seeds).collect();
    let spec = Spec::parse(&format!("objects = {objects:?}\nseeds = {seeds:?}\n{SPEC}"), Path::new(""))?;
    let runs = spec.runs()?;
    let list = RunList::new(runs.get(0));
    execute(&list, 1, None, &Cancel::default())?;
    let template = list.into_records().pop().ok_or("the scan was cancelled")?;
    let write_shard = |number: usize| {
        let dir = folder.join(number.to_string());
        let store = Store::open(&dir, &spec, Shard::new(number, n_shards)?, false)?;
        let mut file = BufWriter::new(File::options().append(true).open(dir.join("runs.jsonl"))?);
        for &number in store.share().iter().flatten() {
            let line = record(&runs, number, &template, draw).ok_or("no such run")?;
            writeln!(file, "{}", serde_json::to_string(&line)?)?;
        }
        file.flush()?;
        Ok(dir)
    };
    (1..=n_shards).map(write_shard).collect()
}

/// A synthetic record of this run.
fn record(runs: &Runs, number: usize, template: &RunRecord, draw: u64) -> Option<RunRecord> {
    let Run { id, data_set, mut config, .. } = runs.get(number)?;
    config.voxel_size_m = template.config.voxel_size_m;
    let mut random = Random::new(number as u64, draw);
    let DoneRun { mut record, extra_memory_mb } = template.done()?.clone();
    let factor = random.range(0.9, 1.0);
    for step in &mut record.steps {
        step.plan_time_ms *= random.range(0.5, 1.5);
        step.path_length_m *= random.range(0.9, 1.1);
        for share in [&mut step.voxel_coverage, &mut step.reachable_coverage, &mut step.map_iou] {
            *share = share.map(|share| factor * share);
        }
    }
    record.skill = record.skill.map(|skill| skill * factor);
    Some(RunRecord {
        object: id.object,
        data_set,
        variant: id.variant,
        seed: id.seed,
        view_seed: id.view_seed,
        first_view: id.first_view,
        config,
        result: RunResult::Done(Box::new(DoneRun { record, extra_memory_mb })),
        ..template.clone()
    })
}
