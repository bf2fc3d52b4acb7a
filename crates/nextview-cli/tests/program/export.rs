//! Results of a scan in the formats of other tools.

use crate::common::Folder;
use crate::recording::{SCAN, write_colors, write_recording};

/// Every format, and a file that it has.
const FORMATS: [(&str, &str); 7] = [
    ("bop", "train/000001/mask_visib/000001_000000.png"),
    ("colmap", "sparse/0/points3D.bin"),
    ("foundationpose", "cam_in_ob/000001.txt"),
    ("nerfstudio", "transforms.json"),
    ("open3d", "trajectory.log"),
    ("pcd", "cloud.pcd"),
    ("tum", "groundtruth.txt"),
];

#[test]
fn a_scan_is_written_in_every_form() {
    let folder = Folder::new("export-formats");
    write_recording(&folder, 3);
    write_colors(&folder, 3);
    folder.run(&SCAN);
    for (format, file) in FORMATS {
        let printed = folder.ok(&["export", "out", "--to", format, "--out", format]);
        assert_eq!(printed, format!("3 views as {format} in {format}\n"));
        assert!(folder.path(&format!("{format}/{file}")).is_file(), "{format}");
        let again = folder.run(&["export", "out", "--to", format, "--out", format]);
        assert!(
            again.code == Some(1) && again.stderr.contains("(--out), or replace them (--force)"),
            "{again:?}"
        );
        folder.ok(&["export", "out", "--to", format, "--out", format, "--force"]);
    }
    // The exported sequence is a recording itself.
    folder.ok(&["scan", "--frames", "tum", "--voxel-size-m", "0.01", "--out=back"]);
}

#[test]
fn what_cannot_be_exported_is_named() {
    let folder = Folder::new("export-faults");
    write_recording(&folder, 2);
    write_colors(&folder, 1);
    folder.run(&SCAN);
    let refused = |args: &[&str], code: i32, parts: &[&str]| {
        let run = folder.run(&[&["export"], args].concat());
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.stderr);
        parts.iter().for_each(|part| assert!(run.stderr.contains(part), "{part:?} in {}", run.stderr));
        assert!(!folder.path("x").exists(), "{args:?} left something");
    };
    refused(
        &["rec", "--to", "tum", "--out=x"],
        1,
        &["rec: holds no results of a scan", "name the folder that a scan has written"],
    );
    refused(&["out", "--to", "tum", "--out=out"], 1, &["out: is the folder of the results", "(--out)"]);
    refused(&["out", "--to", "ply", "--out=x"], 2, &["[possible values: bop, colmap, foundationpose,"]);
    for format in ["colmap", "foundationpose", "nerfstudio"] {
        let message = format!("frame 2 has no colour image, and {format} is of no use without");
        refused(&["out", "--to", format, "--out=x"], 1, &[&message]);
    }
    let note = folder.run(&["export", "out", "--to", "bop", "--out=bop"]).stderr;
    assert_eq!(note, "note: 1 of 2 frames have no colour image\n");
    folder.write("out/mesh.ply", "ply\nformat ternary 1.0\nend_header\n");
    refused(&["out", "--to", "bop", "--out=x"], 1, &["out/mesh.ply: line 2: ", "ternary"]);
    std::fs::rename(folder.path("out/frames"), folder.path("elsewhere")).unwrap();
    refused(&["out", "--to", "bop", "--out=x"], 1, &["out: holds no frames of the scan", "scan again"]);
    std::fs::remove_file(folder.path("out/record.json")).unwrap();
    refused(
        &["out", "--to", "bop", "--out=x"],
        1,
        &["out: holds no results of a scan: there is no record.json"],
    );
}

#[test]
fn frames_of_ones_own_are_not_replaced() {
    let folder = Folder::new("export-own-frames");
    folder.write("out/frames/notes.txt", "mine");
    let run = folder.run(&["scan", "builtin:mug", "--views=1", "--out=out", "--force"]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("out/frames: holds notes.txt, which a scan would remove"), "{}", run.stderr);
    assert_eq!(folder.bytes("out/frames/notes.txt"), b"mine");
}
