//! The program, started as by a launch file. `checks/check_node.py` scans with it.

use std::process::Command;

#[test]
fn arguments_that_cannot_be_are_told_at_once_with_the_status_of_a_wrong_call() {
    let output = Command::new(env!("CARGO_BIN_EXE_nextview-ros2"))
        .args(["--ros-args", "--fast", "-r", "a", "-p", "b"])
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert_eq!(told.lines().count(), 3, "{told}");
    assert!(told.contains("'--fast' is not an argument"), "{told}");
    assert!(output.stdout.is_empty());
}
