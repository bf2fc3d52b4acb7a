//! Devices and pipes may never end, so they are refused immediately wherever a file is read.

use crate::common::{Folder, Run, small};
use crate::recording::{SCAN, write_recording};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::Command;
use std::time::{Duration, Instant};

/// Maximum time to refuse.
const AT_ONCE: Duration = Duration::from_secs(8);

impl Folder {
    /// Makes a pipe that nobody writes to, in place of an existing file.
    fn pipe(&self, name: &str) {
        let _ = std::fs::remove_file(self.path(name));
        assert!(Command::new("mkfifo").arg(self.path(name)).status().unwrap().success());
    }

    /// Runs a command that must end at once with exit code 1 and name the file; it is killed otherwise.
    fn refuses_pipe(&self, args: &[&str], name: &str) {
        let mut command = self.command(args);
        let mut child = command
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if start.elapsed() > AT_ONCE {
                child.kill().unwrap();
                panic!("{args:?} waits for {name}");
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {stderr}");
        assert!(stderr.contains(name), "{args:?}: expected {name} in {stderr}");
    }
}

#[test]
fn as_input_of_every_kind() {
    let folder = Folder::new("irregular");
    folder.ok(&small(&["--views", "1", "--baselines", "off"]));
    folder.write("views.csv", "0.4,0,0.1\n");
    folder.write("weights.toml", "planner = \"nbv-net\"\nnbv_net.weights = \"pipe\"\n");
    folder.pipe("pipe");
    folder.pipe("pipe.ply");
    for file in ["pipe", "/dev/zero"] {
        folder.refuses_pipe(&["scan", "--config", file], file);
        folder.refuses_pipe(&["scan", "builtin:mug", "--view-space", file], file);
        folder.refuses_pipe(&["scan", "--frames", file], file);
        folder.refuses_pipe(&["bench", file], file);
        folder.refuses_pipe(&["plan", "--map", "out/map.ot", "--views", file], file);
        folder.refuses_pipe(&["plan", "--map", file, "--views", "views.csv"], file);
        folder.refuses_pipe(&["map", "info", file], file);
        folder.refuses_pipe(&["map", "convert", file, "new.ot"], file);
    }
    folder.refuses_pipe(&["scan", "pipe.ply"], "pipe.ply");
    folder.refuses_pipe(&["scan", "builtin:mug", "--config", "weights.toml"], "pipe");
    for name in ["runs.jsonl", "spec.toml", "scan.journal", "dataset.toml"] {
        std::fs::create_dir_all(folder.path(name)).unwrap();
        folder.pipe(&format!("{name}/{name}"));
    }
    folder.refuses_pipe(&["report", "runs.jsonl"], "runs.jsonl");
    folder.refuses_pipe(&["bench", "paper-1", "--out", "runs.jsonl"], "runs.jsonl");
    folder.refuses_pipe(&["bench", "--resume", "--out", "spec.toml"], "spec.toml");
    folder.refuses_pipe(&["scan", "--resume", "scan.journal"], "scan.journal");
    folder.refuses_pipe(&["dataset", "nbv-net", "--resume", "--out", "dataset.toml"], "dataset.toml");
}

#[test]
fn as_a_part_of_a_recording() {
    for name in ["intrinsics.txt", "poses.csv", "depth/001.png", "color/001.png", "mask/001.png"] {
        let folder = Folder::new(&format!("irregular-{}", name.replace('/', "-")));
        write_recording(&folder, 3);
        if let Some((images, _)) = name.split_once('/') {
            std::fs::create_dir_all(folder.path(&format!("rec/{images}"))).unwrap();
            if images == "mask" {
                ["000.png", "002.png"].iter().for_each(|mask| folder.pipe(&format!("rec/mask/{mask}")));
            }
        }
        folder.pipe(&format!("rec/{name}"));
        folder.refuses_pipe(&SCAN, name.split_once('/').map_or(name, |(images, _)| images));
    }
    let folder = Folder::new("irregular-truth");
    write_recording(&folder, 3);
    folder.pipe("pipe");
    let with_truth = [&SCAN[..], &["--truth=mug.obj", "--unit=m", "--truth-from-world=pipe"]].concat();
    folder.refuses_pipe(&with_truth, "pipe");
}

/// Configurations and results are text, and contain names of files.
#[test]
fn names_that_are_no_text_are_refused() {
    let folder = Folder::new("not-unicode");
    let name = OsStr::from_bytes(b"part-\xff.obj");
    std::fs::write(folder.path(".").join(name), "v 0 0 0\n").unwrap();
    for before in
        [&["scan"][..], &["scan", "--frames"], &["scan", "--view-space"], &["bench"], &["bench", "paper-1"]]
    {
        let mut command = folder.command(before);
        command.arg(name);
        let run = Run::of(command);
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{}", run.stderr);
        let parts = ["part-\u{fffd}.obj", "the name is not Unicode: rename the file"];
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{}", run.stderr);
    }
}
