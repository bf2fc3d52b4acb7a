use crate::common::Folder;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Interrupts scans after this number of lines on stdout, and checks what they leave in the folder for their
/// results.
fn interrupt_after(n_lines: usize, name: &str, more: &[&str], left: &[&str]) {
    for out in ["new", "deep/er", "."] {
        let folder = Folder::new(name);
        let args = [&["scan", "builtin:mug", "--voxel-size-m", "0.004", "--out", out], more].concat();
        let mut child = folder.command(&args).stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        (0..n_lines).for_each(|_| drop(lines.next().unwrap().unwrap()));
        let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        assert!(kill.success() && !child.wait().unwrap().success());
        let names = if folder.path(out).exists() { folder.names(out) } else { Vec::new() };
        assert_eq!(names, left, "--out {out}");
    }
}

#[test]
fn during_the_baselines_leaves_nothing_behind() {
    interrupt_after(2, "interrupt-baselines", &["--candidates", "4000"], &[]);
}

#[test]
fn during_the_scan_leaves_its_frames() {
    let long = ["--candidates", "100", "--views", "100", "--baselines", "off"];
    interrupt_after(6, "interrupt-scan", &long, &["scan.journal"]);
}

/// The shell that runs the tests may make them ignore Ctrl-C; `env` undoes that.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_says_how_to_go_on() {
    let folder = Folder::new("ctrl-c");
    let scan = "scan builtin:mug --voxel-size-m 0.004 --candidates 100 --views 100 --baselines off --out";
    let bench = "bench paper-1 builtin:mug builtin:teapot --out";
    for (command, out, resume) in [
        (scan, "a mug", "nextview scan --resume 'a mug'"),
        (bench, "runs", "nextview bench --resume --out runs"),
    ] {
        let mut program = Command::new("env");
        program.args(["--default-signal=INT", env!("CARGO_BIN_EXE_nextview")]);
        program.args(command.split(' ')).arg(out).current_dir(folder.path("."));
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let n_lines = if command == scan { 6 } else { 1 };
        (0..n_lines).for_each(|_| drop(lines.next().unwrap().unwrap()));
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(&format!("note: interrupted; to resume: {resume}\n")), "{said}");
        assert_eq!(output.status.code(), Some(130), "{said}");
    }
}
