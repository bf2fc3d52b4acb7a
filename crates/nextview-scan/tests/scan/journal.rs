//! Journals are read back bit for bit, and damage loses only what follows it.

use crate::common::Folder;
use glam::{DQuat, DVec2, DVec3};
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use nextview::sensor::{Depth, DepthImage, Distortion, Frame, Intrinsics};
use nextview_scan::{Journal, JournalEntry, Kept, KeptFrame, SkippedView};
use std::fs;
use std::path::PathBuf;

const HEADING: &str = "views = 3\n";

/// An image of surfaces, missing pixels and free pixels, from an arbitrary pose.
fn frame(seed: u64) -> Frame {
    let mut random = Random::new(seed, 0);
    let camera = Intrinsics::pinhole(13, 7, DVec2::new(10.3, 9.7), DVec2::new(6.1, 3.2)).unwrap();
    let camera = camera.with_distortion(Distortion::BrownConrady([0.1, -0.2, 0.003, 0.004, 0.05])).unwrap();
    let depth = (0..13 * 7).map(|i| match i % 5 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        _ => (random.in_cube().x + 2.0) as f32,
    });
    let image = DepthImage::from_metres(13, 7, depth.collect()).unwrap();
    let rotation = DQuat::from_scaled_axis(random.in_cube());
    Frame::new(image, camera, Pose::new(rotation, random.in_cube() + DVec3::X).unwrap(), 1.0 / 3.0).unwrap()
}

/// The frame of this seed, as it is kept.
fn kept(view: Option<usize>, seed: u64) -> KeptFrame {
    KeptFrame {
        view,
        was_asked: seed != 1,
        frame: frame(seed),
        color: None,
        name: (seed == 2).then(|| "second".to_owned()),
    }
}

fn skipped() -> SkippedView {
    SkippedView { view: 7, reason: "the arm is in the way".to_owned(), was_decided: true }
}

fn frames(kept: &Kept) -> Vec<&KeptFrame> {
    let frames = kept.entries.iter().filter_map(|entry| match entry {
        JournalEntry::Frame(kept) => Some(&**kept),
        JournalEntry::Skip(_) => None,
    });
    frames.collect()
}

fn assert_same(frame: &Frame, expected: &Frame) {
    let bits = |frame: &Frame| {
        let image = frame.image();
        let bits = |(u, v)| match image.get(u, v) {
            Depth::Surface(depth) => depth.to_bits() as u64,
            other => u64::MAX - (other == Depth::Beyond) as u64,
        };
        (0..7).flat_map(|v| (0..13).map(move |u| (u, v))).map(bits).collect::<Vec<u64>>()
    };
    assert_eq!(bits(frame), bits(expected));
    assert_eq!(frame.world_from_camera(), expected.world_from_camera());
    assert_eq!(frame.intrinsics(), expected.intrinsics());
    assert_eq!(frame.range(), expected.range());
}

/// A journal of three frames, for view 0, no view and view 2; and where each entry ends.
fn journal(folder: &Folder) -> (PathBuf, Vec<usize>) {
    let path = folder.path("a.journal");
    let mut journal = Journal::create(&path, HEADING).unwrap();
    let length = || fs::metadata(&path).unwrap().len() as usize;
    let mut ends = vec![length()];
    for (seed, view) in [(0, Some(0)), (1, None), (2, Some(2))] {
        journal.keep(&kept(view, seed)).unwrap();
        ends.push(length());
    }
    (path, ends)
}

/// The number of frames found, which must be the first ones, unchanged.
fn n_whole(kept: &Kept) -> usize {
    assert_eq!(kept.heading, HEADING);
    for (i, found) in frames(kept).into_iter().enumerate() {
        assert_same(&found.frame, &frame(i as u64));
        assert_eq!((found.view, found.was_asked), ([Some(0), None, Some(2)][i], i != 1));
    }
    kept.entries.len()
}

#[test]
fn frames_come_back_to_the_bit() {
    let folder = Folder::new("journal-whole");
    let (path, _) = journal(&folder);
    for n in 3..5 {
        let (mut journal, found) = Journal::open(&path).unwrap();
        assert!(found.damage.is_none());
        let frames = frames(&found);
        assert_eq!(frames.len(), n);
        assert_same(&frames[n - 1].frame, &frame(n as u64 - 1));
        journal.keep(&kept(Some(n), n as u64)).unwrap();
    }
}

#[test]
fn skipped_views_are_kept_in_their_place() {
    let folder = Folder::new("journal-skip");
    let path = folder.path("a.journal");
    let mut journal = Journal::create(&path, HEADING).unwrap();
    journal.keep(&kept(Some(0), 0)).unwrap();
    journal.skip(&skipped()).unwrap();
    journal.keep(&kept(Some(2), 2)).unwrap();
    drop(journal);
    let (_, found) = Journal::open(&path).unwrap();
    assert!(matches!(&found.entries[1], JournalEntry::Skip(entry) if *entry == skipped()));
    assert_eq!((found.entries.len(), frames(&found).len()), (3, 2));
}

#[test]
fn of_a_cut_journal_all_whole_frames_are_left_and_it_goes_on() {
    let folder = Folder::new("journal-cut");
    let (path, ends) = journal(&folder);
    let whole = fs::read(&path).unwrap();
    for length in (0..whole.len()).step_by(23).chain(ends.iter().flat_map(|end| [end - 1, *end])) {
        fs::write(&path, &whole[..length]).unwrap();
        if length < ends[0] {
            let error = Journal::open(&path).unwrap_err().to_string();
            assert!(error.contains("a.journal: "), "{error}");
            continue;
        }
        let (mut journal, kept) = Journal::open(&path).unwrap();
        let expected = ends.iter().filter(|end| **end <= length).count() - 1;
        assert_eq!(n_whole(&kept), expected);
        assert_eq!(kept.damage.is_some(), !ends.contains(&length));
        if let Some(damage) = kept.damage {
            let (start, moved) = (ends[expected], fs::read(&damage.moved_to).unwrap());
            assert_eq!((damage.at, damage.length), (start as u64, (length - start) as u64));
            assert_eq!(moved, &whole[start..length], "what was damaged is not lost");
            fs::remove_file(damage.moved_to).unwrap();
        }
        (expected..3).for_each(|i| journal.keep(&self::kept([Some(0), None, Some(2)][i], i as u64)).unwrap());
        assert_eq!(fs::read(&path).unwrap(), whole);
    }
}

#[test]
fn one_wrong_bit_costs_what_follows_and_nothing_before() {
    let folder = Folder::new("journal-bit");
    let (path, ends) = journal(&folder);
    let whole = fs::read(&path).unwrap();
    for at in (0..whole.len()).step_by(5) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        fs::write(&path, &bytes).unwrap();
        match Journal::open(&path) {
            Err(_) => assert!(at < ends[0], "only the heading is needed"),
            Ok((_, kept)) => {
                let expected = ends.iter().filter(|end| **end <= at).count() - 1;
                assert_eq!(n_whole(&kept), expected, "byte {at}");
                fs::remove_file(kept.damage.unwrap().moved_to).unwrap();
            }
        }
    }
}

#[test]
fn an_entry_in_anothers_place_is_damage() {
    let folder = Folder::new("journal-swapped");
    let (path, ends) = journal(&folder);
    let whole = fs::read(&path).unwrap();
    let entry = |i: usize| &whole[ends[i]..ends[i + 1]];
    fs::write(&path, [&whole[..ends[0]], entry(1), entry(0), entry(2)].concat()).unwrap();
    let (_, kept) = Journal::open(&path).unwrap();
    assert_eq!(n_whole(&kept), 0);
    assert!(kept.damage.unwrap().problem.starts_with("the checksum is "));
}

#[test]
fn one_process_at_a_time_and_none_is_replaced() {
    let folder = Folder::new("journal-open");
    let path = folder.path("a.journal");
    let journal = Journal::create(&path, HEADING).unwrap();
    let error = Journal::open(&path).unwrap_err().to_string();
    assert!(error.ends_with("a.journal: it is already open, here or in another process"), "{error}");
    let error = Journal::create(&path, HEADING).unwrap_err().to_string();
    assert!(error.ends_with("a.journal: already exists"), "{error}");
    drop(journal);
    assert!(Journal::open(&path).is_ok());
    let error = Journal::create(&folder.path("no/folder"), HEADING).unwrap_err().to_string();
    assert!(error.contains("no/folder: cannot be"), "{error}");
    fs::write(&path, "PNG").unwrap();
    let error = Journal::open(&path).unwrap_err().to_string();
    assert!(error.contains("is not the journal of a scan"), "{error}");
}

/// A frame written to a file that nobody can find is lost.
#[cfg(unix)]
#[test]
fn no_frame_is_kept_where_it_would_not_be_found() {
    let folder = Folder::new("journal-elsewhere");
    let (dir, moved) = (folder.path("a"), folder.path("b"));
    fs::create_dir(&dir).unwrap();
    let path = dir.join("a.journal");
    let mut journal = Journal::create(&path, HEADING).unwrap();
    journal.keep(&kept(Some(0), 0)).unwrap();
    let whole = fs::read(&path).unwrap();
    let refused = |journal: &mut Journal, now: &str, part: &str| {
        let fault = journal.keep(&kept(None, 1)).unwrap_err();
        assert!(fault.to_string().contains(part) && fault.remedy.is_some(), "{fault}");
        let fault = journal.skip(&skipped()).unwrap_err();
        assert!(fault.to_string().contains(part), "{fault}");
        if !now.is_empty() {
            assert_eq!(fs::read(folder.path(now)).unwrap(), whole, "as it was before");
        }
    };
    fs::rename(&dir, &moved).unwrap();
    refused(
        &mut journal,
        "b/a.journal",
        "a/a.journal: it was moved, or its folder was, while the scan was under way",
    );
    fs::create_dir(&dir).unwrap();
    fs::copy(moved.join("a.journal"), &path).unwrap();
    refused(&mut journal, "b/a.journal", "a/a.journal: it was replaced by another file");
    assert_eq!(fs::read(&path).unwrap(), fs::read(moved.join("a.journal")).unwrap());
    fs::remove_dir_all(&dir).unwrap();
    fs::rename(&moved, &dir).unwrap();
    journal.keep(&kept(None, 1)).expect("the journal is back");
    fs::remove_file(&path).unwrap();
    refused(&mut journal, "", "a/a.journal: it was removed, with all frames in it");
}

#[test]
fn of_many_who_begin_a_journal_one_does() {
    let folder = Folder::new("journal-race");
    for round in 0..20 {
        let path = folder.path(&format!("{round}.journal"));
        let begin = || Journal::create(&path, HEADING).ok();
        let begun: Vec<Option<Journal>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(begin)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!(begun.iter().flatten().count(), 1);
    }
    assert_eq!(fs::read_dir(folder.path(".")).unwrap().count(), 20, "nothing else is left");
}
