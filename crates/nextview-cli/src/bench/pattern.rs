//! File names with `*` in them.

use crate::Failure;
use std::path::{Path, PathBuf};

/// The files that a path stands for, sorted: `*` is any run of characters within a name, but not a leading dot. A path
/// without `*` is what it is, whether there is such a file or not.
pub(super) fn expand(pattern: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !pattern.to_string_lossy().contains('*') {
        return Ok(vec![pattern.to_owned()]);
    }
    let mut paths = vec![PathBuf::new()];
    for component in pattern.components() {
        let name = component.as_os_str().to_string_lossy();
        if name.contains('*') {
            paths = paths.iter().flat_map(|folder| entries(folder, &name)).collect();
        } else {
            paths.iter_mut().for_each(|path| path.push(component));
        }
    }
    paths.retain(|path| path.is_file());
    paths.sort();
    if paths.is_empty() {
        return Err(Failure::data("matches no file").in_file(pattern));
    }
    Ok(paths)
}

/// What matches in a folder; nothing if it cannot be read.
fn entries(folder: &Path, pattern: &str) -> Vec<PathBuf> {
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let names = std::fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.filter(|name| matches(pattern, &name.to_string_lossy())).map(|name| folder.join(name)).collect()
}

fn matches(pattern: &str, name: &str) -> bool {
    if name.starts_with('.') && !pattern.starts_with('.') {
        return false;
    }
    let (first, rest) = pattern.split_once('*').unwrap_or((pattern, ""));
    let (middle, last) = rest.rsplit_once('*').unwrap_or(("", rest));
    let Some(name) = name.strip_prefix(first).and_then(|name| name.strip_suffix(last)) else { return false };
    let mut left = name;
    middle.split('*').all(|part| match left.find(part) {
        Some(at) => {
            left = &left[at + part.len()..];
            true
        }
        None => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_characters() {
        for (pattern, name, expected) in [
            ("*.ply", "bunny.ply", true),
            ("*.ply", "bunny.stl", false),
            ("*.ply", ".hidden.ply", false),
            ("a*", "a", true),
            ("a*a", "a", false),
            ("a*b*c*d", "axxbcd", true),
            ("a*b*c*d", "axxcbd", false),
            ("*bun*", "abunny", true),
            ("**", "any", true),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn files_come_sorted_and_from_all_folders() {
        let folder = std::env::temp_dir().join(format!("nextview-pattern-{}", std::process::id()));
        for name in ["b/2.ply", "a/1.ply", "a/3.stl", "a/0.ply/folder"] {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let found = expand(&folder.join("*/*.ply")).unwrap();
        assert_eq!(found, [folder.join("a/1.ply"), folder.join("b/2.ply")]);
        assert_eq!(expand(&folder.join("none.ply")).unwrap(), [folder.join("none.ply")]);
        let failure = expand(&folder.join("*.obj")).unwrap_err().to_string();
        assert!(failure.contains("*.obj: matches no file"), "{failure}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
