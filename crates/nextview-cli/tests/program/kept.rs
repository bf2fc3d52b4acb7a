//! Folders written by a program of November 2026 can still be opened: `kept/interrupted`, a scan killed after
//! its first frame; `kept/finished`, a finished scan; `kept/campaign`, two of four runs. Records may gain
//! keys; the folders are never regenerated.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::common::Folder;
use std::fs;
use std::path::Path;

/// A copy of the kept folders, to work in.
fn kept(name: &str) -> Folder {
    fn copy(from: &Path, to: &Path) {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
            let target = to.join(entry.file_name());
            match entry.path().is_dir() {
                true => copy(&entry.path(), &target),
                false => _ = fs::copy(entry.path(), target).unwrap(),
            }
        }
    }
    let folder = Folder::new(name);
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/kept"), &folder.path(""));
    folder
}

#[test]
fn a_kept_journal_is_resumed() {
    let folder = kept("kept-journal");
    let run = folder.run(&["scan", "--resume", "interrupted"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("resuming after 1 frame"), "{}", run.stderr);
    assert_eq!(folder.text("interrupted/views.csv").lines().count(), 1 + 5);
}

#[test]
fn a_kept_scan_is_continued_with_the_object_turned() {
    let folder = kept("kept-scan");
    let record = folder.json(&[
        "scan",
        "--config=scan.toml",
        "--planner=most-surface",
        "--views=2",
        "--table=known",
        "--after=finished",
        "--out=out",
        "--json",
    ]);
    assert!(record["turn"]["residual_mm"].as_f64().unwrap() < 1.0, "{record}");
    assert_eq!(folder.text("out/frames/poses.csv").lines().count(), 1 + 3 + 2, "frames of both placements");
}

#[test]
fn a_kept_campaign_is_reported_but_not_resumed_by_another_build() {
    let folder = kept("kept-campaign");
    let run = folder.run(&["bench", "campaign/spec.toml", "--out=campaign", "--resume"]);
    assert!(run.code == Some(1) && run.stderr.contains("resume with that build"), "{}", run.stderr);
    folder.ok(&["report", "campaign"]);
    assert!(folder.text("campaign/report.md").contains("random"));
}
