//! Reading a campaign's folder.

use crate::Failure;
use crate::bench::{Measures, RunRecord, RunResult};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The runs of a campaign so far.
#[derive(Clone, Debug)]
pub(crate) struct Campaign {
    /// The folder's name.
    pub name: String,
    /// Sorted by variant, object, seed and first view; each run once.
    pub runs: Vec<RunRecord>,
    /// Whether the last line of the file was not whole yet, and was left out.
    pub torn: bool,
}

/// What tells a run from all others of its campaign: variant, object, seed and first view.
pub(crate) type RunKey = (String, String, u64, usize);

/// The key of a run.
pub(crate) fn key(run: &RunRecord) -> RunKey {
    (run.variant.clone(), run.object.clone(), run.seed, run.first_view)
}

/// What was measured of a run; none if it failed.
pub(crate) fn measures(run: &RunRecord) -> Option<&Measures> {
    match &run.result {
        RunResult::Done(measures) => Some(measures),
        RunResult::Failed(_) => None,
    }
}

impl Campaign {
    /// Reads `runs.jsonl` in this folder. A last line without an end may be half written, since the campaign may still be
    /// running, and is left out then. Of a run that was repeated, the last record counts.
    pub fn read(dir: &Path) -> Result<Self, Failure> {
        let path = dir.join("runs.jsonl");
        let hint = "expected a campaign's folder, as `nextview bench` writes it";
        let bytes = fs::read(&path)
            .map_err(|e| Failure::data(format!("cannot be read: {e}")).in_file(&path).with_hint(hint))?;
        let (records, torn) = parse(&bytes).map_err(|failure| failure.in_file(&path))?;
        if records.is_empty() {
            let none = Failure::data("holds no finished run").in_file(&path);
            return Err(none.with_hint("wait until the campaign has finished its first run"));
        }
        let runs: BTreeMap<RunKey, RunRecord> = records.into_iter().map(|run| (key(&run), run)).collect();
        Ok(Self { name: name(dir), runs: runs.into_values().collect(), torn })
    }
}

fn name(dir: &Path) -> String {
    let full = fs::canonicalize(dir).unwrap_or_else(|_| dir.to_owned());
    full.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn parse(bytes: &[u8]) -> Result<(Vec<RunRecord>, bool), Failure> {
    let mut runs = Vec::new();
    for (i, line) in bytes.split_inclusive(|&b| b == b'\n').enumerate() {
        match serde_json::from_slice::<RunRecord>(line) {
            Ok(run) => runs.push(run),
            Err(_) if !line.ends_with(b"\n") => return Ok((runs, true)),
            Err(_) if line.trim_ascii().is_empty() => (),
            Err(error) => return Err(malformed(i + 1, &error)),
        }
    }
    Ok((runs, false))
}

fn malformed(line: usize, error: &serde_json::Error) -> Failure {
    // The error names its place in the text it was given, which is always the first line of one.
    let text = error.to_string();
    let problem = text.split(" at line ").next().unwrap_or_default();
    Failure::data(format!("line {line}, column {}: {problem}, expected the record of a run", error.column()))
        .with_hint("was it written by another version of nextview?")
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    fn lines(n: usize) -> Vec<u8> {
        let runs = made_up::campaign(&["a"], n).runs;
        runs.iter().flat_map(|run| (serde_json::to_string(run).unwrap() + "\n").into_bytes()).collect()
    }

    #[test]
    fn whole_lines_are_read_and_a_torn_one_is_left_out() {
        let whole = lines(3);
        let (runs, torn) = parse(&whole).unwrap();
        assert_eq!((runs, torn), (made_up::campaign(&["a"], 3).runs, false));
        for end in [whole.len() - 2, whole.len() - 500] {
            let (runs, torn) = parse(&whole[..end]).unwrap();
            assert_eq!((runs.len(), torn), (2, true));
        }
        let (runs, torn) = parse(&whole[..whole.len() - 1]).unwrap();
        assert_eq!((runs.len(), torn), (3, false), "only the end of the line is missing");
        assert_eq!(parse(b"\n").unwrap(), (vec![], false));
    }

    #[test]
    fn a_malformed_line_is_named() {
        let mut bytes = lines(2);
        bytes.extend_from_slice(b"{\"object\": 3}\n");
        let error = parse(&bytes).unwrap_err().to_string();
        assert!(error.contains("line 3, column 12: invalid type: integer `3`, expected a string"), "{error}");
        bytes.splice(0..1, *b"[");
        assert!(parse(&bytes).unwrap_err().to_string().contains("line 1, "));
    }

    #[test]
    fn a_run_that_was_repeated_counts_once() {
        let dir = made_up::folder("repeated");
        let mut failed = made_up::campaign(&["a"], 1).runs.remove(0);
        failed.result = RunResult::Failed("no memory".to_owned());
        let mut bytes = (serde_json::to_string(&failed).unwrap() + "\n").into_bytes();
        bytes.extend(lines(2));
        fs::write(dir.join("runs.jsonl"), bytes).unwrap();
        let campaign = Campaign::read(&dir).unwrap();
        fs::remove_dir_all(&dir).unwrap();
        assert_eq!(campaign.runs, made_up::campaign(&["a"], 2).runs);
    }

    #[test]
    fn a_folder_without_runs_is_told() {
        let dir = made_up::folder("no-runs");
        let error = |dir| Campaign::read(dir).unwrap_err().to_string();
        assert!(error(&dir).contains("runs.jsonl: cannot be read") && error(&dir).contains("nextview bench"));
        fs::write(dir.join("runs.jsonl"), "").unwrap();
        assert!(error(&dir).contains("holds no finished run"));
        fs::remove_dir_all(&dir).unwrap();
    }
}
