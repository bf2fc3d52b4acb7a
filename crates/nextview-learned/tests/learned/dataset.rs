//! The folder of a data set.
#![cfg(feature = "dataset")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview_learned::dataset::{DatasetConfig, DatasetError, NetworkName, make};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// More than a file of objects.
const CONFIG: DatasetConfig = DatasetConfig { network: NetworkName::NbvNet, objects: 65, seed: 0 };

const FILES: [&str; 3] = ["dataset.toml", "objects-0000000.npy", "objects-0000064.npy"];

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("nextview-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn contents(folder: &Path) -> Vec<Vec<u8>> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, FILES);
    FILES.iter().map(|file| fs::read(folder.join(file)).unwrap()).collect()
}

fn make_in(folder: &Path, resume: bool, n_threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
    let n_done = AtomicUsize::new(0);
    let progress = || _ = n_done.fetch_add(1, Ordering::Relaxed);
    pool.install(|| make(&CONFIG, folder, resume, progress)).unwrap();
    assert_eq!(n_done.into_inner(), 65);
}

#[test]
fn a_data_set_is_the_same_bytes_for_any_number_of_threads_and_after_interruptions() {
    let Folder(folder) = &Folder::new("dataset");
    make_in(folder, false, 1);
    let whole = contents(folder);
    for (lost, n_threads) in [(&FILES[1..2], 2), (&FILES[..], 3)] {
        lost.iter().for_each(|file| fs::remove_file(folder.join(file)).unwrap());
        make_in(folder, true, n_threads);
        assert!(contents(folder) == whole, "other bytes with {n_threads} threads, without {lost:?}");
    }
}

#[test]
fn a_data_set_is_neither_overwritten_nor_mixed_with_another() {
    let Folder(folder) = &Folder::new("dataset-other");
    let one = DatasetConfig { objects: 1, ..CONFIG };
    make(&one, folder, false, || ()).unwrap();
    let before = fs::read(folder.join(FILES[1])).unwrap();
    let error = |config, resume| make(&config, folder, resume, || ()).unwrap_err();
    assert!(matches!(error(one, false), DatasetError::Exists { .. }));
    let of_another = DatasetConfig { network: NetworkName::PcNbv, ..one };
    for other in [DatasetConfig { objects: 2, ..one }, DatasetConfig { seed: 3, ..one }, of_another] {
        let error = error(other, true);
        assert!(matches!(&error, DatasetError::Differs { found, .. } if *found == one));
        assert!(
            error.to_string().ends_with("dataset.toml: the data set has objects = 1, seed = 0, for nbv-net"),
            "{error}"
        );
    }
    fs::write(folder.join(FILES[0]), "objects = 1\nseeds = 0\n").unwrap();
    let malformed = error(one, true).to_string();
    assert!(malformed.contains("dataset.toml: TOML parse error"), "{malformed}");
    assert_eq!(fs::read(folder.join(FILES[1])).unwrap(), before);
}
