//! A command never overwrites its input, and overwrites results only on request.

use crate::common::{Folder, RESULT_FILES};
use crate::recording::write_recording;
use nextview_scan::ScanJournal;
use std::process::Stdio;
use std::time::{Duration, Instant};

const TETRAHEDRON: &str =
    "OFF\n4 4 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// A scan of the object in the folder, which takes a second.
const QUICK: [&str; 6] =
    ["--candidates=9", "--views=1", "--baselines=off", "--unit=m", "--voxel-size-m", "0.02"];

/// That scan with these arguments before and after.
fn scan<'a>(before: &[&'a str], after: &[&'a str]) -> Vec<&'a str> {
    [&["scan"], before, &QUICK[..], after].concat()
}

/// The scan is refused immediately with this message, and everything stays unchanged.
fn refused(folder: &Folder, args: &[&str], out: &str, parts: &[&str]) {
    let contents = |folder: &Folder| -> Vec<(String, Vec<u8>)> {
        let names = folder.names(out).into_iter().filter(|name| !name.ends_with('/'));
        names.map(|name| (name.clone(), folder.bytes(&format!("{out}/{name}")))).collect()
    };
    let before = contents(folder);
    let start = Instant::now();
    let run = folder.run(args);
    assert!(start.elapsed() < Duration::from_secs(8), "{args:?}");
    assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""), "{args:?}: {}", run.stderr);
    for part in parts {
        assert!(run.stderr.contains(part), "{args:?}: expected {part:?} in {}", run.stderr);
    }
    assert!(contents(folder) == before, "{args:?} changed something");
}

/// As a PLY file, which may have the name of a result.
fn ply() -> String {
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
     element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned()
        + &TETRAHEDRON.lines().skip(2).map(|line| format!("{line}\n")).collect::<String>()
}

#[test]
fn a_scan_keeps_what_it_reads_whatever_is_forced() {
    let folder = Folder::new("keep-inputs");
    folder.write("mesh.ply", ply());
    folder.write("views.csv", "0.4,0,0.1\n0,0.4,0.1\n");
    folder.write("config.toml", "views = 1\n");
    write_recording(&folder, 2);
    for more in [&[][..], &["--force"]] {
        // The number of candidates is that of the file, or of the frames.
        let scan = |args: &[&'static str]| [&["scan"], args, &QUICK[1..], &["--out", "."], more].concat();
        let read = "is an input, and would be overwritten\nhint: choose another folder (--out)";
        refused(&folder, &scan(&["mesh.ply"]), ".", &["error: ./mesh.ply: ", read]);
        refused(&folder, &scan(&["builtin:mug", "--view-space", "views.csv"]), ".", &["./views.csv: ", read]);
        refused(&folder, &scan(&["builtin:mug", "--config", "config.toml"]), ".", &["./config.toml: ", read]);
        let all = ["mesh.ply", "--view-space=views.csv", "--config=config.toml"];
        refused(&folder, &scan(&all), ".", &["./mesh.ply: ", "./views.csv: ", "./config.toml: "]);
        let recorded = ["--frames=rec", "--truth=mesh.ply"];
        refused(&folder, &scan(&recorded), ".", &["./mesh.ply: ", read]);
    }
}

#[cfg(unix)]
#[test]
fn an_input_is_kept_under_all_its_names() {
    let folder = Folder::new("keep-links");
    folder.write("part.ply", ply());
    std::fs::create_dir(folder.path("out")).unwrap();
    let scan = |mesh, out| scan(&[mesh], &["--out", out, "--force"]);
    std::os::unix::fs::symlink("../part.ply", folder.path("out/mesh.ply")).unwrap();
    refused(&folder, &scan("part.ply", "out"), "out", &["out/mesh.ply: is an input"]);
    refused(&folder, &scan("out/mesh.ply", "out"), "out", &["out/mesh.ply: is an input"]);
    std::fs::remove_file(folder.path("out/mesh.ply")).unwrap();
    std::fs::hard_link(folder.path("part.ply"), folder.path("out/mesh.ply")).unwrap();
    refused(&folder, &scan("part.ply", "out"), "out", &["out/mesh.ply: is an input"]);
    std::os::unix::fs::symlink("out", folder.path("linked")).unwrap();
    refused(&folder, &scan("out/mesh.ply", "linked"), "out", &["linked/mesh.ply: is an input"]);
    assert_eq!(folder.text("part.ply"), ply());
}

#[test]
fn results_are_replaced_only_by_force() {
    let folder = Folder::new("keep-results");
    let scan = |args: &[&'static str]| scan(&["builtin:mug"], args);
    folder.ok(&scan(&["--out=out"]));
    let parts = ["error: out: already holds results: config.toml, record.json, ", "replace them (--force)"];
    refused(&folder, &scan(&["--out=out"]), "out", &parts);
    folder.ok(&scan(&["--out=out", "--force", "--planner=random"]));
    assert!(folder.text("out/config.toml").contains("planner = \"random\""));
    assert_eq!(folder.names("out"), RESULT_FILES);
    // A single file of such a name is enough.
    folder.write("other/report.html", "mine");
    refused(&folder, &scan(&["--out=other"]), "other", &["other: already holds results: report.html"]);
}

#[test]
fn the_same_command_works_again() {
    let folder = Folder::new("keep-default");
    let scan = scan(&["builtin:mug"], &[]);
    let told: Vec<String> = (0..3).map(|_| folder.ok(&scan)).collect();
    let names = ["scan-mug-most-surface", "scan-mug-most-surface-2", "scan-mug-most-surface-3"];
    for (told, name) in told.iter().zip(names) {
        assert!(told.ends_with(&format!("\nresults in {name} (open report.html there)\n")), "{told}");
        assert_eq!(folder.names(name), RESULT_FILES);
    }
    let told = folder.ok(&[&scan[..], &["--force"]].concat());
    assert!(told.contains("results in scan-mug-most-surface ("), "{told}");
    assert_eq!(folder.names(".").len(), 3);
    // The next numbered folder holds an interrupted scan, which must be resumed, not skipped.
    folder.write("scan-mug-most-surface-4/scan.journal", "frames");
    let parts = ["scan-mug-most-surface-4: holds an interrupted scan", "--resume scan-mug-most-surface-4"];
    refused(&folder, &scan, "scan-mug-most-surface-4", &parts);
}

/// A user who followed advice to remove the journal there would destroy a scan in progress.
#[test]
fn a_folder_that_is_being_scanned_is_not_taken() {
    let folder = Folder::new("keep-busy");
    let busy =
        ["out", "scan-mug-most-surface"].map(|name| ScanJournal::begin(&folder.path(name), "").unwrap());
    let run = folder.run(&scan(&["builtin:mug"], &["--out=out", "--force"]));
    let told = "error: out: is in use by a running scan, here or in another process\nhint: choose another \
                folder (--out), or wait until that scan is finished\n";
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (Some(1), "", told));
    let run = folder.run(&["scan", "--resume", "out"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), told));
    folder.ok(&scan(&["builtin:mug"], &[]));
    assert_eq!(folder.names("scan-mug-most-surface-2"), RESULT_FILES);
    drop(busy);
}

#[test]
fn two_commands_at_once_take_two_folders() {
    let folder = Folder::new("keep-two");
    let begin = || folder.command(&scan(&["builtin:mug"], &[])).stdout(Stdio::null()).spawn().unwrap();
    for mut process in [begin(), begin()] {
        assert!(process.wait().unwrap().success());
    }
    assert_eq!(folder.names("."), ["scan-mug-most-surface-2/", "scan-mug-most-surface/"]);
    for name in ["scan-mug-most-surface", "scan-mug-most-surface-2"] {
        assert_eq!(folder.names(name), RESULT_FILES);
    }
}

#[test]
fn single_files_are_replaced_only_by_force() {
    let folder = Folder::new("keep-files");
    folder.write("views.csv", "mine");
    let views = ["views", "--count=3", "--out=views.csv"];
    refused(&folder, &views, ".", &["views.csv: already exists", "hint: ", "replace this one (--force)"]);
    folder.ok(&[&views[..], &["--force"]].concat());
    assert!(folder.text("views.csv").starts_with("x_m,y_m,z_m,"));
    assert_eq!(folder.run(&["views", "--force"]).code, Some(2), "nothing to replace");

    folder.ok(&scan(&["builtin:mug"], &["--out=out"]));
    folder.ok(&["map", "convert", "out/map.ot", "a.bt"]);
    refused(&folder, &["map", "convert", "out/map.ot", "a.bt"], ".", &["a.bt: already exists"]);
    folder.ok(&["map", "convert", "out/map.bt", "a.bt", "--force"]);
    for more in [&[][..], &["--force"]] {
        let same = [&["map", "convert", "a.bt", "./out/../a.bt"], more].concat();
        refused(&folder, &same, ".", &["./out/../a.bt: is an input, and would be overwritten"]);
    }
}

#[test]
fn a_report_replaces_reports_of_campaigns() {
    let folder = Folder::new("keep-reports");
    let spec = "name = \"one\"\nobjects = [\"builtin:mug\"]\n[scan]\nviews = 1\ncandidates = 9\nvoxel_size_m = 0.02\n\
                baselines = false\n";
    folder.write("one.toml", spec);
    folder.ok(&["bench", "one.toml"]);
    folder.ok(&["report", "bench-one"]);
    folder.ok(&["report", "bench-one"]);
    // The page of a scan, and texts of someone else.
    let others = [
        ("report.html", "<!DOCTYPE html>\n<title>mug</title>"),
        ("report.md", "# Mine\n"),
        ("objects.csv", "mug\n"),
    ];
    for (name, text) in others {
        folder.write(&format!("bench-one/{name}"), text);
        let parts = ["bench-one: already holds results: ", name, "replace them (--force)"];
        refused(&folder, &["report", "bench-one"], "bench-one", &parts);
        folder.ok(&["report", "bench-one", "--force"]);
    }
}
