//! Rules for the text of sources and documents.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

/// The crates that front ends share.
const LIBRARIES: [&str; 10] = [
    "nextview-scan",
    "nextview-campaign",
    "nextview-report",
    "nextview-learned",
    "nextview-recording",
    "nextview-robot",
    "nextview-sim",
    "nextview-model",
    "nextview-octomap",
    "nextview",
];

/// Characters of a line of prose.
const WIDTH: usize = 110;

/// Code lines of the program: options, progress and printing, and nothing that another front end would need.
const PROGRAM_LINES: usize = 1700;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn files(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            files(&path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
}

/// The lines of a source before its tests that are neither blank nor comments, with their numbers.
fn code(text: &str) -> Vec<(usize, &str)> {
    let lines = text.lines().take_while(|line| line.trim() != "#[cfg(test)]");
    let is_code = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with("//");
    lines.enumerate().filter(|(_, line)| is_code(line)).map(|(i, line)| (i + 1, line)).collect()
}

/// Sources that read texts in a way of their own: those of the system, and what this program alone writes.
const OWN_TEXTS: [&str; 6] = [
    "nextview/src/text.rs",
    "nextview-campaign/src/host.rs",
    "nextview-checks/src/",
    "nextview-scan/src/journal/entry.rs",
    "nextview-scan/src/memory.rs",
    "nextview-server/src/scans/work.rs",
];

/// Byte order marks, line ends and other encodings are the matter of one place.
#[test]
fn texts_are_read_in_one_way() {
    let mut sources = Vec::new();
    files(&workspace().join("crates"), "rs", &mut sources);
    let is_shared = |path: &Path| {
        let path = path.to_string_lossy();
        path.contains("/src/")
            && !OWN_TEXTS.iter().any(|own| path.contains(own))
            && !path.ends_with("tests.rs")
    };
    let mut faults = Vec::new();
    for path in sources.iter().filter(|path| is_shared(path)) {
        let text = fs::read_to_string(path).unwrap();
        for (number, line) in code(&text) {
            if ["read_to_string", "String::from_utf8("].iter().any(|word| line.contains(word)) {
                faults.push(format!("{}:{number}: {}", path.display(), line.trim()));
            }
        }
    }
    assert!(faults.is_empty(), "expected nextview::text\n{}", faults.join("\n"));
}

#[test]
fn libraries_print_nothing_end_no_process_and_name_no_option() {
    let words = ["println!", "print!", "process::exit", "process::abort", "dbg!", "io::stdout", "io::stderr"];
    let is_option = |line: &str| {
        line.split([' ', '`', '(', '"']).any(|word| {
            word.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
        })
    };
    let mut faults = Vec::new();
    for library in LIBRARIES {
        let mut sources = Vec::new();
        files(&workspace().join("crates").join(library).join("src"), "rs", &mut sources);
        assert!(!sources.is_empty());
        for source in sources.into_iter().filter(|source| !source.ends_with("tests.rs")) {
            let text = fs::read_to_string(&source).unwrap();
            let wrong = |line: &str| words.iter().any(|word| line.contains(word)) || is_option(line);
            let lines = code(&text).into_iter().filter(|(_, line)| wrong(line));
            faults.extend(
                lines.map(|(number, line)| format!("{}:{number}: {}", source.display(), line.trim())),
            );
        }
    }
    assert!(faults.is_empty(), "a front end does that:\n{}", faults.join("\n"));
}

#[test]
fn the_program_is_a_program_and_nothing_else() {
    let mut sources = Vec::new();
    files(&workspace().join("crates/nextview-cli/src"), "rs", &mut sources);
    let lines = |source: &PathBuf| code(&fs::read_to_string(source).unwrap()).len();
    let n_lines: usize = sources.iter().map(lines).sum();
    assert!(n_lines <= PROGRAM_LINES, "{n_lines} code lines, expected at most {PROGRAM_LINES}");
}

#[test]
fn prose_fits_on_a_screen() {
    let mut faults = Vec::new();
    let mut report = |file: &Path, number: usize, line: &str| {
        faults.push(format!("{}:{number}: {} characters", file.display(), line.chars().count()));
    };
    let is_long = |line: &str| line.chars().count() > WIDTH;
    let mut sources = Vec::new();
    files(&workspace(), "rs", &mut sources);
    for source in sources {
        let text = fs::read_to_string(&source).unwrap();
        let mut is_block = false;
        for (i, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let comment = comment.trim_start_matches(['/', '!']).trim_start();
            is_block ^= comment.starts_with("```");
            if is_long(line) && !is_block && !comment.starts_with('|') && !line.contains("://") {
                report(&source, i + 1, line);
            }
        }
    }
    let mut pages = Vec::new();
    files(&workspace(), "md", &mut pages);
    // A report that the program writes is data.
    for page in pages.into_iter().filter(|page| !page.ends_with("golden.md")) {
        let text = fs::read_to_string(&page).unwrap();
        let mut is_block = false;
        for (i, line) in text.lines().enumerate() {
            is_block ^= line.trim_start().starts_with("```");
            let is_prose = !is_block && !line.starts_with("    ") && !line.trim_start().starts_with('|');
            // A link is one word.
            if is_prose && is_long(line) && line.split(' ').all(|word| word.chars().count() < WIDTH / 2) {
                report(&page, i + 1, line);
            }
        }
    }
    assert!(faults.is_empty(), "lines of prose beyond {WIDTH} characters:\n{}", faults.join("\n"));
}

/// The pages, without those in tests, relative to the workspace.
fn pages() -> Vec<PathBuf> {
    let mut pages = Vec::new();
    files(&workspace(), "md", &mut pages);
    let inside = |page: PathBuf| page.strip_prefix(workspace()).unwrap().to_owned();
    pages.into_iter().map(inside).filter(|page| !page.ends_with("golden.md")).collect()
}

/// The lines of a page that are not code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_block = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_block ^= is_fence;
        !is_block && !is_fence && !line.starts_with("    ")
    })
}

/// The links of a page to others, relative to it.
fn links(text: &str) -> Vec<String> {
    let lines: Vec<&str> = prose(text).collect();
    let text = lines.join("\n");
    let links = text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap().to_owned());
    links.filter(|link| !link.contains(':')).collect()
}

/// The anchors of a page: its headings as code hosts write them.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    for heading in prose(text).filter(|line| line.starts_with('#')) {
        // Of a link in a heading, its text.
        let heading: String = heading.split("](").enumerate().fold(String::new(), |text, (i, part)| {
            text + if i == 0 { part } else { part.split_once(')').unwrap().1 }
        });
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let anchor = kept.collect::<String>().replace(' ', "-");
        let n_before = anchors.iter().filter(|other| **other == anchor).count();
        anchors.push(if n_before == 0 { anchor } else { format!("{anchor}-{n_before}") });
    }
    anchors
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut faults = Vec::new();
    for page in pages() {
        let text = fs::read_to_string(workspace().join(&page)).unwrap();
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let folder = workspace().join(page.parent().unwrap());
            let target = if file.is_empty() { workspace().join(&page) } else { folder.join(file) };
            let is_right = match (anchor.is_empty(), fs::read_to_string(&target)) {
                (true, _) => target.exists(),
                (false, Ok(text)) => anchors(&text).iter().any(|other| other == anchor),
                (false, Err(_)) => false,
            };
            if !is_right {
                faults.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(faults.is_empty(), "links that lead nowhere:\n{}", faults.join("\n"));
}

#[test]
fn every_page_is_in_the_book() {
    let summary = fs::read_to_string(workspace().join("docs/SUMMARY.md")).unwrap();
    let listed = links(&summary);
    let resolved = |link: &String| workspace().join("docs").join(link).canonicalize().unwrap();
    let listed: Vec<PathBuf> = listed.iter().map(resolved).collect();
    let is_missing = |page: &PathBuf| {
        !page.ends_with("SUMMARY.md") && !listed.contains(&workspace().join(page).canonicalize().unwrap())
    };
    let missing: Vec<PathBuf> = pages().into_iter().filter(is_missing).collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md does not list {missing:?}");
}

/// Phrases that are not English; `…` stands for a word or two.
const NOT_ENGLISH: [&str; 17] = [
    "The same with",
    "none where",
    "none without",
    "`None` without",
    "as it lies",
    "hangs together with",
    "comes about",
    "that which",
    "whoever",
    "Whoever",
    "is to go to",
    "are to go to",
    "from … on joins",
    "Runs that never happened",
    "beside the truth",
    "All others can add",
    "with what it carries",
];

/// A text in one line, without the marks of comments and continued strings, and the line number of each byte.
fn flat(text: &str) -> (String, Vec<usize>) {
    let (mut flat, mut lines) = (String::new(), Vec::new());
    for (i, line) in text.lines().enumerate() {
        let words = line.split_whitespace();
        for word in words.filter(|word| !["//", "///", "//!", "#", "\\"].contains(word)) {
            flat.push_str(word);
            flat.push(' ');
            lines.resize(flat.len(), i + 1);
        }
    }
    (flat, lines)
}

#[test]
fn comments_messages_and_pages_are_english() {
    const FORMATS: [&str; 12] =
        ["cpp", "hpp", "html", "js", "json", "md", "py", "pyi", "rs", "sh", "toml", "txt"];
    let mut sources = Vec::new();
    FORMATS.iter().for_each(|format| files(&workspace(), format, &mut sources));
    sources.extend(fs::read_dir(workspace().join(".ci")).unwrap().map(|entry| entry.unwrap().path()));
    let is_exempt = |source: &PathBuf| source.ends_with("CHANGELOG.md") || source.ends_with("tests/texts.rs");
    let mut faults = Vec::new();
    for source in sources.into_iter().filter(|source| source.is_file() && !is_exempt(source)) {
        let (text, lines) = flat(&String::from_utf8_lossy(&fs::read(&source).unwrap()));
        for phrase in NOT_ENGLISH {
            let (head, tail) = phrase.split_once('…').unwrap_or((phrase, ""));
            for (at, _) in text.match_indices(head) {
                let after: String = text[at + head.len()..].chars().take(20 + tail.len()).collect();
                if after.contains(tail) {
                    faults.push(format!("{}:{}: {phrase}", source.display(), lines[at]));
                }
            }
        }
    }
    assert!(faults.is_empty(), "expected plain English:\n{}", faults.join("\n"));
}
