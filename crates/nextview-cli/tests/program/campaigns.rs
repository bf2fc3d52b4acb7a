//! `report` and `compare` on folders that are not campaigns; their content is tested where it is computed.

use crate::common::Folder;

#[test]
fn a_folder_without_runs_is_told() {
    let folder = Folder::new("campaigns-none");
    folder.write("a/runs.jsonl", "");
    for args in [&["report", "b"][..], &["compare", "b", "a"], &["report", "a"], &["compare", "a", "b"]] {
        let run = folder.run(args);
        assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""));
        let path = format!("{}/runs.jsonl: ", args[1]);
        assert!(run.stderr.starts_with(&format!("error: {path}")), "{}", run.stderr);
        assert!(run.stderr.contains("\nhint: "), "{}", run.stderr);
    }
    assert_eq!(folder.names("a"), ["runs.jsonl"]);
}

#[test]
fn a_malformed_run_is_named_by_file_and_line() {
    let folder = Folder::new("campaigns-malformed");
    folder.write("a/runs.jsonl", "{\"object\": 7}\n");
    let run = folder.run(&["report", "a"]);
    assert_eq!(run.code, Some(1));
    let expected = "error: a/runs.jsonl, line 1, column 12: invalid type: integer `7`, expected a string";
    assert!(run.stderr.starts_with(expected), "{}", run.stderr);
}
