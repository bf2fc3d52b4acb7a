//! File names with `*` in them.

use glob::{MatchOptions, Pattern, glob_with};
use nextview_scan::Fault;
use std::path::{Path, PathBuf};

/// The files that match a path, sorted: `*` matches any characters within a name, except a leading dot, and
/// `**` any folders. A path without `*` stands for itself, even if the file does not exist.
pub(super) fn expand(pattern: &Path) -> Result<Vec<PathBuf>, Fault> {
    let text = pattern.to_string_lossy();
    if !text.contains('*') {
        return Ok(vec![pattern.to_owned()]);
    }
    // Brackets and question marks are common in names, and are literal.
    let escaped = text.split('*').map(Pattern::escape).collect::<Vec<_>>().join("*");
    let options = MatchOptions {
        case_sensitive: true,
        require_literal_separator: true,
        require_literal_leading_dot: true,
    };
    let paths = glob_with(&escaped, options).map_err(|e| Fault::data(e).in_file(pattern))?;
    let mut files: Vec<PathBuf> = paths.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    files.sort();
    if files.is_empty() {
        return Err(Fault::data("matches no file").in_file(pattern));
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_sorted_and_from_all_folders() {
        let folder = std::env::temp_dir().join(format!("nextview-pattern-{}", std::process::id()));
        for name in
            ["b/2.ply", "a/1.ply", "a/3.stl", "a/0.ply/folder", "a/.hidden.ply", "c/[4]?.ply", "c/4x.ply"]
        {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let found = |pattern: &str| expand(&folder.join(pattern)).unwrap();
        let files = |names: &[&str]| names.iter().map(|name| folder.join(name)).collect::<Vec<_>>();
        assert_eq!(found("*/*.ply"), files(&["a/1.ply", "b/2.ply", "c/4x.ply", "c/[4]?.ply"]));
        assert_eq!(found("**/*.stl"), files(&["a/3.stl"]));
        assert_eq!(found("c/[4]*"), files(&["c/[4]?.ply"]));
        assert_eq!(found("none.ply"), files(&["none.ply"]));
        let fault = expand(&folder.join("*.obj")).unwrap_err().to_string();
        assert!(fault.contains("*.obj: matches no file"), "{fault}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
