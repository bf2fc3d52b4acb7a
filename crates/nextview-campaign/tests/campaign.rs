//! Whole campaigns: the results do not depend on interruptions and on the order of the runs.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview::Cancel;
use nextview_campaign::execution::{
    Batch, CampaignEvent, Dispatch, RunList, WorkSource, execute, run_campaign,
};
use nextview_campaign::statistics::{Study, measure};
use nextview_campaign::store::{Store, read};
use nextview_campaign::{RunRecord, Shard, Spec, tables};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Coarse voxels and a small camera: takes about a second.
const SPEC: &str = r#"
name = "tiny"
objects = ["builtin:mug", "builtin:bracket"]
[scan]
profile = "paper"
candidates = 20
views = 3
voxel_size_m = 0.02
stop.entropy_share = 0
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
scan.planner = "random"
seeds = [0, 1]
[[variant]]
label = "flow, \"gamma\" {max_flow.gamma}"
sweep."max_flow.gamma" = [0, 0.5]
[[variant]]
scan = { planner = "clairvoyant", baselines = false }
"#;

const N_RUNS: usize = 10;

fn spec() -> Spec {
    Spec::parse(SPEC, Path::new("")).unwrap()
}

/// An empty folder, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("nextview-campaigns-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The tables that must not depend on how the campaign was executed.
fn lasting_tables(folder: &Folder, store: &Store) -> Vec<Vec<u8>> {
    tables::write(&folder.0, &store.finished()).unwrap();
    let names = ["runs.csv", "steps.csv"].into_iter();
    #[cfg(feature = "parquet")]
    let names = names.chain(["runs.parquet", "steps.parquet"]);
    names.map(|name| fs::read(folder.0.join(name)).unwrap()).collect()
}

fn finished(store: &Store) -> Vec<RunRecord> {
    store.finished().iter().collect::<Result<_, _>>().unwrap()
}

fn campaign(folder: &Folder, n_jobs: Option<usize>) -> (Store, Vec<CampaignEvent>) {
    let events = Mutex::new(Vec::new());
    let mut store = Store::open(&folder.0, &spec(), Shard::WHOLE, true).unwrap();
    let listener = |event| events.lock().unwrap().push(event);
    run_campaign(&mut store, n_jobs, None, &Cancel::default(), &listener).unwrap();
    (store, events.into_inner().unwrap())
}

/// The runs on a table, where about half of the candidates do not exist, from these first views.
fn runs_on_a_table(folder: &Folder, first_views: &str) -> Vec<RunRecord> {
    let (head, _) = SPEC.split_once("[[variant]]").unwrap();
    let spec =
        head.replace("[scan]", &format!("first_views = {first_views}\n[scan]\nobject_box.table = 'known'"));
    let spec = Spec::parse(&(spec + "[[variant]]\nscan.planner = 'random'\n"), Path::new("")).unwrap();
    let mut store = Store::open(&folder.0, &spec, Shard::WHOLE, true).unwrap();
    run_campaign(&mut store, None, None, &Cancel::default(), &|_| ()).unwrap();
    finished(&store)
}

#[test]
fn drawn_first_views_are_above_the_table() {
    let folder = Folder::new("first-views");
    let runs = runs_on_a_table(&folder, "6");
    assert!(runs.iter().all(|run| run.failure().is_none()), "{:?}", runs.iter().find_map(RunRecord::failure));
    for object in ["mug", "bracket"] {
        let of_object = || runs.iter().filter(|run| run.object == object);
        let views: BTreeSet<usize> = of_object().map(|run| run.config.first_view).collect();
        assert_eq!(views.len(), 6);
        assert!(of_object().any(|run| run.config.first_view != run.first_view), "none had to be drawn again");
    }
    assert_eq!(runs_on_a_table(&folder, "6"), runs, "a finished campaign is resumed");
}

/// The specification states their numbers, so a candidate that does not exist is a fault.
#[test]
fn a_listed_first_view_below_the_table_is_a_failed_run() {
    for run in runs_on_a_table(&Folder::new("listed-first-view"), "[19]") {
        let reason = run.failure().unwrap();
        assert!(reason.starts_with("`first_view` is 19, expected 0 to "), "{reason}");
        assert!(reason.ends_with("(only candidates above the table count; they are renumbered)"), "{reason}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_jobs_nor_on_who_hands_out_the_runs() {
    let mut all = Vec::new();
    for n_jobs in [1, 2, 5] {
        let folder = Folder::new(&format!("jobs-{n_jobs}"));
        let (store, events) = campaign(&folder, Some(n_jobs));
        all.push(lasting_tables(&folder, &store));
        let began = CampaignEvent::Began { n_objects: 2, n_runs: N_RUNS, n_finished: 0 };
        assert_eq!(events[0], began);
        let ended =
            |event: &&CampaignEvent| matches!(event, CampaignEvent::RunFinished { failure: None, .. });
        assert_eq!(events.iter().filter(ended).count(), N_RUNS);
        let objects: Vec<&CampaignEvent> = events
            .iter()
            .filter(|event| matches!(event, CampaignEvent::ObjectFinished { n_runs: 5, .. }))
            .collect();
        assert_eq!(objects.len(), 2);
        let has_memory = finished(&store).iter().all(|run| run.done().unwrap().extra_memory_mb.is_some());
        assert!(n_jobs > 1 || has_memory || !cfg!(target_os = "linux"));
        assert!(n_jobs == 1 || !has_memory, "memory is that of a run only where there is no other beside it");
        let stored = read(&folder.0).unwrap();
        let mut sorted = finished(&store);
        sorted.sort_by_key(RunRecord::id);
        let stored: Vec<RunRecord> = stored.runs.iter().collect::<Result<_, _>>().unwrap();
        assert_eq!(stored, sorted, "the same bits on the disk");

        let list = RunList::new(spec().runs().unwrap().iter().take(3));
        execute(&list, n_jobs, None, &Cancel::default()).unwrap();
        for record in list.into_records() {
            let same = stored.iter().find(|run| run.id() == record.id()).unwrap();
            assert!(same.has_same_results(&record) && same.config == record.config);
        }
    }
    assert!(all.iter().all(|tables| *tables == all[0]));
}

/// Executes the batches for `n_workers` workers, each from its text, as another process would; returns the
/// number of runs of each.
fn dispatched(folder: &Folder, n_workers: usize) -> (Dispatch, Vec<CampaignEvent>, Vec<usize>) {
    let mut dispatch = Dispatch::new(Store::open(&folder.0, &spec(), Shard::WHOLE, true).unwrap());
    let (mut events, mut sizes) = (dispatch.beginning(), Vec::new());
    while let Some(batch) = dispatch.take(n_workers) {
        sizes.push(batch.runs().len());
        let mut runs = Batch::from_json(&batch.to_json().unwrap()).unwrap().begin(1, None).unwrap();
        while let Some(record) = runs.next_record(&Cancel::default()).unwrap() {
            let record: RunRecord = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
            events.extend(dispatch.keep(&record).unwrap());
            assert_eq!(dispatch.keep(&record).unwrap(), [], "once more changes nothing");
        }
    }
    (dispatch, events, sizes)
}

#[test]
fn workers_elsewhere_give_the_same_tables() {
    let folder = Folder::new("dispatch");
    let (dispatch, events, sizes) = dispatched(&folder, 2);
    assert!(dispatch.finish().unwrap().is_empty());
    assert_eq!(sizes, [5, 3, 1, 1], "objects whole, and the last one divided");
    let n = |is: fn(&CampaignEvent) -> bool| events.iter().filter(|event| is(event)).count();
    assert_eq!(events[0], CampaignEvent::Began { n_objects: 2, n_runs: N_RUNS, n_finished: 0 });
    assert_eq!(n(|event| matches!(event, CampaignEvent::RunFinished { failure: None, .. })), N_RUNS);
    assert_eq!(n(|event| matches!(event, CampaignEvent::ObjectFinished { n_runs: 5, n_failed: 0, .. })), 2);
    let tables =
        |folder: &Folder| ["runs.csv", "steps.csv"].map(|name| fs::read(folder.0.join(name)).unwrap());
    let written = tables(&folder);
    drop(dispatch);
    let alone = Folder::new("dispatch-alone");
    let (store, _) = campaign(&alone, Some(1));
    assert_eq!(lasting_tables(&alone, &store)[..2], written);

    let text = fs::read_to_string(folder.0.join("runs.jsonl")).unwrap();
    let kept: String = text.split_inclusive('\n').take(7).collect();
    fs::write(folder.0.join("runs.jsonl"), kept + "{\"object\": \"mu").unwrap();
    let dispatch = Dispatch::new(Store::open(&folder.0, &spec(), Shard::WHOLE, true).unwrap());
    assert!(matches!(dispatch.beginning()[..], [CampaignEvent::Note(_), CampaignEvent::Began { .. }]));
    let message = dispatch.finish().unwrap_err().to_string();
    assert!(message.contains("3 of 10 runs have no record:\n  object bracket, variant "), "{message}");
    drop(dispatch);
    let (dispatch, events, sizes) = dispatched(&folder, 64);
    assert_eq!((events.len(), sizes), (1 + 3 + 1, vec![1, 1, 1]), "only what was missing");
    dispatch.finish().unwrap();
    assert_eq!(tables(&folder), written);
}

#[test]
fn tables_hold_every_run_and_view() {
    let folder = Folder::new("tables");
    let (store, _) = campaign(&folder, None);
    tables::write(store.dir(), &store.finished()).unwrap();
    let records = finished(&store);
    let records: Vec<&RunRecord> = records.iter().collect();
    let n_steps = records.iter().map(|run| run.done().unwrap().record.steps.len()).sum();
    for (name, n_rows) in [("runs", N_RUNS), ("steps", n_steps), ("times", n_steps)] {
        let csv = fs::read_to_string(folder.0.join(format!("{name}.csv"))).unwrap();
        assert_eq!(csv.lines().count(), 1 + n_rows);
        assert!(csv.contains("\nmug,builtin,\"flow, \"\"gamma\"\" 0.5\",0,0,"), "{csv}");
        #[cfg(feature = "parquet")]
        assert_eq!(parquet_table::as_csv(&folder.0.join(format!("{name}.parquet"))), csv);
    }
    let runs = tables::runs(&records).unwrap();
    let names: Vec<&str> = runs.columns().iter().map(|(name, _)| name.as_str()).collect();
    let identity = ["object", "data_set", "variant", "seed", "view_seed", "first_view"];
    assert_eq!((&names[..6], names[6]), (&identity[..], "config.baseline_seed"));
    let measures = &names[names.iter().position(|name| *name == "build").unwrap()..];
    let expected = "build status reason object_voxels reachable_voxels stop_reason views frames_set_aside \
         voxel_coverage false_voxels map_precision map_recall map_iou reachable_coverage estimated_completeness expected_new_voxels surface_coverage_1mm \
         surface_coverage_2mm surface_coverage_5mm misplaced_mm registration_overlap entropy_nats \
         entropy_share path_length_m trajectory_length_m trajectory_time_s cloud_accuracy_mean_mm \
         cloud_accuracy_median_mm cloud_accuracy_p95_mm cloud_precision_1mm cloud_precision_2mm \
         cloud_precision_5mm cloud_completeness_1mm cloud_completeness_2mm cloud_completeness_5mm \
         cloud_completeness_mean_mm cloud_recall_1mm cloud_recall_2mm cloud_recall_5mm \
         cloud_reachable_completeness_mean_mm cloud_f_score_1mm cloud_f_score_2mm cloud_f_score_5mm \
         cloud_chamfer_mm alignment_moved_mm alignment_turned_deg skill coverage_auc_views \
         coverage_auc_time views_to_90 views_to_95 views_to_99";
    assert_eq!(measures, expected.split_whitespace().collect::<Vec<_>>());
    for (name, column) in runs.columns() {
        let tables::Column::Float(values) = column else { continue };
        let is_always_known = ["map_", "cloud_", "coverage_auc"].iter().any(|start| name.starts_with(start));
        if is_always_known {
            assert!(values.iter().all(Option::is_some), "{name}: {values:?}");
        }
        if name.starts_with("cloud_accuracy_mean") || name.starts_with("cloud_completeness_2mm") {
            assert!(values.iter().flatten().all(|value| (1e-6..2.0).contains(value)), "{name}: {values:?}");
        }
    }
}

/// Twelve objects, two repetitions of random views from two first views.
const RANDOM: &str = r#"
name = "random"
objects = [OBJECTS]
seeds = [0, 1]
first_views = 2
[scan]
candidates = 60
views = 6
voxel_size_m = 0.02
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
scan.planner = "random"
"#;

/// Random views have skill 0 by definition. If all objects share their draws, the errors of the objects do
/// not cancel out: the intervals of twelve such objects are then 0.07 to 0.33 with the seeds 0 and 1, -0.38
/// to -0.17 with 2 and 3, 0.40 to 0.59 with 4 and 5.
#[test]
fn the_interval_of_the_skill_of_random_views_contains_0() {
    let objects: Vec<String> = (1..=12).map(|n| format!("\"builtin:random-{n}\"")).collect();
    let text = RANDOM.replace("OBJECTS", &objects.join(", "));
    let spec = Spec::parse(&text, Path::new("")).unwrap();
    let list = RunList::new(spec.runs().unwrap().iter());
    execute(&list, 2, None, &Cancel::default()).unwrap();
    let records = list.into_records();
    let study = Study::new(&records);
    let skill = study.variants[0].sample(&measure::SKILL);
    let interval = skill.interval().unwrap();
    assert_eq!((skill.n_objects(), study.n_runs), (12, 48));
    assert!((interval.low..interval.high).contains(&0.0), "{interval:?}");
    assert!(interval.high - interval.low < 0.5, "an interval that says something: {interval:?}");
}

#[test]
fn a_cancelled_campaign_keeps_what_is_finished_and_is_resumed() {
    let folder = Folder::new("cancel");
    let cancel = Cancel::default();
    let mut store = Store::open(&folder.0, &spec(), Shard::WHOLE, false).unwrap();
    let stop_at_third = |event| {
        if let CampaignEvent::RunFinished { run, .. } = event
            && (&run.object[..], run.seed) == ("mug", 1)
        {
            cancel.cancel();
        }
    };
    run_campaign(&mut store, Some(1), None, &cancel, &stop_at_third).unwrap();
    assert_eq!(store.finished().len(), 2, "in one job, the runs come one after the other");
    assert!(store.failed().is_empty());
    drop(store);
    let (store, events) = campaign(&folder, Some(2));
    assert_eq!(events[0], CampaignEvent::Began { n_objects: 2, n_runs: N_RUNS, n_finished: 2 });
    let whole = Folder::new("not-cancelled");
    let (expected, _) = campaign(&whole, Some(2));
    assert_eq!(lasting_tables(&folder, &store), lasting_tables(&whole, &expected));
}

#[test]
fn a_torn_line_is_noted_and_done_again() {
    let folder = Folder::new("torn");
    let (store, _) = campaign(&folder, Some(2));
    let expected = lasting_tables(&folder, &store);
    drop(store);
    let path = folder.0.join("runs.jsonl");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let (store, events) = campaign(&folder, Some(1));
    let note = "the last line of runs.jsonl is incomplete; its run is repeated";
    assert_eq!(events[0], CampaignEvent::Note(note.to_owned()));
    assert_eq!(events[1], CampaignEvent::Began { n_objects: 2, n_runs: N_RUNS, n_finished: N_RUNS - 1 });
    assert_eq!(lasting_tables(&folder, &store), expected);
}

#[test]
fn a_broken_object_does_not_stop_the_others() {
    let folder = Folder::new("broken");
    fs::create_dir_all(&folder.0).unwrap();
    fs::write(folder.0.join("broken.ply"), "ply\n").unwrap();
    fs::write(folder.0.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let objects = r#"objects = ["builtin:mug", "broken.ply", { file = "m.obj", unit = "m", size_m = 9 }]"#;
    let text = SPEC.replace(r#"objects = ["builtin:mug", "builtin:bracket"]"#, objects);
    let spec = Spec::parse(&text, &folder.0).unwrap();
    let mut store = Store::open(&folder.0.join("out"), &spec, Shard::WHOLE, false).unwrap();
    let events = Mutex::new(Vec::new());
    let listener = |event| events.lock().unwrap().push(event);
    run_campaign(&mut store, None, None, &Cancel::default(), &listener).unwrap();
    let failed = store.failed();
    let found: Vec<(&str, usize)> = failed.iter().map(|failed| (&failed.object[..], failed.n_runs)).collect();
    assert_eq!(found, [("broken", 5), ("m", 5)]);
    assert!(failed[0].reason.contains("broken.ply: ") && failed[1].reason.contains("9 m"), "{failed:?}");
    let of_broken = CampaignEvent::ObjectFinished { object: "broken".to_owned(), n_runs: 5, n_failed: 5 };
    assert!(events.lock().unwrap().contains(&of_broken));
    let records = finished(&store);
    let records: Vec<&RunRecord> = records.iter().collect();
    let runs = tables::runs(&records).unwrap();
    let mut csv = Vec::new();
    runs.write_csv(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    assert_eq!((csv.matches(",done,").count(), csv.matches(",failed,").count()), (5, 10), "{csv}");
    assert_eq!(tables::steps(&records).unwrap().n_rows(), 5 * 3);
}

#[test]
fn a_source_that_cannot_keep_a_record_ends_the_execution() {
    struct Broken(RunList, Mutex<usize>);
    impl WorkSource for Broken {
        fn take(&self) -> Result<Option<Vec<nextview_campaign::Run>>, nextview_scan::Fault> {
            self.0.take()
        }

        fn finish(&self, _: RunRecord) -> Result<(), nextview_scan::Fault> {
            *self.1.lock().unwrap() += 1;
            Err(nextview_scan::Fault::data("the disk is full"))
        }
    }
    let source = Broken(RunList::new(spec().runs().unwrap().iter()), Mutex::default());
    let fault = execute(&source, 2, None, &Cancel::default()).unwrap_err();
    assert_eq!(fault.message, "the disk is full");
    assert!(*source.1.lock().unwrap() <= 2, "one run per job");
}

#[cfg(feature = "parquet")]
mod parquet_table {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    use std::fs::File;
    use std::path::Path;

    /// The lines of a table of Parquet as CSV.
    pub fn as_csv(path: &Path) -> String {
        let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
        let line = |fields: Vec<String>| fields.join(",") + "\n";
        let fields = reader.metadata().file_metadata().schema().get_fields().to_vec();
        let head = line(fields.iter().map(|field| field.name().to_owned()).collect());
        let rows = reader.get_row_iter(None).unwrap().map(|row| {
            let row = row.unwrap();
            line(row.get_column_iter().map(|(_, field)| text(field)).collect())
        });
        head + &rows.collect::<String>()
    }

    fn text(field: &Field) -> String {
        match field {
            Field::Null => String::new(),
            Field::Bool(value) => value.to_string(),
            Field::Long(value) => value.to_string(),
            Field::Double(value) => value.to_string(),
            Field::Str(text) if text.contains([',', '"']) => format!("\"{}\"", text.replace('"', "\"\"")),
            Field::Str(text) => text.clone(),
            field => panic!("an unexpected type: {field:?}"),
        }
    }
}
