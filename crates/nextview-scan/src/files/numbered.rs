use std::path::{Path, PathBuf};

/// The folders `name`, `name-2`, `name-3`, ...: those that are taken, and the first free one.
pub fn numbered(name: &str, is_taken: impl Fn(&Path) -> bool) -> (Vec<PathBuf>, PathBuf) {
    let (mut taken, mut folder) = (Vec::new(), PathBuf::from(name));
    while is_taken(&folder) {
        taken.push(folder);
        folder = PathBuf::from(format!("{name}-{}", taken.len() + 1));
    }
    (taken, folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_begin_with_two() {
        let free = |taken: &[&str]| numbered("scan", |path| taken.iter().any(|name| path == Path::new(name)));
        assert_eq!(free(&[]), (vec![], "scan".into()));
        assert_eq!(free(&["scan"]), (vec!["scan".into()], "scan-2".into()));
        let (taken, free) = free(&["scan", "scan-2", "scan-4"]);
        assert_eq!((taken.len(), free.as_path()), (2, Path::new("scan-3")));
    }
}
