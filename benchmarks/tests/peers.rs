//! `peers.sh` on a tiny workload: our programs, the peers that can be built here, and the tables.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_benchmarks::stage::stages;
use nextview_checks::skipped;
use std::path::Path;
use std::process::Command;

#[test]
fn the_script_runs_and_fills_its_tables() {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers");
    let programs = Path::new(env!("CARGO_BIN_EXE_stages")).parent().unwrap();
    let mut script = Command::new("bash");
    script.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/peers.sh")).arg("bracket");
    script.envs([("QUICK", "1"), ("ROUNDS", "1")]);
    script.env("PROGRAMS", programs).env("CARGO_TARGET_DIR", &scratch).env_remove("WORKLOAD");
    let output = match script.output() {
        Err(error) => {
            return skipped("the_script_runs_and_fills_its_tables", "bash", error);
        }
        Ok(output) => output,
    };
    let [tables, notes] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(output.status.success(), "{notes}\n{tables}");
    for stage in stages() {
        assert!(tables.contains(&format!("\n| {} | {} | ", stage.name, stage.case)), "{stage}: {tables}");
    }
    for (peer, row) in [
        ("octomap", "| read .bt | 5 mm |"),
        ("embree", "| depth image | 16x |"),
        ("bonxai", "| insertion A"),
        ("open3d", "| fuse ten images | 2 mm |"),
        ("small_gicp", "| align an image | 2 mm |"),
    ] {
        let reason = notes.lines().find_map(|line| line.strip_prefix(&format!("skipped: {peer}, ")));
        match reason {
            Some(reason) => skipped("the_script_runs_and_fills_its_tables", peer, reason),
            None => {
                let compared = |line: &&str| line.starts_with(row) && line.contains(&format!(" | {peer} | "));
                assert!(tables.lines().any(|line| compared(&line)), "{peer}: {tables}");
            }
        }
    }
}
