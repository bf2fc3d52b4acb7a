//! What Ctrl-C does to work that can be resumed.

use crate::flags::quoted;
use std::path::{Path, PathBuf};

/// The exit code of a program that Ctrl-C ended, as shells have it.
const INTERRUPTED: i32 = 130;

/// From now on, Ctrl-C ends the program with the command that resumes its work in this folder, as long as
/// `file` exists. Where the shell has the program ignore Ctrl-C, it still does.
pub fn resumable(command: &str, dir: &Path, file: PathBuf) {
    let command = format!("{command} {}", quoted(dir));
    // The first handler stays: of a scan that was turned, no command is printed. Without any, there is none.
    _ = ctrlc::try_set_handler(move || {
        if file.exists() {
            eprintln!("\nnote: interrupted; to resume: {command}");
        }
        std::process::exit(INTERRUPTED)
    });
}
