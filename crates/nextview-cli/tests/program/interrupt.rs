use crate::common::Folder;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Interrupts a scan after this many lines on stdout.
fn interrupt_after(n_lines: usize, name: &str, more: &[&str]) {
    let folder = Folder::new(name);
    for out in ["new", "deep/new", "."] {
        let args = [&["scan", "builtin:mug", "--voxel-size-m", "0.004", "--out", out], more].concat();
        let mut child = folder.command(&args).stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        (0..n_lines).for_each(|_| drop(lines.next().unwrap().unwrap()));
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(kill.success() && !child.wait().unwrap().success());
        assert_eq!(folder.names("."), [""; 0], "--out {out}");
    }
}

#[test]
fn during_the_baselines_leaves_nothing_behind() {
    interrupt_after(2, "interrupt-baselines", &["--candidates", "4000"]);
}

#[test]
fn during_the_scan_leaves_nothing_behind() {
    interrupt_after(6, "interrupt-scan", &["--candidates", "100", "--views", "100", "--baselines", "off"]);
}
