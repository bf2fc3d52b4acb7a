use crate::common::{Folder, Run};
use nextview_checks::skipped;
use std::process::{Command, Stdio};

/// Whether this machine has the program; reports the test as skipped if not.
fn has(test: &str, program: &str) -> bool {
    let is_there = Command::new(program).arg("--version").stdout(Stdio::null()).status().is_ok();
    if !is_there {
        skipped(test, program, format!("{program} is not installed"));
    }
    is_there
}

#[test]
fn every_shell_completes_every_command() {
    let folder = Folder::new("completions");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = folder.ok(&["completions", shell]);
        for word in ["inspect", "nbv-net", "voxel-size-m", "most-surface"] {
            // Elvish completes no values.
            assert!(script.contains(word) || (shell, word) == ("elvish", "most-surface"), "{shell}: {word}");
        }
        folder.write(shell, script);
    }
    let run = folder.run(&["completions", "tcsh"]);
    assert!(run.code == Some(2) && run.stderr.contains("[possible values: bash,"), "{run:?}");
}

#[test]
fn bash_completes_commands_options_and_values() {
    if !has("bash_completes_commands_options_and_values", "bash") {
        return;
    }
    let folder = Folder::new("completions-bash");
    folder.write("script", folder.ok(&["completions", "bash"]));
    for (line, expected) in [
        ("nextview ins", "inspect"),
        ("nextview scan --voxel", "--voxel-size-m"),
        ("nextview map c", "convert"),
    ] {
        let words = line.split(' ').count();
        let mut bash = Command::new("bash");
        bash.args(["--norc", "-c"]).current_dir(folder.path("."));
        bash.arg(format!(
            ". ./script; COMP_WORDS=({line}); COMP_CWORD={}; _nextview nextview \"${{COMP_WORDS[COMP_CWORD]}}\" \"\"
             echo \"${{COMPREPLY[@]}}\"",
            words - 1
        ));
        let run = Run::of(bash);
        assert_eq!((run.stdout.trim(), run.stderr.as_str()), (expected, ""), "{line}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = Folder::new("man");
    let told = folder.ok(&["man", "--out", "man/man1"]);
    let pages = folder.names("man/man1");
    assert_eq!(told, format!("{} manual pages in man/man1\n", pages.len()));
    for page in ["nextview.1", "nextview-scan.1", "nextview-map-info.1", "nextview-man.1"] {
        assert!(pages.iter().any(|name| name == page), "{page} is not in {pages:?}");
    }
    assert!(!pages.iter().any(|name| name.contains("help")), "{pages:?}");
    for page in &pages {
        let text = folder.text(&format!("man/man1/{page}"));
        for section in [".TH nextview", ".SH NAME", ".SH SYNOPSIS", ".SH DESCRIPTION", ".SH OPTIONS"] {
            assert!(text.contains(section), "{page} has no {section}");
        }
    }
    if has("every_command_has_a_manual_page", "groff") {
        for page in &pages {
            let mut groff = Command::new("groff");
            groff.args(["-man", "-ww", "-z"]).arg(folder.path("man/man1").join(page));
            let run = Run::of(groff);
            assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{page}");
        }
    }
    let again = folder.run(&["man", "--out", "man/man1"]);
    assert!(again.code == Some(1) && again.stderr.contains("--force"), "{again:?}");
    assert_eq!(folder.ok(&["man", "--out", "man/man1", "--force"]), told);
}
