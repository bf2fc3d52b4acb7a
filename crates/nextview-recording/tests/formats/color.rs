//! Colour images beside the depth.

use crate::jpeg::jpeg;
use crate::synthetic::{Folder, SyntheticRecording, png};
use nextview_recording::{Recording, RecordingError};
use png::{BitDepth, ColorType};
use std::fs;

/// The colour of a pixel of a frame.
fn color(frame: u8, u: u32, v: u32) -> [u8; 3] {
    [u as u8, v as u8, frame]
}

fn color_png(frame: u8) -> Vec<u8> {
    let bytes: Vec<u8> = (0..80 * 60).flat_map(|i| color(frame, i % 80, i / 80)).collect();
    png(80, 60, ColorType::Rgb, BitDepth::Eight, &bytes)
}

/// The third number of each frame's colour, which is its own; none for frames without.
fn numbers(recording: &Recording) -> Vec<Option<u8>> {
    let load = |frame: &nextview_recording::RecordedFrame| {
        let image = frame.load_color().unwrap();
        assert_eq!(image.is_some(), frame.has_color());
        image.map(|image| {
            let [u, v, number] = image.get(33, 21);
            assert_eq!((u, v, image.width(), image.height()), (33, 21, 80, 60));
            number
        })
    };
    recording.frames.iter().map(load).collect()
}

/// A folder of our own form with three frames.
fn plain(name: &str) -> Folder {
    let folder = Folder::new(&format!("color-{name}"));
    SyntheticRecording::new(3).write_folder(&folder);
    folder
}

#[test]
fn a_folder_may_have_colour() {
    let folder = plain("folder");
    assert_eq!(numbers(&folder.open().unwrap()), [None; 3]);
    for i in 0..3 {
        folder.write(&format!("color/{i:03}.png"), color_png(i + 5));
    }
    folder.write("color/notes.txt", "");
    let recording = folder.open().unwrap();
    assert_eq!((numbers(&recording), recording.notes.len()), (vec![Some(5), Some(6), Some(7)], 0));
    fs::remove_file(folder.0.join("color/001.png")).unwrap();
    let recording = folder.open().unwrap();
    assert_eq!(numbers(&recording), [Some(5), None, Some(7)]);
    assert_eq!(recording.notes, ["1 of 3 frames have no colour image"]);
    fs::remove_dir_all(folder.0.join("color")).unwrap();
    assert_eq!(numbers(&folder.open().unwrap()), [None; 3]);
}

#[test]
fn colour_may_be_jpeg() {
    let folder = Folder::new("color-jpeg");
    let mut synthetic = SyntheticRecording::new(1);
    synthetic.camera =
        nextview::sensor::Intrinsics::pinhole(80, 64, synthetic.camera.focal(), synthetic.camera.center())
            .unwrap();
    synthetic.images[0].extend([0; 80 * 4]);
    synthetic.write_folder(&folder);
    let block = |x: u16, y: u16| [25 * x as u8, 30 * y as u8, 200];
    folder.write("color/000.jpg", jpeg(80, 64, block));
    let image = folder.open().unwrap().frames[0].load_color().unwrap().unwrap();
    for (u, v) in [(0, 0), (79, 0), (33, 21), (5, 63), (79, 63)] {
        let [expected, found] = [block(u as u16 / 8, v as u16 / 8), image.get(u, v)];
        assert!(expected.iter().zip(found).all(|(a, b)| a.abs_diff(b) <= 2), "{expected:?} {found:?}");
    }
    let whole = jpeg(80, 64, block);
    for length in [2, 30, 150, whole.len() / 2, whole.len() - 20] {
        folder.write("color/000.jpg", &whole[..length]);
        let cut = error(folder.open());
        assert!(cut.contains("color/000.jpg: is not a complete JPEG image"), "{length}: {cut}");
    }
    for i in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[i] ^= 1 << (i % 8);
        folder.write("color/000.jpg", damaged);
        _ = folder.open(); // whatever it says, it does not panic
    }
    folder.write("color/000.png", color_png(1));
    let error = folder.open().unwrap_err().to_string();
    assert!(error.contains("color/000.png: frame 0 already has an image"), "{error}");
}

#[test]
fn tum_has_colour_at_its_own_times() {
    let folder = Folder::new("color-tum");
    SyntheticRecording::new(4).write_tum(&folder);
    (0..4).for_each(|i| folder.write(&format!("rgb/{i}.png"), color_png(i)));
    // 15 ms off; just beyond 20 ms; there is no such file; nearer to another.
    folder.write(
        "rgb.txt",
        "# color images\n1305031102.015 rgb/0.png\n1305031102.1201 rgb/1.png\n1305031102.2 rgb/9.png\n\
         1305031102.31 rgb/2.png\n1305031102.295 rgb/3.png\n",
    );
    let recording = folder.open().unwrap();
    assert_eq!(numbers(&recording), [Some(0), None, None, Some(3)]);
    assert_eq!(recording.notes, ["2 of 4 frames have no colour image"]);
    folder.replace("rgb.txt", "rgb/9.png", "rgb/9.png x");
    assert!(error(folder.open()).contains("rgb.txt: line 4: 3 words, expected `timestamp file`"));
}

fn error(outcome: Result<Recording, RecordingError>) -> String {
    outcome.unwrap_err().to_string()
}

#[test]
fn images_that_are_no_colour_are_refused() {
    let folder = plain("faults");
    let with = |name: &str, image: &[u8]| {
        folder.write(name, image);
        let error = error(folder.open());
        fs::remove_file(folder.0.join(name)).unwrap();
        error
    };
    let plain = |color, depth, n: usize| png(80, 60, color, depth, &vec![7; 80 * 60 * n]);
    let gray = with("color/001.png", &plain(ColorType::Grayscale, BitDepth::Eight, 1));
    let expected = "color/001.png: is a PNG image of 8 bits, Grayscale, expected colour: 8 bits of red, green and blue each";
    assert!(gray.ends_with(expected), "{gray}");
    let deep = with("color/001.png", &plain(ColorType::Rgb, BitDepth::Sixteen, 6));
    assert!(deep.contains("is a PNG image of 16 bits, Rgb"), "{deep}");
    let transparent = with("color/001.png", &plain(ColorType::Rgba, BitDepth::Eight, 4));
    assert!(transparent.contains("is a PNG image of 8 bits, Rgba"), "{transparent}");
    let small = png(40, 60, ColorType::Rgb, BitDepth::Eight, &[7; 40 * 60 * 3]);
    let small = with("color/001.png", &small);
    assert!(small.contains(
        "001.png: the colour image has 40 x 60 pixels, expected the size of the depth image, 80 x 60"
    ));
    let large = with("color/002.jpg", &jpeg(80, 64, |_, _| [9; 3]));
    assert!(large.contains("002.jpg: the colour image has 80 x 64 pixels"), "{large}");
    let name = with("color/first.jpeg", &[]);
    assert!(name.contains("first.jpeg: is not a frame number, expected names such as 000.png"), "{name}");
    let whole = color_png(1);
    for length in [0, 20, whole.len() / 2, whole.len() - 30] {
        let cut = with("color/001.png", &whole[..length]);
        assert!(cut.contains("color/001.png: is not a complete PNG image"), "{length}: {cut}");
    }
}
