use crate::common::Folder;
use std::fs;

/// More objects than one file holds.
const MAKE: [&str; 6] = ["dataset", "nbv-net", "--objects", "65", "--out", "data"];

const FILES: [&str; 3] = ["dataset.toml", "objects-0000000.npy", "objects-0000064.npy"];

fn contents(folder: &Folder) -> Vec<Vec<u8>> {
    assert_eq!(folder.names("data"), FILES);
    FILES.iter().map(|file| folder.bytes(&format!("data/{file}"))).collect()
}

#[test]
fn a_data_set_is_the_same_bytes_for_any_number_of_threads_and_after_interruptions() {
    let folder = Folder::new("dataset");
    let told = folder.ok(&[&MAKE[..], &["--threads", "1"]].concat());
    assert_eq!(told, "65 objects in 2 files in data\n");
    let whole = contents(&folder);
    for (lost, threads) in [(&FILES[1..2], "2"), (&FILES[..], "3")] {
        lost.iter().for_each(|file| fs::remove_file(folder.path(&format!("data/{file}"))).unwrap());
        folder.ok(&[&MAKE[..], &["--resume", "--threads", threads]].concat());
        assert!(contents(&folder) == whole, "other bytes with {threads} threads, without {lost:?}");
    }
}

#[test]
fn a_data_set_is_neither_overwritten_nor_mixed_with_another() {
    let folder = Folder::new("dataset-other");
    let make = |more: &[&str]| folder.run(&[&["dataset", "nbv-net", "--out", "data"], more].concat());
    assert_eq!(make(&["--objects", "1"]).stdout, "1 object in 1 file in data\n");
    let before = folder.bytes("data/objects-0000000.npy");
    for (more, expected) in [
        (&["--objects", "1"][..], "--resume"),
        (&["--objects", "2", "--resume"], "has objects = 1, seed = 0"),
        (&["--objects", "1", "--seed", "3", "--resume"], "pass --objects 1 --seed 0"),
    ] {
        let run = make(more);
        assert!(run.code == Some(1) && run.stderr.contains(expected), "{more:?}: {run:?}");
    }
    folder.write("data/dataset.toml", "objects = 1\nseeds = 0\n");
    let run = make(&["--objects", "1", "--resume"]);
    assert!(run.code == Some(1) && run.stderr.contains("dataset.toml: TOML parse error"), "{run:?}");
    assert_eq!(folder.bytes("data/objects-0000000.npy"), before);
    for objects in ["0", "-3", "1000001"] {
        assert_eq!(make(&["--objects", objects]).code, Some(2), "{objects}");
    }
}
