//! Ctrl-C during resumable work.

use crate::flags::quoted;
use std::path::{Path, PathBuf};

/// The conventional exit code of a program ended by Ctrl-C.
const INTERRUPTED: i32 = 130;

/// Makes Ctrl-C end the program and print the command that resumes its work in this folder, as long as `file`
/// exists. If the shell makes the program ignore Ctrl-C, it still does.
pub fn resumable(command: &str, dir: &Path, file: PathBuf) {
    let command = format!("{command} {}", quoted(dir));
    // The first handler stays: for a turned scan, no command is printed. Failure to set one is ignored.
    _ = ctrlc::try_set_handler(move || {
        if file.exists() {
            eprintln!("\nnote: interrupted; to resume: {command}");
        }
        std::process::exit(INTERRUPTED)
    });
}
