//! What is wrong with a recording is told: an error with its place, or something left out with a reason.

use crate::synthetic::{Folder, SyntheticRecording, png};
use nextview::sensor::Depth;
use png::{BitDepth, ColorType};
use std::fs;

/// A recording of three frames, changed.
fn changed(name: &str, change: impl Fn(&Folder)) -> Result<Vec<String>, String> {
    check(name, |synthetic, folder| synthetic.write_folder(folder), change)
}

fn changed_tum(name: &str, change: impl Fn(&Folder)) -> Result<Vec<String>, String> {
    check(name, |synthetic, folder| synthetic.write_tum(folder), change)
}

/// What was left out, in words, or the error.
fn check(
    name: &str,
    write: impl Fn(&SyntheticRecording, &Folder),
    change: impl Fn(&Folder),
) -> Result<Vec<String>, String> {
    let folder = Folder::new(&format!("faults-{name}"));
    write(&SyntheticRecording::new(3), &folder);
    change(&folder);
    let recording = folder.open().map_err(|error| error.to_string())?;
    recording.frames.iter().for_each(|frame| _ = frame.load().unwrap());
    assert_eq!(recording.frames.len() + recording.skipped.len(), 3);
    Ok(recording.skipped.iter().map(|skipped| skipped.to_string()).collect())
}

fn remove(folder: &Folder, name: &str) {
    fs::remove_file(folder.0.join(name)).unwrap();
}

#[track_caller]
fn assert_error(outcome: Result<Vec<String>, String>, parts: &[&str]) {
    let error = outcome.unwrap_err();
    for part in parts {
        assert!(error.contains(part), "expected {part:?} in {error:?}");
    }
}

#[test]
fn images_that_are_no_depth() {
    let with = |name: &str, image: Vec<u8>| changed(name, |folder| folder.write("depth/001.png", &image));
    let plain = |depth, bytes: usize| png(80, 60, ColorType::Grayscale, depth, &vec![7; 80 * 60 * bytes]);
    assert_error(
        with("8-bit", plain(BitDepth::Eight, 1)),
        &["depth/001.png: is a PNG image of 8 bits without colour, expected depth: 16 bits"],
    );
    let colour = png(80, 60, ColorType::Rgb, BitDepth::Eight, &[7; 80 * 60 * 3]);
    assert_error(with("colour", colour), &["001.png: is a PNG image of 8 bits with colour"]);
    let small = png(40, 60, ColorType::Grayscale, BitDepth::Sixteen, &[7; 40 * 60 * 2]);
    assert_error(
        with("small", small),
        &["001.png: the image has 40 x 60 pixels, but the intrinsics are for 80 x 60"],
    );
    let whole = SyntheticRecording::new(1).png(0);
    for length in [0, 4, 20, whole.len() / 2, whole.len() - 30] {
        assert_error(with("cut", whole[..length].to_vec()), &["001.png: is not a complete PNG image"]);
    }
}

#[test]
fn images_that_show_nothing_are_left_out() {
    let with = |name: &str, value: u8| {
        let image = png(80, 60, ColorType::Grayscale, BitDepth::Sixteen, &[value; 80 * 60 * 2]);
        changed(name, |folder| folder.write("depth/001.png", &image))
    };
    assert_eq!(with("zero", 0).unwrap(), ["frame 1 is left out: no pixel has a depth"]);
    assert_eq!(with("constant", 2).unwrap(), ["frame 1 is left out: every pixel has the depth 0.514 m"]);
    let nothing = changed("nothing", |folder| {
        let image = png(80, 60, ColorType::Grayscale, BitDepth::Sixteen, &[0; 80 * 60 * 2]);
        (0..3).for_each(|i| folder.write(&format!("depth/00{i}.png"), &image));
    });
    assert_error(nothing, &["holds no usable frame; frame 0 is left out: no pixel has a depth"]);
}

#[test]
fn holes_are_left_out() {
    let hole = changed("hole", |folder| remove(folder, "depth/001.png")).unwrap();
    let why = "the pose of frame 1 (poses.csv, line 3) is left out: depth/ has no image with that number";
    assert_eq!(hole, [why]);
    let extra = changed("extra", |folder| {
        let poses = folder.text("poses.csv");
        folder.write("poses.csv", poses.lines().take(3).collect::<Vec<_>>().join("\n"));
    });
    assert_eq!(extra.unwrap(), ["the image of frame 2 is left out: poses.csv has no row for that frame"]);
    let moved = changed_tum("moved", |folder| {
        folder.replace("groundtruth.txt", "1305031102.1050", "1305031102.1249")
    });
    let why = "depth/1305031102.1000.png (depth.txt, line 4) is left out: the nearest pose (line 4) is 25 ms away in time, \
               more than 20 ms";
    assert_eq!(moved.unwrap(), [why]);
    let missing = changed_tum("missing", |folder| remove(folder, "depth/1305031102.1000.png")).unwrap();
    assert!(missing[0].ends_with("the file does not exist"), "{missing:?}");
}

#[test]
fn twins_are_told_by_both_lines() {
    assert_error(
        changed("twin", |folder| folder.replace("poses.csv", "\n1,", "\n0,")),
        &["poses.csv: line 3: frame 0 is already in line 2"],
    );
    assert_error(
        changed("twin-image", |folder| folder.write("depth/1.png", "")),
        &["depth/1.png: frame 1 already has an image", "depth/001.png"],
    );
    assert_error(
        changed_tum("twin-time", |folder| {
            folder.replace("depth.txt", "1305031102.1000 ", "1305031102.0000 ")
        }),
        &["depth.txt: line 4: has the same timestamp, 1305031102, as line 3"],
    );
}

#[test]
fn files_that_are_missing_cut_or_strange() {
    assert_error(
        changed("no-lens", |folder| remove(folder, "intrinsics.txt")),
        &["intrinsics.txt: cannot be read", "expected a line each for width, height"],
    );
    assert_error(
        changed("no-poses", |folder| remove(folder, "poses.csv")),
        &["is not a recording, expected a folder"],
    );
    assert_error(
        changed("cut-poses", |folder| {
            let poses = folder.text("poses.csv");
            folder.write("poses.csv", &poses[..poses.len() - 40]);
        }),
        &["poses.csv: line 4: ", "columns, expected 13"],
    );
    assert_error(
        changed("name", |folder| folder.write("depth/first.png", "")),
        &["first.png: is not a frame number"],
    );
    assert_error(
        changed("binary", |folder| folder.write("poses.csv", [0x61, 0x0a, 0xff])),
        &["poses.csv: byte 2 in line 2: is not UTF-8 text"],
    );
    assert_error(
        changed("utf-16", |folder| folder.write("poses.csv", [0xff, 0xfe])),
        &["poses.csv: byte 0: is text in UTF-16, expected UTF-8"],
    );
    assert_error(
        changed_tum("no-truth", |folder| remove(folder, "groundtruth.txt")),
        &["groundtruth.txt: cannot be read"],
    );
    assert_error(
        changed_tum("empty", |folder| folder.write("depth.txt", "# nothing\n")),
        &["holds no usable frame"],
    );
    assert_error(
        changed_tum("scaled", |folder| {
            folder.replace("groundtruth.txt", " 0 0 0 0 0 0 1\n", " 900 0 0 0 0 0 1\n")
        }),
        &["groundtruth.txt: line 3: the position is 900 m from the origin", "is it in millimetres?"],
    );
}

#[test]
fn masks_make_what_they_leave_out_free() {
    let mask = |value: u8| {
        let half: Vec<u8> = (0..60 * 80).map(|i| if i % 80 < 40 { 0 } else { value }).collect();
        png(80, 60, ColorType::Grayscale, BitDepth::Eight, &half)
    };
    let folder = Folder::new("faults-masks");
    SyntheticRecording::new(2).write_folder(&folder);
    let plain = folder.open().unwrap().frames[0].load().unwrap();
    fs::create_dir_all(folder.0.join("mask")).unwrap();
    folder.write("mask/000.png", mask(255));
    let masked = folder.open().unwrap();
    let skipped: Vec<String> = masked.skipped.iter().map(|skipped| skipped.to_string()).collect();
    assert_eq!(skipped, ["frame 1 is left out: mask/ has no image with that number"]);
    let masked = masked.frames[0].load().unwrap();
    for v in 0..60 {
        (0..40).for_each(|u| assert_eq!(masked.image().get(u, v), Depth::Beyond));
        (40..80).for_each(|u| assert_eq!(masked.image().get(u, v), plain.image().get(u, v)));
    }
    folder.write("mask/001.png", mask(0));
    let empty = folder.open().unwrap().skipped;
    assert_eq!(empty[0].to_string(), "frame 1 is left out: the mask covers no pixel with a depth");
    folder.write("mask/001.png", png(80, 60, ColorType::Grayscale, BitDepth::Sixteen, &[1; 80 * 60 * 2]));
    let error = folder.open().unwrap_err().to_string();
    assert!(error.ends_with("mask/001.png: is a PNG image of 16 bits without colour, expected a mask: 8 bits a pixel without colour"), "{error}");
}

/// Notepad and spreadsheets put a byte order mark before the first line.
#[test]
fn a_byte_order_mark_is_no_part_of_a_text() {
    let marked = changed("mark", |folder| {
        for name in ["poses.csv", "intrinsics.txt"] {
            folder.write(name, format!("\u{feff}{}", folder.text(name)));
        }
    });
    assert_eq!(marked, Ok(Vec::new()));
}
