use crate::common::Folder;

/// The help of a command is exactly what `tests/program/help` holds. After an intended change, check it and
/// write the file again: `nextview COMMAND --help | cat > FILE`.
fn check(command: &[&str]) {
    let folder = Folder::new(&format!("help{}", command.join("-")));
    let help = folder.ok(&[command, &["--help"]].concat());
    let name = [&["nextview"], command].concat().join("-");
    let path = format!("{}/tests/program/help/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(help, expected, "the help of {command:?} differs from {path}");
    assert!(help.lines().all(|line| line.chars().count() <= 100), "wider than 100 columns");
    let (_, examples) = help.split_once("\nExample").expect("an example");
    assert!(examples.contains(&[&["  nextview"], command].concat().join(" ")), "{examples}");
    assert_eq!(folder.names("."), [""; 0]);
}

#[test]
fn of_the_program() {
    check(&[]);
}

#[test]
fn of_scan() {
    check(&["scan"]);
}

#[test]
fn of_bench() {
    check(&["bench"]);
}

#[test]
fn of_serve() {
    check(&["serve"]);
}

#[test]
fn of_plan() {
    check(&["plan"]);
}

#[test]
fn of_views() {
    check(&["views"]);
}

#[test]
fn of_map() {
    check(&["map"]);
    check(&["map", "info"]);
    check(&["map", "convert"]);
}

#[test]
fn of_report_compare_and_merge() {
    check(&["report"]);
    check(&["compare"]);
    check(&["merge"]);
    check(&["export"]);
    check(&["inspect"]);
}

#[test]
fn of_dataset() {
    check(&["dataset"]);
    check(&["dataset", "nbv-net"]);
    check(&["dataset", "nbv-regression"]);
    check(&["dataset", "pc-nbv"]);
}

#[test]
fn names_all_built_in_objects() {
    let help = Folder::new("help-objects").ok(&["scan", "--help"]);
    let words: Vec<&str> = help.split(|c: char| !c.is_alphanumeric() && c != '-').collect();
    assert!(nextview_sim::builtin::names().all(|name| words.contains(&name)));
}

#[test]
fn no_command_shows_the_help_as_an_error() {
    let run = Folder::new("help-none").run(&[]);
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
    assert!(run.stderr.contains("Usage: nextview [OPTIONS] <COMMAND>"));
}

#[test]
fn of_completions_and_man() {
    check(&["completions"]);
    check(&["man"]);
}

#[test]
fn the_version_names_the_build() {
    let folder = Folder::new("version");
    let short = format!("nextview {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(folder.ok(&["-V"]), format!("{short}\n"));
    let long = folder.ok(&["--version"]);
    let build = long.strip_prefix(&format!("{short} (")).and_then(|rest| rest.strip_suffix(")\n"));
    let parts: Vec<&str> = build.unwrap_or_default().split(", ").collect();
    let [source, target, profile] = parts[..] else { panic!("{long}") };
    assert_eq!(source, nextview_scan::BuildIdentity::this().source);
    assert!(target.starts_with(std::env::consts::ARCH) && !profile.is_empty(), "{long}");
}
