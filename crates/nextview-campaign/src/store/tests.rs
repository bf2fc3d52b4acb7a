use super::*;
use crate::{Run, RunRecord, RunResult, Shard, Spec, synthetic};
use nextview_scan::Faults;
use std::fs;
use std::path::{Path, PathBuf};

fn spec() -> Spec {
    let text = "name = \"x\"\nobjects = [\"builtin:mug\", \"builtin:bracket\"]\nseeds = [0, 1]\n";
    Spec::parse(text, Path::new("")).unwrap()
}

/// The record of a run as this build would write it.
fn record(run: &Run) -> RunRecord {
    RunRecord {
        object: run.id.object.clone(),
        data_set: run.data_set.clone(),
        variant: run.id.variant.clone(),
        seed: run.id.seed,
        view_seed: run.id.view_seed,
        first_view: run.id.first_view,
        config: run.config.clone(),
        ..synthetic::campaign(&["a"], 1).remove(0)
    }
}

fn records_of_spec() -> Vec<RunRecord> {
    spec().runs().unwrap().iter().map(|run| record(&run)).collect()
}

fn line(record: &RunRecord) -> String {
    serde_json::to_string(record).unwrap() + "\n"
}

/// All records, read from disk.
fn all(records: &RunRecords) -> Vec<RunRecord> {
    records.iter().collect::<Result<_, _>>().unwrap()
}

/// A folder with these lines of records.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let dir = synthetic::folder(name);
        fs::write(dir.join(Spec::FILE), spec().to_toml().unwrap()).unwrap();
        Self(dir)
    }

    fn with(self, text: impl AsRef<[u8]>) -> Self {
        fs::write(self.0.join(RUNS), text).unwrap();
        self
    }

    fn text(&self) -> String {
        fs::read_to_string(self.0.join(RUNS)).unwrap()
    }

    fn resume(&self) -> Result<Store, Faults> {
        Store::open(&self.0, &spec(), Shard::WHOLE, true)
    }

    /// The faults reported by a reader and on resuming.
    fn faults(&self) -> [String; 2] {
        [read(&self.0).unwrap_err().to_string(), self.resume().unwrap_err().to_string()]
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Otherwise the next run of the tests does it.
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn what_is_appended_is_read() {
    let folder = Folder::new("append");
    let records = records_of_spec();
    let mut store = Store::open(&folder.0, &spec(), Shard::WHOLE, false).unwrap();
    assert!(store.finished().is_empty() && store.share() == [vec![0, 1], vec![2, 3]]);
    for (n, record) in records.iter().rev().zip(1..) {
        store.append(n).unwrap();
        assert_eq!(store.finished().len(), record);
    }
    let read = read(&folder.0).unwrap();
    assert!(!read.torn && read.name.starts_with("nextview-campaign-append"));
    let mut sorted = records.clone();
    sorted.sort_by_key(RunRecord::id);
    assert_eq!(all(&read.runs), sorted);
    assert_eq!(all(&store.finished()), records, "in the order of the runs");
    drop(store);
    assert_eq!(all(&folder.resume().unwrap().finished()), records);
    let lines = super::records(&folder.0).unwrap().map(|stored| stored.map(|stored| stored.line));
    assert_eq!(lines.collect::<Result<Vec<_>, _>>().unwrap(), [1, 2, 3, 4]);
}

#[test]
fn a_torn_line_is_left_out_by_readers_and_cut_by_who_resumes() {
    let records = records_of_spec();
    let whole: String = records.iter().map(line).collect();
    let last = line(&records[3]).len();
    for n_missing in [1, 40, last - 1] {
        let folder = Folder::new(&format!("torn-{n_missing}")).with(&whole[..whole.len() - n_missing]);
        let stored = read(&folder.0).unwrap();
        assert_eq!((stored.runs.len(), stored.torn), (3, true));
        let mut store = folder.resume().unwrap();
        assert!(store.was_torn() && !store.is_finished(3) && store.finished().len() == 3);
        assert_eq!(folder.text(), whole[..whole.len() - last]);
        store.append(&records[3]).unwrap();
        assert_eq!(folder.text(), whole);
        drop(store);
        assert!(!folder.resume().unwrap().was_torn());
    }
}

#[test]
fn a_malformed_line_is_named_wherever_it_is() {
    let records = records_of_spec();
    let good = line(&records[0]);
    for (text, expected) in [
        (
            format!("{good}{{\"object\": 3}}\n{good}"),
            "runs.jsonl, line 2, column 12: invalid type: integer `3`, expected",
        ),
        (
            format!("{good}{{\"object\": 3}}\n"),
            "runs.jsonl, line 2, column 12: invalid type: integer `3`, expected a string",
        ),
        (format!("{}\n", good.replace('}', "")), "runs.jsonl, line 1, column "),
        (format!("{good}\n"), "runs.jsonl, line 2, column 1: EOF while parsing a value"),
        // A file changed by an editor has no torn line, which would be cut.
        (
            good.replace('\n', "\r"),
            "runs.jsonl, line 1, column 1: has a byte order mark or a carriage return",
        ),
        (
            format!("\u{feff}{good}"),
            "runs.jsonl, line 1, column 1: has a byte order mark or a carriage return",
        ),
    ] {
        let folder = Folder::new("malformed").with(&text);
        for fault in folder.faults() {
            assert!(fault.contains(expected), "{expected} in {fault}");
        }
        assert_eq!(folder.text(), text, "nothing is deleted");
    }
}

#[test]
fn equal_repeated_records_count_once() {
    let records = records_of_spec();
    let mut again = records[1].clone();
    again.host.name = "another".to_owned();
    synthetic::done_mut(&mut again).extra_memory_mb = None;
    synthetic::steps_mut(&mut again)[2].plan_time_ms += 1.0;
    let text: String = [&records[1], &records[0], &again].map(line).concat();
    let folder = Folder::new("equal").with(&text);
    assert_eq!(read(&folder.0).unwrap().runs.len(), 2);
    let mut store = folder.resume().unwrap();
    assert_eq!(all(&store.finished()), records[..2]);
    store.append(&again).unwrap();
    assert_eq!(folder.text(), text, "a third time is no line more");
}

#[test]
fn unequal_repeated_records_name_both_lines() {
    let records = records_of_spec();
    let unequal = |change: fn(&mut RunRecord)| {
        let mut again = records[1].clone();
        change(&mut again);
        let folder = Folder::new("unequal").with([&records[1], &records[0], &again].map(line).concat());
        (read(&folder.0).unwrap_err().to_string(), again, folder)
    };
    let (fault, again, folder) = unequal(|run| synthetic::steps_mut(run)[2].entropy_nats += 1.0);
    for fault in [fault, folder.resume().unwrap_err().to_string()] {
        assert!(fault.contains("runs.jsonl, line 3, column 1: lines 1 and 3 have different"), "{fault}");
        assert!(
            fault.contains("object mug, variant most-surface, seed 1") && fault.contains("results differ"),
            "{fault}"
        );
    }
    let folder = folder.with(line(&records[1]));
    let fault = folder.resume().unwrap().append(&again).unwrap_err().to_string();
    assert!(
        fault.contains("already a different record of object mug") && fault.contains("results differ"),
        "{fault}"
    );
    assert_eq!(folder.text(), line(&records[1]));

    let (fault, ..) = unequal(|run| run.config.views = Some(3));
    assert!(fault.contains("lines 1 and 3") && fault.contains("views is 10 and 3"), "{fault}");
    let (fault, ..) = unequal(|run| run.build.source = "feed".to_owned());
    assert!(fault.contains("lines 1 and 3") && fault.contains("feed"), "{fault}");
    let (fault, ..) = unequal(|run| run.result = RunResult::Failed("no memory".to_owned()));
    assert!(fault.contains("lines 1 and 3"), "{fault}");
}

#[test]
fn records_of_another_build_are_read_but_not_resumed() {
    let mut records = records_of_spec();
    records[1].build.source = "feed".to_owned();
    let folder = Folder::new("build").with(records.iter().map(line).collect::<String>());
    assert_eq!(read(&folder.0).unwrap().runs.len(), 4);
    let fault = folder.resume().unwrap_err().to_string();
    let [theirs, ours] = [&records[1], &records[0]].map(|record| record.build.to_string());
    assert!(fault.contains("runs.jsonl, line 2, column 1: object mug") && theirs != ours, "{fault}");
    assert!(fault.contains(&format!("by build {theirs}, but this is build {ours}")), "{fault}");
    let folder = folder.with("");
    let fault = folder.resume().unwrap().append(&records[1]).unwrap_err().to_string();
    assert!(fault.contains(&theirs) && folder.text().is_empty(), "{fault}");
}

#[test]
fn one_process_writes_at_a_time() {
    let folder = Folder::new("lock").with(line(&records_of_spec()[0]));
    let store = folder.resume().unwrap();
    let faults = folder.resume().unwrap_err();
    assert!(faults.to_string().contains("another process is writing there"), "{faults}");
    assert!(faults.iter().all(|fault| fault.remedy.is_some()));
    assert_eq!(read(&folder.0).unwrap().runs.len(), 1, "who reads does not mind");
    drop(store);
    folder.resume().unwrap();
}

#[test]
fn what_a_kill_left_of_tables_and_specification_is_removed() {
    let folder = Folder::new("remnants").with(line(&records_of_spec()[0]));
    let path = |name: &str| folder.0.join(name);
    let left = [".runs.csv.12.partial", ".times.csv.12.partial", ".spec.toml.12.partial"];
    left.iter().for_each(|name| fs::write(path(name), "half").unwrap());
    fs::write(path(".mine.12.partial"), "kept").unwrap();
    folder.resume().unwrap();
    assert!(left.iter().all(|name| !path(name).exists()) && path(".mine.12.partial").exists());
}

#[test]
fn a_folder_is_that_of_one_campaign() {
    let records = records_of_spec();
    let folder = Folder::new("one").with(line(&records[0]));
    let faults = Store::open(&folder.0, &spec(), Shard::WHOLE, false).unwrap_err();
    assert!(faults.to_string().contains("already has the results of a campaign"), "{faults}");
    let mut other = spec();
    other.seeds.push(2);
    let faults = Store::open(&folder.0, &other, Shard::WHOLE, true).unwrap_err();
    assert!(faults.to_string().contains("spec.toml: the folder belongs to another"), "{faults}");
    assert!(faults.to_string().contains("seeds is [0, 1] there, [0, 1, 2] here"), "{faults}");

    let refused = |record: &RunRecord, part: &str| {
        let folder = Folder::new("stranger").with([&records[0], record].map(line).concat());
        let fault = folder.resume().unwrap_err().to_string();
        assert!(fault.contains("line 2") && fault.contains(part), "{part} in {fault}");
        assert_eq!(read(&folder.0).unwrap().runs.len(), 2);
    };
    refused(&RunRecord { seed: 9, ..records[1].clone() }, "no run of this campaign: object mug");
    let mut other = records[1].clone();
    other.config.views = Some(4);
    refused(&other, "has a different configuration in the folder: views is 4 there, 10 here");
    let mut chosen = records[1].clone();
    chosen.config.voxel_size_m = Some(0.003);
    let folder = folder.with(line(&chosen));
    assert_eq!(all(&folder.resume().unwrap().finished()), [chosen], "the voxel size is chosen in the run");
}

#[test]
fn a_folder_without_runs_is_no_campaign_to_read() {
    let folder = Folder::new("none");
    let faults = read(&folder.0).unwrap_err();
    assert!(faults.to_string().contains("runs.jsonl: cannot be read"), "{faults}");
    let folder = folder.with("");
    let faults = read(&folder.0).unwrap_err();
    assert!(faults.to_string().contains("runs.jsonl: holds no finished run"), "{faults}");
    assert!(faults.iter().all(|fault| fault.remedy.is_some()));
    assert!(
        folder.resume().unwrap().finished().is_empty(),
        "a campaign that was killed at its beginning is resumed"
    );
}
