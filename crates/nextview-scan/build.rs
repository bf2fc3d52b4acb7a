//! Identifies the sources of this build, for the identity of the build in records.

use std::fs;
use std::hash::Hasher;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates that decide the results of a scan.
const CRATES: [&str; 5] =
    ["nextview", "nextview-sim", "nextview-recording", "nextview-learned", "nextview-scan"];

fn main() {
    let crate_dir = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let root = crate_dir.join("../..");
    // In the repository, the sources of all crates that decide results; in a package of this crate alone, its
    // own sources.
    let is_repository = root.join("crates/nextview-scan/build.rs").exists();
    let folders: Vec<PathBuf> = match is_repository {
        true => CRATES.map(|name| root.join("crates").join(name)).to_vec(),
        false => vec![crate_dir.clone()],
    };
    let mut files = Vec::new();
    for folder in &folders {
        println!("cargo::rerun-if-changed={}", folder.join("src").display());
        collect(&folder.join("src"), &mut files);
        files.push(folder.join("Cargo.toml"));
    }
    if is_repository {
        files.push(root.join("Cargo.lock"));
        println!("cargo::rerun-if-changed={}", root.join("Cargo.lock").display());
    }
    println!("cargo::rerun-if-changed=build.rs");
    files.sort();
    let hash = hash_of(&files, &root);
    println!("cargo::rustc-env=NEXTVIEW_SOURCE={}", commit(&root, is_repository, &hash));
}

/// The commit, with the hash if the sources differ from it; only the hash if there is no repository.
fn commit(root: &Path, is_repository: bool, hash: &str) -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(root).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let head = git(&["rev-parse", "HEAD"]).filter(|_| is_repository && root.join(".git").exists());
    let Some(head) = head else { return format!("sources-{hash}") };
    if let Some(folder) = git(&["rev-parse", "--absolute-git-dir"]) {
        println!("cargo::rerun-if-changed={folder}/HEAD");
        println!("cargo::rerun-if-changed={folder}/logs/HEAD");
    }
    let short = &head[..head.len().min(12)];
    let paths = CRATES.map(|name| format!("crates/{name}"));
    let paths = paths.iter().map(String::as_str).chain(["Cargo.lock"]);
    match git(&["status", "--porcelain", "--"].into_iter().chain(paths).collect::<Vec<_>>()) {
        Some(changes) if changes.is_empty() => short.to_owned(),
        _ => format!("{short}+{hash}"),
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        match path.is_dir() {
            true => collect(&path, files),
            false => files.push(path),
        }
    }
}

/// FNV-1a over names and contents: 12 hexadecimal digits.
fn hash_of(files: &[PathBuf], root: &Path) -> String {
    let mut hasher = Fnv(0xcbf2_9ce4_8422_2325);
    for file in files {
        let name = file.strip_prefix(root).unwrap_or(file);
        hasher.write(name.to_string_lossy().as_bytes());
        hasher.write(&fs::read(file).unwrap_or_default());
    }
    format!("{:012x}", hasher.finish() >> 16)
}

struct Fnv(u64);

impl Hasher for Fnv {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
