//! The commands on the pages are valid: the program knows their options and values, and the files of this
//! repository that they name exist.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use clap::Parser;
use clap::error::ErrorKind;
use nextview_cli::commands::Cli;
use std::fs;
use std::path::PathBuf;

/// Folders of this repository whose files commands name.
const FOLDERS: [&str; 7] =
    [".ci/", "benchmarks/", "contrib/", "crates/", "examples/", "python/", "training/"];

fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Name and text of README.md and of the pages below docs and python.
fn pages() -> Vec<(String, String)> {
    let mut pages = Vec::new();
    for folder in ["", "docs", "docs/methods", "docs/planner", "python"] {
        for entry in fs::read_dir(workspace().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "md") {
                let name = path.strip_prefix(workspace()).unwrap().display().to_string();
                pages.push((name, fs::read_to_string(path).unwrap()));
            }
        }
    }
    pages
}

/// The lines of the blocks of shell commands, joined where a backslash continues them.
fn shell_lines(page: &str) -> Vec<String> {
    let blocks = page.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let joined = blocks.map(|block| block.replace("\\\n", " "));
    joined.flat_map(|block| block.lines().map(str::to_owned).collect::<Vec<_>>()).collect()
}

/// Quotations between single backticks that begin as commands; values may be missing.
fn quoted(page: &str) -> Vec<String> {
    let prose: String = page.split("```").step_by(2).collect();
    let quotations = prose.split('`').skip(1).step_by(2).map(|quotation| quotation.replace('\n', " "));
    quotations.filter(|quotation| quotation.starts_with("nextview ")).collect()
}

/// The words of each command of a line, without comment, redirections and variables set before it.
fn commands(line: &str) -> Vec<Vec<String>> {
    let words = shlex::split(line).unwrap_or_else(|| panic!("an open quotation: {line}"));
    let command = |part: &[String]| {
        let words = part.iter().take_while(|word| !word.starts_with('>'));
        let is_variable = |word: &&String| word.contains('=') && !word.starts_with('-');
        words.skip_while(is_variable).cloned().collect::<Vec<_>>()
    };
    let parts = words.split(|word| ["&&", "|", ";"].contains(&word.as_str()));
    parts.map(command).filter(|command| !command.is_empty()).collect()
}

/// The fault of a command; `None` if it is valid, or not a command of the program.
fn fault(command: &[String]) -> Option<clap::Error> {
    let arguments = match command {
        [program, ..] if program == "nextview" => command,
        [cargo, run, rest @ ..] if cargo == "cargo" && run == "run" => {
            let place = rest.iter().position(|word| word == "--")?;
            // If nothing is named, the program runs.
            let names = ["-p", "--package", "--bin", "--example", "--manifest-path"];
            let is_program = !rest[..place].iter().any(|word| names.contains(&word.as_str()));
            is_program.then_some(&rest[place..])?
        }
        _ => return None,
    };
    if arguments.get(1).is_some_and(|word| word == "COMMAND") {
        return None;
    }
    let parsed = Cli::try_parse_from(arguments.iter().filter(|word| *word != "..."));
    let error = parsed.err()?;
    let is_fine = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    (!is_fine).then_some(error)
}

fn is_unknown(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand)
}

/// The files of this repository that a command names and that are missing.
fn missing_files(command: &[String]) -> Vec<&String> {
    let is_ours = |word: &&String| FOLDERS.iter().any(|folder| word.starts_with(folder));
    let is_pattern = |word: &&String| word.contains(['*', '[']);
    let ours = command.iter().filter(is_ours).filter(|word| !is_pattern(word));
    ours.filter(|word| !workspace().join(word).exists()).collect()
}

#[test]
fn commands_on_the_pages_are_accepted() {
    let (mut faults, mut n) = (Vec::new(), 0);
    for (page, text) in pages() {
        let whole = shell_lines(&text).into_iter().map(|line| (line, true));
        for (line, is_whole) in whole.chain(quoted(&text).into_iter().map(|line| (line, false))) {
            for command in commands(&line) {
                n += usize::from(command[0] == "nextview");
                let fault = fault(&command).filter(|fault| is_whole || is_unknown(fault.kind()));
                faults.extend(fault.map(|fault| format!("{page}: {line}\n{fault}")));
                let missing = missing_files(&command);
                faults.extend(missing.iter().map(|file| format!("{page}: {line}\n{file} is missing")));
            }
        }
    }
    assert!(n > 60, "only {n} commands of the program found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn lines_are_cut_as_a_shell_cuts_them() {
    let cut = |line| commands(line).iter().map(|words| words.join("|")).collect::<Vec<_>>();
    assert_eq!(cut("A=1 nextview scan 'a b' --json > x # note"), ["nextview|scan|a b|--json"]);
    assert_eq!(cut("nextview bench x && nextview report y"), ["nextview|bench|x", "nextview|report|y"]);
    assert!(cut("# only a comment").is_empty());
}

#[test]
fn a_misspelt_option_is_a_fault() {
    let fault = |line| fault(&commands(line)[0]);
    assert!(fault("nextview scan part.stl --unit mm").is_none());
    assert!(is_unknown(fault("nextview scan part.stl --units mm").unwrap().kind()));
    assert!(fault("cargo run --release -- scan --view 3").is_some());
    assert!(fault("cargo run -p nextview-training -- --view 3").is_none(), "another program");
    assert!(fault("cargo install --locked").is_none());
    assert_eq!(missing_files(&commands("benchmarks/no.sh x")[0]), ["benchmarks/no.sh"]);
}
